//! What the check says in the roles that it plays.

use super::record::{At, Saying};
use super::session::{ConformError, Session};
use super::session_robot;
use node::clock;
use node::health::Health;
use node::peers::STATUS_PERIOD;
use spatial::TICK_US;
use spatial::kinematics::Axes;
use spatial::ports::{
    Authenticity, ClockEcho, Command, DeflectionSample, Deflections, HORIZON, Hello, NodeState, PROTOCOL,
    RobotState, Role, SampleFlags, Stamp, Task, TaskAction,
};
use std::time::{Duration, Instant};

impl Session {
    /// Statuses every 100 ms, and commands where no state asks for them.
    pub(super) fn keep_up(&mut self, now: Instant) -> Result<(), ConformError> {
        if now >= self.next_status {
            self.next_status = now + STATUS_PERIOD;
            let hello = self.hello();
            for role in &self.played {
                let mut status = Health::new(*role, hello).status();
                status.stamp = Stamp {
                    step: 0,
                    utime: self.us(now),
                    boot_id: self.boot_id,
                };
                status.state = NodeState::Running;
                status.authenticated = self.signatures.is_some();
                self.link.publish(&status)?;
            }
        }
        if let Some((due, step)) = self.next_command.filter(|(due, _)| now >= *due) {
            let ticks = i64::from(self.hello().ticks_per_cycle).clamp(1, 12);
            let period = Duration::from_micros((ticks * TICK_US).unsigned_abs());
            // What is late stays late.
            self.next_command = Some(((due + period).max(now), step + ticks));
            self.send(step, false, Axes::zeros(), false)?;
        }
        Ok(())
    }

    /// What is agreed on: as the robot says, or the node under test.
    fn hello(&self) -> Hello {
        let robot = self
            .record
            .peers
            .iter()
            .rev()
            .find(|it| it.message.role == Role::Robot);
        let said = robot.or(self.record.statuses.last());
        said.map_or(
            Hello {
                protocol: PROTOCOL,
                ticks_per_cycle: 4,
                ..Hello::default()
            },
            |it| it.message.hello,
        )
    }

    /// Ask for a reset, with every eighth state. While enabled commands come, only where they have come in time: what has not
    /// been enabled for 2 T may be reset.
    fn ask_reset(&mut self, step: i64) -> Result<(), ConformError> {
        let period = self.record.period_ticks().max(1);
        let mut newest = self.record.commands.iter().rev().map(|it| it.us);
        let gap_us = newest.next().zip(newest.next()).map_or(i64::MAX, |(b, a)| b - a);
        if step / period % 8 != 0 || 2 * gap_us > 3 * period * TICK_US {
            return Ok(());
        }
        self.requests += 1;
        let stamp = Stamp {
            step: self.requests,
            utime: 0,
            boot_id: self.boot_id,
        };
        let mut task = Task {
            stamp,
            action: TaskAction::Reset,
            ..Task::default()
        };
        if let Some(signatures) = &mut self.signatures {
            signatures.task(&mut task);
        }
        self.record.resets_us.push(self.us(clock::now()));
        Ok(self.link.publish(&task)?)
    }

    /// Answer a state by what is to be said.
    pub(super) fn answer(&mut self, state: &RobotState) -> Result<(), ConformError> {
        let (step, stay) = (state.stamp.step, state.axis_setpoint);
        if self.played.contains(&Role::Sensor) {
            self.press_nothing(step)?;
        }
        let reference = self.reference.unwrap_or(stay);
        // Half of what counts as motion: it is seen, and does no harm.
        let other = reference + Axes::repeat(0.5 * session_robot::STAY_RAD);
        match self.saying {
            Saying::Silence => Ok(()),
            Saying::Released => self.send(step, false, stay, false),
            Saying::Reset => {
                self.send(step, false, stay, false)?;
                self.ask_reset(step)
            }
            Saying::Future => self.send(step + 1000, false, stay, true),
            Saying::Old => self.send((step - 1000).max(0), false, stay, true),
            Saying::OutOfRange => self.send(step, false, Axes::repeat(1e6), true),
            Saying::Foreign => {
                self.send(step, false, stay, false)?;
                self.intrude(step, false, other)
            }
            Saying::Unsigned => {
                let at = self.command(step, self.boot_id, true, reference);
                self.record.odd_commands.push(at);
                Ok(self.link.publish(&at.message)?)
            }
            Saying::Stay => self.send(step, true, reference, false),
            Saying::ResetWhileEnabled => {
                self.send(step, true, reference, false)?;
                self.ask_reset(step)
            }
            Saying::Intruder => {
                self.send(step, true, reference, false)?;
                self.intrude(step, true, other)
            }
        }
    }

    fn send(&mut self, step: i64, enable: bool, axes: Axes, odd: bool) -> Result<(), ConformError> {
        let at = self.publish(step, self.boot_id, enable, axes)?;
        let record = if odd {
            &mut self.record.odd_commands
        } else {
            &mut self.record.commands
        };
        record.push(at);
        Ok(())
    }

    /// A sensor on which nothing hangs: a robot begins no motion without one.
    fn press_nothing(&mut self, step: i64) -> Result<(), ConformError> {
        let us = self.us(clock::now());
        let sample = |i| DeflectionSample {
            utime: us - i as i64 * TICK_US,
            flags: SampleFlags {
                valid: true,
                ..SampleFlags::default()
            },
            ..DeflectionSample::default()
        };
        let mut deflections = Deflections {
            stamp: Stamp {
                step,
                utime: us,
                boot_id: self.boot_id,
            },
            samples: std::array::from_fn(sample),
            echo: ClockEcho::default(),
            authenticity: Authenticity::default(),
        };
        if let Some(signatures) = &mut self.signatures {
            signatures.deflections(&mut deflections);
        }
        Ok(self.link.publish(&deflections)?)
    }

    /// A command of somebody else.
    fn intrude(&mut self, step: i64, enable: bool, axes: Axes) -> Result<(), ConformError> {
        self.publish(step, self.boot_id ^ 1, enable, axes).map(|_| ())
    }

    fn publish(
        &mut self,
        step: i64,
        boot_id: i64,
        enable: bool,
        axes: Axes,
    ) -> Result<At<Command>, ConformError> {
        let mut at = self.command(step, boot_id, enable, axes);
        if let Some(signatures) = &mut self.signatures {
            signatures.command(&mut at.message);
        }
        self.link.publish(&at.message)?;
        Ok(at)
    }

    /// A command of now, which is not signed.
    fn command(&self, step: i64, boot_id: i64, enable: bool, axes: Axes) -> At<Command> {
        let us = self.us(clock::now());
        let message = Command {
            stamp: Stamp {
                step,
                utime: us,
                boot_id,
            },
            enable,
            axis_position: [axes; HORIZON],
            send_utime: us,
            authenticity: Authenticity::default(),
        };
        At { us, message }
    }
}
