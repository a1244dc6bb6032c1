//! The programs under test.

use std::path::PathBuf;
use std::process::Command;
use std::sync::OnceLock;

/// The directory with the programs (and, in `examples`, the skeleton of a driver), built from the present sources in the profile of the tests.
///
/// `cargo test` builds a program only for tests of its own package, so this asks cargo, which does nothing when
/// nothing has changed.
///
/// # Panics
/// If they can't be built: no test of them makes sense then.
#[expect(clippy::panic, reason = "there is nothing to test")]
pub fn programs() -> PathBuf {
    static BUILT: OnceLock<PathBuf> = OnceLock::new();
    BUILT
        .get_or_init(|| {
            let mut build = Command::new(env!("CARGO"));
            build.args(["build", "--workspace", "--bins", "--examples", "--quiet"]);
            if !cfg!(debug_assertions) {
                build.arg("--release");
            }
            let built = build.current_dir(env!("CARGO_MANIFEST_DIR")).status();
            match (built, experiment::launch::programs()) {
                (Ok(status), Ok(directory)) if status.success() => directory,
                (status, directory) => panic!("can't build the programs: {status:?}, {directory:?}"),
            }
        })
        .clone()
}

/// The command `touchdown`, to be given its arguments.
pub fn touchdown() -> Command {
    let mut command = Command::new(programs().join("touchdown"));
    command
        .env_remove("RUST_LOG")
        .env("XDG_STATE_HOME", std::env::temp_dir().join("touchdown-tests"));
    command
}
