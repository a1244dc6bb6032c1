//! What stands beside a log: the scenario with all its values, and what made it.

use lcmtypes::LCM_VERSION;
use node::scenario::Scenario;
use spatial::ports::PROTOCOL;
use std::path::{Path, PathBuf};

/// Where the scenario of `log` is: `proposed.toml` beside `proposed.lcmlog`.
pub fn path(log: &Path) -> PathBuf {
    log.with_extension("toml")
}

/// The file beside `log`, which `touchdown run` has made of the scenario `name`: the scenario as it was resolved, to be read
/// as any other, below a comment of seed and versions.
pub fn text(log: &Path, name: &str, scenario: &Scenario) -> String {
    let file = log.file_name().unwrap_or_default().to_string_lossy();
    let (major, minor, micro) = LCM_VERSION;
    format!(
        "# All values of the scenario that {file} was recorded with.\n\
         # scenario: {name}\n\
         # seed: {}\n\
         # configuration_hash: {:016x}\n\
         # touchdown: {}\n\
         # protocol: {PROTOCOL}\n\
         # lcm: {major}.{minor}.{micro}\n\n{}",
        scenario.timing.seed,
        scenario.hash(),
        env!("CARGO_PKG_VERSION"),
        scenario.to_toml()
    )
}
