//! Which set-points the robot follows: those of the commands that it has taken, by what its state says.
//!
//! A command that is lost leaves the robot on the horizon of the one before. Whatever is modelled of the robot, or
//! allowed to it, goes on from what it executes, not from what it was sent. A command takes n_d periods until it acts, so
//! that the next state tells in time what became of it.

use spatial::kinematics::Axes;
use spatial::ports::HORIZON;

/// Set-points that are followed between two cycles: a horizon, and its end thrice, after which the robot stands.
pub const FOLLOWED: usize = HORIZON + 3;

/// A command's horizon, and when it was sent.
#[derive(Clone, Copy, Debug)]
struct Given {
    tick: i64,
    horizon: [Axes; HORIZON],
}

impl Given {
    /// The set-point `periods` after the first; at the end it stays.
    fn at(&self, periods: usize) -> Axes {
        self.horizon[periods.min(HORIZON - 1)]
    }
}

/// What was sent, and what of it the robot has taken.
#[derive(Clone, Copy, Debug)]
pub struct Delivery {
    period_ticks: i64,
    /// The newest command that the robot has taken; `None`: none yet.
    taken: Option<Given>,
    /// The command sent last.
    sent: Option<Given>,
}

/// The set-points of the periods since the cycle before.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Followed {
    set_points: [Axes; FOLLOWED],
    count: usize,
    stands: bool,
}

impl Followed {
    /// In their order, T apart.
    pub fn set_points(&self) -> &[Axes] {
        &self.set_points[..self.count]
    }

    /// Whether the last one lies beyond the end of the horizon: the robot stands there.
    pub fn stands(&self) -> bool {
        self.stands
    }
}

impl Delivery {
    /// Nothing sent, with a period of `period_ticks`.
    pub fn new(period_ticks: i64) -> Self {
        Self {
            period_ticks,
            taken: None,
            sent: None,
        }
    }

    /// A command with this `horizon` (rad) is sent at `tick`.
    pub fn send(&mut self, tick: i64, horizon: &[Axes; HORIZON]) {
        self.sent = Some(Given {
            tick,
            horizon: *horizon,
        });
    }

    /// What the robot has followed instead of the first set-point sent in the cycle before; `None`: just that. At `tick` its
    /// state says that the newest command taken is that of `command_step`, -1: that of a robot that does not tell takes
    /// all.
    pub fn followed(&mut self, tick: i64, command_step: i64) -> Option<Followed> {
        let sent = self.sent?;
        if command_step == sent.tick || command_step < 0 {
            self.taken = self.sent;
        }
        // Before the first command that is taken the robot stands.
        let taken = self.taken?;
        let periods =
            |from: i64, to: i64| usize::try_from(to.saturating_sub(from) / self.period_ticks).unwrap_or(0);
        let (first, count) = (periods(taken.tick, sent.tick), periods(sent.tick, tick));
        let followed = Followed {
            set_points: std::array::from_fn(|i| taken.at(first.saturating_add(i))),
            count: count.min(FOLLOWED),
            stands: first.saturating_add(count) > HORIZON,
        };
        (first != 0 || count != 1).then_some(followed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The horizon sent at `tick`: ten times the instant at which each set-point is reached, in periods of four ticks.
    fn horizon(tick: i64) -> [Axes; HORIZON] {
        std::array::from_fn(|i| Axes::repeat(10.0 * (tick / 4 + i as i64) as f64))
    }

    fn followed(delivery: &mut Delivery, tick: i64, command_step: i64) -> Option<Vec<f64>> {
        let followed = delivery.followed(tick, command_step)?;
        Some(followed.set_points().iter().map(|axes| axes.x).collect())
    }

    #[test]
    fn a_command_that_is_taken_is_followed() {
        let mut delivery = Delivery::new(4);
        assert_eq!(followed(&mut delivery, 0, -1), None);
        for tick in (0..40).step_by(4) {
            delivery.send(tick, &horizon(tick));
            assert_eq!(followed(&mut delivery, tick + 4, tick), None);
        }
    }

    #[test]
    fn instead_of_a_lost_one_the_horizon_before_is_followed_to_its_end() {
        let mut delivery = Delivery::new(4);
        delivery.send(0, &horizon(0));
        assert_eq!(followed(&mut delivery, 4, 0), None);
        for i in 1..12 {
            delivery.send(4 * i, &[Axes::repeat(-1.0); HORIZON]);
            let expected = 10.0 * i.min(7) as f64;
            assert_eq!(followed(&mut delivery, 4 * i + 4, 0), Some(vec![expected]));
        }
        assert_eq!(followed(&mut delivery, 48, 44), None);
    }

    /// A lost state is a cycle that is missed.
    #[test]
    fn in_a_missed_cycle_the_horizon_is_followed() {
        let mut delivery = Delivery::new(4);
        delivery.send(0, &horizon(0));
        assert_eq!(followed(&mut delivery, 12, 0), Some(vec![0.0, 10.0, 20.0]));
        delivery.send(12, &horizon(12));
        assert_eq!(followed(&mut delivery, 20, 0), Some(vec![30.0, 40.0]));
        delivery.send(20, &horizon(20));
        assert_eq!(
            followed(&mut delivery, 4000, 20).map(|all| all.len()),
            Some(FOLLOWED)
        );
    }
}
