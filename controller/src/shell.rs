//! The controller as a process: what drives its time, and what it says to the others.

mod lockstep;
mod realtime;
mod schedule;
mod timeline;

use node::shell::{Flags, Pace};
use spatial::ports::Role;

/// Run the node until a signal ends it.
pub(crate) fn run(flags: &Flags) -> anyhow::Result<()> {
    let shell = match flags.realtime(flags.start(Role::Controller)?)? {
        Pace::Lockstep(shell) => lockstep::run(flags, shell)?,
        Pace::RealTime(node) => realtime::run(flags, node)?,
    };
    shell.finish()
}
