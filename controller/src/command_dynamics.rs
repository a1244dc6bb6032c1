//! The known answer of the position controlled robot to a set-point, and its inversion: the feed-forward of Fig. 2.
//!
//! Paper II-B: position control "is assumed to be ideal", which "requires a feedforward controller". Here the
//! robot's command filter is simulated along, and the next set-point is chosen such that the robot moves like a
//! reference model of second order: `x'' = w_r^2 (x_d - x) - 2 w_r x'`, within its acceleration limit.
//!
//! Model choice: the robot is its command filter `x'' = w^2 (c - x) - 2 zeta w x'` with the acceleration limited
//! (the servo behind it follows with its own feed-forward), `c` linear between set-points.

use spatial::TICK_S;

/// The command filter of one coordinate, at the instant from which on the next set-point acts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CommandDynamics {
    /// w, rad/s.
    frequency: f64,
    /// zeta.
    damping: f64,
    /// m/s^2.
    acceleration_limit: f64,
    period_ticks: i64,
    position: f64,
    velocity: f64,
    setpoint: f64,
}

impl CommandDynamics {
    /// At rest at `position` (m).
    pub fn new(
        frequency_hz: f64,
        damping: f64,
        acceleration_limit: f64,
        period_ticks: i64,
        position: f64,
    ) -> Self {
        Self {
            frequency: std::f64::consts::TAU * frequency_hz,
            damping,
            acceleration_limit,
            period_ticks,
            position,
            velocity: 0.0,
            setpoint: position,
        }
    }

    /// The set-point last given, m.
    pub fn setpoint(&self) -> f64 {
        self.setpoint
    }

    /// The set-point at which a robot at `position` moving with `velocity` accelerates with `acceleration`:
    /// the inverse `c = x + 2 zeta / w x' + x'' / w^2`.
    pub fn inverse(&self, position: f64, velocity: f64, acceleration: f64) -> f64 {
        position + (2.0 * self.damping * velocity + acceleration / self.frequency) / self.frequency
    }

    /// The next set-point (m) towards `target` (m) with the reference model's `bandwidth` w_r (rad/s).
    ///
    /// Over the coming period T the acceleration runs linearly from a_0 to a_1, hence
    /// `x_1 = x + T v + T^2 (2 a_0 + a_1) / 6`, `v_1 = v + T (a_0 + a_1) / 2`; the reference model holds at its
    /// end: `a_1 = w_r^2 (x_d - x_1) - 2 w_r v_1`, solved for a_1.
    pub fn towards(&self, target: f64, bandwidth: f64) -> f64 {
        let period = self.period_ticks as f64 * TICK_S;
        let (x, v, a0) = (self.position, self.velocity, self.acceleration(self.setpoint));
        let (stiffness, damping) = (bandwidth * bandwidth, 2.0 * bandwidth);
        let wanted = stiffness * (target - x - period * v - period * period * a0 / 3.0)
            - damping * (v + 0.5 * period * a0);
        let a1 = wanted / (1.0 + stiffness * period * period / 6.0 + damping * 0.5 * period);
        let a1 = a1.clamp(-self.acceleration_limit, self.acceleration_limit);
        let x1 = x + period * v + period * period * (2.0 * a0 + a1) / 6.0;
        let v1 = v + 0.5 * period * (a0 + a1);
        self.inverse(x1, v1, a1)
    }

    /// Simulate the robot over one period in which the set-point moves linearly to `setpoint` (m).
    pub fn advance(&mut self, setpoint: f64) {
        for tick in 0..self.period_ticks {
            let share = tick as f64 / self.period_ticks as f64;
            let a = self.acceleration(self.setpoint + (setpoint - self.setpoint) * share);
            self.position += self.velocity * TICK_S + 0.5 * a * TICK_S * TICK_S;
            self.velocity += a * TICK_S;
        }
        self.setpoint = setpoint;
    }

    fn acceleration(&self, setpoint: f64) -> f64 {
        let w = self.frequency;
        (w * w * (setpoint - self.position) - 2.0 * self.damping * w * self.velocity)
            .clamp(-self.acceleration_limit, self.acceleration_limit)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_robot_moves_like_the_reference_model() {
        // A step small enough to stay within the acceleration limit: x(t) = x_d (1 - (1 + w t) e^-wt).
        let mut dynamics = CommandDynamics::new(15.0, 0.8, 5.0, 4, 0.0);
        let bandwidth = std::f64::consts::TAU * 10.0;
        for period in 1..60 {
            dynamics.advance(dynamics.towards(1e-3, bandwidth));
            // The acceleration ramps up over the first period: half a period late.
            let t = (f64::from(period) - 0.5) * 4e-3;
            let ideal = 1e-3 * (1.0 - (1.0 + bandwidth * t) * libm::exp(-bandwidth * t));
            assert!(
                (dynamics.position - ideal).abs() < 0.03e-3,
                "{period}: {} {ideal}",
                dynamics.position
            );
        }
        assert!((dynamics.position - 1e-3).abs() < 1e-6);
    }

    #[test]
    fn the_acceleration_limit_is_kept_and_the_target_reached() {
        let mut dynamics = CommandDynamics::new(15.0, 0.8, 5.0, 4, 0.0);
        for _ in 0..100 {
            let before = dynamics.velocity;
            dynamics.advance(dynamics.towards(5e-3, std::f64::consts::TAU * 20.0));
            assert!((dynamics.velocity - before).abs() <= 5.0 * 4e-3 + 1e-12);
        }
        assert!((dynamics.position - 5e-3).abs() < 1e-6);
    }
}
