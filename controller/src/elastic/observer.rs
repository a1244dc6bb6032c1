//! Where links, motors and object are, from the motors' way and the sensor's deflection: one hypothesis of the modes.

use super::plant::{ACCELERATION, DEVIATION, DEVIATION_RATE, INTEGRAL};
use super::plant::{MODAL, POSITION, Plant, SPEED, State};
use crate::contact::Waypoint;
use nalgebra::{SMatrix, SVector};
use node::scenario;
use spatial::TICK_S;

/// Modes and object.
const ESTIMATED: usize = MODAL + 1;
/// How well the object and the modes are known at the first contact, m: as far as the tool swings in free motion.
const OBJECT_AT_FIRST_M: f64 = 2e-4;
const MODE_AT_FIRST_M: f64 = 3e-5;
/// How far the object's estimate wanders in a tick, m.
const OBJECT_WANDERS_M: f64 = 1e-8;
/// How much of an error the observer of the motors takes away in a tick, of their way and of their speed.
const MOTOR_GAINS: [f64; 2] = [0.6, 0.2];

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

/// A Kalman filter for modes and object, behind motors whose way is measured, and an observer of the motors' deviation
/// from their filters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Observer {
    /// Coordinates and rates of the modes, and the object's coordinate, m and m/s.
    estimate: SVector<f64, ESTIMATED>,
    covariance: SMatrix<f64, ESTIMATED, ESTIMATED>,
    /// y, y' and the integral part of the servo.
    deviation: [f64; 3],
    /// Of all readings so far, the older ones forgotten.
    log_likelihood: f64,
}

impl Observer {
    /// At the first contact, with the motors at `motors` (m) and links and tool moving along at `speed` (m/s).
    pub fn new(plant: &Plant, motors: f64, speed: f64) -> Self {
        let mut estimate = SVector::zeros();
        let mut covariance = SMatrix::zeros();
        for i in (0..MODAL).step_by(2) {
            estimate[i] = motors;
            estimate[i + 1] = speed;
            let rate = MODE_AT_FIRST_M * plant.frequencies[i / 2];
            covariance[(i, i)] = MODE_AT_FIRST_M * MODE_AT_FIRST_M;
            covariance[(i + 1, i + 1)] = rate * rate;
        }
        estimate[MODAL] = motors;
        covariance[(MODAL, MODAL)] = OBJECT_AT_FIRST_M * OBJECT_AT_FIRST_M;
        Self {
            estimate,
            covariance,
            deviation: [0.0; 3],
            log_likelihood: 0.0,
        }
    }

    /// One tick on, in which the motors moved from `before` (m) to where `reading` says; `filter` is where their command
    /// filters are.
    pub fn take(
        &mut self,
        plant: &Plant,
        parameters: &scenario::ElasticLaw,
        before: f64,
        reading: &Reading,
        filter: &Waypoint,
    ) {
        self.follow_motors(plant, reading.motors, filter);
        let modal = self.modal();
        let modal = plant.modal * modal + plant.held * before + plant.ramped * (reading.motors - before);
        self.estimate.fixed_rows_mut::<MODAL>(0).copy_from(&modal);
        self.spread(plant, parameters);
        if !reading.touches {
            return;
        }
        let object = self.object();
        let mut seen = SVector::<f64, ESTIMATED>::zeros();
        seen.fixed_rows_mut::<MODAL>(0).copy_from(&plant.seen.transpose());
        seen[MODAL] = -plant.share();
        let expected = (plant.seen * modal)[0] + plant.rigid_share * reading.motors - plant.share() * object;
        let error = reading.deflection - expected;
        let shared = self.covariance * seen;
        let noise = parameters.deflection_noise_m;
        let variance = seen.dot(&shared) + noise * noise;
        self.estimate += shared * (error / variance);
        self.covariance -= shared * shared.transpose() / variance;
        let likelihood = -0.5 * (error * error / variance + libm::log(variance / (noise * noise)));
        self.log_likelihood = parameters.likelihood_memory * self.log_likelihood + likelihood;
    }

    /// Covariance over a tick.
    fn spread(&mut self, plant: &Plant, parameters: &scenario::ElasticLaw) {
        let mut transition = SMatrix::<f64, ESTIMATED, ESTIMATED>::identity();
        transition
            .fixed_view_mut::<MODAL, MODAL>(0, 0)
            .copy_from(&plant.modal);
        self.covariance = transition * self.covariance * transition.transpose();
        let unknown = parameters.unknown_acceleration_m_per_s2 * TICK_S;
        for i in (1..MODAL).step_by(2) {
            self.covariance[(i, i)] += unknown * unknown;
        }
        self.covariance[(MODAL, MODAL)] += OBJECT_WANDERS_M * OBJECT_WANDERS_M;
    }

    /// The motors' deviation over a tick, as the servo and the gears move it, corrected by what is measured.
    fn follow_motors(&mut self, plant: &Plant, motors: f64, filter: &Waypoint) {
        let ahead = plant.tick * self.state(&before(filter));
        let error = motors - filter.position - ahead[DEVIATION];
        self.deviation = [
            ahead[DEVIATION] + MOTOR_GAINS[0] * error,
            ahead[DEVIATION_RATE] + MOTOR_GAINS[1] * error / TICK_S,
            ahead[INTEGRAL],
        ];
    }

    /// All states of the plant, relative to the object, with the command filter at `filter`.
    pub fn state(&self, filter: &Waypoint) -> State {
        let mut state = State::zeros();
        let object = self.object();
        state.fixed_rows_mut::<MODAL>(0).copy_from(&self.modal());
        for i in (0..MODAL).step_by(2) {
            state[i] -= object;
        }
        [state[DEVIATION], state[DEVIATION_RATE], state[INTEGRAL]] = self.deviation;
        state[POSITION] = filter.position - object;
        state[SPEED] = filter.rate;
        state[ACCELERATION] = filter.change;
        state
    }

    /// Where the object is, m.
    pub fn object(&self) -> f64 {
        self.estimate[MODAL]
    }

    /// How well the readings agree with this hypothesis.
    pub fn log_likelihood(&self) -> f64 {
        self.log_likelihood
    }

    fn modal(&self) -> SVector<f64, MODAL> {
        self.estimate.fixed_rows::<MODAL>(0).into_owned()
    }
}

/// Where a command filter was a tick before, with the acceleration held.
fn before(filter: &Waypoint) -> Waypoint {
    let rate = filter.rate - filter.change * TICK_S;
    Waypoint {
        position: filter.position - (rate + 0.5 * filter.change * TICK_S) * TICK_S,
        rate,
        change: filter.change,
    }
}
