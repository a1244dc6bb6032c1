//! Where links, motors and object are, from the motors' way and the sensor's deflection: one hypothesis of the modes.

use super::MODES;
use super::plant::{ACCELERATION, DEVIATION, MODAL, POSITION, Plant, RATE, SPEED, State};
use crate::contact::Waypoint;
use nalgebra::{SMatrix, SVector};
use node::scenario;
use spatial::TICK_S;

/// Modes and object.
pub const ESTIMATED: usize = MODAL + 1;
/// How well the object and the modes are known at the first contact, m: as far as the tool swings in free motion.
const OBJECT_AT_FIRST_M: f64 = 2e-4;
const MODE_AT_FIRST_M: f64 = 3e-5;
/// How far the object's estimate wanders in a tick, m.
const OBJECT_WANDERS_M: f64 = 1e-8;
/// How much of an error the observer of the motors takes away in a tick, of their way and of their speed.
pub const MOTOR_GAINS: [f64; 2] = [0.6, 0.2];

/// What one sample says along the normal.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Reading {
    /// How far the sensor has yielded, m.
    pub deflection: f64,
    /// Where the motors are, as the tcp that hangs from them, m.
    pub motors: f64,
    /// Whether the tool touches the object.
    pub touches: bool,
}

/// A Kalman filter for modes and object, and an observer of the motors' deviations from their command filters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Observer {
    /// All states, relative to the object.
    state: State,
    /// The object's coordinate, m.
    object: f64,
    /// Of modes and object, as coordinates that do not move with the object.
    covariance: SMatrix<f64, ESTIMATED, ESTIMATED>,
    /// Of all readings so far, the older ones forgotten.
    log_likelihood: f64,
}

impl Observer {
    /// At the first contact, with the motors where the command filters are, at `filter`, links and tool moving along.
    pub fn new(plant: &Plant, filter: &Waypoint) -> Self {
        let mut observer = Self {
            state: State::zeros(),
            object: filter.position,
            covariance: SMatrix::zeros(),
            log_likelihood: 0.0,
        };
        for i in 0..MODES {
            let (at, rate) = (2 * i, 2 * i + 1);
            observer.state[rate] = plant.rest[at] * filter.rate;
            let swing = MODE_AT_FIRST_M * plant.rest[at];
            let speed = swing * plant.frequencies[i];
            observer.covariance[(at, at)] = swing * swing;
            observer.covariance[(rate, rate)] = speed * speed;
        }
        observer.covariance[(MODAL, MODAL)] = OBJECT_AT_FIRST_M * OBJECT_AT_FIRST_M;
        observer.place(filter);
        observer
    }

    /// One tick on, to where `reading` says and the command filters are at `filter`.
    pub fn take(
        &mut self,
        plant: &Plant,
        parameters: &scenario::ElasticLaw,
        reading: &Reading,
        filter: &Waypoint,
    ) {
        self.state = plant.after_a_tick(&self.state);
        self.place(filter);
        self.spread(plant, parameters);

        let yielded: f64 = (0..6)
            .map(|axis| plant.tcp_per_axis[axis] * self.state[DEVIATION + axis])
            .sum();
        let error = reading.motors - filter.position - yielded;
        for axis in 0..6 {
            let missed = plant.axes_per_tcp[axis] * error;
            self.state[DEVIATION + axis] += MOTOR_GAINS[0] * missed;
            self.state[RATE + axis] += MOTOR_GAINS[1] * missed / TICK_S;
        }
        if reading.touches {
            self.correct(plant, parameters.deflection_noise_m, reading.deflection);
            self.place(filter);
        }
    }

    /// What an error of the deflection corrects of modes and object after `ticks` of contact, m per m (of rates: 1/s).
    pub fn gain_after(
        plant: &Plant,
        parameters: &scenario::ElasticLaw,
        ticks: usize,
    ) -> SVector<f64, ESTIMATED> {
        let mut observer = Self::new(plant, &Waypoint::default());
        let mut gain = SVector::zeros();
        for _ in 0..ticks {
            observer.spread(plant, parameters);
            let (shared, variance) = observer.gain(plant, parameters.deflection_noise_m);
            gain = shared / variance;
        }
        gain
    }

    /// Kalman's gain for the deflection with this `noise` (m) times the variance of its prediction, and that variance,
    /// m^2; the covariance is that of afterwards.
    fn gain(&mut self, plant: &Plant, noise: f64) -> (SVector<f64, ESTIMATED>, f64) {
        let mut seen = SVector::<f64, ESTIMATED>::zeros();
        for i in 0..MODES {
            seen[2 * i] = 1.0;
        }
        seen[MODAL] = -plant.share();
        let shared = self.covariance * seen;
        let variance = seen.dot(&shared) + noise * noise;
        self.covariance -= shared * shared.transpose() / variance;
        (shared, variance)
    }

    /// Kalman's correction by the deflection that is measured, m.
    fn correct(&mut self, plant: &Plant, noise: f64, deflection: f64) {
        let error = deflection - plant.deflection(&self.state);
        let (shared, variance) = self.gain(plant, noise);
        let correction = shared * (error / variance);
        self.object += correction[MODAL];
        for i in 0..MODAL {
            self.state[i] += correction[i] - plant.rest[i] * correction[MODAL];
        }
        self.log_likelihood -= 0.5 * (error * error / variance + libm::log(variance / (noise * noise)));
    }

    /// Covariance over a tick.
    fn spread(&mut self, plant: &Plant, parameters: &scenario::ElasticLaw) {
        let mut transition = SMatrix::<f64, ESTIMATED, ESTIMATED>::identity();
        transition
            .fixed_view_mut::<MODAL, MODAL>(0, 0)
            .copy_from(&plant.tick.fixed_view::<MODAL, MODAL>(0, 0));
        self.covariance = transition * self.covariance * transition.transpose();
        self.log_likelihood *= parameters.likelihood_memory;
        for i in 0..MODES {
            let unknown = parameters.unknown_acceleration_m_per_s2 * TICK_S * plant.rest[2 * i];
            self.covariance[(2 * i + 1, 2 * i + 1)] += unknown * unknown;
        }
        self.covariance[(MODAL, MODAL)] += OBJECT_WANDERS_M * OBJECT_WANDERS_M;
    }

    /// The command filters' part of the state.
    fn place(&mut self, filter: &Waypoint) {
        place(&mut self.state, filter, self.object);
    }

    /// All states of the plant, relative to the object.
    pub fn state(&self) -> State {
        self.state
    }

    /// Where the object is, m.
    pub fn object(&self) -> f64 {
        self.object
    }

    /// How well the readings agree with this hypothesis.
    pub fn log_likelihood(&self) -> f64 {
        self.log_likelihood
    }
}

/// The command filters' part of a `state` relative to the `object` (m).
pub fn place(state: &mut State, filter: &Waypoint, object: f64) {
    state[POSITION] = filter.position - object;
    state[SPEED] = filter.rate;
    state[ACCELERATION] = filter.change;
}
