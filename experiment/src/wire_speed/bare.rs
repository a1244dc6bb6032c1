//! Processes that say as much as the programs, as often, and nothing.
//!
//! Each receives from a raw socket and sends messages of the real ones' sizes, of which only the tick is filled in; instead of
//! computing it spins for as long as that would take. What three of them reach is what the wire allows. `OBJECT_POSE`, which
//! few scenarios have, is left out.

use super::wire::Wire;
use super::{WireSpeedError, command, program};
use crate::launch::NodeCommand;
use crate::run_port::RunPort;
use lcmtypes::datagram;
use node::clock;
use node::greeting::role_name;
use spatial::ports::Role;
use std::time::{Duration, Instant};

/// How long the robot waits for an answer before it repeats its messages.
const REPEAT: Duration = Duration::from_millis(5);
/// Room for the largest message.
const LARGEST: usize = 1024;

/// A message without content: its channel and how long its encoding is, bytes.
#[derive(Clone, Copy)]
struct Hollow(&'static str, usize);

const ROBOT_STATE: Hollow = Hollow("ROBOT_STATE", 604);
const SENSOR_DEFLECTION: Hollow = Hollow("SENSOR_DEFLECTION", 956);
const ROBOT_COMMAND: Hollow = Hollow("ROBOT_COMMAND", 461);
const CONTROLLER_STATUS: Hollow = Hollow("CONTROLLER_STATUS", 613);
const SIM_LINK_MOTION: Hollow = Hollow("SIM_LINK_MOTION", 216);
const SIM_TOOL_MOTION: Hollow = Hollow("SIM_TOOL_MOTION", 184);
const SIM_TRUTH: Hollow = Hollow("SIM_TRUTH", 280);

/// What a bare process is and does.
#[derive(Clone, Copy, Debug)]
pub struct Bare {
    /// Whose messages it sends.
    pub role: Role,
    /// The port of the device channels; the simulated world has the next one.
    pub port: u16,
    /// T, ticks.
    pub period_ticks: i64,
    /// How long it spins instead of computing: the controller in a cycle, the others in a tick.
    pub spin: Duration,
}

impl Bare {
    /// What starts it: this program's subcommand `bench bare`.
    pub(super) fn command(
        role: Role,
        port: &RunPort,
        period_ticks: i64,
        spin: Duration,
    ) -> Result<NodeCommand, WireSpeedError> {
        let values = [
            ("--port", i128::from(port.port())),
            ("--period-ticks", i128::from(period_ticks)),
            ("--spin-ns", spin.as_nanos() as i128),
        ];
        let mut arguments = ["bench", "bare", role_name(role)].map(Into::into).to_vec();
        for (flag, value) in values {
            arguments.extend([flag.into(), value.to_string().into()]);
        }
        command(role, program("touchdown")?, arguments)
    }

    /// Work until the process is ended.
    pub fn run(&self) -> Result<(), WireSpeedError> {
        match self.role {
            Role::Robot => self.robot(),
            Role::Sensor => self.sensor(),
            Role::Controller => self.controller(),
        }
    }

    /// The clock master, which never ends.
    fn robot(&self) -> Result<(), WireSpeedError> {
        let (mut device, mut world) = (self.device()?, self.world()?);
        for tick in 0.. {
            let due = tick % self.period_ticks == 0;
            let (mut moved, mut commanded) = (false, !due);
            while !(moved && commanded) {
                say(&mut world, SIM_LINK_MOTION, tick)?;
                if due {
                    say(&mut device, ROBOT_STATE, tick)?;
                }
                moved = moved || hears(&mut world, SIM_TOOL_MOTION, tick)?;
                commanded = commanded || (moved && hears(&mut device, ROBOT_COMMAND, tick)?);
            }
            spin(self.spin);
        }
        Ok(())
    }

    fn sensor(&self) -> Result<(), WireSpeedError> {
        let (mut device, mut world) = (self.device()?, self.world()?);
        let mut answered = -1;
        loop {
            let Some(tick) = next(&mut world, SIM_LINK_MOTION)?.filter(|tick| *tick >= answered) else {
                continue;
            };
            if tick > answered {
                spin(self.spin);
            }
            answered = tick;
            say(&mut device, SENSOR_DEFLECTION, tick)?;
            say(&mut world, SIM_TOOL_MOTION, tick)?;
            say(&mut world, SIM_TRUTH, tick)?;
        }
    }

    fn controller(&self) -> Result<(), WireSpeedError> {
        let mut device = self.device()?;
        let (mut state, mut deflection, mut answered) = (-1, -1, -1);
        loop {
            let Some((channel, encoding)) = device.receive()? else {
                continue;
            };
            let known = match channel {
                _ if channel == ROBOT_STATE.0.as_bytes() => &mut state,
                _ if channel == SENSOR_DEFLECTION.0.as_bytes() => &mut deflection,
                _ => continue,
            };
            *known = datagram::step(encoding).unwrap_or(*known);
            // Either of the two may come last; a repeated tick is answered again.
            if state != deflection || state < answered {
                continue;
            }
            if state > answered {
                spin(self.spin);
            }
            answered = state;
            say(&mut device, ROBOT_COMMAND, state)?;
            say(&mut device, CONTROLLER_STATUS, state)?;
        }
    }

    fn device(&self) -> Result<Wire, WireSpeedError> {
        Wire::join(self.port, REPEAT)
    }

    fn world(&self) -> Result<Wire, WireSpeedError> {
        Wire::join(self.port + 1, REPEAT)
    }
}

/// The bytes of a message of `length` bytes that tells its tick alone.
fn hollow(length: usize, tick: i64) -> [u8; LARGEST] {
    let mut bytes = [0; LARGEST];
    debug_assert!(length <= LARGEST, "{length} bytes are no message");
    bytes[8..16].copy_from_slice(&tick.to_be_bytes());
    bytes
}

fn say(wire: &mut Wire, Hollow(channel, length): Hollow, tick: i64) -> Result<(), WireSpeedError> {
    wire.send(channel, &hollow(length, tick)[..length])
}

/// The tick of the next message, if it is one of `kind`.
fn next(wire: &mut Wire, kind: Hollow) -> Result<Option<i64>, WireSpeedError> {
    Ok(wire
        .receive()?
        .filter(|(channel, _)| *channel == kind.0.as_bytes())
        .and_then(|(_, encoding)| datagram::step(encoding)))
}

/// Whether `kind` of `tick` comes before nothing does for a while.
fn hears(wire: &mut Wire, kind: Hollow, tick: i64) -> Result<bool, WireSpeedError> {
    let give_up = clock::now() + REPEAT;
    loop {
        match wire.receive()? {
            None => return Ok(false),
            Some((channel, encoding)) if channel == kind.0.as_bytes() => {
                if datagram::step(encoding) == Some(tick) {
                    return Ok(true);
                }
            }
            Some(_) => {}
        }
        if clock::now() >= give_up {
            return Ok(false);
        }
    }
}

fn spin(duration: Duration) {
    let until: Option<Instant> = (!duration.is_zero()).then(|| clock::now() + duration);
    while until.is_some_and(|until| clock::now() < until) {
        std::hint::spin_loop();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::in_process;
    use crate::scenarios::Source;
    use lcmtypes::{Encoded, Message};

    #[test]
    fn hollow_messages_are_as_long_as_the_real_ones() {
        let paper = Source::find("paper").unwrap();
        let scenario = paper.scenario(&["timing.duration_s=0.001".to_owned()]).unwrap();
        let mut said: Vec<Encoded> = Vec::new();
        in_process::run(&scenario, |tick| {
            said.extend(tick.robot_state.map(|it| it.encode().unwrap()));
            said.extend(tick.controller.map(|it| it.command.encode().unwrap()));
            said.extend(tick.controller.map(|it| it.status.encode().unwrap()));
            said.push(tick.link_motion.encode().unwrap());
            said.push(tick.sensor.deflections.encode().unwrap());
            said.push(tick.sensor.tool_motion.encode().unwrap());
            said.push(tick.sensor.truth.encode().unwrap());
        });
        for Hollow(channel, length) in [
            ROBOT_STATE,
            SENSOR_DEFLECTION,
            ROBOT_COMMAND,
            CONTROLLER_STATUS,
            SIM_LINK_MOTION,
            SIM_TOOL_MOTION,
            SIM_TRUTH,
        ] {
            let real = said.iter().find(|it| it.channel() == channel).unwrap();
            assert_eq!(real.as_bytes().len(), length, "{channel}");
        }
        assert_eq!(datagram::step(&hollow(24, 7)), Some(7));
    }
}
