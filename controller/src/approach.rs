//! The free motion towards the object: a straight line with a smooth start and end.

/// Position, velocity and acceleration along a path: m, m/s, m/s^2.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PathPoint {
    /// Distance travelled, m.
    pub distance: f64,
    /// m/s.
    pub speed: f64,
    /// m/s^2.
    pub acceleration: f64,
}

/// Speed from 0 to `speed` as `10 s^3 - 15 s^4 + 6 s^5`, a cruise, and the mirror image at the end.
///
/// Model choice (PLANT.md section 2): the ramp takes `max(0.1 s, speed / 0.25 m/s^2)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Approach {
    length: f64,
    speed: f64,
    ramp_time: f64,
    cruise_time: f64,
}

impl Approach {
    /// Over `length` (m) with at most `speed` (m/s): less where the path is too short to reach it.
    pub fn new(length: f64, speed: f64) -> Self {
        let ramp_time = (speed / 0.25).max(0.1);
        let speed = speed.min(length / ramp_time);
        Self {
            length,
            speed,
            ramp_time,
            cruise_time: length / speed - ramp_time,
        }
    }

    /// When the path ends, s after its start.
    pub fn duration(&self) -> f64 {
        2.0 * self.ramp_time + self.cruise_time
    }

    /// The point `time` s after the start.
    pub fn at(&self, time: f64) -> PathPoint {
        let from_end = self.duration() - time;
        if time < self.ramp_time + self.cruise_time {
            return self.ramp(time);
        }
        let mirrored = self.ramp(from_end);
        PathPoint {
            distance: self.length - mirrored.distance,
            speed: mirrored.speed,
            acceleration: -mirrored.acceleration,
        }
    }

    /// The ramp up and the cruise behind it.
    fn ramp(&self, time: f64) -> PathPoint {
        let s = time.max(0.0) / self.ramp_time;
        if s >= 1.0 {
            let distance = self.speed * (time - 0.5 * self.ramp_time);
            return PathPoint {
                distance,
                speed: self.speed,
                acceleration: 0.0,
            };
        }
        PathPoint {
            distance: self.speed * self.ramp_time * s * s * s * s * (2.5 + s * (s - 3.0)),
            speed: self.speed * s * s * s * (10.0 + s * (6.0 * s - 15.0)),
            acceleration: self.speed / self.ramp_time * 30.0 * s * s * (1.0 - s) * (1.0 - s),
        }
    }
}

/// How a value from 0 to 1 is spread over `duration` (s): the quintic with no speed and acceleration at its ends.
pub fn spread(time: f64, duration: f64) -> PathPoint {
    let s = (time / duration).clamp(0.0, 1.0);
    PathPoint {
        distance: s * s * s * (10.0 + s * (6.0 * s - 15.0)),
        speed: 30.0 * s * s * (1.0 - s) * (1.0 - s) / duration,
        acceleration: 60.0 * s * (1.0 - s) * (1.0 - 2.0 * s) / (duration * duration),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// That speed and acceleration are the derivatives of the distance.
    fn consistent(at: impl Fn(f64) -> PathPoint, time: f64, scale: f64) {
        let h = 1e-5;
        let (before, now, after) = (at(time - h), at(time), at(time + h));
        assert!(((after.distance - before.distance) / (2.0 * h) - now.speed).abs() < 1e-6 * scale);
        assert!(((after.speed - before.speed) / (2.0 * h) - now.acceleration).abs() < 1e-4 * scale);
    }

    proptest! {
        #[test]
        fn the_path_is_smooth_and_complete(length in 0.001..0.5, speed in 0.001..0.5, share in 0.01..0.99) {
            let path = Approach::new(length, speed);
            consistent(|t| path.at(t), share * path.duration(), 10.0);
            prop_assert!((path.at(path.duration()).distance - length).abs() < 1e-12);
            prop_assert_eq!(path.at(0.0), PathPoint::default());
            prop_assert_eq!(path.at(path.duration() + 1.0).speed, 0.0);
            prop_assert!(path.at(share * path.duration()).speed <= speed * (1.0 + 1e-12));
        }

        #[test]
        fn spreading_is_smooth(share in 0.01..0.99) {
            consistent(|t| spread(t, 0.1), share * 0.1, 1000.0);
        }
    }
}
