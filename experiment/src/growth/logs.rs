//! What `touchdown analyse` and `touchdown replay` take, by how long the log is.

use super::GrowthError;
use crate::launch;
use crate::transcript;
use crate::usage::Usage;
use crate::wire_speed::{Programs, wait_until};
use crossbeam::channel::Receiver;
use node::clock;
use node::scenario::Scenario;
use serde::Serialize;
use std::fs;
use std::io;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

/// Between two looks at a process.
const LOOK: Duration = Duration::from_millis(1);
const MIB: f64 = (1 << 20) as f64;

/// What a log takes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Row {
    /// Simulated time, s.
    pub log_s: f64,
    /// Its size, MiB.
    pub log_mib: f64,
    /// Time of `touchdown analyse` on a core, s.
    pub analyse_core_s: f64,
    /// Its memory at most, MiB.
    pub analyse_mib: f64,
    /// Time of `touchdown replay` on a core, s.
    pub replay_core_s: f64,
    /// Its memory at most, MiB.
    pub replay_mib: f64,
}

/// Record `scenario`, which is that of `programs`, for each of `logs_s` in a file in `directory`, and read it.
pub(super) fn measure(
    programs: &Programs,
    scenario: &Scenario,
    logs_s: &[f64],
    directory: &Path,
    stop: &Receiver<()>,
) -> Result<Vec<Row>, GrowthError> {
    let touchdown = launch::programs()
        .map_err(GrowthError::Command)?
        .join("touchdown");
    let path = directory.join("growth.lcmlog");
    let row = |log_s: &f64| {
        let duration = format!("timing.duration_s={log_s:?}");
        let recorded = scenario.with(std::slice::from_ref(&duration))?;
        transcript::write_log(&path, &transcript::in_process(&recorded)?)?;
        let taken = |subcommand: &str| {
            let mut command = Command::new(&touchdown);
            command
                .arg(subcommand)
                .arg(&path)
                .arg("--scenario")
                .arg(&programs.scenario);
            for change in programs.overrides.iter().chain([&duration]) {
                command.args(["--set", change]);
            }
            taken(command.stdin(Stdio::null()).stdout(Stdio::null()), stop)
        };
        let (analyse_core_s, analyse_mib) = taken("analyse")?;
        let (replay_core_s, replay_mib) = taken("replay")?;
        Ok(Row {
            log_s: *log_s,
            log_mib: fs::metadata(&path).map_err(GrowthError::Command)?.len() as f64 / MIB,
            analyse_core_s,
            analyse_mib,
            replay_core_s,
            replay_mib,
        })
    };
    logs_s.iter().map(row).collect()
}

/// What `command` takes: time on a core, s, and memory at most, MiB.
fn taken(command: &mut Command, stop: &Receiver<()>) -> Result<(f64, f64), GrowthError> {
    let mut child = command.spawn().map_err(GrowthError::Command)?;
    let mut most_mib = 0.0;
    // A process that has ended has no memory, but its account until it is waited for.
    while let Some(mib) = most_resident_mib(child.id()).map_err(GrowthError::Command)? {
        most_mib = mib;
        if let Err(interrupted) = wait_until(clock::now() + LOOK, stop) {
            let _ = child.kill();
            let _ = child.wait();
            return Err(GrowthError::Launch(interrupted));
        }
    }
    let used = Usage::of(child.id());
    let status = child.wait().map_err(GrowthError::Command)?;
    if !status.success() {
        return Err(GrowthError::Failed);
    }
    Ok((used.map_err(GrowthError::Command)?.core_s, most_mib))
}

/// How much memory of the process `id` has been resident at most, MiB; `None`: it has ended.
fn most_resident_mib(id: u32) -> io::Result<Option<f64>> {
    let status = fs::read_to_string(format!("/proc/{id}/status"))?;
    let kib = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    let kib = kib.and_then(|rest| rest.split_ascii_whitespace().next()?.parse::<f64>().ok());
    Ok(kib.map(|kib| kib / 1024.0))
}
