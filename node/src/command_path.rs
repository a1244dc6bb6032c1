//! From the controller's set-points to what the servo is asked for at each tick: pure.

use spatial::kinematics::Axes;
use spatial::ports::{Command, HORIZON};

/// Set-points at multiples of the command period, with linear interpolation between them.
///
/// A command issued at tick k acts from k + n_d T: set-point i of its horizon is reached at k + (n_d + 1 + i) T.
/// A newer command overwrites what an older one said about the same instants.
#[derive(Clone, Debug)]
pub struct CommandPath {
    period: i64,
    delay_periods: i64,
    /// Set-points by period, as a ring of (period index, set-point).
    ring: Vec<(i64, Axes)>,
}

impl CommandPath {
    /// A path that holds `axes` until the first command acts; `period` in ticks.
    pub fn new(period: i64, delay_periods: i64, axes: Axes) -> Self {
        let length = HORIZON + delay_periods as usize + 2;
        // Everything up to the first instant a command of tick 0 can reach holds still.
        let ring = (0..length as i64)
            .map(|slot| (slot - length as i64, axes))
            .collect();
        let mut path = Self {
            period,
            delay_periods,
            ring,
        };
        for index in 0..=delay_periods {
            path.put(index, axes);
        }
        path
    }

    /// Take at tick `now` the horizon of a command that was issued at its own tick. What of it belongs to a period that is
    /// over or under way comes too late.
    pub fn accept(&mut self, now: i64, command: &Command) {
        let first = command.stamp.step / self.period + self.delay_periods + 1;
        let under_way = (now + self.period - 1) / self.period;
        // What is held since the last horizon's end is written out up to the new one: that takes the places of the last.
        for index in now / self.period..=under_way.max(first - 1) {
            self.put(index, self.get(index));
        }
        for (index, axes) in (first..).zip(&command.axis_position) {
            if index > under_way {
                self.put(index, *axes);
            }
        }
    }

    /// The set-point that the horizon of a command issued at `tick` follows.
    pub fn before(&self, tick: i64) -> Axes {
        self.get(tick / self.period + self.delay_periods)
    }

    /// The set-point at `tick`. Beyond the last horizon: its last set-point.
    pub fn at(&self, tick: i64) -> Axes {
        let index = tick.div_euclid(self.period);
        let inside = tick.rem_euclid(self.period) as f64 / self.period as f64;
        let start = self.get(index);
        if inside == 0.0 {
            return start;
        }
        start + (self.get(index + 1) - start) * inside
    }

    fn put(&mut self, index: i64, axes: Axes) {
        let slot = self.slot(index);
        self.ring[slot] = (index, axes);
    }

    /// The set-point of period `index`, or the newest one before it.
    fn get(&self, index: i64) -> Axes {
        let (known, axes) = self.ring[self.slot(index)];
        if known == index {
            return axes;
        }
        self.ring
            .iter()
            .filter(|(known, _)| *known < index)
            .max_by_key(|(known, _)| *known)
            .map_or(axes, |e| e.1)
    }

    fn slot(&self, index: i64) -> usize {
        index.rem_euclid(self.ring.len() as i64) as usize
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use spatial::ports::{Authenticity, Stamp};

    fn command(tick: i64, first: f64, slope: f64) -> Command {
        Command {
            stamp: Stamp {
                step: tick,
                ..Stamp::default()
            },
            enable: true,
            axis_position: std::array::from_fn(|i| Axes::repeat(first + slope * i as f64)),
            send_utime: 0,
            authenticity: Authenticity::default(),
        }
    }

    #[test]
    fn a_command_acts_after_its_delay_and_moves_linearly() {
        let mut path = CommandPath::new(4, 2, Axes::zeros());
        path.accept(0, &command(0, 1.0, 0.0));
        let heights: Vec<f64> = (0..=14).map(|tick| path.at(tick).x).collect();
        let expected = [
            0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.25, 0.5, 0.75, 1.0, 1.0, 1.0,
        ];
        assert_eq!(heights, expected);
    }

    #[test]
    fn newer_commands_overwrite_older_horizons() {
        let mut path = CommandPath::new(4, 2, Axes::zeros());
        path.accept(0, &command(0, 1.0, 1.0));
        path.accept(4, &command(4, 0.0, 0.0));
        assert_eq!(path.at(12).x, 1.0);
        assert_eq!(path.at(16).x, 0.0);
        assert_eq!(path.at(40).x, 0.0);
    }

    #[test]
    fn without_commands_the_horizon_is_followed_to_its_end_and_held() {
        let mut path = CommandPath::new(4, 2, Axes::zeros());
        path.accept(0, &command(0, 1.0, 1.0));
        assert_eq!(path.at(40).x, 8.0);
        assert_eq!(path.at(42).x, 8.0);
        assert_eq!(path.at(4000).x, 8.0);
    }

    /// After a silence of any length the robot goes on from where it was held, not from where it was before.
    #[test]
    fn a_command_after_a_silence_goes_on_from_the_end_of_the_last_horizon() {
        for silence in 0..30 {
            let mut path = CommandPath::new(4, 2, Axes::zeros());
            path.accept(0, &command(0, 1.0, 1.0));
            let (step, late) = (40 + 4 * silence, silence % 4);
            path.accept(step + late, &command(step, 8.0, 0.0));
            for tick in step + late..step + 80 {
                assert_eq!(path.at(tick).x, 8.0, "{silence} periods, tick {tick}");
            }
        }
    }

    /// The command of tick 0 acts from tick 8 on; it comes at tick 10, in the period that ends with its first set-point.
    #[test]
    fn what_comes_too_late_does_not_bend_the_period_under_way() {
        let mut path = CommandPath::new(4, 2, Axes::zeros());
        path.accept(10, &command(0, 1.0, 1.0));
        let heights: Vec<f64> = (10..=16).map(|tick| path.at(tick).x).collect();
        assert_eq!(heights, [0.0, 0.0, 0.0, 0.5, 1.0, 1.5, 2.0]);
    }
}
