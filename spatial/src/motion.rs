//! Motion of a frame, and its reconstruction between and beyond the ticks at which it is known.

use crate::{Pose, rotation};
use nalgebra::Vector3;

/// Pose of a frame in r with its first two derivatives, all expressed in r.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion {
    /// `r_from_a`.
    pub pose: Pose,
    /// Velocity of the origin, m/s.
    pub velocity: Vector3<f64>,
    /// Angular velocity, rad/s.
    pub angular_velocity: Vector3<f64>,
    /// Acceleration of the origin, m/s^2.
    pub acceleration: Vector3<f64>,
    /// Angular acceleration, rad/s^2.
    pub angular_acceleration: Vector3<f64>,
}

impl Motion {
    /// At rest at `pose`.
    pub fn at_rest(pose: Pose) -> Self {
        Self {
            pose,
            velocity: Vector3::zeros(),
            angular_velocity: Vector3::zeros(),
            acceleration: Vector3::zeros(),
            angular_acceleration: Vector3::zeros(),
        }
    }

    /// The motion `time` s later if the accelerations stay as they are.
    #[inline]
    pub fn extrapolate(&self, time: f64) -> Self {
        let half = 0.5 * time * time;
        let turn = self.angular_velocity * time + self.angular_acceleration * half;
        let shift = self.velocity * time + self.acceleration * half;
        Self {
            pose: Pose::from_parts(
                (self.pose.translation.vector + shift).into(),
                rotation::exp(turn) * self.pose.rotation,
            ),
            velocity: self.velocity + self.acceleration * time,
            angular_velocity: self.angular_velocity + self.angular_acceleration * time,
            ..*self
        }
    }

    /// Go over to another point of the same rigid body, at `position` in r (m).
    #[inline]
    pub fn carry(&mut self, position: Vector3<f64>) {
        let lever = position - self.pose.translation.vector;
        let spin = self.angular_velocity.cross(&lever);
        self.pose.translation.vector = position;
        self.velocity += spin;
        self.acceleration += self.angular_acceleration.cross(&lever) + self.angular_velocity.cross(&spin);
    }

    /// Go over to a body that turns against this one about `axis` (unit vector in r, through the origin) with
    /// `rate` (rad/s) and `change` (rad/s^2). The orientation is left as it is.
    #[inline]
    pub fn turn(&mut self, axis: Vector3<f64>, rate: f64, change: f64) {
        self.angular_acceleration += axis * change + self.angular_velocity.cross(&axis) * rate;
        self.angular_velocity += axis * rate;
    }
}

/// The motion between two instants at which it is known: cubic Hermite interpolation of position and velocity.
///
/// Exact for a constant acceleration within the segment, whatever jump lies at its ends: a servo holds its
/// output over a tick, so the accelerations *at* the ends would be those of the neighbouring ticks.
#[derive(Clone, Copy, Debug)]
pub struct MotionSegment {
    start: Motion,
    duration: f64,
    shift: [Vector3<f64>; 3],
    turn: [Vector3<f64>; 3],
}

impl MotionSegment {
    /// The segment of `duration` s from `start` to `end`, which is turned by less than pi against it.
    pub fn new(start: Motion, end: Motion, duration: f64) -> Self {
        let shift = end.pose.translation.vector - start.pose.translation.vector;
        let turn = rotation::log(&(end.pose.rotation * start.pose.rotation.inverse()));
        // In the coordinates v of Exp(v): w = J(v) v', hence v' = J^-1 w.
        let turn_rate = rotation::rate_of_change(turn, end.angular_velocity);
        Self {
            start,
            duration,
            shift: cubic(shift, start.velocity * duration, end.velocity * duration),
            turn: cubic(turn, start.angular_velocity * duration, turn_rate * duration),
        }
    }

    /// The motion `time` s after the segment's start, 0 <= `time` <= duration.
    #[inline]
    pub fn at(&self, time: f64) -> Motion {
        let s = time / self.duration;
        let (shift, velocity, acceleration) = evaluate(&self.shift, s, self.duration);
        let (turn, rate, rate_change) = evaluate(&self.turn, s, self.duration);
        Motion {
            pose: Pose::from_parts(
                (self.start.pose.translation.vector + shift).into(),
                rotation::exp(turn) * self.start.pose.rotation,
            ),
            velocity,
            angular_velocity: rotation::angular_velocity(turn, rate),
            acceleration,
            angular_acceleration: rotation::angular_velocity(turn, rate_change),
        }
    }
}

/// Coefficients of s, s^2, s^3 with s = t / duration: from 0 to `change` with the given rates at the ends.
fn cubic(change: Vector3<f64>, start_rate: Vector3<f64>, end_rate: Vector3<f64>) -> [Vector3<f64>; 3] {
    [
        start_rate,
        change * 3.0 - start_rate * 2.0 - end_rate,
        start_rate + end_rate - change * 2.0,
    ]
}

/// Value and first two derivatives in time.
fn evaluate(c: &[Vector3<f64>; 3], s: f64, duration: f64) -> (Vector3<f64>, Vector3<f64>, Vector3<f64>) {
    let value = (c[0] + (c[1] + c[2] * s) * s) * s;
    let rate = c[0] + (c[1] * 2.0 + c[2] * (3.0 * s)) * s;
    let change = c[1] * 2.0 + c[2] * (6.0 * s);
    (value, rate / duration, change / (duration * duration))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A frame that swings along and about several axes.
    fn swing(t: f64) -> Motion {
        let (w, u) = (60.0, 40.0);
        let axis = Vector3::new(0.6, -0.48, 0.64);
        let angle = 0.02 * libm::sin(u * t);
        let rate = 0.02 * u * libm::cos(u * t);
        let change = -0.02 * u * u * libm::sin(u * t);
        let amplitude = Vector3::new(1e-3, 2e-3, -3e-3);
        Motion {
            pose: Pose::from_parts((amplitude * libm::sin(w * t)).into(), rotation::exp(axis * angle)),
            velocity: amplitude * (w * libm::cos(w * t)),
            angular_velocity: axis * rate,
            acceleration: amplitude * (-w * w * libm::sin(w * t)),
            angular_acceleration: axis * change,
        }
    }

    fn distance(a: &Motion, b: &Motion) -> f64 {
        let turn = rotation::log(&(a.pose.rotation * b.pose.rotation.inverse()));
        (a.pose.translation.vector - b.pose.translation.vector).norm() + turn.norm()
    }

    #[test]
    fn a_segment_meets_both_ends() {
        let (start, end) = (swing(0.010), swing(0.011));
        let segment = MotionSegment::new(start, end, 0.001);
        for (given, found) in [(start, segment.at(0.0)), (end, segment.at(0.001))] {
            assert!(distance(&given, &found) < 1e-15);
            assert!((given.velocity - found.velocity).norm() < 1e-12);
            assert!((given.angular_velocity - found.angular_velocity).norm() < 1e-12);
        }
    }

    #[test]
    fn a_segment_errs_with_the_fourth_power_of_its_length() {
        let error = |duration: f64| {
            let segment = MotionSegment::new(swing(0.010), swing(0.010 + duration), duration);
            distance(&segment.at(0.5 * duration), &swing(0.010 + 0.5 * duration))
        };
        let ratio = error(0.002) / error(0.001);
        assert!((14.0..18.0).contains(&ratio), "{ratio}");
    }

    #[test]
    fn extrapolation_errs_with_the_third_power_of_time() {
        let error = |time: f64| distance(&swing(0.010).extrapolate(time), &swing(0.010 + time));
        let ratio = error(0.002) / error(0.001);
        assert!((6.0..10.0).contains(&ratio), "{ratio}");
    }
}
