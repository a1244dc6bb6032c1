//! The tool on its sensor, and its contact, integrated here and by MuJoCo: how fast at equal accuracy.
//!
//! The link stands still and the object swings against the tool, which it touches, bounces on, presses and leaves. Both know the
//! same equations: MuJoCo has the sensor's springs and dampers as those of joints, and the contact as a tendon that is slack above
//! the surface (`mujoco/tool.py`), which is exact and cheaper than its solver for contacts. The contact is elastic, since
//! MuJoCo's has no memory.

mod rival;

pub use rival::MujocoError;

use crate::cost::{self, median};
use nalgebra::Vector3;
use node::scenario::{Scenario, ScenarioError};
use rival::Rival;
use sensor_sim::SensorSim;
use sensor_sim::tool::{Body, State};
use serde::Serialize;
use spatial::ports::{LinkMotion, Role, Stamp};
use spatial::{Motion, Pose, TICK_S};
use std::path::Path;

/// MuJoCo's integrators, by its own names.
const INTEGRATORS: [&str; 3] = ["Euler", "implicitfast", "RK4"];
/// How far the object swings, m, and how often, Hz: it touches the tool at 20 mm/s.
const SWING_M: f64 = 1e-3;
const SWING_HZ: f64 = 3.183;
/// Where in its swing the object begins, rad: 0 is where it touches the tool. Several runs, since the error of a single one
/// depends on where within a step the contacts fall.
const PHASES_RAD: [f64; 4] = [-1.0, -0.9, -0.8, -0.7];
/// Ticks of each run: three swings.
const TICKS: usize = 1000;
/// MuJoCo's shortest step is a tick divided by this.
const MOST_STEPS_PER_TICK: usize = 4096;
/// The reference's steps, s: while the contact is smooth, and around its kinks at most.
const FINE_S: [f64; 2] = [1e-5, 1e-6];

/// What one method does.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// `touchdown` or an integrator of MuJoCo's.
    pub method: String,
    /// Its step, s; touchdown's around kinks.
    pub step_s: f64,
    /// Its error, m: how far the tcp is from where the reference has it, rms over all ticks.
    pub error_m: f64,
    /// Simulated time in a second of one core, s: the median of all repetitions.
    pub simulated_s_per_core_s: f64,
    /// How many times as long touchdown simulates.
    pub touchdown_ratio: f64,
}

/// The tool of a scenario, and an object that swings.
struct Problem {
    /// One for each phase.
    scenarios: Vec<Scenario>,
    body: Body,
    start: State,
}

/// Where the tcp is after each tick, m in r.
type Trace = Vec<Vector3<f64>>;

/// Integrate the tool of `scenario` here, with its steps, and by each integrator of the MuJoCo that `python` has, with the
/// longest of steps that are shortened by a factor of sqrt(2) at which that errs no more; time both `repetitions` times, in turns.
pub fn compare(python: &Path, scenario: &Scenario, repetitions: u16) -> Result<Vec<Row>, MujocoError> {
    let problem = Problem::new(scenario)?;
    let sensor = &scenario.sensor;
    let steps = [sensor.smooth_step_s, sensor.integration_step_s];
    let fine = problem.traces(FINE_S);
    let error_m = distance(&problem.traces(steps), &fine);
    let mut rivals = problem.rivals(python)?;
    let found = INTEGRATORS.map(|integrator| equal(&mut rivals, integrator, &fine, error_m));
    let mut rows = vec![("touchdown".to_owned(), sensor.integration_step_s, error_m)];
    let mut steps_per_tick = Vec::new();
    for (integrator, found) in INTEGRATORS.iter().zip(found) {
        let (steps, error_m) = found?;
        rows.push((format!("MuJoCo {integrator}"), TICK_S / steps as f64, error_m));
        steps_per_tick.push((*integrator, steps));
    }
    let mut rates = vec![Vec::new(); rows.len()];
    let simulated_s = (TICKS * PHASES_RAD.len()) as f64 * TICK_S;
    for _ in 0..repetitions {
        let own = cost::ticks_per_core_s(1, 1, || {
            problem.traces(steps);
        });
        rates[0].push(own[0] * simulated_s);
        for (rates, (integrator, steps)) in rates[1..].iter_mut().zip(&steps_per_tick) {
            let mut core_s = 0.0;
            for rival in &mut rivals {
                core_s += rival.core_s(integrator, *steps, TICKS)?;
            }
            rates.push(simulated_s / core_s);
        }
    }
    for rates in &mut rates {
        rates.sort_by(f64::total_cmp);
    }
    let rates: Vec<f64> = rates.iter().map(|rates| median(rates)).collect();
    let row = |((method, step_s, error_m), rate): ((String, f64, f64), &f64)| Row {
        method,
        step_s,
        error_m,
        simulated_s_per_core_s: *rate,
        touchdown_ratio: rates[0] / rate,
    };
    Ok(rows.into_iter().zip(&rates).map(row).collect())
}

/// The steps in a tick with which `integrator` errs by at most `wanted_m`, and by how much it does.
fn equal(
    rivals: &mut [Rival],
    integrator: &'static str,
    fine: &[Trace],
    wanted_m: f64,
) -> Result<(usize, f64), MujocoError> {
    let (mut steps, mut error_m) = (0, f64::INFINITY);
    for halves in 4.. {
        let next = libm::rint(libm::exp2(0.5 * f64::from(halves))) as usize;
        if next > MOST_STEPS_PER_TICK {
            break;
        }
        let traces = rivals
            .iter_mut()
            .map(|rival| rival.trace(integrator, next, TICKS));
        let traces = traces.collect::<Result<Vec<_>, _>>()?;
        (steps, error_m) = (next, distance(&traces, fine));
        if error_m <= wanted_m {
            return Ok((steps, error_m));
        }
    }
    Err(MujocoError::Coarse {
        integrator,
        step_s: TICK_S / steps as f64,
        error_m,
        wanted_m,
    })
}

/// How far apart `some` and `others` are, rms, m; NaN: they are not of the same ticks.
fn distance(some: &[Trace], others: &[Trace]) -> f64 {
    let pairs = || some.iter().flatten().zip(others.iter().flatten());
    if some.iter().map(Vec::len).ne(others.iter().map(Vec::len)) {
        return f64::NAN;
    }
    let sum: f64 = pairs().map(|(one, other)| (one - other).norm_squared()).sum();
    (sum / pairs().count() as f64).sqrt()
}

impl Problem {
    fn new(scenario: &Scenario) -> Result<Self, ScenarioError> {
        let body = Body::new(&scenario.tool, &scenario.sensor);
        let start = body.hanging(&Pose::identity());
        let (tcp, _) = body.tcp_motion(&start);
        let swinging = |phase: f64| {
            scenario.with(&[
                format!("object.height_m={:?}", tcp.translation.z),
                format!("object.swing_amplitude_m=[0.0, 0.0, {SWING_M:?}]"),
                format!("object.swing_frequency_hz={SWING_HZ:?}"),
                format!("object.swing_phase_rad={phase:?}"),
                "object.rebound_ratio=1.0".to_owned(),
            ])
        };
        Ok(Self {
            scenarios: PHASES_RAD.map(swinging).into_iter().collect::<Result<_, _>>()?,
            body,
            start,
        })
    }

    fn rivals(&self, python: &Path) -> Result<Vec<Rival>, MujocoError> {
        let start = |scenario| Rival::start(python, &rival::model(&self.body, &self.start, scenario));
        self.scenarios.iter().map(start).collect()
    }

    /// In steps of `smooth_s` and, around kinks, at most `kink_s`.
    fn traces(&self, [smooth_s, kink_s]: [f64; 2]) -> Vec<Trace> {
        let trace = |scenario: &Scenario| {
            let mut scenario = scenario.clone();
            scenario.sensor.smooth_step_s = smooth_s;
            scenario.sensor.integration_step_s = kink_s;
            let mut sensor = SensorSim::new(&scenario, &Motion::at_rest(Pose::identity()));
            sensor.advance(&link(0));
            (1..=TICKS)
                .map(|tick| sensor.advance(&link(tick)).truth.tcp_pose.translation.vector)
                .collect()
        };
        self.scenarios.iter().map(trace).collect()
    }
}

/// That stands still.
fn link(tick: usize) -> LinkMotion {
    LinkMotion {
        stamp: Stamp::lockstep(tick as i64, 0, Role::Robot),
        motion: Motion::at_rest(Pose::identity()),
        kinetic_energy_j: 0.0,
        elastic_energy_j: 0.0,
        motor_work_j: 0.0,
        dissipated_energy_j: 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn problem() -> Problem {
        Problem::new(&Scenario::default()).unwrap()
    }

    /// It hangs until the object comes, is pressed up by about 1 mm, and let go again.
    #[test]
    fn the_object_comes_and_goes() {
        let trace = &problem().traces([1e-3, 1e-3])[0];
        let risen = |tick: usize| trace[tick].z - trace[0].z;
        assert!(risen(40).abs() < 1e-9, "{}", risen(40));
        let highest = (0..TICKS).map(risen).fold(0.0, f64::max);
        assert!((0.8e-3..2e-3).contains(&highest), "{highest}");
        assert!((0..TICKS).any(|tick| tick > 200 && risen(tick) < 0.2e-3));
    }

    #[test]
    fn shorter_steps_err_less() {
        let problem = problem();
        let fine = problem.traces([1e-4, 4e-6]);
        let errors = [1e-3, 2e-5].map(|kink| distance(&problem.traces([1e-3, kink]), &fine));
        assert!(errors[1] > 0.0 && errors[1] < 0.1 * errors[0], "{errors:?}");
        assert!(distance(&fine[..1], &fine).is_nan());
    }
}
