//! A Python that has LCM, and the types that lcm-gen makes for it. The multi-process tests use this file, too.

use std::env;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

pub(crate) const REMEDY: &str = "apt-get install python3 python3-pip python3-venv, and let pip reach the network once; \
                                 or set LCM_PYTHON to a Python that has the package lcm 1.5.3";

/// `LCM_PYTHON`, or a virtual environment below target/, made once; or why there is none.
pub(crate) fn python() -> Result<PathBuf, String> {
    if let Some(python) = env::var_os("LCM_PYTHON") {
        return Ok(python.into());
    }
    let environment = Path::new(env!("CARGO_TARGET_TMPDIR")).join("python-lcm-1.5.3");
    let python = environment.join("bin/python");
    let complete = Command::new(&python)
        .args(["-c", "import lcm"])
        .stderr(Stdio::null())
        .status();
    if !complete.is_ok_and(|status| status.success()) {
        run(Command::new("python3")
            .args(["-m", "venv", "--clear"])
            .arg(&environment))?;
        let install = [
            "-m",
            "pip",
            "install",
            "--quiet",
            "--disable-pip-version-check",
            "lcm==1.5.3",
        ];
        run(Command::new(&python).args(install))?;
    }
    Ok(python)
}

/// Generate the types of the directory `types` by `lcm_gen` into `directory`.
pub(crate) fn generate(lcm_gen: &Path, types: &Path, directory: &Path) -> Result<(), String> {
    let files = std::fs::read_dir(types).map_err(|error| format!("{}: {error}", types.display()))?;
    let files = files.flatten().map(|file| file.path());
    run(Command::new(lcm_gen)
        .args(["-p", "--ppath"])
        .arg(directory)
        .args(files))
}

/// Run `command` to its end.
pub(crate) fn run(command: &mut Command) -> Result<(), String> {
    match command.output() {
        Ok(output) if output.status.success() => Ok(()),
        Ok(output) => Err(format!(
            "{command:?} failed: {}\n{REMEDY}",
            String::from_utf8_lossy(&output.stderr)
        )),
        Err(error) => Err(format!("{command:?} can't be run: {error}\n{REMEDY}")),
    }
}
