//! What is said to a robot, in which order.

use super::record::Saying;
use super::session::{ConformError, Options, Session};
use spatial::ports::{Fault, RobotMode, RobotState, Role};
use std::time::Duration;

/// Set-points farther than this from where the robot stands ask for motion, rad.
pub(super) const STAY_RAD: f64 = 1e-3;
/// How long each kind of command that is nobody's business is said.
const PROBE: Duration = Duration::from_millis(300);
/// Arming may take 10 s.
const ARMING: Duration = Duration::from_secs(12);
/// All else that a robot does to the end.
const LONG: Duration = Duration::from_secs(2);

/// Listen, try what must do nothing and, if that was asked for, enable the robot.
pub(super) fn run(session: &mut Session, options: &Options) -> Result<(), ConformError> {
    session.meet()?;
    if let Some(boot_id) = session.controller {
        return Err(ConformError::Controller {
            boot_id,
            url: options.url.clone(),
        });
    }
    session.play(Role::Controller);
    if !session
        .record
        .peers
        .iter()
        .any(|it| it.message.role == Role::Sensor)
    {
        session.play(Role::Sensor);
    }
    session.say(Saying::Released, options.listen, never)?;
    let newest = session.record.states.last().map(|it| it.message);
    let Some(state) = newest.filter(|state| state.fault == Fault::None) else {
        return Ok(());
    };
    session.reference = Some(state.axis_setpoint);
    for odd in [Saying::Future, Saying::Old, Saying::Foreign, Saying::OutOfRange] {
        session.say(odd, PROBE, never)?;
    }
    match options.expectation.moved {
        true => enable(session, options),
        false => Ok(()),
    }
}

fn enable(session: &mut Session, options: &Options) -> Result<(), ConformError> {
    let mode = |wanted| move |state: &RobotState| state.mode == wanted;
    let gap = Duration::try_from_secs_f64(options.expectation.command_gap_s).unwrap_or_default();
    if session.signatures.is_some() {
        session.say(Saying::Unsigned, PROBE, never)?;
    }
    session.say(Saying::Stay, ARMING, mode(RobotMode::Following))?;
    session.say(Saying::Intruder, PROBE, never)?;
    session.say(Saying::Released, LONG, mode(RobotMode::Idle))?;
    session.say(Saying::Stay, ARMING, mode(RobotMode::Following))?;
    session.say(Saying::Silence, gap + LONG, mode(RobotMode::Fault))?;
    // Enabled commands come before a reset is asked for: what came in silence may be reset.
    session.say(Saying::Stay, PROBE, never)?;
    session.say(Saying::ResetWhileEnabled, 4 * PROBE, never)?;
    session.say(Saying::Released, PROBE, never)?;
    session.say(Saying::Reset, LONG, |state| state.fault == Fault::None)?;
    session.say(Saying::Released, PROBE, never)
}

fn never(_: &RobotState) -> bool {
    false
}
