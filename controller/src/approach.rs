//! The free motion towards the object: a straight line with shaped changes of speed.

use crate::shaping::{Point, Shape};

/// Value, rate and its rate along a path: 1, 1/s, 1/s^2.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Share {
    /// From 0 to 1.
    pub value: f64,
    /// 1/s.
    pub rate: f64,
    /// 1/s^2.
    pub acceleration: f64,
}

/// A stretch over which the speed goes from one value to another.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Stretch {
    duration: f64,
    before: f64,
    after: f64,
}

impl Stretch {
    fn ramp(shape: &Shape, before: f64, after: f64) -> Self {
        Self {
            duration: shape.ramp_time(after - before),
            before,
            after,
        }
    }

    fn cruise(speed: f64, length: f64) -> Self {
        Self {
            duration: (length / speed).max(0.0),
            before: speed,
            after: speed,
        }
    }

    fn length(&self) -> f64 {
        0.5 * (self.before + self.after) * self.duration
    }

    fn at(&self, shape: &Shape, time: f64) -> Point {
        if self.before == self.after {
            return Point {
                distance: self.before * time,
                speed: self.before,
                ..Point::default()
            };
        }
        shape.ramp(self.before, self.after - self.before, time)
    }
}

/// From rest at `speed` to where the object may be, on at the speed of the search until it is met, and to rest.
///
/// Where nothing is known of the object, all of the way is search. How long a change of speed takes, its shape says.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Approach {
    shape: Shape,
    stretches: [Stretch; 5],
}

impl Approach {
    /// Over `length` (m) with at most `speed` (m/s): less where the way is too short to reach it.
    pub fn new(shape: Shape, length: f64, speed: f64) -> Self {
        let speed = speed.min(shape.speed_within(1.0, length));
        let [up, down] = [(0.0, speed), (speed, 0.0)].map(|(from, to)| Stretch::ramp(&shape, from, to));
        Self {
            shape,
            stretches: [
                up,
                Stretch::cruise(speed, length - up.length() - down.length()),
                down,
                Stretch::default(),
                Stretch::default(),
            ],
        }
    }

    /// Over `free` (m) with at most `speed` (m/s), and `search` (m) with `search_speed`, which is the slower one.
    pub fn with_search(shape: Shape, free: f64, speed: f64, search: f64, search_speed: f64) -> Self {
        // No faster than what can start and be held within the free way (`slow/2 R(slow) + slow R(0)`, R the time of a
        // ramp, which is at most `2 (slow/2 R(2 slow))`), and stop within the search.
        let slow = search_speed
            .min(speed)
            .min(shape.speed_within(1.5, free))
            .min(shape.speed_within(0.5, search));
        // What fits into the free way: `speed/2 R(speed) + (speed + slow)/2 R(speed - slow)`, which is
        // `speed R(speed) + slow/2 R(0) - slow^2/(2 a)`.
        let kept = 0.5 * slow * (slow / shape.acceleration() - shape.ramp_time(0.0));
        let speed = speed.min(shape.speed_within(1.0, free + kept)).max(slow);
        let [up, down, end] =
            [(0.0, speed), (speed, slow), (slow, 0.0)].map(|(from, to)| Stretch::ramp(&shape, from, to));
        Self {
            shape,
            stretches: [
                up,
                Stretch::cruise(speed, free - up.length() - down.length()),
                down,
                Stretch::cruise(slow, search - end.length()),
                end,
            ],
        }
    }

    /// When the way ends, s after its start.
    pub fn duration(&self) -> f64 {
        self.stretches.iter().map(|stretch| stretch.duration).sum()
    }

    /// The point `time` s after the start; at rest before and after.
    pub fn at(&self, time: f64) -> Point {
        let (mut time, mut distance) = (time.max(0.0), 0.0);
        for stretch in &self.stretches {
            if time < stretch.duration {
                let point = stretch.at(&self.shape, time);
                return Point {
                    distance: distance + point.distance,
                    ..point
                };
            }
            time -= stretch.duration;
            distance += stretch.length();
        }
        Point {
            distance,
            ..Point::default()
        }
    }
}

/// How a value from 0 to 1 is spread over `duration` (s): the quintic with no speed and acceleration at its ends.
pub fn spread(time: f64, duration: f64) -> Share {
    let s = (time / duration).clamp(0.0, 1.0);
    Share {
        value: s * s * s * (10.0 + s * (6.0 * s - 15.0)),
        rate: 30.0 * s * s * (1.0 - s) * (1.0 - s) / duration,
        acceleration: 60.0 * s * (1.0 - s) * (1.0 - 2.0 * s) / (duration * duration),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// That `[value, rate, acceleration]` are derivatives of each other.
    fn consistent(at: impl Fn(f64) -> [f64; 3], time: f64, scale: f64) {
        let h = 1e-5;
        let (before, now, after) = (at(time - h), at(time), at(time + h));
        assert!(((after[0] - before[0]) / (2.0 * h) - now[1]).abs() < 1e-6 * scale);
        assert!(((after[1] - before[1]) / (2.0 * h) - now[2]).abs() < 1e-4 * scale);
    }

    fn along(path: &Approach) -> impl Fn(f64) -> [f64; 3] + '_ {
        |time| {
            let Point {
                distance,
                speed,
                acceleration,
                ..
            } = path.at(time);
            [distance, speed, acceleration]
        }
    }

    fn shape() -> Shape {
        Shape::smooth(2.0, 14.0, 0.01)
    }

    proptest! {
        #[test]
        fn the_path_is_smooth_and_complete(length in 0.001..0.5, speed in 0.001..0.5, share in 0.01..0.99) {
            let path = Approach::new(shape(), length, speed);
            consistent(along(&path), share * path.duration(), 10.0);
            prop_assert!((path.at(path.duration()).distance - length).abs() < 1e-12);
            prop_assert_eq!(path.at(0.0), Point::default());
            prop_assert_eq!(path.at(path.duration() + 1.0).speed, 0.0);
            let point = path.at(share * path.duration());
            prop_assert!(point.speed <= speed * (1.0 + 1e-12) && point.acceleration.abs() <= 2.0, "{point:?}");
        }

        #[test]
        fn the_search_is_slow_and_begins_where_the_free_way_ends(
            free in 0.001..0.5, search in 0.001..0.02, speed in 0.001..0.5, slow in 1e-4..0.01, share in 0.01..0.99
        ) {
            let path = Approach::with_search(shape(), free, speed, search, slow);
            consistent(along(&path), share * path.duration(), 10.0);
            let point = path.at(share * path.duration());
            prop_assert!(point.speed <= speed * (1.0 + 1e-12));
            prop_assert!(point.distance < free - 1e-9 || point.speed <= slow * (1.0 + 1e-9), "{point:?}");
            let end = path.at(path.duration()).distance;
            prop_assert!((end - free - search).abs() < 1e-9 && path.at(path.duration() + 1.0).speed == 0.0);
        }

        #[test]
        fn a_trapezoid_is_complete_too(length in 0.001..0.5, search in 0.001..0.02, speed in 0.001..0.5) {
            let shape = Shape::trapezoid(2.0);
            for (path, length) in [
                (Approach::new(shape, length, speed), length),
                (Approach::with_search(shape, length, speed, search, 0.002), length + search),
            ] {
                prop_assert!((path.at(path.duration()).distance - length).abs() < 1e-9);
            }
        }

        #[test]
        fn spreading_is_smooth(share in 0.01..0.99) {
            let at = |time| {
                let Share { value, rate, acceleration } = spread(time, 0.1);
                [value, rate, acceleration]
            };
            consistent(at, share * 0.1, 1000.0);
        }
    }
}
