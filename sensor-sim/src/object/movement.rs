//! How the object moves, whatever touches it: constant velocity, sinusoid and recorded profile, added up.

use nalgebra::Vector3;
use node::scenario;
use std::f64::consts::TAU;

/// The prescribed motion of the object's origin in r; it never turns.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Movement {
    start: Vector3<f64>,
    velocity: Vector3<f64>,
    amplitude: Vector3<f64>,
    rad_per_s: f64,
    phase: f64,
    profile: Vec<Knot>,
    still: bool,
}

/// Where the object's origin is in r, m, and how fast it moves, m/s.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Base {
    /// m.
    pub position: Vector3<f64>,
    /// m/s.
    pub velocity: Vector3<f64>,
}

/// A point of the profile: time (s), height (m) and its rate (m/s).
#[derive(Clone, Copy, Debug, PartialEq)]
struct Knot {
    time: f64,
    height: f64,
    rate: f64,
}

impl Movement {
    /// The movement of a scenario's object.
    pub(super) fn new(object: &scenario::Object) -> Self {
        let [x, y] = object.origin_m;
        let velocity: Vector3<f64> = object.velocity_m_per_s.into();
        let amplitude: Vector3<f64> = object.swing_amplitude_m.into();
        let profile = knots(&object.profile_time_s, &object.profile_height_m);
        Self {
            start: Vector3::new(x, y, object.height_m),
            velocity,
            amplitude,
            rad_per_s: TAU * object.swing_frequency_hz,
            phase: object.swing_phase_rad,
            still: velocity == Vector3::zeros() && amplitude == Vector3::zeros() && profile.is_empty(),
            profile,
        }
    }

    /// At `time`, s after the start.
    pub(super) fn at(&self, time: f64) -> Base {
        if self.still {
            return Base {
                position: self.start,
                velocity: Vector3::zeros(),
            };
        }
        let (sine, cosine) = libm::sincos(self.rad_per_s * time + self.phase);
        let (height, rate) = recorded(&self.profile, time);
        Base {
            position: self.start + self.velocity * time + self.amplitude * sine + Vector3::z() * height,
            velocity: self.velocity + self.amplitude * (self.rad_per_s * cosine) + Vector3::z() * rate,
        }
    }
}

/// Model choice: between its points the profile is a cubic with the slope of the neighbours' connection at each
/// (Catmull and Rom), beyond its ends it rests: no jump in velocity, no oscillation of high order.
fn knots(times: &[f64], heights: &[f64]) -> Vec<Knot> {
    let points: Vec<_> = times.iter().copied().zip(heights.iter().copied()).collect();
    let rate = |i: usize| match (i.checked_sub(1).and_then(|i| points.get(i)), points.get(i + 1)) {
        (Some((t0, h0)), Some((t1, h1))) => (h1 - h0) / (t1 - t0),
        _ => 0.0,
    };
    let knot = |(i, &(time, height))| Knot {
        time,
        height,
        rate: rate(i),
    };
    points.iter().enumerate().map(knot).collect()
}

/// Height (m) and rate (m/s) of the profile at `time`.
fn recorded(profile: &[Knot], time: f64) -> (f64, f64) {
    let next = profile.partition_point(|knot| knot.time <= time);
    let before = next.checked_sub(1).and_then(|i| profile.get(i));
    match (before, profile.get(next)) {
        (Some(a), Some(b)) => {
            let duration = b.time - a.time;
            let s = (time - a.time) / duration;
            let (rise, p, q) = (b.height - a.height, a.rate * duration, b.rate * duration);
            let (square, cube) = (3.0 * rise - 2.0 * p - q, p + q - 2.0 * rise);
            let height = a.height + s * (p + s * (square + s * cube));
            (height, (p + s * (2.0 * square + s * 3.0 * cube)) / duration)
        }
        (Some(end), None) | (None, Some(end)) => (end.height, 0.0),
        (None, None) => (0.0, 0.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_velocity_is_the_derivative_of_the_position() {
        let movement = Movement::new(&scenario::Object {
            velocity_m_per_s: [0.1, 0.0, -0.01],
            swing_amplitude_m: [0.0, 1e-3, 2e-3],
            swing_frequency_hz: 3.0,
            swing_phase_rad: 0.4,
            profile_time_s: vec![0.5, 0.7, 1.3],
            profile_height_m: vec![0.001, -0.002, 0.004],
            ..Default::default()
        });
        for i in 0..200 {
            let (time, h) = (f64::from(i) * 0.01 + 1e-3, 1e-6);
            let slope = (movement.at(time + h).position - movement.at(time - h).position) / (2.0 * h);
            assert!((slope - movement.at(time).velocity).norm() < 1e-7, "{time}");
        }
    }

    #[test]
    fn a_profile_passes_through_its_points_and_rests_beyond_its_ends() {
        let movement = Movement::new(&scenario::Object {
            height_m: 0.1,
            profile_time_s: vec![0.5, 0.7, 1.3],
            profile_height_m: vec![0.001, -0.002, 0.004],
            ..Default::default()
        });
        for (time, height) in [
            (0.0, 0.001),
            (0.5, 0.001),
            (0.7, -0.002),
            (1.3, 0.004),
            (9.0, 0.004),
        ] {
            assert!((movement.at(time).position.z - 0.1 - height).abs() < 1e-15);
        }
    }
}
