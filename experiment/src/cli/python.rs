//! A Python that has what is needed.

use super::WrongUsage;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// `python`, python3 unless told, if it has `package`.
pub(super) fn with(package: &str, python: Option<&Path>) -> Result<PathBuf, WrongUsage> {
    let interpreter = python.unwrap_or(Path::new("python3"));
    let mut asked = Command::new(interpreter);
    let asked = asked.args(["-c", &format!("import {package}")]);
    if asked
        .stderr(Stdio::null())
        .status()
        .is_ok_and(|status| status.success())
    {
        return Ok(interpreter.to_owned());
    }
    Err(WrongUsage(format!(
        "{} has no package {package}; `pip install {package}` into a virtual environment and name its Python by --python",
        interpreter.display()
    )))
}
