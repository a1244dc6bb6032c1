//! The robot's states, and who may command it: pure, counted in ticks, for the simulator and for a real robot's driver.
//!
//! ```text
//! Idle -> Armed -> Following <-> Bridging
//!   ^       |          |            |
//!   |       |       Braking <-------+
//!   +-------+----------+--> Fault        (out of it only by a reset)
//! ```
//!
//! A driver tells of each command with [`RobotStates::hear`] and does what the [`Answer`] says, and of the end of each tick
//! with [`RobotStates::pass`]. Between commands it follows the newest horizon to its end and holds there.

use spatial::ports::{Fault, HORIZON, RobotMode};

/// How long what may last, ticks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Patience {
    /// Good commands have to come for so long before one is executed.
    pub arming: i64,
    /// Without a new command for longer, commands are missing.
    pub missing: i64,
    /// From a command to the end of its horizon: older ones say nothing any more.
    pub horizon: i64,
    /// From the end of the horizon on: without a new command for longer, the robot brakes.
    pub gap: i64,
}

impl Patience {
    /// Of a robot on which commands act after `delay_periods` periods of `period` ticks; `arming` and `gap` in ticks.
    pub fn new(period: i64, delay_periods: i64, arming: i64, gap: i64) -> Self {
        Self {
            arming,
            missing: 2 * period,
            horizon: (delay_periods + HORIZON as i64) * period,
            gap,
        }
    }

    /// The longest silence that is bridged.
    fn bridged(&self) -> i64 {
        self.horizon + self.gap
    }

    /// A silence for which it does not matter how long it has lasted.
    fn forever(&self) -> i64 {
        self.bridged() + 1
    }
}

/// What is known of a command before it is looked at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Heard {
    /// Ticks since the robot's state that it answers; negative: from the future.
    pub age: i64,
    /// Who has sent it.
    pub owner: i64,
    /// Whether it asks for motion.
    pub enable: bool,
    /// Whether what the sensor says is fresh: without it no motion begins.
    pub sensed: bool,
}

/// What a command asks for, as its set-points show.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// To stay where the robot is.
    Stay,
    /// A motion that the robot can execute.
    Move,
    /// What the robot can't execute: why, and the first axis concerned.
    Refused(Fault, i32),
}

/// What to do with a command.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Answer {
    /// Follow its horizon.
    Execute,
    /// It is counted, and not followed.
    Counted,
    /// As if it had not come: late, repeated, from the future, from somebody else, or the robot does not listen.
    Ignored,
}

/// The robot's state and what led to it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct RobotStates {
    mode: RobotMode,
    fault: Fault,
    fault_axis: i32,
    /// Who commands the robot.
    owner: Option<i64>,
    /// Ticks since the state that the newest command of the owner answers.
    silence: i64,
    /// Ticks since anybody's last command that asks for motion.
    released: i64,
    /// Ticks since it was armed.
    armed: i64,
}

impl RobotStates {
    /// A robot at rest.
    pub fn new(patience: &Patience) -> Self {
        Self {
            mode: RobotMode::Idle,
            fault: Fault::None,
            fault_axis: -1,
            owner: None,
            silence: patience.forever(),
            released: patience.forever(),
            armed: 0,
        }
    }

    /// The state.
    pub fn mode(&self) -> RobotMode {
        self.mode
    }

    /// First cause of a latched fault.
    pub fn fault(&self) -> Fault {
        self.fault
    }

    /// Axis that the fault concerns, -1: none.
    pub fn fault_axis(&self) -> i32 {
        self.fault_axis
    }

    /// A command has come; `judge` looks at its set-points, if they matter.
    pub fn hear(&mut self, patience: &Patience, heard: Heard, judge: impl FnOnce() -> Verdict) -> Answer {
        if heard.age < 0 || heard.age > patience.horizon {
            return Answer::Ignored;
        }
        if heard.enable {
            self.released = 0;
        }
        let foreign = self.owner.is_some_and(|owner| owner != heard.owner);
        let old = self.owner.is_some() && heard.age >= self.silence;
        if foreign || old || matches!(self.mode, RobotMode::Braking | RobotMode::Fault) {
            return Answer::Ignored;
        }
        if !heard.enable {
            return self.release();
        }
        let verdict = judge();
        if let Verdict::Refused(fault, axis) = verdict {
            self.latch(fault, axis);
            return Answer::Ignored;
        }
        let arming =
            (patience.arming > 0 || !heard.sensed) && matches!(self.mode, RobotMode::Idle | RobotMode::Armed);
        if arming && verdict == Verdict::Move {
            return self.release();
        }
        if self.mode == RobotMode::Idle {
            self.armed = 0;
        }
        self.owner = Some(heard.owner);
        self.silence = heard.age;
        if arming && (self.mode == RobotMode::Idle || self.armed < patience.arming || !heard.sensed) {
            self.mode = RobotMode::Armed;
            return Answer::Counted;
        }
        self.mode = RobotMode::Following;
        Answer::Execute
    }

    /// A tick has passed; `standing`: no axis moves.
    pub fn pass(&mut self, patience: &Patience, standing: bool) {
        let silent = self.silence > patience.bridged();
        match self.mode {
            RobotMode::Armed if silent => {
                self.release();
            }
            RobotMode::Following | RobotMode::Bridging if silent => self.latch(Fault::CommandGap, -1),
            RobotMode::Following if self.silence > patience.missing => self.mode = RobotMode::Bridging,
            _ => {}
        }
        if self.mode == RobotMode::Braking && standing {
            self.owner = None;
            self.mode = match self.fault {
                Fault::None => RobotMode::Idle,
                _ => RobotMode::Fault,
            };
        }
        let forever = patience.forever();
        self.silence = (self.silence + 1).min(forever);
        self.released = (self.released + 1).min(forever);
        self.armed = (self.armed + 1).min(patience.arming);
    }

    /// Brake, because of `fault` on `axis` (-1: none). Of several faults the first is kept.
    pub fn latch(&mut self, fault: Fault, axis: i32) {
        if self.fault == Fault::None {
            self.fault = fault;
            self.fault_axis = axis;
            self.mode = RobotMode::Braking;
        }
    }

    /// Clear a fault that has stopped the robot; refused, with `false`, while it still moves, while somebody asks for
    /// motion, or while the cause is there.
    pub fn reset(&mut self, patience: &Patience, cause_gone: bool) -> bool {
        let released = self.released > patience.missing;
        if self.mode != RobotMode::Fault || !released || !cause_gone {
            return false;
        }
        *self = Self::new(patience);
        true
    }

    /// Motion is not asked for any more.
    fn release(&mut self) -> Answer {
        self.mode = match self.mode {
            RobotMode::Following | RobotMode::Bridging => RobotMode::Braking,
            _ => {
                self.owner = None;
                RobotMode::Idle
            }
        };
        Answer::Counted
    }
}

#[cfg(test)]
mod tests;
