//! How many ticks three processes in lockstep do in a second.
//!
//! Nobody listens to them meanwhile: who does is woken up by each message. The ticks are read off `ROBOT_STATE` at the beginning
//! and at the end.

use super::bare::Bare;
use super::wire::Wire;
use super::{Programs, QUIET, SILENT, WireSpeedError, wait_until};
use crate::cost::{self, median};
use crate::in_process::{self, Part};
use crate::launch::{Cell, NodeCommand};
use crate::run_port::RunPort;
use crossbeam::channel::Receiver;
use lcmtypes::{Message, datagram};
use node::clock;
use node::scenario::Scenario;
use serde::Serialize;
use spatial::ports::{RobotState, Role};
use std::time::{Duration, Instant};

pub(super) const ROLES: [Role; 3] = [Role::Sensor, Role::Controller, Role::Robot];
/// Between the first tick and the first that counts.
pub(super) const WARM_UP: Duration = Duration::from_millis(200);
/// How long this process listens before it looks for a signal.
const LOOK: Duration = Duration::from_millis(50);
/// How often a part's computation is timed.
const REPETITIONS: u16 = 3;

/// The three programs beside three bare processes.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Lockstep {
    /// The programs': the median of all runs, the lowest and the highest.
    pub lockstep_ticks_per_s: f64,
    #[allow(missing_docs)]
    pub lockstep_ticks_per_s_min: f64,
    #[allow(missing_docs)]
    pub lockstep_ticks_per_s_max: f64,
    /// The bare processes': the median of all runs.
    pub bare_ticks_per_s: f64,
    /// Of the medians, and of each run to the one beside it.
    pub lockstep_ratio: f64,
    #[allow(missing_docs)]
    pub lockstep_ratio_min: f64,
    #[allow(missing_docs)]
    pub lockstep_ratio_max: f64,
    /// How long each bare process spins, since its part computes for so long, us.
    pub robot_us_per_tick: f64,
    #[allow(missing_docs)]
    pub sensor_us_per_tick: f64,
    #[allow(missing_docs)]
    pub controller_us_per_cycle: f64,
    /// From the start of the programs to their first tick, s; of the last run.
    pub start_up_s: f64,
}

/// What a ring has done.
struct Rate {
    ticks_per_s: f64,
    start_up_s: f64,
}

/// Time `repetitions` runs (at least one) of the programs for `window`, and between them as many of bare processes, each of which
/// spins for as long as its part computes in a run of `scenario`.
pub fn compare(
    programs: &Programs,
    scenario: &Scenario,
    repetitions: u16,
    window: Duration,
    stop: &Receiver<()>,
) -> Result<Lockstep, WireSpeedError> {
    let spins = computation(scenario);
    let period_ticks = scenario.timing.command_period_ticks;
    let (mut real, mut bare, mut ratios) = (Vec::new(), Vec::new(), Vec::new());
    let mut start_up_s = f64::NAN;
    for _ in 0..repetitions {
        let own = rate(window, stop, |role, port| programs.command(role, port, ""))?;
        let limit = rate(window, stop, |role, port| {
            Bare::command(role, port, period_ticks, spins[role as usize])
        })?;
        start_up_s = own.start_up_s;
        real.push(own.ticks_per_s);
        bare.push(limit.ticks_per_s);
        ratios.push(own.ticks_per_s / limit.ticks_per_s);
    }
    for values in [&mut real, &mut bare, &mut ratios] {
        values.sort_by(f64::total_cmp);
    }
    let [robot_us_per_tick, sensor_us_per_tick, controller_us_per_cycle] =
        spins.map(|spin| 1e6 * spin.as_secs_f64());
    Ok(Lockstep {
        lockstep_ticks_per_s: median(&real),
        lockstep_ticks_per_s_min: real[0],
        lockstep_ticks_per_s_max: real[real.len() - 1],
        bare_ticks_per_s: median(&bare),
        lockstep_ratio: median(&real) / median(&bare),
        lockstep_ratio_min: ratios[0],
        lockstep_ratio_max: ratios[ratios.len() - 1],
        robot_us_per_tick,
        sensor_us_per_tick,
        controller_us_per_cycle,
        start_up_s,
    })
}

/// How long each part computes in a tick of a run of `scenario`, by role; the controller in a cycle.
fn computation(scenario: &Scenario) -> [Duration; 3] {
    let mut said = Vec::new();
    in_process::run(scenario, |tick| said.push(*tick));
    let period_ticks = scenario.timing.command_period_ticks as f64;
    let parts = [
        (Part::Robot, 1.0),
        (Part::Sensor, 1.0),
        (Part::Controller, period_ticks),
    ];
    parts.map(|(part, ticks)| {
        let seconds = ticks * cost::part_s_per_tick(part, scenario, &said, REPETITIONS);
        Duration::try_from_secs_f64(seconds).unwrap_or_default()
    })
}

/// Start the processes of a ring and time it.
fn rate(
    window: Duration,
    stop: &Receiver<()>,
    command: impl Fn(Role, &RunPort) -> Result<NodeCommand, WireSpeedError>,
) -> Result<Rate, WireSpeedError> {
    let port = RunPort::free(QUIET)?;
    let nodes = ROLES.map(|role| command(role, &port));
    let nodes = nodes.into_iter().collect::<Result<Vec<_>, _>>()?;
    let listening = Wire::join(port.port(), LOOK)?;
    let started = clock::now();
    // A link of its own hears nothing and is not woken up.
    let _cell = Cell::of("memq://", 0, &nodes)?;
    let (_, first) = next_tick(listening, "", stop)?;
    wait_until(first + WARM_UP, stop)?;
    let (tick, from) = look(&port, "", stop)?;
    wait_until(from + window, stop)?;
    let (last, until) = look(&port, "", stop)?;
    Ok(Rate {
        ticks_per_s: (last - tick) as f64 / (until - from).as_secs_f64(),
        start_up_s: (first - started).as_secs_f64(),
    })
}

/// The tick that a ring on `port`, whose channels end in `suffix`, has come to, and when.
pub(super) fn look(
    port: &RunPort,
    suffix: &str,
    stop: &Receiver<()>,
) -> Result<(i64, Instant), WireSpeedError> {
    next_tick(Wire::join(port.port(), LOOK)?, suffix, stop)
}

/// The tick of the next `ROBOT_STATE`, and when it came.
fn next_tick(mut wire: Wire, suffix: &str, stop: &Receiver<()>) -> Result<(i64, Instant), WireSpeedError> {
    let states = RobotState::CHANNEL.to_owned() + suffix;
    let give_up = clock::now() + SILENT;
    while clock::now() < give_up {
        wait_until(clock::now(), stop)?;
        let Some((channel, encoding)) = wire.receive()? else {
            continue;
        };
        if channel == states.as_bytes()
            && let Some(tick) = datagram::step(encoding)
        {
            return Ok((tick, clock::now()));
        }
    }
    Err(WireSpeedError::Silent {
        what: RobotState::CHANNEL,
        port: wire.port,
        seconds: SILENT.as_secs(),
    })
}
