//! How a motion that is left off fades away, so that the next one can begin at rest.

use crate::dofs::Dofs;

/// From an offset with a rate, without acceleration, to nothing.
///
/// Model choice: the quintic that has the offset x and the rate v at the beginning and nothing else at its ends,
/// `x (1 - 10 s^3 + 15 s^4 - 6 s^5) + v D (s - 6 s^3 + 8 s^4 - 3 s^5)`, s from 0 to 1 over the duration D.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Fade {
    /// m and rad.
    offset: Dofs,
    /// m/s and rad/s.
    rate: Dofs,
    duration_s: f64,
}

/// Least duration, s: that of the shortest change of speed of an approach.
const SHORTEST_S: f64 = 0.1;
/// How fast the speed changes on average at most, m/s^2 (and rad/s^2).
const DECELERATION: f64 = 0.25;

impl Fade {
    /// How long a motion with `rate` takes to come to rest, s.
    pub(super) fn duration_s(rate: &Dofs) -> f64 {
        (rate.amax() / DECELERATION).max(SHORTEST_S)
    }

    /// How far it goes until it rests: to the middle between start and goal, so that its speed falls as
    /// `1 - 3 s^2 + 2 s^3` and never turns back.
    pub(super) fn way_to_rest(rate: &Dofs) -> Dofs {
        rate * (0.5 * Self::duration_s(rate))
    }

    /// From `offset` with `rate` on.
    pub(super) fn new(offset: Dofs, rate: Dofs) -> Self {
        Self {
            offset,
            rate,
            duration_s: Self::duration_s(&rate),
        }
    }

    /// How long it takes, s.
    pub(super) fn lasts_s(&self) -> f64 {
        self.duration_s
    }

    /// What is left `time` (s) after the beginning.
    pub(super) fn at(&self, time: f64) -> Dofs {
        let s = (time / self.duration_s).clamp(0.0, 1.0);
        let cube = s * s * s;
        self.offset * (1.0 - cube * (10.0 + s * (6.0 * s - 15.0)))
            + self.rate * (self.duration_s * (s - cube * (6.0 + s * (3.0 * s - 8.0))))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 20 mm/s come to rest within 0.1 s and 1 mm, at 0.3 m/s^2 at most, without turning back.
    #[test]
    fn a_speed_fades_smoothly_and_never_turns_back() {
        let rate = Dofs::ith(2, -0.02);
        let way = Fade::way_to_rest(&rate);
        assert!((way.z + 1e-3).abs() < 1e-12);
        let fade = Fade::new(-way, rate);
        assert_eq!(
            (fade.at(-1.0), fade.at(0.1), fade.at(9.0)),
            (-way, Dofs::zeros(), Dofs::zeros())
        );
        let h = 1e-4;
        let at = |i: i32| fade.at(f64::from(i) * h).z;
        for i in 1..1000 {
            let speed = (at(i + 1) - at(i)) / h;
            let change = (at(i + 1) - 2.0 * at(i) + at(i - 1)) / (h * h);
            assert!((-0.02 - 1e-9..=1e-9).contains(&speed), "{speed} m/s at {i}");
            assert!(change.abs() < 0.3 + 1e-4, "{change} m/s^2 at {i}");
        }
    }
}
