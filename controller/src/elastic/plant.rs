//! The way from the acceleration of the axes' command filters to the sensor's deflection, as one linear system.

use super::MODES;
use super::flexibility::Flexibility;
use super::regulator;
use nalgebra::{RowSVector, SMatrix, SVector};
use node::scenario;
use spatial::TICK_S;
use std::f64::consts::TAU;

/// Coordinates and rates of the modes, m and m/s in turn.
pub const MODAL: usize = 2 * MODES;
/// All states: modes, deviation of the motors, command filters.
pub const STATES: usize = MODAL + 6;

/// Place of the motors' deviation from their command filters, m.
pub const DEVIATION: usize = MODAL;
/// Of its rate, m/s.
pub const DEVIATION_RATE: usize = MODAL + 1;
/// Of the acceleration that the servos' integral parts cause, m/s^2.
pub const INTEGRAL: usize = MODAL + 2;
/// Of the command filters' position, m.
pub const POSITION: usize = MODAL + 3;
/// Of their speed, m/s.
pub const SPEED: usize = MODAL + 4;
/// Of their acceleration, m/s^2.
pub const ACCELERATION: usize = MODAL + 5;

/// All states of the plant, relative to the object.
pub type State = SVector<f64, STATES>;

/// One hypothesis of what is between command filter and sensor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plant {
    /// Of the modes, rad/s.
    pub frequencies: [f64; MODES],
    /// Transition of the modes over a tick.
    pub modal: SMatrix<f64, MODAL, MODAL>,
    /// What the motors' way at its beginning adds.
    pub held: SVector<f64, MODAL>,
    /// What its change, linear over the tick, adds.
    pub ramped: SVector<f64, MODAL>,
    /// Transition of all states over a tick, with the filter's acceleration held.
    pub tick: SMatrix<f64, STATES, STATES>,
    /// The same over a period.
    pub period: SMatrix<f64, STATES, STATES>,
    /// What a change of the filter's acceleration, linear over the period, adds.
    pub input: State,
    /// The deflection that the modes show.
    pub seen: RowSVector<f64, MODAL>,
    /// What the motors' way adds to it.
    pub rigid_share: f64,
    /// Feedback of the states to that change, m/s^2.
    pub gain: RowSVector<f64, STATES>,
    /// The state at rest for each metre of the motors beyond the object.
    pub rest: State,
}

impl Plant {
    /// `flexibility` behind the assumed servos, with a period of `ticks`; a change of the acceleration by 1 m/s^2 costs
    /// as much as a deflection of `effort` (s^2, m per m/s^2).
    ///
    /// With y the motors' deviation from their filters (`disturbance.rs`), pulled back by the gears:
    /// `y'' = -w_v (y' + k y) - w_v / T_i integral(y' + k y) + alpha a - pull`.
    pub fn new(
        flexibility: &Flexibility,
        servo: &scenario::AssumedServo,
        ticks: i64,
        effort: f64,
    ) -> Option<Self> {
        let mut rates = SMatrix::<f64, STATES, STATES>::zeros();
        let mut seen = RowSVector::<f64, MODAL>::zeros();
        let mut rest = State::zeros();
        let velocity_gain = TAU * servo.velocity_bandwidth_hz;
        let (k, integral) = (
            servo.position_gain_per_s,
            velocity_gain / servo.velocity_integral_time_s,
        );
        let mut pulled = flexibility.pull;
        for (i, mode) in flexibility.modes.iter().enumerate() {
            let (at, rate, square) = (2 * i, 2 * i + 1, mode.frequency * mode.frequency);
            rates[(at, rate)] = 1.0;
            rates[(rate, at)] = -square;
            rates[(rate, rate)] = -2.0 * flexibility.damping * mode.frequency;
            rates[(rate, POSITION)] = square;
            rates[(rate, DEVIATION)] = square;
            rates[(DEVIATION_RATE, at)] = mode.pull;
            seen[at] = mode.share;
            rest[at] = 1.0;
            pulled -= mode.pull;
        }
        rates[(DEVIATION, DEVIATION_RATE)] = 1.0;
        rates[(DEVIATION_RATE, DEVIATION)] = -velocity_gain * k - flexibility.pull;
        rates[(DEVIATION_RATE, DEVIATION_RATE)] = -velocity_gain;
        rates[(DEVIATION_RATE, POSITION)] = -flexibility.pull;
        rates[(DEVIATION_RATE, INTEGRAL)] = 1.0;
        rates[(DEVIATION_RATE, ACCELERATION)] = flexibility.feed_forward;
        rates[(INTEGRAL, DEVIATION)] = -integral * k;
        rates[(INTEGRAL, DEVIATION_RATE)] = -integral;
        rates[(POSITION, SPEED)] = 1.0;
        rates[(SPEED, ACCELERATION)] = 1.0;
        rest[POSITION] = 1.0;
        rest[INTEGRAL] = pulled;

        // Over a period the acceleration changes linearly: an input that is held is its slope.
        let mut slope = State::zeros();
        slope[ACCELERATION] = 1.0;
        let (tick, slope_tick) = over_a_tick(&rates, &slope);
        let (mut period, mut input) = (tick, slope_tick);
        for _ in 1..ticks {
            input = tick * input + slope_tick;
            period = tick * period;
        }
        input /= ticks as f64 * TICK_S;

        let motion = rates.fixed_view::<MODAL, MODAL>(0, 0).into_owned();
        let push = rates.fixed_view::<MODAL, 1>(0, POSITION).into_owned();
        let (modal, held) = over_a_tick(&motion, &push);
        // The response to a ramp is the integral of that to a step: one more state carries it.
        let mut with_ramp = SMatrix::<f64, { MODAL + 1 }, { MODAL + 1 }>::zeros();
        with_ramp.fixed_view_mut::<MODAL, MODAL>(0, 0).copy_from(&motion);
        with_ramp.fixed_view_mut::<MODAL, 1>(0, MODAL).copy_from(&push);
        let mut climbs = SVector::<f64, { MODAL + 1 }>::zeros();
        climbs[MODAL] = 1.0 / TICK_S;
        let (_, ramped) = over_a_tick(&with_ramp, &climbs);
        let ramped = ramped.fixed_rows::<MODAL>(0).into_owned();

        let mut all_seen = RowSVector::<f64, STATES>::zeros();
        all_seen.fixed_columns_mut::<MODAL>(0).copy_from(&seen);
        all_seen[POSITION] = flexibility.rigid_share;
        all_seen[DEVIATION] = flexibility.rigid_share;
        Some(Self {
            frequencies: flexibility.modes.map(|mode| mode.frequency),
            modal,
            held,
            ramped,
            tick,
            period,
            input,
            seen,
            rigid_share: flexibility.rigid_share,
            gain: gain(&period, &input, &all_seen, effort)?,
            rest,
        })
    }

    /// What the deflection is at rest per way of the motors.
    pub fn share(&self) -> f64 {
        self.seen.sum() + self.rigid_share
    }
}

/// `exp(A h)` and the response to a held input over a tick h, by their series: nothing here is faster than some 60 Hz.
fn over_a_tick<const N: usize>(
    rates: &SMatrix<f64, N, N>,
    input: &SVector<f64, N>,
) -> (SMatrix<f64, N, N>, SVector<f64, N>) {
    let step = rates * TICK_S;
    let mut term = SMatrix::<f64, N, N>::identity();
    let (mut transition, mut integral) = (term, term * TICK_S);
    for n in 1..12 {
        term = term * step / f64::from(n);
        transition += term;
        integral += term * (TICK_S / f64::from(n + 1));
    }
    (transition, integral * input)
}

/// The regulator's gain; solved in units of 10 um and 10 ms, in which all states are of the order of one.
fn gain(
    period: &SMatrix<f64, STATES, STATES>,
    input: &State,
    seen: &RowSVector<f64, STATES>,
    effort: f64,
) -> Option<RowSVector<f64, STATES>> {
    const LENGTH: f64 = 1e-5;
    const TIME: f64 = 1e-2;
    let unit = State::from_fn(|i, _| match i {
        INTEGRAL | ACCELERATION => LENGTH / (TIME * TIME),
        SPEED | DEVIATION_RATE => LENGTH / TIME,
        _ if i < MODAL && i % 2 == 1 => LENGTH / TIME,
        _ => LENGTH,
    });
    let transition = SMatrix::<f64, STATES, STATES>::from_fn(|i, j| period[(i, j)] * unit[j] / unit[i]);
    let scaled = input.component_div(&unit);
    let output = seen.component_mul(&unit.transpose()) / LENGTH;
    // What the deflection does not show is kept from growing.
    let cost = output.transpose() * output + SMatrix::identity() * 1e-8;
    let effort = effort / LENGTH;
    let gain = regulator::gain(&transition, &scaled, &cost, effort * effort)?;
    Some(gain.component_div(&unit.transpose()))
}
