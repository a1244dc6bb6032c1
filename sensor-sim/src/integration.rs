//! How the tool gets from tick to tick: in long exponential steps while its contacts are smooth, halved around each
//! kink of the contacts' laws down to short Runge-Kutta steps, which take it as it comes.

use crate::contacts::Moment;
use crate::exponential::{self, Place, Vector};
use crate::signal::{SignalChain, Weights};
use crate::smooth::Smooth;
use crate::tool::{Instant, Rates, State, Work};
use crate::{FirstContact, SensorSim, reading};
use node::scenario;
use spatial::{Motion, MotionSegment, TICK_S};

/// The lengths that steps have: the longest, its half, its quarter, ...
#[derive(Clone, Debug)]
pub(crate) struct Steps {
    per_tick: usize,
    /// Length (s) and low pass of each.
    levels: Vec<(f64, Weights)>,
}

impl Steps {
    /// Those of a scenario: from smooth_step_s on, halved until at most integration_step_s.
    pub(crate) fn new(sensor: &scenario::Sensor, chain: &SignalChain) -> Self {
        let per_tick = libm::rint(TICK_S / sensor.smooth_step_s).max(1.0);
        let mut lengths = vec![TICK_S / per_tick];
        // Not halved for the sake of rounding.
        while lengths[lengths.len() - 1] > sensor.integration_step_s * (1.0 + 1e-9) {
            lengths.push(0.5 * lengths[lengths.len() - 1]);
        }
        Self {
            per_tick: per_tick as usize,
            levels: lengths.iter().map(|&step| (step, chain.weights(step))).collect(),
        }
    }

    pub(crate) fn smooth(&self) -> Smooth {
        Smooth::new(self.levels[0].0, self.levels.len())
    }
}

/// The way that link and object go within one tick.
struct Way {
    segment: MotionSegment,
    start_s: f64,
}

impl SensorSim {
    /// From tick `start_tick` to the next one, where the link is at `end`.
    pub(crate) fn integrate(&mut self, start_tick: i64, end: &Motion) {
        let way = Way {
            segment: MotionSegment::new(self.now.link, *end, TICK_S),
            start_s: start_tick as f64 * TICK_S,
        };
        for i in 0..self.steps.per_tick {
            self.cover(&way, i as f64 * self.steps.levels[0].0, 0);
        }
    }

    /// One step of `level` from `time` s after the tick, or its halves.
    fn cover(&mut self, way: &Way, time: f64, level: usize) {
        if level + 1 == self.steps.levels.len() {
            self.step(way, time, level);
        } else if !self.stride(way, time, level) {
            let half = self.steps.levels[level + 1].0;
            self.cover(way, time, level + 1);
            self.cover(way, time + half, level + 1);
        }
    }

    /// A Runge-Kutta step. What the contacts remember is frozen within it.
    fn step(&mut self, way: &Way, time: f64, level: usize) {
        let length = self.steps.levels[level].0;
        let (middle, end) = (
            self.instant(way, time + 0.5 * length),
            self.instant(way, time + length),
        );
        let instants = [&self.now, &middle, &end];
        let (state, work) = self.body.integrate(&self.state, instants, &self.contacts, length);
        self.state = state;
        self.now = end;
        self.rates = None;
        self.work.add(&work);

        let before = self.indentation_m;
        let h = self.contacts.remember(&self.state, &self.now.base);
        self.indentation_m = h;
        if h > 0.0 {
            let force = self.contact_force(&self.now.base).norm();
            self.contact_force_peak_n = self.contact_force_peak_n.max(force);
            self.first_contact.get_or_insert_with(|| FirstContact {
                time_s: way.start_s + time + length * (-before / (h - before)),
                speed_m_per_s: (h - before) / length,
            });
        }
        self.feel(None, level);
    }

    /// An exponential step, unless a contact is not smooth or does not stay so.
    fn stride(&mut self, way: &Way, time: f64, level: usize) -> bool {
        let Some(pieces) = self.contacts.pieces(&self.state, &self.now.base) else {
            return false;
        };
        let length = self.steps.levels[level].0;
        let (middle, end) = (
            self.instant(way, time + 0.5 * length),
            self.instant(way, time + length),
        );
        if !self.clear_of_stops(&self.state, &self.now, length) {
            return false;
        }
        let rates = self.rates();
        let (body, contacts) = (&self.body, &self.contacts);
        let linear = self.smooth.about(body, contacts, &self.state, &pieces);
        let known = |state: &State, at: &Instant| body.rates_on(Some(&pieces), state, at, contacts);
        let (mut halfway, mut middles) = (Vector::zeros(), [rates; 2]);
        let start = rates.of_change(&self.state.angular_velocity, &Default::default());
        let phi = [&linear.levels[level], &linear.levels[level + 1]];
        let change = exponential::step(&linear.operator, phi, &start, |change, place| {
            let state = self.state.changed(change);
            let at = if place == Place::Middle { &middle } else { &end };
            let rates = known(&state, at);
            if place == Place::Middle {
                halfway += change * 0.5;
                middles = [middles[1], rates];
            }
            let turn = change.fixed_rows::<3>(3).into_owned();
            rates.of_change(&state.angular_velocity, &turn)
        });
        let state = self.state.changed(&change);
        let end_rates = known(&state, &end);
        let before = Moment {
            state: &self.state,
            rates: &rates,
            base: &self.now.base,
        };
        let after = Moment {
            state: &state,
            rates: &end_rates,
            base: &end.base,
        };
        let Some(pressing) = contacts.stayed(&pieces, [&before, &after], &linear.swings, length) else {
            return false;
        };
        if !self.clear_of_stops(&state, &end, length) {
            return false;
        }
        let halfway = self.state.changed(&halfway);
        let felt = reading(&self.body, &halfway, &middle.link, self.wrench_measured);
        self.work.add(&work(
            &Rates::mean(&rates, &middles[0], &middles[1], &end_rates),
            length,
        ));
        self.work.on_object += pressing.stored_j;
        self.contact_force_peak_n = self.contact_force_peak_n.max(pressing.largest_force_n);
        self.state = state;
        self.now = end;
        self.rates = Some(end_rates);
        self.indentation_m = self.contacts.remember(&self.state, &self.now.base);
        self.feel(Some(&felt), level);
        true
    }

    /// How the state changes now.
    pub(crate) fn rates(&mut self) -> Rates {
        *self
            .rates
            .get_or_insert_with(|| self.body.rates(&self.state, &self.now, &self.contacts))
    }

    /// Whether the sensor keeps away from its end stops for `time` s at its present speed.
    fn clear_of_stops(&self, state: &State, at: &Instant, time: f64) -> bool {
        let plate = self.body.plate(state);
        self.body.suspension.clear_of_stops(&at.link, &plate, time)
    }

    fn instant(&self, way: &Way, time: f64) -> Instant {
        Instant {
            link: way.segment.at(time),
            base: self.contacts.object().base(way.start_s + time),
        }
    }

    fn feel(&mut self, halfway: Option<&crate::signal::Reading>, level: usize) {
        let felt = reading(&self.body, &self.state, &self.now.link, self.wrench_measured);
        self.chain.follow(halfway, &felt, &self.steps.levels[level].1);
    }
}

/// What `mean` powers do within `time` s, without what the contacts' springs store.
fn work(mean: &Rates, time: f64) -> Work {
    Work {
        on_object: mean.work.on_object - mean.indenting_power,
        ..mean.work
    }
    .over(time)
}
