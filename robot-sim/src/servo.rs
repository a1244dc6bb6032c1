//! The position controller of one axis: command filter, position and velocity loop, feed-forward.

use spatial::TICK_S;
use std::f64::consts::TAU;

/// What the servo of an axis is set to. An axis coordinate is an angle in rad.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ServoParameters {
    /// w_f, rad/s.
    pub filter_rad_per_s: f64,
    /// zeta_f.
    pub filter_damping: f64,
    /// Limit of the filter's acceleration, rad/s^2.
    pub acceleration_limit: f64,
    /// Limit of the filter's velocity, rad/s.
    pub velocity_limit: f64,
    /// Gain from position error to velocity, 1/s.
    pub position_gain: f64,
    /// K_v, Nm s/rad: motor inertia times the bandwidth of the velocity loop.
    pub velocity_gain: f64,
    /// Integral time of the velocity loop, s.
    pub integral_time_s: f64,
    /// Inertia that the feed-forward accelerates: motor and link, kg m^2.
    pub inertia: f64,
}

impl ServoParameters {
    /// K_v for a motor of `inertia` kg m^2 and a velocity loop of `bandwidth_hz`.
    pub fn velocity_gain(inertia: f64, bandwidth_hz: f64) -> f64 {
        inertia * TAU * bandwidth_hz
    }
}

/// Servo of one axis; its torque is held over a tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Servo {
    parameters: ServoParameters,
    filtered_position: f64,
    filtered_velocity: f64,
    /// Integral part of the torque, Nm.
    integral_torque: f64,
}

impl Servo {
    /// At rest at `position` (rad).
    pub fn new(parameters: ServoParameters, position: f64) -> Self {
        Self {
            parameters,
            filtered_position: position,
            filtered_velocity: 0.0,
            integral_torque: 0.0,
        }
    }

    /// The torque (Nm) for the coming tick from the set-point and the motor's measured position (rad) and
    /// velocity (rad/s).
    ///
    /// `a = clamp(w_f^2 (x_c - x_f) - 2 zeta_f w_f v_f)`; `e = v_f + k (x_f - x_m) - v_m`;
    /// `u = K_v e + K_v / T_i integral(e) + (m_m + m_l) a` (PLANT.md section 2). The error uses the filter's
    /// state before it is advanced. The integral's torque is bounded by what the acceleration limit needs, so
    /// that it can't wind up against an obstacle.
    pub fn torque(&mut self, setpoint: f64, position: f64, velocity: f64) -> f64 {
        let p = &self.parameters;
        let w = p.filter_rad_per_s;
        let wanted =
            w * w * (setpoint - self.filtered_position) - 2.0 * p.filter_damping * w * self.filtered_velocity;
        let limited = wanted.clamp(-p.acceleration_limit, p.acceleration_limit);
        let next_velocity =
            (self.filtered_velocity + limited * TICK_S).clamp(-p.velocity_limit, p.velocity_limit);
        // Where the velocity limit binds, the feed-forward must not push on.
        let acceleration = (next_velocity - self.filtered_velocity) / TICK_S;

        let error = self.filtered_velocity + p.position_gain * (self.filtered_position - position) - velocity;
        let bound = p.inertia * p.acceleration_limit;
        self.integral_torque = (self.integral_torque + p.velocity_gain / p.integral_time_s * error * TICK_S)
            .clamp(-bound, bound);

        self.filtered_position += 0.5 * (self.filtered_velocity + next_velocity) * TICK_S;
        self.filtered_velocity = next_velocity;
        p.velocity_gain * error + self.integral_torque + p.inertia * acceleration
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parameters() -> ServoParameters {
        ServoParameters {
            filter_rad_per_s: TAU * 15.0,
            filter_damping: 0.8,
            acceleration_limit: 5.0,
            velocity_limit: 1.0,
            position_gain: 25.0,
            velocity_gain: ServoParameters::velocity_gain(120.0, 60.0),
            integral_time_s: 0.03,
            inertia: 180.0,
        }
    }

    /// A rigid axis of 180 kg under the servo, with an outer force.
    fn run(ticks: usize, setpoint: impl Fn(f64) -> f64, force: f64) -> Vec<(f64, f64)> {
        let mut servo = Servo::new(parameters(), 0.0);
        let (mut x, mut v) = (0.0, 0.0);
        (0..ticks)
            .map(|tick| {
                let a = (servo.torque(setpoint(tick as f64 * TICK_S), x, v) + force) / 180.0;
                x += v * TICK_S + 0.5 * a * TICK_S * TICK_S;
                v += a * TICK_S;
                (x, v)
            })
            .collect()
    }

    #[test]
    fn limits_of_velocity_and_acceleration_hold() {
        let trace = run(2000, |_| 1.0, 0.0);
        assert!(trace.iter().all(|(_, v)| v.abs() <= 1.0 + 0.02));
        assert!(
            trace
                .windows(2)
                .all(|w| ((w[1].1 - w[0].1) / TICK_S).abs() <= 5.0 * 1.1)
        );
    }

    #[test]
    fn a_small_step_is_reached() {
        assert!((run(1000, |_| 1e-3, 0.0).last().unwrap().0 - 1e-3).abs() < 1e-9);
    }

    #[test]
    fn a_constant_force_is_integrated_away() {
        let trace = run(3000, |_| 0.0, 20.0);
        assert!(trace.last().unwrap().0.abs() < 1e-9);
    }

    #[test]
    fn the_integral_does_not_wind_up_against_an_obstacle() {
        let mut servo = Servo::new(parameters(), 0.0);
        for _ in 0..10_000 {
            servo.torque(0.01, 0.0, 0.0);
        }
        assert!(servo.integral_torque <= 900.0);
    }
}
