//! What `touchdown analyse` and `touchdown replay` take, by how long the log is.

use super::GrowthError;
use crate::analyse::Analysis;
use crate::cost::core_time_s;
use crate::log::Log;
use crate::replay::replay;
use crate::transcript;
use node::scenario::Scenario;
use serde::Serialize;
use std::fs;
use std::hint::black_box;
use std::path::Path;

/// What a log takes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Row {
    /// Simulated time, s.
    pub log_s: f64,
    /// Its size, MiB.
    pub log_mib: f64,
    /// Time on a core to read and analyse it, s.
    pub analyse_core_s: f64,
    /// Memory at most meanwhile, MiB.
    pub analyse_mib: f64,
    /// Time on a core to read and replay it, s.
    pub replay_core_s: f64,
    /// Memory at most meanwhile, MiB.
    pub replay_mib: f64,
}

/// Record `scenario` for each of `logs_s`, from the shortest on, in a file in `directory`, and read it.
pub(super) fn measure(
    scenario: &Scenario,
    logs_s: &[f64],
    directory: &Path,
) -> Result<Vec<Row>, GrowthError> {
    logs_s
        .iter()
        .map(|log_s| row(scenario, *log_s, directory))
        .collect()
}

fn row(scenario: &Scenario, log_s: f64, directory: &Path) -> Result<Row, GrowthError> {
    let scenario = scenario.with(&[format!("timing.duration_s={log_s:?}")])?;
    let path = directory.join("growth.lcmlog");
    transcript::write_log(&path, &transcript::in_process(&scenario)?)?;
    let (analyse_core_s, analyse_mib) = taken(|| {
        let log = Log::open(&path)?;
        black_box(Analysis::new(&scenario, &log).metrics());
        Ok(())
    })?;
    let (replay_core_s, replay_mib) = taken(|| {
        let log = Log::open(&path)?;
        black_box(replay(&scenario, &log)?);
        Ok(())
    })?;
    let size = fs::metadata(&path).map_err(GrowthError::Memory)?.len();
    Ok(Row {
        log_s,
        log_mib: size as f64 / MIB,
        analyse_core_s,
        analyse_mib,
        replay_core_s,
        replay_mib,
    })
}

const MIB: f64 = (1 << 20) as f64;

/// What time on a core `work` takes, s, and how much more memory at most than was used before, MiB.
fn taken(work: impl FnOnce() -> Result<(), GrowthError>) -> Result<(f64, f64), GrowthError> {
    // Linux counts the most anew from now on.
    fs::write("/proc/self/clear_refs", "5").map_err(GrowthError::Memory)?;
    let before_kib = resident_kib("VmRSS:").map_err(GrowthError::Memory)?;
    let start_s = core_time_s();
    work()?;
    let core_s = core_time_s() - start_s;
    let most_kib = resident_kib("VmHWM:").map_err(GrowthError::Memory)?;
    Ok((core_s, (most_kib - before_kib) / 1024.0))
}

/// What the kernel says of this process's memory.
fn resident_kib(what: &str) -> std::io::Result<f64> {
    let status = fs::read_to_string("/proc/self/status")?;
    let line = status.lines().find_map(|line| line.strip_prefix(what));
    let kib = line.and_then(|line| line.split_ascii_whitespace().next()?.parse().ok());
    kib.ok_or_else(|| std::io::ErrorKind::InvalidData.into())
}
