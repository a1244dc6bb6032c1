//! The desired force as a disturbance of the position control, known in advance.
//!
//! Paper II-B: to ideal position control the desired wrench is a known disturbance, which the feed-forward takes away. The contact force acts on the axes, whose servos yield to it until their integral parts have taken it
//! over. That deviation is computed from what is known of the servos, and the desired pose is led by it.
//!
//! Model choice: the servo of `robot-sim` as a manufacturer would describe it. With y the deviation of an axis from its
//! filtered set-point, m its inertia, `K_v = m_m w_v`:
//! `m y'' = tau - K_v (y' + k y) - K_v / T_i integral(y' + k y)`.

use crate::contact::PREVIEW;
use node::scenario;
use spatial::TICK_S;
use spatial::kinematics::Axes;
use std::f64::consts::TAU;

/// How the servos of the axes yield, at one instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Disturbance {
    servos: [Servo; 6],
    /// y, rad.
    deviation: Axes,
    /// y', rad/s.
    rate: Axes,
    /// Torque of the integral parts, Nm.
    integral: Axes,
}

/// What a tick makes of a servo's state; a division takes as long as ten products.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Servo {
    /// k, 1/s.
    position_gain: f64,
    /// K_v k, Nm/rad.
    stiffness: f64,
    /// h K_v / T_i, Nm per rad/s.
    integral_gain: f64,
    /// h / m, s/(kg m^2).
    push: f64,
    /// 1 / (1 + h K_v / m).
    damping: f64,
}

impl Disturbance {
    /// The servos that the controller assumes, undisturbed.
    pub fn new(servo: &scenario::AssumedServo) -> Self {
        let one = |axis: usize| {
            let motor = servo.motor_inertia_kg_m2[axis];
            let velocity_gain = motor * TAU * servo.velocity_bandwidth_hz;
            let push = TICK_S / (motor + servo.link_inertia_kg_m2[axis]);
            Servo {
                position_gain: servo.position_gain_per_s,
                stiffness: velocity_gain * servo.position_gain_per_s,
                integral_gain: TICK_S * velocity_gain / servo.velocity_integral_time_s,
                push,
                damping: 1.0 / (1.0 + push * velocity_gain),
            }
        };
        Self {
            servos: std::array::from_fn(one),
            deviation: Axes::zeros(),
            rate: Axes::zeros(),
            integral: Axes::zeros(),
        }
    }

    /// How far the axes will have yielded (rad) at the ends of the coming periods of `ticks` under `tau` (Nm); the first
    /// of them is kept.
    pub fn preview(&mut self, tau: &Axes, ticks: i64) -> [Axes; PREVIEW] {
        let mut ahead = *self;
        std::array::from_fn(|i| {
            for _ in 0..ticks {
                ahead.advance(tau);
            }
            if i == 0 {
                *self = ahead;
            }
            ahead.deviation
        })
    }

    /// How far the axes have yielded, rad.
    pub fn deviation(&self) -> &Axes {
        &self.deviation
    }

    /// One tick under the torque `tau` (Nm) of the environment on the axes; the rate is damped implicitly, so that no
    /// gain makes the step unstable.
    pub fn advance(&mut self, tau: &Axes) {
        for (axis, servo) in self.servos.iter().enumerate() {
            let push = tau[axis] - servo.stiffness * self.deviation[axis] - self.integral[axis];
            self.rate[axis] = (self.rate[axis] + servo.push * push) * servo.damping;
            self.deviation[axis] += TICK_S * self.rate[axis];
            let error = self.rate[axis] + servo.position_gain * self.deviation[axis];
            self.integral[axis] += servo.integral_gain * error;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The deviation under a step of 10 N: its integral over time is that of the transfer function at s = 0,
    /// `T_i / (K_v k) tau`, since `y(s) = s tau / (m s^3 + K_v s^2 + K_v (k + 1/T_i) s + K_v k / T_i)` and tau = 10 / s.
    #[test]
    fn a_constant_torque_is_yielded_to_and_taken_over() {
        let servo = scenario::AssumedServo::default();
        let mut disturbance = Disturbance::new(&servo);
        let tau = Axes::ith(2, 10.0);
        let (mut sum, mut most) = (0.0, 0.0f64);
        for _ in 0..3000 {
            disturbance.advance(&tau);
            let y = disturbance.deviation();
            assert_eq!((y.x, y.w), (0.0, 0.0));
            sum += y.z * TICK_S;
            most = most.max(y.z);
        }
        assert!(disturbance.deviation().z.abs() < 1e-9);
        let gain = servo.motor_inertia_kg_m2[2] * TAU * servo.velocity_bandwidth_hz;
        let expected = servo.velocity_integral_time_s / (gain * servo.position_gain_per_s) * 10.0;
        assert!((sum / expected - 1.0).abs() < 0.02, "{sum} {expected}");
        assert!((2e-6..8e-6).contains(&most), "{most} m");
    }
}
