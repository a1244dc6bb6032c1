//! The speed of the tcp towards the object, from heights that are known sample by sample.

/// Samples that are kept: older ones say nothing of the present.
const KEPT: usize = 64;
/// Samples that the swing's speed is taken from: 32 ms average 4.5 um of noise to 0.1 mm/s.
const SWING: usize = 32;
/// Samples of the encoders that one of the robot's speeds is taken from.
const ROBOT: usize = 8;
/// How long before the estimated instant of contact a sample surely was free, s.
const MARGIN_S: f64 = 0.002;

/// Where the tcp was at an instant. Heights along the normal, m.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Passed {
    time_s: f64,
    /// Of the deflected tcp: where it is.
    tcp_m: f64,
    /// Of the hanging tcp: where it would be without contact.
    hanging_m: f64,
}

/// The last samples, from which slopes are taken by least squares.
#[derive(Clone, Debug, PartialEq)]
pub struct SpeedEstimate {
    passed: [Passed; KEPT],
    count: usize,
}

impl Default for SpeedEstimate {
    fn default() -> Self {
        Self {
            passed: [Passed::default(); KEPT],
            count: 0,
        }
    }
}

impl SpeedEstimate {
    /// Take one sample in the order of sampling: when it was true (s), and the heights (m) of the deflected tcp and of
    /// the hanging one.
    pub fn take(&mut self, time_s: f64, tcp_m: f64, hanging_m: f64) {
        self.passed[self.count % KEPT] = Passed {
            time_s,
            tcp_m,
            hanging_m,
        };
        self.count += 1;
    }

    /// The speed (m/s) of the tcp downwards at the newest sample; 0 before there are enough.
    pub fn present(&self) -> f64 {
        let now_s = self.newest().time_s;
        self.robot(now_s).map_or(0.0, |robot| robot + self.swing(now_s))
    }

    /// The speed (m/s) of tcp and object towards each other at the contact that the newest sample has detected; the
    /// object comes with `object_m_per_s`.
    ///
    /// The robot does not know of the contact yet, so that the hanging tcp moves on as before while the real one rests
    /// on the object: the way between the two tells how long the contact has lasted. The speed is the robot's then, and
    /// that of the tool's swing on the sensor in the samples before. A slow approach is detected so late that none of
    /// them is left; then it is the robot's now, and the swing too slow to matter.
    pub fn at_contact(&self, object_m_per_s: f64) -> f64 {
        let newest = self.newest();
        let robot_now = self.robot(newest.time_s).unwrap_or(0.0);
        let since_s = (newest.tcp_m - newest.hanging_m) / (robot_now + object_m_per_s);
        // Not a number (without any speed) is before nothing.
        let contact_s = newest.time_s - since_s;
        let robot = self.robot(contact_s).unwrap_or(robot_now);
        robot + self.swing(contact_s - MARGIN_S) + object_m_per_s
    }

    fn newest(&self) -> Passed {
        self.passed[self.count.wrapping_sub(1) % KEPT]
    }

    /// The speed (m/s) of the hanging tcp downwards at `time_s`, from the samples until then: the encoders know it
    /// without noise, so that the last two speeds can be extrapolated where the robot accelerates.
    fn robot(&self, time_s: f64) -> Option<f64> {
        let hanging = |passed: &Passed| passed.hanging_m;
        let (last, at_s) = self.slope(time_s, 0, ROBOT, hanging)?;
        let Some((before, before_s)) = self.slope(time_s, ROBOT, ROBOT, hanging) else {
            return Some(last);
        };
        let acceleration = (last - before) / (at_s - before_s);
        let extrapolated = last + acceleration * (time_s - at_s);
        Some(if extrapolated.is_finite() {
            extrapolated
        } else {
            last
        })
    }

    /// The speed (m/s) downwards of the tcp against the hanging one, in the samples until `time_s`; 0 without enough of
    /// them.
    fn swing(&self, time_s: f64) -> f64 {
        self.slope(time_s, 0, SWING, |passed| passed.tcp_m - passed.hanging_m)
            .map_or(0.0, |(slope, _)| slope)
    }

    /// The slope downwards (m/s) of `height` over the last `count` samples not after `until_s`, `skipped` of them left
    /// out, and its time (s); `None` if there are not as many.
    fn slope(
        &self,
        until_s: f64,
        skipped: usize,
        count: usize,
        height: impl Fn(&Passed) -> f64,
    ) -> Option<(f64, f64)> {
        let newest_first = (0..self.count.min(KEPT)).map(|age| &self.passed[(self.count - 1 - age) % KEPT]);
        let until = newest_first.filter(|passed| passed.time_s <= until_s);
        let taken = || until.clone().skip(skipped).take(count);
        if taken().count() < count {
            return None;
        }
        let mean = |of: &dyn Fn(&Passed) -> f64| taken().map(of).sum::<f64>() / count as f64;
        let (mean_time, mean_height) = (mean(&|passed| passed.time_s), mean(&height));
        let (mut product, mut square) = (0.0, 0.0);
        for passed in taken() {
            let time = passed.time_s - mean_time;
            product += time * (height(passed) - mean_height);
            square += time * time;
        }
        (square > 0.0).then_some((-product / square, mean_time))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An approach at `speed`, with the tool's swing on top of it, that meets the object after 0.5 s and is followed for
    /// `after` s more: what is said of it at the end.
    fn approach(speed: f64, swing_m: f64, after: f64) -> SpeedEstimate {
        let mut estimate = SpeedEstimate::default();
        let ticks = (1e3 * (0.5 + after)) as i64;
        for tick in 0..=ticks {
            let time = tick as f64 * 1e-3;
            let hanging = -speed * time;
            let swing = swing_m * libm::sin(20.0 * (time - 0.5));
            estimate.take(time, (hanging + swing).max(-speed * 0.5), hanging);
        }
        estimate
    }

    #[test]
    fn the_present_speed_is_the_slope() {
        assert_eq!(SpeedEstimate::default().present(), 0.0);
        assert!((approach(0.02, 0.0, 0.0).present() - 0.02).abs() < 1e-12);
        let mut away = SpeedEstimate::default();
        (0..100).for_each(|tick| {
            away.take(
                f64::from(tick) * 1e-3,
                f64::from(tick) * 1e-5,
                f64::from(tick) * 1e-5,
            )
        });
        assert!((away.present() + 0.01).abs() < 1e-12);
    }

    /// After 3 ms (20 mm/s), and after 24 ms and 240 ms of pressing unnoticed.
    #[test]
    fn the_speed_at_contact_is_that_before_it() {
        for (speed, after) in [(0.02, 0.003), (0.001, 0.024), (1e-4, 0.24)] {
            let found = approach(speed, 0.0, after).at_contact(0.0);
            assert!((found / speed - 1.0).abs() < 1e-9, "{found} instead of {speed}");
        }
    }

    /// The tool swings against the approach with 20 rad/s times 50 um, 1 of 20 mm/s, a little less in the mean.
    #[test]
    fn the_tools_swing_counts() {
        let found = approach(0.02, 5e-5, 0.003).at_contact(0.0);
        assert!((0.0190..0.0192).contains(&found), "{found}");
    }

    /// While the robot brakes with 0.25 m/s^2, from 20 mm/s on: 15 mm/s 20 ms later, at the contact 3 ms ago.
    #[test]
    fn a_braking_robot_is_as_fast_as_it_is() {
        let mut estimate = SpeedEstimate::default();
        for tick in 0..=123 {
            let time = f64::from(tick) * 1e-3;
            let braking = (time - 0.1).max(0.0);
            let hanging = -0.02 * time + 0.125 * braking * braking;
            let object = -0.02 * 0.12 + 0.125 * 0.02 * 0.02;
            estimate.take(time, hanging.max(object), hanging);
        }
        let found = estimate.at_contact(0.0);
        assert!((found - 0.015).abs() < 2e-4, "{found}");
        assert!(
            (estimate.present() - 0.01425).abs() < 3e-3,
            "{}",
            estimate.present()
        );
    }

    /// The tool stands still, the object comes.
    #[test]
    fn a_moving_object_counts() {
        let mut estimate = SpeedEstimate::default();
        for tick in 0..=503 {
            let object = 0.02 * (f64::from(tick) * 1e-3 - 0.5);
            estimate.take(f64::from(tick) * 1e-3, object.max(0.0), 0.0);
        }
        let found = estimate.at_contact(0.02);
        assert!((found / 0.02 - 1.0).abs() < 1e-9, "{found}");
    }

    #[test]
    fn standing_still_is_no_speed() {
        let mut still = SpeedEstimate::default();
        assert_eq!(still.at_contact(0.0), 0.0);
        (0..100).for_each(|tick| still.take(f64::from(tick) * 1e-3, 0.5, 0.5));
        assert_eq!((still.present(), still.at_contact(0.0)), (0.0, 0.0));
    }
}
