//! The robot as a process: what drives its time, and what it says to the others.

mod lockstep;
mod realtime;

use anyhow::bail;
use node::shell::{Flags, Pace, Shell};
use spatial::ports::Role;

/// Run the node until a signal ends it.
pub(crate) fn run(flags: &Flags) -> anyhow::Result<()> {
    let shell = match flags.realtime(flags.start(Role::Robot)?)? {
        Pace::Lockstep(shell) => lockstep::run(flags, shell)?,
        Pace::RealTime(node) => realtime::run(flags, node)?,
    };
    finish(shell)
}

fn finish(shell: Shell) -> anyhow::Result<()> {
    let faulty = shell.health.faulty();
    shell.finish()?;
    if faulty {
        bail!("ended with a latched fault, see above");
    }
    Ok(())
}
