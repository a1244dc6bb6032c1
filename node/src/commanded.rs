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
use spatial::ports::{Command, Deflections, Fault};

/// Slower than this an axis stands, rad/s.
pub const STANDING_RAD_PER_S: f64 = 2e-3;

/// The sensor's newest sample is believed for so long if older ones follow it, ticks.
const MISLED: i64 = 500;

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
    sensor: Option<Sensed>,
}

/// What has been heard of the sensor.
#[derive(Clone, Copy, Debug)]
struct Sensed {
    /// Instant of the newest sample, us on the sensor's clock.
    utime: i64,
    /// Tick at which it came.
    tick: i64,
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
            sensor: None,
        }
    }

    /// From now on no motion begins unless a sample that the sensor took within 3 T has been heard ([`Self::sense`]). In
    /// lockstep each tick waits for the sensor anyway.
    pub fn require_sensor(&mut self) {
        // Older than any.
        self.sensor = Some(Sensed {
            utime: i64::MIN,
            tick: i64::MIN / 2,
        });
    }

    /// The sensor that is worked with has said this before `tick`.
    pub fn sense(&mut self, tick: i64, deflections: &Deflections) {
        let valid = deflections.samples.iter().filter(|sample| sample.flags.valid);
        if let (Some(known), Some(utime)) = (&mut self.sensor, valid.map(|sample| sample.utime).max()) {
            if utime > known.utime {
                *known = Sensed { utime, tick };
            } else if utime < known.utime && tick - known.tick > MISLED {
                // Nobody's time goes back for long: the newest sample was none of the sensor's.
                known.utime = utime;
            }
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
            sensed: self
                .sensor
                .is_none_or(|known| tick - known.tick <= 3 * self.period),
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

#[cfg(test)]
mod tests {
    use super::*;
    use spatial::ports::{Authenticity, ClockEcho, DeflectionSample, HORIZON, RobotMode, SampleFlags, Stamp};

    fn deflections(utime: i64, valid: bool) -> Deflections {
        let flags = SampleFlags {
            valid,
            ..SampleFlags::default()
        };
        let sample = DeflectionSample {
            utime,
            flags,
            ..DeflectionSample::default()
        };
        Deflections {
            stamp: Stamp::default(),
            samples: [sample; 8],
            echo: ClockEcho::default(),
            authenticity: Authenticity::default(),
        }
    }

    /// The mode after a second of good commands, the sensor saying `said` of each tick.
    fn mode(require: bool, said: impl Fn(i64) -> Option<Deflections>) -> RobotMode {
        let scenario = Scenario::default();
        let axes = scenario.start_axes().unwrap();
        let mut robot = Commanded::new(&scenario, axes);
        if require {
            robot.require_sensor();
        }
        for tick in 0..1000 {
            if let Some(said) = said(tick) {
                robot.sense(tick, &said);
            }
            if tick % 4 == 0 {
                let command = Command {
                    stamp: Stamp {
                        step: tick,
                        utime: 0,
                        boot_id: 1,
                    },
                    enable: true,
                    axis_position: [axes; HORIZON],
                    send_utime: 0,
                    authenticity: Authenticity::default(),
                };
                robot.hear(tick, &command);
            }
            robot.begin(tick);
            robot.pass(true);
        }
        robot.states().mode()
    }

    #[test]
    fn a_robot_that_requires_a_sensor_follows_with_fresh_samples_alone() {
        let fresh = |tick| Some(deflections(1000 * tick, true));
        assert_eq!(mode(true, fresh), RobotMode::Following);
        assert_eq!(mode(true, |_| None), RobotMode::Armed);
        assert_eq!(mode(true, |_| Some(deflections(5, true))), RobotMode::Armed);
        assert_eq!(
            mode(true, |tick| Some(deflections(1000 * tick, false))),
            RobotMode::Armed
        );
        assert_eq!(mode(false, |_| None), RobotMode::Following);
        // A sample of the far future in the sensor's name.
        let lie = |tick: i64| Some(deflections(if tick == 0 { i64::MAX } else { 1000 * tick }, true));
        assert_eq!(mode(true, lie), RobotMode::Following);
    }
}
