//! What no controller can beat, even with a perfect model: the least error after the contact, by linear programmes
//! (PLANT.md section 6).
//!
//! Nothing can act before the contact has been detected and a command has gone its way. From then on the acceleration of
//! the command filters along the normal is free at knots T apart, linear between them and within its limit; the force
//! follows from the linear plant ([`plant`]). (Set-points
//! far beyond what is wanted drive the filters into their limit within less than a period; as in PLANT.md, that is left
//! out. docs/elastic.md says what it is worth.) What makes IAE, peak or settling times least is a programme each
//! ([`programme`]).

pub mod plant;
pub mod programme;
mod text;

use clarabel::solver::SolverStatus;
use node::scenario::{ExpectedFrom, Scenario, TaskKind};
use plant::{Plant, STEP_S};
use programme::Programme;
use serde::Serialize;
use spatial::TICK_S;
use std::f64::consts::TAU;

/// How long after the contact the force is judged, s: what comes later only adds to the errors.
const HORIZON_S: f64 = 0.3;
/// Steps of the plant's grid in a tick.
const STEPS_PER_TICK: usize = 10;

/// From the contact to the first effect of a command that answers it, s, on the mean over contact phases.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Delay {
    /// Until the low-passed deflection exceeds the threshold, and a sample is due.
    pub detection_s: f64,
    /// The sensor's delay.
    pub sensor_s: f64,
    /// Until the controller's next cycle.
    pub cycle_s: f64,
    /// n_d T.
    pub command_s: f64,
}

impl Delay {
    /// In all, s.
    pub fn sum_s(&self) -> f64 {
        self.detection_s + self.sensor_s + self.cycle_s + self.command_s
    }
}

/// Figures of a force over time, as `experiment::metrics` has them. Not a number: not within the horizon.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Figures {
    /// Largest force, N.
    pub peak_n: f64,
    /// Last exit from desired force +- 10 %, s after the contact.
    pub settling_10_s: f64,
    /// Last exit from desired force +- 2 %, s after the contact.
    pub settling_2_s: f64,
    /// Integral of the force error's magnitude, N s.
    pub iae_n_s: f64,
}

/// The lower bounds of a scenario.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Bound {
    /// Until a command can act.
    pub delay: Delay,
    /// The largest acceleration of the command filters along the normal, m/s^2.
    pub acceleration_limit_m_per_s2: f64,
    /// Each figure's own least value.
    pub least: Figures,
    /// All figures of the motion with the least IAE.
    pub with_least_iae: Figures,
    /// The smallest force between tool and object in that motion once commands act, N: below zero, a real tool leaves it.
    pub least_contact_n: f64,
}

/// Why there is no bound.
#[derive(Debug, thiserror::Error)]
pub enum BoundError {
    /// Another task, or an object that moves.
    #[error("no lower bound for {key} = {value}: it is known for {known} only; set {key}={known}")]
    Unknown {
        /// The key in question.
        key: &'static str,
        /// Its value.
        value: String,
        /// What it must be.
        known: &'static str,
    },
    /// No such plant.
    #[error(
        "the plant has no linear model at task.start_position_m = {start:?} m: a mass or stiffness is not positive, or the \
         start is out of reach; check [robot], [sensor], [tool] and the start"
    )]
    Singular {
        /// Start, m.
        start: [f64; 3],
    },
    /// Too slow or too high a threshold.
    #[error(
        "at {speed} m/s the force does not exceed the detection threshold of {threshold} N within {HORIZON_S} s; approach \
         faster, or lower controller.detection_threshold_n"
    )]
    Undetected {
        /// m/s.
        speed: f64,
        /// N.
        threshold: f64,
    },
    /// The solver gave up.
    #[error(
        "a linear programme has no solution to working precision ({0:?}); check the stiffnesses and masses of the scenario"
    )]
    Unsolved(SolverStatus),
}

/// The lower bounds of `scenario`, from its real parameters.
pub fn bound(scenario: &Scenario) -> Result<Bound, BoundError> {
    check(scenario)?;
    let plant = Plant::new(scenario).ok_or(BoundError::Singular {
        start: scenario.task.start_position_m,
    })?;
    let ticks = libm::rint(HORIZON_S / TICK_S) as usize;
    let steps = ticks * STEPS_PER_TICK;
    let [free, contact] = plant.coasting(steps);
    let delay = delay(scenario, &free).ok_or(BoundError::Undetected {
        speed: scenario.task.approach_speed_m_per_s,
        threshold: scenario.controller.detection_threshold_n,
    })?;
    // Never later than it is, so that it stays a bound.
    let acts = libm::floor(delay.sum_s() / STEP_S) as usize;
    let rise = scenario.timing.command_period_ticks as usize * STEPS_PER_TICK;
    let [hat, hat_contact] = plant.hat(rise, steps);
    let columns = |response: &[f64]| -> Vec<Vec<f64>> {
        (acts..steps)
            .step_by(rise)
            .map(|from| {
                (0..ticks)
                    .map(|tick| (tick * STEPS_PER_TICK).checked_sub(from))
                    .map(|since| since.map_or(0.0, |since| response[since] * plant.acceleration_limit))
                    .collect()
            })
            .collect()
    };
    let at_ticks = |values: &[f64]| values.iter().step_by(STEPS_PER_TICK).copied().collect();
    let programme = Programme {
        free: at_ticks(&free),
        reach: columns(&hat),
        desired: scenario.task.desired_force_n,
    };
    let best = programme.least_sum().map_err(BoundError::Unsolved)?;
    let with_least_iae = figures(&programme.forces(&best), programme.desired);
    // From the first tick on at which a command has acted.
    let first = acts / STEPS_PER_TICK + 1;
    let later = |mut series: Vec<f64>| series.split_off(first);
    let contact = Programme {
        free: later(at_ticks(&contact)),
        reach: columns(&hat_contact).into_iter().map(later).collect(),
        desired: 0.0,
    };
    let settled = |band: f64| least_settling(&programme, band * programme.desired, first - 1);
    let least_settling = |band: f64| settled(band).map_err(BoundError::Unsolved);
    Ok(Bound {
        delay,
        acceleration_limit_m_per_s2: plant.acceleration_limit,
        least: Figures {
            peak_n: programme.least_peak().map_err(BoundError::Unsolved)?,
            settling_10_s: least_settling(0.10)?,
            settling_2_s: least_settling(0.02)?,
            iae_n_s: with_least_iae.iae_n_s,
        },
        least_contact_n: contact.forces(&best).into_iter().fold(f64::INFINITY, f64::min),
        with_least_iae,
    })
}

/// A bound is known for a force pressed on a point of an object at rest, found by contact.
fn check(scenario: &Scenario) -> Result<(), BoundError> {
    let (task, object) = (&scenario.task, &scenario.object);
    let moves = object.velocity_m_per_s.iter().chain(&object.swing_amplitude_m);
    let moves = moves.copied().fold(0.0, |most: f64, v| most.max(v.abs()));
    let dofs = task.force_controlled.dofs();
    let conditions = [
        (
            task.kind == TaskKind::Press,
            "task.kind",
            format!("{:?}", task.kind),
            "press",
        ),
        (
            dofs == [false, false, true, false, false, false],
            "task.force_controlled",
            format!("{dofs:?}"),
            "z alone",
        ),
        (
            scenario.controller.expected.from == ExpectedFrom::Nothing,
            "controller.expected.from",
            format!("{:?}", scenario.controller.expected.from),
            "nothing",
        ),
        (
            moves == 0.0 && object.profile_time_s.is_empty(),
            "[object]",
            format!("an object that moves ({moves})"),
            "an object at rest",
        ),
        (
            object.support_n_per_m == 0.0,
            "object.support_n_per_m",
            object.support_n_per_m.to_string(),
            "0",
        ),
    ];
    match conditions.into_iter().find(|(holds, ..)| !holds) {
        None => Ok(()),
        Some((_, key, value, known)) => Err(BoundError::Unknown { key, value, known }),
    }
}

/// From the contact to the first effect, if the `free` force ever exceeds the threshold: through the sensor's low pass,
/// with half a tick to the next sample and half of what remains of T to the cycle that takes it.
fn delay(scenario: &Scenario, free: &[f64]) -> Option<Delay> {
    let share = 1.0 - libm::exp(-TAU * scenario.sensor.bandwidth_hz * STEP_S);
    let mut passed = 0.0;
    let exceeds = free.iter().position(|force| {
        passed += share * (force - passed);
        passed >= scenario.controller.detection_threshold_n
    })?;
    let period = scenario.timing.command_period_ticks;
    Some(Delay {
        detection_s: exceeds as f64 * STEP_S + 0.5 * TICK_S,
        sensor_s: scenario.sensor.delay_ticks as f64 * TICK_S,
        cycle_s: 0.5 * (period - 1) as f64 * TICK_S,
        command_s: (scenario.robot.command_delay_periods * period) as f64 * TICK_S,
    })
}

/// The first tick from which on the error can stay within `band` (N), as a time in s, by bisection: what is possible from
/// a tick on is possible from every later one on.
fn least_settling(programme: &Programme, band: f64, acts: usize) -> Result<f64, SolverStatus> {
    // A solution is known to some digits only.
    let possible = |from: usize| Ok(programme.least_error(from)? <= band * (1.0 + 1e-4));
    let (mut before, mut from) = (acts.saturating_sub(1), programme.free.len() - 1);
    if !possible(from)? {
        return Ok(f64::NAN);
    }
    while from - before > 1 {
        let middle = before.midpoint(from);
        if possible(middle)? {
            from = middle;
        } else {
            before = middle;
        }
    }
    Ok(from as f64 * TICK_S)
}

fn figures(forces: &[f64], desired: f64) -> Figures {
    let error = |force: &f64| (force - desired).abs();
    let settled = |band: f64| match forces.iter().rposition(|force| error(force) > band * desired) {
        None => 0.0,
        Some(last) if last + 1 == forces.len() => f64::NAN,
        Some(last) => (last + 1) as f64 * TICK_S,
    };
    Figures {
        peak_n: forces.iter().copied().fold(0.0, f64::max),
        settling_10_s: settled(0.10),
        settling_2_s: settled(0.02),
        iae_n_s: forces.iter().map(error).sum::<f64>() * TICK_S,
    }
}
