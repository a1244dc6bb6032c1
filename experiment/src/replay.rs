//! The controller once more on what it has heard: do its commands and statuses come out the same, bit for bit?
//!
//! In lockstep the tick says what a cycle has heard, so that any log that begins with the run will do, one of lcm-logger
//! included. In real time that depends on when messages arrived, which only the controller itself knows: its own record has
//! it on channels `HEARD_*` ([`node::record`]).

mod cycles;
mod difference;

pub use difference::Difference;

use crate::log::Log;
use crate::transcript::Entry;
use controller::margins::Assessment;
use controller::{Controller, Heard, Outputs};
use cycles::Cycle;
use lcmtypes::Message;
use node::scenario::Scenario;
use spatial::ports::{Command, ControllerStatus, Fault, Invalid};
use std::collections::VecDeque;

/// What has come of a replay.
#[derive(Clone, Debug, PartialEq)]
pub struct Replay {
    /// Commands that are equal, up to the first difference.
    pub commands: usize,
    /// Statuses that are equal, up to the first difference.
    pub statuses: usize,
    /// The first difference; `None`: there is none.
    pub difference: Option<Difference>,
    /// Why the rest of the log could not be repeated.
    pub stopped: Option<String>,
}

/// Why a log can't be replayed at all.
#[derive(Debug, thiserror::Error)]
pub enum Unreplayable {
    /// Real time, recorded on the network.
    #[error(
        "the log is one of real time without HEARD_* channels: what each cycle of the controller had heard when it began is \
         not in it; record with `touchdown run --record`, or start the controller with --record FILE and replay that"
    )]
    NotHeard,
    /// It begins in the middle.
    #[error(
        "the log begins at step {0} of ROBOT_STATE: a replay needs all that the controller has heard since its start"
    )]
    Middle(i64),
    /// No command in it.
    #[error(
        "the log has no ROBOT_COMMAND that a controller has answered to a ROBOT_STATE: there is nothing to compare"
    )]
    Nothing,
    /// The controller says what can't be said.
    #[error("the replayed controller says what can't be published: {0}")]
    Invalid(#[from] Invalid),
}

/// Replay `log`, which was recorded with `scenario`.
pub fn replay(scenario: &Scenario, log: &Log) -> Result<Replay, Unreplayable> {
    let (cycles, stopped, live) = cycles::of(scenario, log)?;
    let mut controller = Controller::new(scenario);
    let mut found = VecDeque::new();
    let mut replay = Replay {
        commands: 0,
        statuses: 0,
        difference: None,
        stopped,
    };
    for cycle in &cycles {
        if cycle.anew {
            controller = Controller::new(scenario);
            found.clear();
        }
        if live {
            act_from_outside(&mut controller, &mut found, cycle);
        }
        if let Some(task) = &cycle.task {
            controller.request(task);
        }
        let outputs = controller.cycle(&Heard {
            tick: cycle.tick,
            state: cycle.state.as_ref(),
            deflections: cycle.deflections.as_ref(),
            object: cycle.object.as_ref(),
        });
        compare(&mut replay, &outputs, cycle, live)?;
        if replay.difference.is_some() {
            break;
        }
        if live {
            found.extend(controller.to_assess().map(|job| job.found()));
        } else {
            controller.assess();
        }
    }
    match replay.commands + replay.statuses {
        0 if replay.difference.is_none() => Err(Unreplayable::Nothing),
        _ => Ok(replay),
    }
}

/// In real time margins are published when a thread has found them, and a clock is found to have jumped by its stamps: when that
/// was is read off the recorded statuses, what the margins are is not.
fn act_from_outside(controller: &mut Controller, found: &mut VecDeque<Assessment>, cycle: &Cycle<'_>) {
    let Some(recorded) = cycle
        .status
        .and_then(|entry| ControllerStatus::decode(&entry.bytes).ok())
    else {
        return;
    };
    if recorded.fault == Fault::ClockJump {
        controller.latch(recorded.fault);
    }
    while let Some(next) = found.front() {
        if next.gain_margin.to_bits() != recorded.gain_margin.to_bits()
            || next.phase_margin_rad.to_bits() != recorded.phase_margin_rad.to_bits()
        {
            return;
        }
        controller.publish_assessment(*next);
        found.pop_front();
    }
}

fn compare(
    replay: &mut Replay,
    outputs: &Outputs,
    cycle: &Cycle<'_>,
    live: bool,
) -> Result<(), Unreplayable> {
    let Outputs {
        mut command,
        mut status,
    } = *outputs;
    if let Some(entry) = cycle.command {
        if live && let Ok(recorded) = Command::decode(&entry.bytes) {
            // The clock's, which the library does not know.
            (command.stamp, command.send_utime) = (recorded.stamp, recorded.send_utime);
        }
        replay.commands += usize::from(same(replay, &command, entry)?);
    }
    if replay.difference.is_some() {
        return Ok(());
    }
    if let Some(entry) = cycle.status {
        if live && let Ok(recorded) = ControllerStatus::decode(&entry.bytes) {
            status.stamp = recorded.stamp;
        }
        replay.statuses += usize::from(same(replay, &status, entry)?);
    }
    Ok(())
}

fn same<M: Message>(replay: &mut Replay, replayed: &M, recorded: &Entry) -> Result<bool, Unreplayable> {
    let encoded = replayed.encode()?;
    replay.difference = Difference::first(M::CHANNEL, &recorded.bytes, encoded.as_bytes());
    Ok(replay.difference.is_none())
}

#[cfg(test)]
mod tests;
