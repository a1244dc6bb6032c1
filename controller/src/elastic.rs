//! The object-model law for robots with elastic gears: the links are brought to where the desired force results.
//!
//! Paper VI names the gears' compliance as an open problem: encoders see the motors, (12) takes them for the links, and a
//! fast law makes the links swing. In contact, though, the deflection tells where the links are: the tool stands on an
//! object that does not move, so that what the sensor yields is what the links have moved. So:
//!
//! 1. [`flexibility`]: links on gears and tool on sensor as modes, seen from motors and sensor, along the normal.
//! 2. [`observer`]: a Kalman filter finds modes and object from encoders and deflection, sample by sample at the time of
//!    its truth.
//! 3. The plant is predicted to the instant at which the next set-point begins to act, with the commands that are on
//!    their way.
//! 4. [`regulator`]: linear-quadratic feedback of all states chooses how the acceleration of the command filters
//!    changes. Its goal is (2): the deflection `C f_d`.
//! 5. What is not known well is the gears' frequency. Several hypotheses run side by side; each is believed as much as
//!    its predictions of the deflection were right (multiple-model adaptive estimation, Magill, IEEE Trans. Autom.
//!    Control 10 (1965) 434), and the set-point is the mean of theirs.
//!
//! Deviates: (12) is not used along this degree of freedom; the observer's object takes its place, which the gears'
//! compliance does not shift.

pub mod course;
pub mod flexibility;
pub mod observer;
pub mod plant;
pub mod regulator;

use crate::contact::{Aim, ContactSample, PREVIEW, Situation, Touch, Waypoint};
use crate::structure::Structure;
use course::Course;
use flexibility::Flexibility;
use node::scenario::{self, Gears, Scenario};
use observer::{Observer, Reading, place};
use plant::{Plant, State};
use spatial::TICK_S;
use spatial::kinematics::Axes;
use std::f64::consts::TAU;
use std::sync::Arc;

/// Modes that are modelled; the others are taken as rigid.
pub const MODES: usize = 3;
/// Hypotheses of the gears' frequency.
pub const HYPOTHESES: usize = 5;

/// The longest sensor delay, and eleven of the longest periods until a command acts, ticks.
const LONGEST_WAY: usize = 100 + 11 * 12;

/// What is computed before anything runs.
#[derive(Clone, Debug, PartialEq)]
pub struct Design {
    parameters: scenario::ElasticLaw,
    plants: [Plant; HYPOTHESES],
    /// The largest acceleration along the normal, m/s^2.
    acceleration_limit: f64,
    period_s: f64,
}

impl Design {
    /// Where the task begins; `None` if what is assumed can't be regulated.
    pub fn new(scenario: &Scenario) -> Option<Self> {
        let controller = &scenario.controller;
        let parameters = controller.elastic.clone();
        let axes = scenario.start_axes().ok()?;
        let kinematics = scenario.robot.kinematics();
        let structure = Structure::new(controller, &kinematics, &axes, Gears::Elastic);
        let plant = |i: usize| {
            let off = 2.0 * i as f64 / (HYPOTHESES - 1) as f64 - 1.0;
            let scaled = structure.scaled(1.0 + off * parameters.mode_spread);
            let flexibility = Flexibility::new(controller, &scaled)?;
            let (servo, ticks) = (&controller.servo, scenario.timing.command_period_ticks);
            Plant::new(&flexibility, servo, ticks, &parameters)
        };
        let plants = [plant(0)?, plant(1)?, plant(2)?, plant(3)?, plant(4)?];
        let limits = Axes::from(controller.acceleration_limit_rad_per_s2);
        let per_metre = plants[0].axes_per_tcp;
        let acceleration_limit = (0..6)
            .map(|i| limits[i] / per_metre[i].abs().max(1e-9))
            .fold(f64::INFINITY, f64::min);
        Some(Self {
            plants,
            parameters,
            acceleration_limit,
            period_s: scenario.timing.command_period_ticks as f64 * TICK_S,
        })
    }

    /// The hypothesis that is nearest to gears `ratio` times as fast as they are assumed.
    pub fn nearest(&self, ratio: f64) -> &Plant {
        let spread = self.parameters.mode_spread;
        let off = if spread > 0.0 { (ratio - 1.0) / spread } else { 0.0 };
        let last = (HYPOTHESES - 1) as f64;
        &self.plants[libm::rint(0.5 * last * (1.0 + off)).clamp(0.0, last) as usize]
    }
}

/// The law along the normal.
#[derive(Clone, Debug, PartialEq)]
pub struct Elastic {
    design: Arc<Design>,
    observers: Option<[Observer; HYPOTHESES]>,
    course: Course,
    /// When the newest sample was true (s), and where the motors were then (m).
    newest: Option<(f64, f64)>,
    /// Whether the tool touched the object in the newest sample.
    touches: bool,
    /// How long the deflection still has to stay in the range before the regulator acts, s: a swing of the slowest mode
    /// after the deflection has left it.
    waits_s: f64,
    /// Whether the regulator acts.
    regulated: bool,
    motion: [Waypoint; PREVIEW],
}

impl Elastic {
    /// Nothing known of the object.
    pub fn new(design: Arc<Design>) -> Self {
        Self {
            design,
            observers: None,
            course: Course::default(),
            newest: None,
            touches: false,
            waits_s: 0.0,
            regulated: false,
            motion: [Waypoint::default(); PREVIEW],
        }
    }

    /// The command filters will be at `waypoint` at `time_s` (s), when the next set-point begins to act.
    pub fn track(&mut self, time_s: f64, waypoint: Waypoint) {
        self.course.push(time_s, waypoint);
    }

    /// Take one sample in contact, in the order of sampling.
    pub fn take(&mut self, sample: &ContactSample) {
        let reading = Reading {
            deflection: sample.object - sample.actual,
            motors: sample.actual,
            touches: sample.touch == Touch::Contact,
        };
        self.touches = reading.touches;
        let begins = self.observers.is_none() || sample.touch == Touch::Lost;
        let Some((time_s, motors)) = self.newest.filter(|_| !begins) else {
            let filter = self.course.at(sample.time_s);
            self.observers = Some(
                self.design
                    .plants
                    .each_ref()
                    .map(|plant| Observer::new(plant, &filter)),
            );
            self.newest = Some((sample.time_s, sample.actual));
            return;
        };
        let ticks = libm::round((sample.time_s - time_s) / TICK_S).clamp(0.0, 100.0) as i64;
        let Some(observers) = &mut self.observers else {
            return;
        };
        for tick in 1..=ticks {
            let last = tick == ticks;
            let time_s = sample.time_s - (ticks - tick) as f64 * TICK_S;
            let now = Reading {
                motors: motors + (sample.actual - motors) * (tick as f64 / ticks as f64),
                touches: last && reading.touches,
                ..reading
            };
            let filter = self.course.at(time_s);
            for (observer, plant) in observers.iter_mut().zip(&self.design.plants) {
                observer.take(plant, &self.design.parameters, &now, &filter);
            }
        }
        self.newest = Some((sample.time_s, sample.actual));
    }

    /// Where the command filters are to be at the coming instants, T apart.
    pub fn desired(&mut self, aim: &Aim, situation: &Situation) -> [f64; PREVIEW] {
        let (Some(observers), Some((time_s, _))) = (&self.observers, self.newest) else {
            return [situation.desired; PREVIEW];
        };
        let weights = weights(observers);
        let (acts_s, mut waypoint) = self.course.newest();
        let ticks = libm::round((acts_s - time_s) / TICK_S).clamp(0.0, LONGEST_WAY as f64) as usize;
        let mut way = [Waypoint::default(); LONGEST_WAY];
        for (tick, waypoint) in (1..=ticks).zip(&mut way) {
            *waypoint = self.course.at(time_s + tick as f64 * TICK_S);
        }
        let mut states: [State; HYPOTHESES] = std::array::from_fn(|i| {
            let object = observers[i].object();
            let mut state = observers[i].state();
            for waypoint in &way[..ticks] {
                state = self.design.plants[i].after_a_tick(&state);
                place(&mut state, waypoint, object);
            }
            state
        });
        let period = self.design.period_s;
        // How far the deflection is from what is desired, in the mean of the hypotheses.
        let off: f64 = (0..HYPOTHESES)
            .map(|i| weights[i] * (self.design.plants[i].deflection(&states[i]) - aim.displacement))
            .sum();
        let parameters = &self.design.parameters;
        let [linear, governed] = [parameters.linear_range, parameters.governed_range]
            .map(|multiple| multiple * libm::fabs(aim.displacement));
        self.waits_s = match self.touches && libm::fabs(off) <= governed {
            true => (self.waits_s - self.design.period_s).max(0.0),
            false => TAU / self.design.plants[0].frequencies[0],
        };
        self.regulated = self.waits_s == 0.0;
        if !self.regulated {
            return [self.resting_place(aim, &weights); PREVIEW];
        }
        // What is further off than a linear regulator may see is approached by a goal that goes ahead of it.
        let goal_m = aim.displacement + off - off.clamp(-linear, linear);
        for motion in &mut self.motion {
            let mut change = 0.0;
            for ((plant, state), weight) in self.design.plants.iter().zip(&states).zip(weights) {
                let goal = plant.rest * (goal_m / plant.share());
                change -= weight * (plant.gain * (state - goal))[0];
            }
            let before = waypoint;
            let limit = self.design.acceleration_limit;
            let after = (before.change + change).clamp(-limit, limit);
            waypoint = Waypoint {
                position: before.position
                    + period * (before.rate + period * (2.0 * before.change + after) / 6.0),
                rate: before.rate + period * 0.5 * (before.change + after),
                change: after,
            };
            for ((plant, state), observer) in self.design.plants.iter().zip(&mut states).zip(observers) {
                *state = plant.after_a_period(state, after - before.change);
                place(state, &waypoint, observer.object());
            }
            *motion = waypoint;
        }
        self.motion.map(|waypoint| waypoint.position)
    }

    /// Paper (2): where the motors rest when the desired force results.
    fn resting_place(&self, aim: &Aim, weights: &[f64; HYPOTHESES]) -> f64 {
        let observers = self.observers.iter().flatten();
        let places = observers.zip(&self.design.plants).zip(weights);
        places
            .map(|((observer, plant), weight)| {
                weight * (observer.object() + aim.displacement / plant.share())
            })
            .sum()
    }

    /// The motion that [`Elastic::desired`] asked for last, T apart.
    pub fn motion(&self) -> Option<&[Waypoint; PREVIEW]> {
        self.regulated.then_some(&self.motion)
    }

    /// The object's coordinate and its rate.
    pub fn object(&self) -> Option<(f64, f64)> {
        let observers = self.observers.as_ref()?;
        let object = observers
            .iter()
            .zip(weights(observers))
            .map(|(observer, weight)| weight * observer.object())
            .sum();
        Some((object, 0.0))
    }
}

/// How much each hypothesis is believed; their sum is 1.
fn weights(observers: &[Observer; HYPOTHESES]) -> [f64; HYPOTHESES] {
    let best = observers
        .iter()
        .map(Observer::log_likelihood)
        .fold(f64::NEG_INFINITY, f64::max);
    let weights = observers
        .each_ref()
        .map(|observer| libm::exp(observer.log_likelihood() - best));
    let sum: f64 = weights.iter().sum();
    weights.map(|weight| weight / sum)
}

#[cfg(test)]
mod tests;
