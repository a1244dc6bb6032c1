//! The way from the acceleration of the axes' command filters to the sensor's deflection, as one linear system.

use super::MODES;
use super::flexibility::Flexibility;
use super::regulator;
use nalgebra::{RowSVector, SMatrix, SVector};
use node::scenario;
use spatial::TICK_S;
use spatial::kinematics::Axes;
use std::f64::consts::TAU;

/// Coordinates and rates of the modes, m and m/s in turn.
pub const MODAL: usize = 2 * MODES;
/// Place of the motors' deviations from their command filters, rad; rates (rad/s) and the accelerations that the servos'
/// integral parts cause (rad/s^2) follow.
pub const DEVIATION: usize = MODAL;
/// Place of their rates.
pub const RATE: usize = DEVIATION + 6;
/// Place of what the integral parts cause.
pub const INTEGRAL: usize = RATE + 6;
/// Place of the command filters' position along the normal, m.
pub const POSITION: usize = INTEGRAL + 6;
/// Of their speed, m/s.
pub const SPEED: usize = POSITION + 1;
/// Of their acceleration, m/s^2.
pub const ACCELERATION: usize = SPEED + 1;
/// All states: modes, deviations of the motors, command filters.
pub const STATES: usize = ACCELERATION + 1;

/// All states of the plant, relative to the object.
pub type State = SVector<f64, STATES>;

/// One hypothesis of what is between command filter and sensor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plant {
    /// Of the modes, rad/s.
    pub frequencies: [f64; MODES],
    /// Transition over a tick, with the filters' acceleration held.
    pub tick: SMatrix<f64, STATES, STATES>,
    /// The same over a period.
    pub period: SMatrix<f64, STATES, STATES>,
    /// What a change of the filters' acceleration, linear over the period, adds.
    pub input: State,
    /// The deflection, m.
    pub seen: RowSVector<f64, STATES>,
    /// Feedback of the states to that change, m/s^2.
    pub gain: RowSVector<f64, STATES>,
    /// The state at rest for each metre of the motors beyond the object.
    pub rest: State,
    /// What the tcp moves along the normal per way of each axis, m/rad.
    pub tcp_per_axis: Axes,
    /// How the axes move the tcp along the normal, rad/m.
    pub axes_per_tcp: Axes,
}

impl Plant {
    /// `flexibility` behind the assumed servos, with a period of `ticks`; a change of the acceleration by 1 m/s^2 costs
    /// as much as a deflection of `effort` (s^2, m per m/s^2). `None` if that can't be regulated.
    ///
    /// With y the deviation of a motor from its command filter (`disturbance.rs`):
    /// `y'' = -w_v (y' + k y) - w_v / T_i integral(y' + k y) + m_l / m_m a - pull of the gear / m_m`.
    pub fn new(
        flexibility: &Flexibility,
        servo: &scenario::AssumedServo,
        ticks: i64,
        parameters: &scenario::ElasticLaw,
    ) -> Option<Self> {
        let Flexibility {
            modes, axes_per_tcp, ..
        } = flexibility;
        let mut rates = SMatrix::<f64, STATES, STATES>::zeros();
        let mut seen = RowSVector::<f64, STATES>::zeros();
        let mut force = RowSVector::<f64, STATES>::zeros();
        let mut rest = State::zeros();
        for (i, mode) in modes.iter().enumerate() {
            let (at, rate, square) = (2 * i, 2 * i + 1, mode.frequency * mode.frequency);
            rates[(at, rate)] = 1.0;
            rates[(rate, at)] = -square;
            rates[(rate, rate)] = -2.0 * flexibility.damping * mode.frequency;
            rates[(rate, POSITION)] = mode.push.dot(axes_per_tcp);
            seen[at] = 1.0;
            force[at] = mode.force;
            rest[at] = rates[(rate, POSITION)] / square;
            for axis in 0..6 {
                rates[(rate, DEVIATION + axis)] = mode.push[axis];
                rates[(RATE + axis, at)] = mode.pull[axis];
            }
        }
        let velocity_gain = TAU * servo.velocity_bandwidth_hz;
        let (k, integral) = (
            servo.position_gain_per_s,
            velocity_gain / servo.velocity_integral_time_s,
        );
        let pulled = flexibility.gears * axes_per_tcp;
        for axis in 0..6 {
            let (y, rate, part) = (DEVIATION + axis, RATE + axis, INTEGRAL + axis);
            rates[(y, rate)] = 1.0;
            rates[(rate, y)] = -velocity_gain * k;
            rates[(rate, rate)] = -velocity_gain;
            rates[(rate, part)] = 1.0;
            rates[(rate, POSITION)] = -pulled[axis];
            rates[(rate, ACCELERATION)] = flexibility.feed_forward[axis];
            for other in 0..6 {
                rates[(rate, DEVIATION + other)] -= flexibility.gears[(axis, other)];
            }
            rates[(part, y)] = -integral * k;
            rates[(part, rate)] = -integral;
            seen[y] = flexibility.rigid[axis];
            force[y] = flexibility.rigid_force[axis];
            let held: f64 = (0..MODES).map(|i| modes[i].pull[axis] * rest[2 * i]).sum();
            rest[part] = pulled[axis] - held;
        }
        rates[(POSITION, SPEED)] = 1.0;
        rates[(SPEED, ACCELERATION)] = 1.0;
        rest[POSITION] = 1.0;
        seen[POSITION] = flexibility.rigid.dot(axes_per_tcp);
        force[POSITION] = flexibility.rigid_force.dot(axes_per_tcp);

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
        Some(Self {
            frequencies: modes.each_ref().map(|mode| mode.frequency),
            tick,
            period,
            input,
            seen,
            gain: gain(
                &period,
                &input,
                &[seen, force * libm::sqrt(parameters.contact_weight)],
                parameters.effort_s2,
            )?,
            rest,
            tcp_per_axis: flexibility.tcp_per_axis,
            axes_per_tcp: *axes_per_tcp,
        })
    }

    /// The `state` a tick later, but for the command filters' part, which is known.
    pub fn after_a_tick(&self, state: &State) -> State {
        after(&self.tick, state)
    }

    /// The same a period later, over which the filters' acceleration has changed by `change` (m/s^2).
    pub fn after_a_period(&self, state: &State, change: f64) -> State {
        after(&self.period, state) + self.input * change
    }

    /// The deflection in a `state`, m.
    pub fn deflection(&self, state: &State) -> f64 {
        (self.seen * state)[0]
    }

    /// What the deflection is at rest per metre of the motors beyond the object.
    pub fn share(&self) -> f64 {
        self.deflection(&self.rest)
    }
}

/// `transition * state` in the rows before the command filters'; the sums run as nalgebra's.
fn after(transition: &SMatrix<f64, STATES, STATES>, state: &State) -> State {
    let mut next = [0.0; POSITION];
    for (column, x) in transition.as_slice().chunks_exact(STATES).zip(state) {
        for (sum, entry) in next.iter_mut().zip(column) {
            *sum += entry * x;
        }
    }
    State::from_fn(|i, _| next.get(i).copied().unwrap_or_default())
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
    outputs: &[RowSVector<f64, STATES>; 2],
    effort: f64,
) -> Option<RowSVector<f64, STATES>> {
    const LENGTH: f64 = 1e-5;
    const TIME: f64 = 1e-2;
    let unit = State::from_fn(|i, _| match i {
        ..MODAL if i % 2 == 0 => LENGTH,
        ..MODAL | SPEED | RATE..INTEGRAL => LENGTH / TIME,
        DEVIATION..RATE | POSITION => LENGTH,
        _ => LENGTH / (TIME * TIME),
    });
    let transition = SMatrix::<f64, STATES, STATES>::from_fn(|i, j| period[(i, j)] * unit[j] / unit[i]);
    let scaled = input.component_div(&unit);
    // What the outputs do not show is kept from growing.
    let mut cost = SMatrix::identity() * 1e-8;
    for output in outputs {
        let output = output.component_mul(&unit.transpose()) / LENGTH;
        cost += output.transpose() * output;
    }
    let effort = effort / LENGTH;
    let gain = regulator::gain(&transition, &scaled, &cost, effort * effort)?;
    Some(gain.component_div(&unit.transpose()))
}
