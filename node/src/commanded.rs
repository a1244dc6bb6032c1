//! What a robot does with commands: which of them count, what the axes are asked for, and what state that brings it into;
//! pure, for the simulator and for a real robot's driver.
//!
//! Between two ticks a driver tells of what comes ([`Commanded::hear`], [`Commanded::reset`]); at each tick it asks for the
//! set-points ([`Commanded::begin`]), and at its end it says whether the axes stand ([`Commanded::pass`]).

use crate::command_path::CommandPath;
use crate::guard::Guard;
use crate::robot_states::{Answer, Heard, Patience, RobotStates};
use crate::scenario::Scenario;
use spatial::TICK_S;
use spatial::kinematics::Axes;
use spatial::ports::{Command, Fault};

/// Slower than this an axis stands, rad/s.
pub const STANDING_RAD_PER_S: f64 = 2e-3;

/// A robot under command.
#[derive(Clone, Debug)]
pub struct Commanded {
    period: i64,
    guard: Guard,
    path: CommandPath,
    patience: Patience,
    states: RobotStates,
    command_step: i64,
    /// A command has been taken in this period.
    answered: bool,
    missed_commands: i64,
}

impl Commanded {
    /// A scenario's robot, with its limits, at rest at `axes` (rad).
    pub fn new(scenario: &Scenario, axes: Axes) -> Self {
        let ticks = |seconds: f64| libm::rint(seconds / TICK_S) as i64;
        let (robot, period) = (&scenario.robot, scenario.timing.command_period_ticks);
        let delay = robot.command_delay_periods;
        let patience = Patience::new(period, delay, ticks(robot.arming_s), ticks(robot.command_gap_s));
        Self {
            period,
            guard: Guard::new(scenario),
            path: CommandPath::new(period, delay, axes),
            states: RobotStates::new(&patience),
            patience,
            command_step: -1,
            answered: false,
            missed_commands: 0,
        }
    }

    /// Take a command before `tick`; says whether it counts.
    ///
    /// One that can't be executed ([`Guard`]) is not executed in part either: the fault latches, and the robot follows the
    /// last good command's horizon to its end and holds.
    pub fn hear(&mut self, tick: i64, command: &Command) -> Answer {
        let step = command.stamp.step;
        let heard = Heard {
            age: tick - step,
            owner: command.stamp.boot_id,
            enable: command.enable,
        };
        let (guard, before) = (&self.guard, self.path.before(step));
        let answer = self
            .states
            .hear(&self.patience, heard, || guard.judge(&before, command));
        if answer != Answer::Ignored {
            self.answered = true;
            self.command_step = step;
        }
        if answer == Answer::Execute {
            self.path.accept(tick, command);
        }
        answer
    }

    /// Tick `tick` begins: the set-points (rad) that the axes are asked for.
    pub fn begin(&mut self, tick: i64) -> Axes {
        if tick % self.period == 0 && !std::mem::take(&mut self.answered) {
            self.missed_commands += 1;
        }
        self.path.at(tick)
    }

    /// The tick has passed; `standing`: no axis is faster than [`STANDING_RAD_PER_S`].
    pub fn pass(&mut self, standing: bool) {
        self.states.pass(&self.patience, standing);
    }

    /// Brake and latch `fault` on `axis` (-1: none), which comes from elsewhere.
    pub fn latch(&mut self, fault: Fault, axis: i32) {
        self.states.latch(fault, axis);
    }

    /// Clear a fault; `false`: not while the robot moves, while somebody asks for motion, or while the cause is there.
    pub fn reset(&mut self, cause_gone: bool) -> bool {
        self.states.reset(&self.patience, cause_gone)
    }

    /// State, fault and its axis.
    pub fn states(&self) -> &RobotStates {
        &self.states
    }

    /// Tick of the newest command accepted, -1: none.
    pub fn command_step(&self) -> i64 {
        self.command_step
    }

    /// Periods without a new command.
    pub fn missed_commands(&self) -> i64 {
        self.missed_commands
    }
}
