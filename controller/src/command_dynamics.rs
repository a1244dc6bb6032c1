//! The known answer of the position controlled robot to set-points, and its inversion: the feed-forward of Fig. 2.
//!
//! Paper II-B: ideal position control needs a feed-forward that processes *future* desired poses. Here the desired
//! axes of the coming instants (the preview) tell the velocity and the acceleration with which the robot is to pass
//! the next of them. The command filter of each axis is simulated along, and the next set-point is chosen such that
//! the axis closes in on its desired motion like a reference model of second order,
//! `x'' = x_d'' + w_r^2 (x_d - x) + 2 w_r (x_d' - x')`, within its acceleration limit.
//!
//! Model choice: an axis is its command filter `x'' = w^2 (c - x) - 2 zeta w x'` with the acceleration limited
//! (the servo behind it follows with its own feed-forward), `c` linear between set-points.

use crate::contact::PREVIEW;
use spatial::TICK_S;
use spatial::kinematics::Axes;
use spatial::ports::HORIZON;

/// A desired motion of the axes at an instant: rad, rad/s, rad/s^2.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Target {
    /// x_d.
    pub position: Axes,
    /// x_d'.
    pub velocity: Axes,
    /// x_d''.
    pub acceleration: Axes,
}

impl Target {
    /// At the first of three desired positions a `period` (s) apart, to second order.
    pub fn ahead(position: [&Axes; 3], period: f64) -> Self {
        let [now, next, after] = position;
        Self {
            position: *now,
            velocity: (next * 4.0 - now * 3.0 - after) / (2.0 * period),
            acceleration: (now - next * 2.0 + after) / (period * period),
        }
    }
}

/// The command filters of the axes, at the instant from which on the next set-point acts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CommandDynamics {
    /// w, rad/s.
    frequency: f64,
    /// zeta.
    damping: f64,
    /// rad/s^2.
    acceleration_limit: Axes,
    period_ticks: i64,
    position: Axes,
    velocity: Axes,
    setpoint: Axes,
}

impl CommandDynamics {
    /// At rest at `position` (rad).
    pub fn new(
        frequency_hz: f64,
        damping: f64,
        acceleration_limit: Axes,
        period_ticks: i64,
        position: Axes,
    ) -> Self {
        Self {
            frequency: std::f64::consts::TAU * frequency_hz,
            damping,
            acceleration_limit,
            period_ticks,
            position,
            velocity: Axes::zeros(),
            setpoint: position,
        }
    }

    /// The set-point at which a robot at `position` moving with `velocity` accelerates with `acceleration`:
    /// the inverse `c = x + 2 zeta / w x' + x'' / w^2`. Linear, hence for any coordinate.
    pub fn inverse(&self, position: f64, velocity: f64, acceleration: f64) -> f64 {
        position + (2.0 * self.damping * velocity + acceleration / self.frequency) / self.frequency
    }

    /// What a robot is to do at the coming instants, of which `desired` says where it is to be.
    pub fn targets(&self, desired: &[Axes; PREVIEW]) -> [Target; HORIZON] {
        std::array::from_fn(|i| Target::ahead([&desired[i], &desired[i + 1], &desired[i + 2]], self.period()))
    }

    /// The next set-points (rad) of a robot that is to do what `targets` says at the coming instants, with the
    /// reference model's `bandwidth` w_r (rad/s).
    pub fn follow(&self, targets: &[Target; HORIZON], bandwidth: f64) -> [Axes; HORIZON] {
        let (mut ahead, mut setpoints) = (*self, [self.setpoint; HORIZON]);
        for (i, target) in targets.iter().enumerate() {
            if i > 0 {
                ahead.advance(&setpoints[i - 1]);
            }
            setpoints[i] = ahead.towards(target, bandwidth);
        }
        setpoints
    }

    /// The next set-point (rad) towards `target`, at the end of the coming period T.
    ///
    /// Over that period the acceleration runs linearly from a_0 to a_1, hence
    /// `x_1 = x + T v + T^2 (2 a_0 + a_1) / 6`, `v_1 = v + T (a_0 + a_1) / 2`; the reference model holds at its
    /// end: `a_1 = x_d'' + w_r^2 (x_d - x_1) + 2 w_r (x_d' - v_1)`, solved for a_1.
    pub fn towards(&self, target: &Target, bandwidth: f64) -> Axes {
        let period = self.period();
        let (stiffness, damping) = (bandwidth * bandwidth, 2.0 * bandwidth);
        let accelerations = self.accelerations(&self.setpoint);
        Axes::from_fn(|axis, _| {
            let (x, v) = (self.position[axis], self.velocity[axis]);
            let a0 = accelerations[axis];
            let wanted = target.acceleration[axis]
                + stiffness * (target.position[axis] - x - period * v - period * period * a0 / 3.0)
                + damping * (target.velocity[axis] - v - 0.5 * period * a0);
            let a1 = wanted / (1.0 + stiffness * period * period / 6.0 + damping * 0.5 * period);
            let a1 = a1.clamp(-self.acceleration_limit[axis], self.acceleration_limit[axis]);
            let x1 = x + period * v + period * period * (2.0 * a0 + a1) / 6.0;
            let v1 = v + 0.5 * period * (a0 + a1);
            self.inverse(x1, v1, a1)
        })
    }

    /// Simulate the robot over one period in which the set-point moves linearly to `setpoint` (rad); its mean
    /// acceleration, rad/s^2.
    pub fn advance(&mut self, setpoint: &Axes) -> Axes {
        let before = self.velocity;
        let change = setpoint - self.setpoint;
        for tick in 0..self.period_ticks {
            let share = tick as f64 / self.period_ticks as f64;
            let a = self.accelerations(&(self.setpoint + change * share));
            self.position += self.velocity * TICK_S + a * 0.5 * TICK_S * TICK_S;
            self.velocity += a * TICK_S;
        }
        self.setpoint = *setpoint;
        (self.velocity - before) / self.period()
    }

    /// Where the robot will be when the next set-point begins to act.
    pub fn reached(&self) -> Target {
        Target {
            position: self.position,
            velocity: self.velocity,
            acceleration: self.accelerations(&self.setpoint),
        }
    }

    fn period(&self) -> f64 {
        self.period_ticks as f64 * TICK_S
    }

    /// Where the set-points are these (rad), rad/s^2.
    fn accelerations(&self, setpoints: &Axes) -> Axes {
        let w = self.frequency;
        let wanted = (setpoints - self.position) * (w * w) - self.velocity * (2.0 * self.damping * w);
        wanted.zip_map(&self.acceleration_limit, |wanted, limit| {
            wanted.clamp(-limit, limit)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    fn dynamics(position: f64) -> CommandDynamics {
        CommandDynamics::new(15.0, 0.8, Axes::repeat(5.0), 4, Axes::repeat(position))
    }

    /// One period towards a desired position that stays.
    fn step(dynamics: &mut CommandDynamics, target: f64, bandwidth: f64) {
        let setpoints = dynamics.follow(&dynamics.targets(&[Axes::repeat(target); PREVIEW]), bandwidth);
        dynamics.advance(&setpoints[0]);
    }

    #[test]
    fn the_robot_moves_like_the_reference_model() {
        // A step small enough to stay within the acceleration limit: x(t) = x_d (1 - (1 + w t) e^-wt).
        let mut dynamics = dynamics(0.0);
        let bandwidth = TAU * 10.0;
        for period in 1..60 {
            step(&mut dynamics, 1e-3, bandwidth);
            // The acceleration ramps up over the first period: half a period late.
            let t = (f64::from(period) - 0.5) * 4e-3;
            let ideal = 1e-3 * (1.0 - (1.0 + bandwidth * t) * libm::exp(-bandwidth * t));
            assert!(
                (dynamics.position.z - ideal).abs() < 0.03e-3,
                "{period}: {} {ideal}",
                dynamics.position.z
            );
        }
        assert!((dynamics.position.z - 1e-3).abs() < 1e-6);
    }

    #[test]
    fn the_acceleration_limit_is_kept_and_the_target_reached() {
        let mut dynamics = dynamics(0.0);
        for _ in 0..100 {
            let before = dynamics.velocity.x;
            step(&mut dynamics, 5e-3, TAU * 20.0);
            assert!((dynamics.velocity.x - before).abs() <= 5.0 * 4e-3 + 1e-12);
        }
        assert!((dynamics.position.x - 5e-3).abs() < 1e-6);
    }

    /// The preview turns a desired motion into set-points that lead it: a robot that knew only the present desired
    /// position would trail by 2 zeta / w = 17 ms, 0.7 mm here.
    #[test]
    fn a_moving_target_is_followed_without_lag() {
        let mut dynamics = dynamics(0.0);
        let path = |t: f64| 2e-3 * (1.0 - libm::cos(20.0 * t));
        for period in 1..200 {
            let t = |i: usize| f64::from(period) * 4e-3 + i as f64 * 4e-3;
            let desired = std::array::from_fn(|i| Axes::repeat(path(t(i))));
            let setpoints = dynamics.follow(&dynamics.targets(&desired), TAU * 20.0);
            dynamics.advance(&setpoints[0]);
            let error = dynamics.position.y - path(t(0));
            assert!(error.abs() < 10e-6, "{error} at {} s", t(0));
        }
    }
}
