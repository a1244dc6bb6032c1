//! Which set-points the robot follows: those of the commands that it has taken, by what its state says.
//!
//! A command that is lost leaves the robot on the horizon of the one before. Whatever is modelled of the robot, or
//! allowed to it, goes on from what it executes, not from what it was sent. A command takes n_d periods until it acts, so
//! that the next state tells in time what became of it. Where that state is lost, the robot is taken to have followed what
//! it was sent, until another one tells; then the model goes back to where that was wrong.

use crate::command_dynamics::CommandDynamics;
use crate::limits::Sent;
use spatial::kinematics::Axes;
use spatial::ports::HORIZON;

/// Set-points that are followed until a cycle: a horizon, and its end thrice, after which the robot stands.
pub const FOLLOWED: usize = HORIZON + 3;

/// What is modelled of the robot before a command.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Modelled {
    /// The set-points that it follows.
    pub sent: [Sent; 6],
    /// How it follows them; `None`: that is not modelled.
    pub dynamics: Option<CommandDynamics>,
}

/// A command's horizon, when it was sent, and what was modelled before.
#[derive(Clone, Copy, Debug)]
struct Given {
    tick: i64,
    horizon: [Axes; HORIZON],
    before: Modelled,
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
    /// The newest command of which a state has told; `None`: of none yet.
    taken: Option<Given>,
    /// The commands sent last.
    sent: [Given; FOLLOWED],
    /// Place of the next one.
    next: usize,
    count: usize,
}

/// The set-points that the robot has followed instead of those of the commands since one that it has not taken.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Followed {
    before: Modelled,
    set_points: [Axes; FOLLOWED],
    count: usize,
    stands: bool,
}

impl Followed {
    /// What was modelled before the first of them.
    pub fn before(&self) -> &Modelled {
        &self.before
    }

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
        let nothing = Given {
            tick: 0,
            horizon: [Axes::zeros(); HORIZON],
            before: Modelled::default(),
        };
        Self {
            period_ticks,
            taken: None,
            sent: [nothing; FOLLOWED],
            next: 0,
            count: 0,
        }
    }

    /// A command with this `horizon` (rad) is sent at `tick`; `before` it this was modelled of the robot.
    pub fn send(&mut self, tick: i64, horizon: &[Axes; HORIZON], before: Modelled) {
        self.sent[self.next] = Given {
            tick,
            horizon: *horizon,
            before,
        };
        self.next = (self.next + 1) % FOLLOWED;
        self.count = (self.count + 1).min(FOLLOWED);
    }

    /// The commands sent last, the oldest first.
    fn sent(&self) -> impl DoubleEndedIterator<Item = &Given> {
        (0..self.count).map(|i| &self.sent[(self.next + FOLLOWED - self.count + i) % FOLLOWED])
    }

    /// What the robot has followed until `tick` instead of the first set-point of each command; `None`: just those. Its state
    /// says that the newest command taken is that of `command_step`, -1: that of a robot that does not tell takes all; so
    /// does one of which no state has come, `None`, until another one tells.
    pub fn followed(&mut self, tick: i64, command_step: Option<i64>) -> Option<Followed> {
        let newest = *self.sent().next_back()?;
        let told = match command_step {
            Some(step) if step >= 0 => self.sent().find(|given| given.tick == step).copied(),
            _ => Some(newest),
        };
        if command_step.is_some() {
            self.taken = told.or(self.taken);
        }
        let taken = match command_step {
            None => newest,
            // Before the first command that is taken the robot stands.
            Some(_) => self.taken?,
        };
        let since = *self
            .sent()
            .find(|given| given.tick > taken.tick)
            .unwrap_or(&newest);
        let periods =
            |from: i64, to: i64| usize::try_from(to.saturating_sub(from) / self.period_ticks).unwrap_or(0);
        let (first, count) = (periods(taken.tick, since.tick), periods(since.tick, tick));
        let followed = Followed {
            before: since.before,
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

    /// What is modelled before the command of `tick`: there, with the tick as the set-point.
    fn before(tick: i64) -> Modelled {
        Modelled {
            sent: [Sent::at_rest(tick as f64); 6],
            dynamics: None,
        }
    }

    fn send(delivery: &mut Delivery, tick: i64) {
        delivery.send(tick, &horizon(tick), before(tick));
    }

    /// From the command of which tick on, and what.
    fn followed(delivery: &mut Delivery, tick: i64, command_step: Option<i64>) -> Option<(i64, Vec<f64>)> {
        let followed = delivery.followed(tick, command_step)?;
        let since = followed.before().sent[0].position as i64;
        Some((since, followed.set_points().iter().map(|axes| axes.x).collect()))
    }

    #[test]
    fn a_command_that_is_taken_is_followed() {
        let mut delivery = Delivery::new(4);
        assert_eq!(followed(&mut delivery, 0, Some(-1)), None);
        for tick in (0..40).step_by(4) {
            send(&mut delivery, tick);
            assert_eq!(followed(&mut delivery, tick + 4, Some(tick)), None);
        }
    }

    #[test]
    fn instead_of_lost_ones_the_horizon_before_is_followed_to_its_end() {
        let mut delivery = Delivery::new(4);
        send(&mut delivery, 0);
        assert_eq!(followed(&mut delivery, 4, Some(0)), None);
        let mut expected = Vec::new();
        for i in 1..12 {
            delivery.send(4 * i, &[Axes::repeat(-1.0); HORIZON], before(4 * i));
            expected.push(10.0 * i.min(7) as f64);
            let found = followed(&mut delivery, 4 * i + 4, Some(0));
            assert_eq!(found, Some((4, expected.clone())));
        }
        assert_eq!(followed(&mut delivery, 48, Some(44)), None);
    }

    /// Without a state all commands are taken to be taken, until one tells of the one that was lost.
    #[test]
    fn what_was_assumed_is_put_right_by_the_next_state() {
        let mut delivery = Delivery::new(4);
        for (tick, told) in [(0, Some(-1)), (4, Some(0)), (8, None), (12, None)] {
            assert_eq!(followed(&mut delivery, tick, told), None);
            send(&mut delivery, tick);
        }
        let mut found = delivery;
        assert_eq!(followed(&mut found, 16, Some(12)), None);
        assert_eq!(followed(&mut found, 16, Some(8)), Some((12, vec![30.0])));
        assert_eq!(followed(&mut found, 16, Some(4)), Some((8, vec![20.0, 30.0])));
        assert_eq!(
            followed(&mut delivery, 16, Some(0)),
            Some((4, vec![10.0, 20.0, 30.0]))
        );
    }

    #[test]
    fn in_a_missed_cycle_the_horizon_is_followed() {
        let mut delivery = Delivery::new(4);
        send(&mut delivery, 0);
        assert_eq!(
            followed(&mut delivery, 12, Some(0)),
            Some((0, vec![0.0, 10.0, 20.0]))
        );
        send(&mut delivery, 12);
        assert_eq!(followed(&mut delivery, 20, None), Some((12, vec![30.0, 40.0])));
        send(&mut delivery, 20);
        let found = followed(&mut delivery, 4000, Some(20));
        assert_eq!(found.map(|(_, all)| all.len()), Some(FOLLOWED));
    }
}
