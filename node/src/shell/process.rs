//! What any process does: its logging, its signals, its parent, its last word.

use anyhow::Context;
use crossbeam::channel::{Receiver, bounded};
use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM, SIGXFSZ};
use signal_hook::iterator::Signals;
use std::io::{IsTerminal, Write};
use std::os::unix::net::UnixStream;
use std::process::ExitCode;
use std::sync::Arc;
use tracing::Level;
use tracing_subscriber::filter::Targets;
use tracing_subscriber::prelude::*;

/// Get SIGTERM when the process `parent`, which started this one, ends.
pub fn follow(parent: i32) -> anyhow::Result<()> {
    let term = rustix::process::Signal::TERM;
    rustix::process::set_parent_process_death_signal(Some(term))
        .context("can't follow the parent process")?;
    // It may have ended before the line above.
    let now = rustix::process::getppid().map_or(0, rustix::process::Pid::as_raw_pid);
    anyhow::ensure!(
        now == parent,
        "process {parent}, which started this one, has ended"
    );
    Ok(())
}

/// Run a program's body and turn an error into a message and exit code 1.
pub fn run(body: impl FnOnce() -> anyhow::Result<()>) -> ExitCode {
    match body() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            // Who has closed stderr does not want to know.
            let _ = writeln!(std::io::stderr(), "error: {}", told(&error));
            ExitCode::FAILURE
        }
    }
}

/// The error and its causes, outermost first; a cause that has been told already is not told again.
pub fn told(error: &anyhow::Error) -> String {
    let mut text = error.to_string();
    for cause in error.chain().skip(1).map(ToString::to_string) {
        if !text.contains(&cause) {
            text += &format!(": {cause}");
        }
    }
    text
}

/// Log to stderr; `RUST_LOG` chooses what, such as `warn` or `info,lcmtypes=debug` (default: info).
pub fn log_to_stderr() {
    let asked = std::env::var("RUST_LOG")
        .ok()
        .and_then(|asked| asked.parse().ok());
    let chosen = asked.unwrap_or_else(|| Targets::new().with_default(Level::INFO));
    let lines = tracing_subscriber::fmt::layer()
        .with_writer(std::io::stderr)
        // It would tell them on stderr, too, and a terminal that is gone must not end the process.
        .log_internal_errors(false)
        .with_ansi(std::io::stderr().is_terminal())
        .with_target(false)
        .without_time()
        .with_filter(chosen);
    // A second call, in a test, keeps the first subscriber.
    let _ = tracing_subscriber::registry().with(lines).try_init();
}

/// A stream that has something to read once a signal has asked the process to end.
pub(super) fn stop_stream() -> anyhow::Result<UnixStream> {
    let failed = "can't handle signals";
    outlast_limits()?;
    let (stop, sender) = UnixStream::pair().context(failed)?;
    for signal in [SIGTERM, SIGINT, SIGHUP] {
        let sender = sender.try_clone().context(failed)?;
        signal_hook::low_level::pipe::register(signal, sender).context(failed)?;
    }
    Ok(stop)
}

/// A file that may not grow any more (`ulimit -f`) fails its writer and does not end the process.
fn outlast_limits() -> anyhow::Result<()> {
    let handled = signal_hook::flag::register(SIGXFSZ, Arc::default());
    handled.map(drop).context("can't handle signals")
}

/// A receiver that gets one message for each signal that asks the process to end.
pub fn signals() -> anyhow::Result<Receiver<()>> {
    outlast_limits()?;
    let mut signals = Signals::new([SIGTERM, SIGINT, SIGHUP]).context("can't handle signals")?;
    let (sender, receiver) = bounded(4);
    std::thread::spawn(move || {
        for _ in signals.forever() {
            let _ = sender.try_send(());
        }
    });
    Ok(receiver)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cause_is_told_once() {
        let cause = || anyhow::anyhow!("no such device (os error 19)");
        let named =
            cause().context("can't join the group: no such device (os error 19); see `touchdown doctor`");
        assert_eq!(told(&named), named.to_string());
        let bare = cause().context("can't join the group");
        assert_eq!(told(&bare), "can't join the group: no such device (os error 19)");
    }
}
