//! The free motion towards the object: a straight line with smooth changes of speed.

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

/// How long the speed takes to change by `change` (m/s), s. Model choice (PLANT.md section 2).
fn ramp_time(change: f64) -> f64 {
    (change / 0.25).max(0.1)
}

/// A stretch over which the speed goes from one value to another as `10 s^3 - 15 s^4 + 6 s^5`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Stretch {
    duration: f64,
    before: f64,
    after: f64,
}

impl Stretch {
    fn ramp(before: f64, after: f64, duration: f64) -> Self {
        Self {
            duration,
            before,
            after,
        }
    }

    fn cruise(speed: f64, length: f64) -> Self {
        Self::ramp(speed, speed, (length / speed).max(0.0))
    }

    fn length(&self) -> f64 {
        0.5 * (self.before + self.after) * self.duration
    }

    fn at(&self, time: f64) -> PathPoint {
        let (change, s) = (self.after - self.before, time / self.duration);
        PathPoint {
            distance: self.before * time + change * self.duration * s * s * s * s * (2.5 + s * (s - 3.0)),
            speed: self.before + change * s * s * s * (10.0 + s * (6.0 * s - 15.0)),
            acceleration: change / self.duration * 30.0 * s * s * (1.0 - s) * (1.0 - s),
        }
    }
}

/// From rest at `speed` to where the object may be, on at the speed of the search until it is met, and to rest.
///
/// Where nothing is known of the object, all of the way is search. Each change of speed takes
/// `max(0.1 s, change / 0.25 m/s^2)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Approach {
    stretches: [Stretch; 5],
}

impl Approach {
    /// Over `length` (m) with at most `speed` (m/s): less where the way is too short to reach it.
    pub fn new(length: f64, speed: f64) -> Self {
        let ramp = ramp_time(speed);
        let speed = speed.min(length / ramp);
        Self {
            stretches: [
                Stretch::ramp(0.0, speed, ramp),
                Stretch::cruise(speed, length - speed * ramp),
                Stretch::ramp(speed, 0.0, ramp),
                Stretch::default(),
                Stretch::default(),
            ],
        }
    }

    /// Over `free` (m) with at most `speed` (m/s), and `search` (m) with `search_speed`, which is the slower one.
    pub fn with_search(free: f64, speed: f64, search: f64, search_speed: f64) -> Self {
        // No faster than what can start and be held within the free way, and stop within the search: `slow^2 / (2 0.25
        // m/s^2)`, or half of 0.1 s at that speed.
        let slow = search_speed
            .min(speed)
            .min(free / (0.5 * ramp_time(search_speed) + ramp_time(0.0)))
            .min((20.0 * search).min((0.5 * search).sqrt()));
        // What fits into the free way: half of each ramp's duration at full speed.
        let (ramp_up, ramp_down) = (ramp_time(speed), ramp_time(speed - slow));
        let speed = speed
            .min((2.0 * free - slow * ramp_down) / (ramp_up + ramp_down))
            .max(slow);
        let (ramp_up, ramp_down) = (ramp_time(speed), ramp_time(speed - slow));
        let stop = ramp_time(slow);
        let ramps = [
            Stretch::ramp(0.0, speed, ramp_up),
            Stretch::ramp(speed, slow, ramp_down),
            Stretch::ramp(slow, 0.0, stop),
        ];
        let [up, down, end] = ramps;
        Self {
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
    pub fn at(&self, time: f64) -> PathPoint {
        let (mut time, mut distance) = (time.max(0.0), 0.0);
        for stretch in &self.stretches {
            if time < stretch.duration {
                let point = stretch.at(time);
                return PathPoint {
                    distance: distance + point.distance,
                    ..point
                };
            }
            time -= stretch.duration;
            distance += stretch.length();
        }
        PathPoint {
            distance,
            ..PathPoint::default()
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
        fn the_search_is_slow_and_begins_where_the_free_way_ends(
            free in 0.001..0.5, search in 0.001..0.02, speed in 0.001..0.5, slow in 1e-4..0.01, share in 0.01..0.99
        ) {
            let path = Approach::with_search(free, speed, search, slow);
            consistent(|t| path.at(t), share * path.duration(), 10.0);
            let point = path.at(share * path.duration());
            prop_assert!(point.speed <= speed * (1.0 + 1e-12));
            prop_assert!(point.distance < free - 1e-9 || point.speed <= slow * (1.0 + 1e-9), "{point:?}");
            let end = path.at(path.duration()).distance;
            prop_assert!((end - free - search).abs() < 1e-9 && path.at(path.duration() + 1.0).speed == 0.0);
        }

        #[test]
        fn spreading_is_smooth(share in 0.01..0.99) {
            consistent(|t| spread(t, 0.1), share * 0.1, 1000.0);
        }
    }
}
