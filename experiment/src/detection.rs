//! How well contacts are detected: false alarms per hour in noise and under acceleration, and the delay over the speed of
//! the approach, with the threshold alone and with the cumulative sum beside it.

mod figure;

pub use figure::draw;

use crate::in_process;
use controller::detection::Detector;
use controller::dofs::{NORMAL, Selection, TcpCompliance};
use controller::tare::Tare;
use controller::transform::deflection_at_tcp;
use node::scenario::Scenario;
use rayon::prelude::*;
use sensor_sim::signal::{Reading, SignalChain};
use serde::Serialize;
use spatial::ports::{ControllerPhase, Fault};
use spatial::{Compliance, TICK_S};

/// False alarms in a time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Alarms {
    /// Simulated hours in which there is nothing to be detected.
    pub hours: f64,
    /// Contacts that were none, detected by the threshold alone.
    pub threshold: u64,
    /// By threshold and cumulative sum.
    pub both: u64,
    /// Collisions that were none.
    pub collisions: u64,
}

impl Alarms {
    fn plus(self, other: Self) -> Self {
        Self {
            hours: self.hours + other.hours,
            threshold: self.threshold + other.threshold,
            both: self.both + other.both,
            collisions: self.collisions + other.collisions,
        }
    }
}

/// Detection delays at one speed, s: from the first touch to the sampling of what detected it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Delay {
    /// Speed of the approach, m/s.
    pub speed_m_per_s: f64,
    /// With the threshold alone, mean and longest; `None`: a run without detection, or with a false alarm.
    pub threshold_s: Option<[f64; 2]>,
    /// With the cumulative sum beside it.
    pub both_s: Option<[f64; 2]>,
}

/// Length of a watch in noise after each tare, s: that of a long approach.
const WATCH_S: f64 = 30.0;

/// The scenario with the threshold alone.
fn without_sum(scenario: &Scenario) -> Scenario {
    let mut alone = scenario.clone();
    alone.controller.cusum.enabled = false;
    alone
}

/// False alarms of the noise alone in `hours`, without the plant: the sensor's signal chain, a tare as long as the
/// controller's, and its detectors, every sample. An alarm ends a watch.
pub fn noise(scenario: &Scenario, hours: f64, done: impl Fn() + Sync) -> Alarms {
    let watches = watches(hours);
    (0..watches)
        .into_par_iter()
        .map(|watch| {
            let alarms = noise_watch(scenario, scenario.timing.seed.wrapping_add(watch as i64));
            done();
            alarms
        })
        .reduce(Alarms::default, Alarms::plus)
}

/// How many watches [`noise`] makes of `hours`.
pub fn watches(hours: f64) -> u64 {
    (hours * 3600.0 / WATCH_S).ceil() as u64
}

fn noise_watch(scenario: &Scenario, seed: i64) -> Alarms {
    let controller = &scenario.controller;
    let sensor = node::scenario::Sensor {
        delay_ticks: 0,
        ..scenario.sensor.clone()
    };
    let mut chain = SignalChain::new(&sensor, seed, &Reading::default());
    let d = controller.tcp_in_s_m.into();
    let compliance = Compliance::isotropic(controller.compliance_m_per_n, controller.compliance_rad_per_nm);
    let selection = Selection::new(&scenario.task.force_controlled);
    let along = TcpCompliance::new(&compliance, d, &selection).along(NORMAL);
    let mut normal_m = |tick: i64| {
        let sample = chain.sample(tick)[0];
        (
            deflection_at_tcp(&sample.deflection, d).translation[NORMAL],
            sample,
        )
    };
    let tare_ticks = libm::rint(controller.tare_s / TICK_S) as i64;
    let mut tare = Tare::default();
    let mut zero_m = 0.0;
    for tick in 0..tare_ticks {
        let (normal, sample) = normal_m(tick);
        tare.add(&sample, normal);
        zero_m += normal / tare_ticks as f64;
    }
    let noise_n = tare.noise_m() / along;
    let mut detectors = [
        Detector::of(&without_sum(scenario).controller, noise_n),
        Detector::of(controller, noise_n),
    ];
    let mut counts = [0; 2];
    let ticks = libm::rint(WATCH_S / TICK_S) as i64;
    for tick in tare_ticks..tare_ticks + ticks {
        let force_n = (normal_m(tick).0 - zero_m) / along;
        for (detector, count) in detectors.iter_mut().zip(&mut counts) {
            if detector.take(force_n, true) {
                *count += 1;
                // Look anew.
                detector.take(0.0, false);
            }
        }
    }
    Alarms {
        hours: ticks as f64 * TICK_S / 3600.0,
        threshold: counts[0],
        both: counts[1],
        collisions: 0,
    }
}

/// Speeds of the approaches in [`accelerations`], m/s.
const HARD_SPEEDS_M_PER_S: [f64; 4] = [0.02, 0.05, 0.1, 0.2];

/// The approach through empty space that [`accelerations`] repeats, with the scenario's own ramps: hardly more than
/// acceleration, its ringing and braking.
fn empty_approach(scenario: &Scenario, number: u64) -> Scenario {
    let mut empty = scenario.clone();
    let speed = HARD_SPEEDS_M_PER_S[(number % 4) as usize];
    empty.timing.seed = scenario.timing.seed.wrapping_add(number as i64) & i64::MAX;
    empty.controller.expected.from = node::scenario::ExpectedFrom::Nothing;
    empty.task.approach_speed_m_per_s = speed;
    // Far enough ahead for the fastest one.
    empty.controller.max_lead_m = empty.controller.max_lead_m.max(0.04 * speed);
    let ramp_s = f64::max(0.1, speed / 0.25);
    empty.task.search_depth_m = 0.0;
    empty.task.expected_height_m = empty.task.start_position_m[2] - speed * (ramp_s + 0.5);
    empty.object.height_m = empty.task.expected_height_m - 0.5;
    empty.timing.duration_s = empty.task.standstill_s + 2.0 * ramp_s + 1.0;
    empty
}

/// Approaches that make up `hours`.
pub fn approaches(scenario: &Scenario, hours: f64) -> u64 {
    let all: f64 = (0..4)
        .map(|i| empty_approach(scenario, i).timing.duration_s - scenario.task.standstill_s)
        .sum();
    4 * (hours * 3600.0 / all).ceil() as u64
}

/// False alarms under acceleration in `hours` of approaches through empty space, with the whole plant.
pub fn accelerations(scenario: &Scenario, hours: f64, done: impl Fn() + Sync) -> Alarms {
    (0..approaches(scenario, hours))
        .into_par_iter()
        .map(|number| {
            let empty = empty_approach(scenario, number);
            let [alone, both] = [&without_sum(&empty), &empty].map(first_alarm);
            done();
            Alarms {
                hours: (empty.timing.duration_s - empty.task.standstill_s) / 3600.0,
                threshold: u64::from(alone == Some(Fault::None)),
                both: u64::from(both == Some(Fault::None)),
                collisions: u64::from(both.is_some_and(|fault| fault != Fault::None)),
            }
        })
        .reduce(Alarms::default, Alarms::plus)
}

/// What was taken for a contact (`Fault::None`) or for a collision where there is nothing.
fn first_alarm(scenario: &Scenario) -> Option<Fault> {
    let mut alarm = None;
    in_process::run(scenario, |tick| {
        let Some(answer) = &tick.controller else { return };
        let status = &answer.status;
        if alarm.is_none() && status.phase == ControllerPhase::Contact {
            alarm = Some(Fault::None);
        }
        if alarm.is_none() && !matches!(status.fault, Fault::None | Fault::NoContact) {
            alarm = Some(status.fault);
        }
    });
    alarm
}

/// The delays at `speeds` (m/s), over `phases` contact phases each, with the whole plant.
pub fn delays(scenario: &Scenario, speeds: &[f64], phases: usize, done: impl Fn() + Sync) -> Vec<Delay> {
    let of = |scenario: &Scenario| {
        let variations = crate::compare::variations(scenario, phases, 1);
        let delays: Vec<_> = variations.par_iter().map(delay_s).collect();
        done();
        let delays: Vec<f64> = delays.into_iter().collect::<Option<_>>()?;
        let mean = delays.iter().sum::<f64>() / delays.len().max(1) as f64;
        Some([mean, delays.iter().copied().fold(0.0, f64::max)])
    };
    speeds
        .iter()
        .map(|&speed| {
            let met = met_at(scenario, speed);
            Delay {
                speed_m_per_s: speed,
                threshold_s: of(&without_sum(&met)),
                both_s: of(&met),
            }
        })
        .collect()
}

/// The scenario with an approach at `speed` (m/s) that meets the object after 0.6 s of cruise.
fn met_at(scenario: &Scenario, speed: f64) -> Scenario {
    let mut met = scenario.clone();
    met.controller.expected.from = node::scenario::ExpectedFrom::Nothing;
    met.task.approach_speed_m_per_s = speed;
    let ramp_s = f64::max(0.1, speed / 0.25);
    // 1 mm for the tool's sag.
    let above_m = 1e-3 + speed * (0.5 * ramp_s + 0.6);
    met.task.start_position_m[2] = met.object.height_m + above_m;
    // The end of the search, with its ramp, lies well below.
    met.task.expected_height_m = met.object.height_m - 0.005 - 0.6 * speed * ramp_s;
    met.timing.duration_s = met.task.standstill_s + ramp_s + above_m / speed + 0.3;
    met
}

/// How long after the first touch the sample was taken that detected it, s; `None`: nothing, or a false alarm.
fn delay_s(scenario: &Scenario) -> Option<f64> {
    let (mut touched_s, mut detected_s) = (None, None);
    in_process::run(scenario, |tick| {
        let truth = &tick.sensor.truth;
        if touched_s.is_none() && truth.first_contact_time_s >= 0.0 {
            touched_s = Some(truth.first_contact_time_s);
        }
        let step = tick
            .controller
            .map_or(-1, |answer| answer.status.detection.contact_step);
        if step >= 0 && detected_s.is_none() {
            detected_s = Some(step as f64 * TICK_S);
        }
    });
    let delay = detected_s? - touched_s?;
    (delay >= 0.0).then_some(delay)
}
