//! How far the devices' clocks are ahead of the controller's.

use crate::transcript::{self, Entry};
use serde::Serialize;
use spatial::TICK_US;
use spatial::ports::{Command, Deflections, NodeStatus, RobotState, Role};

/// Offset of a device's clock.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Clock {
    /// `robot` or `sensor`.
    pub device: &'static str,
    /// Who tells: `controller`, which has measured it, or `log`, by the times at which messages arrived there.
    pub told_by: &'static str,
    /// How far it is ahead of the controller's, s.
    pub ahead_s: f64,
    /// Bound of the error, s; `null`: what the messages' ways differ by is not known.
    pub bound_s: Option<f64>,
    /// How much faster it goes, 1; `null`: not known.
    pub rate: Option<f64>,
}

/// What the controller has published last, and what can be told from a recorder's times.
pub(super) fn of(said: &[Entry]) -> Vec<Clock> {
    let mut clocks = Vec::new();
    let devices = [("robot", Role::Robot), ("sensor", Role::Sensor)];
    let told = transcript::messages::<NodeStatus>(said)
        .filter(|status| {
            status.role == Role::Controller && status.clock_bound_s.iter().any(|bound| *bound > 0.0)
        })
        .last();
    for (device, role) in devices {
        let Some(status) = &told else { break };
        clocks.push(Clock {
            device,
            told_by: "controller",
            ahead_s: status.clock_offset_s[role as usize],
            bound_s: Some(status.clock_bound_s[role as usize]),
            rate: Some(status.clock_rate[role as usize]),
        });
    }
    // A node's own record has the ticks' times.
    let states = || messages::<RobotState>(said);
    if states().all(|(utime, state)| utime == state.stamp.step * TICK_US) {
        return clocks;
    }
    let robot = least(states().map(|(utime, it)| (utime, it.echo.send_utime)));
    let sensor = least(messages::<Deflections>(said).map(|(utime, it)| (utime, it.echo.send_utime)));
    let controller = least(messages::<Command>(said).map(|(utime, it)| (utime, it.send_utime)));
    for ((device, _), least) in devices.into_iter().zip([robot, sensor]) {
        if let (Some(device_us), Some(controller_us)) = (least, controller) {
            clocks.push(Clock {
                device,
                told_by: "log",
                ahead_s: 1e-6 * (controller_us - device_us) as f64,
                bound_s: None,
                rate: None,
            });
        }
    }
    clocks
}

/// Messages with the time at which they were recorded, us.
fn messages<M: lcmtypes::Message>(said: &[Entry]) -> impl Iterator<Item = (i64, M)> {
    let of = said.iter().filter(|entry| entry.channel == M::CHANNEL);
    of.filter_map(|entry| Some((entry.utime, M::decode(&entry.bytes).ok()?)))
}

/// The least way from a stamp of sending (us; 0: none) to the recorder.
fn least(times: impl Iterator<Item = (i64, i64)>) -> Option<i64> {
    times
        .filter(|(_, sent)| *sent != 0)
        .map(|(utime, sent)| utime - sent)
        .min()
}
