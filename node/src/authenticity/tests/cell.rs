//! A cell by its gates alone, and what is said in it.

use super::super::*;
use spatial::kinematics::Axes;
use spatial::ports::{
    ClockEcho, DeflectionSample, ENCODER_SAMPLES, Fault, HORIZON, RobotMode, Stamp, TaskAction,
};

/// 0, 1, 2, ...
pub(super) fn secret() -> [u8; KEY_BYTES] {
    std::array::from_fn(|i| i as u8)
}

pub(super) fn keyring(secret: [u8; KEY_BYTES]) -> Keyring {
    Keyring::new(Key::new(&secret), Vec::new())
}

pub(super) fn stamp(step: i64, boot_id: i64) -> Stamp {
    Stamp {
        step,
        utime: 1000 * step,
        boot_id,
    }
}

pub(super) fn state(step: i64, boot_id: i64) -> RobotState {
    RobotState {
        stamp: stamp(step, boot_id),
        sample_count: 1,
        axis_position: [Axes::repeat(0.25); ENCODER_SAMPLES],
        axis_velocity: Axes::zeros(),
        axis_setpoint: Axes::zeros(),
        mode: RobotMode::Idle,
        fault: Fault::None,
        fault_axis: -1,
        command_step: -1,
        missed_commands: 0,
        echo: ClockEcho::default(),
        authenticity: Authenticity::default(),
    }
}

pub(super) fn deflections(step: i64, boot_id: i64) -> Deflections {
    Deflections {
        stamp: stamp(step, boot_id),
        samples: [DeflectionSample::default(); 8],
        echo: ClockEcho::default(),
        authenticity: Authenticity::default(),
    }
}

pub(super) fn command(step: i64, boot_id: i64) -> Command {
    Command {
        stamp: stamp(step, boot_id),
        enable: true,
        axis_position: [Axes::repeat(0.25); HORIZON],
        send_utime: 1000 * step,
        authenticity: Authenticity::default(),
    }
}

pub(super) fn task(step: i64, boot_id: i64) -> Task {
    Task {
        stamp: stamp(step, boot_id),
        action: TaskAction::Start,
        ..Task::default()
    }
}

/// A cell whose nodes have the boot ids 1, 2, 3, and somebody who asks, with 4.
pub(super) struct Cell {
    pub(super) robot: Gate,
    pub(super) sensor: Gate,
    pub(super) controller: Gate,
    pub(super) operator: Gate,
    pub(super) step: i64,
}

/// What is said in a period.
pub(super) struct Said {
    pub(super) state: RobotState,
    pub(super) command: Command,
    pub(super) deflections: Deflections,
    pub(super) task: Task,
}

impl Cell {
    pub(super) fn new() -> Self {
        let keyring = keyring(secret());
        Self {
            robot: Gate::of_robot(keyring.clone(), &[7; KEY_BYTES]),
            sensor: Gate::new(keyring.clone(), Author::Sensor),
            controller: Gate::new(keyring.clone(), Author::Controller),
            operator: Gate::new(keyring, Author::Operator),
            step: 0,
        }
    }

    /// Everybody speaks once, in the order of a period, `controller` as that process; nobody listens yet.
    pub(super) fn say(&mut self, controller: i64) -> Said {
        self.step += 4;
        let mut state = state(self.step, 1);
        self.robot.sign(&mut state);
        let mut command = command(self.step, controller);
        self.controller.sign(&mut command);
        let mut deflections = deflections(self.step, 2);
        self.sensor.sign(&mut deflections);
        let mut task = task(self.step, 4);
        self.operator.sign(&mut task);
        Said {
            state,
            command,
            deflections,
            task,
        }
    }

    /// Everybody hears; whether each took what it should.
    pub(super) fn hear(&mut self, said: &Said) -> [Result<(), Refusal>; 7] {
        let states = [&mut self.controller, &mut self.operator].map(|gate| gate.admit(&said.state));
        let [controller, operator] = states;
        [
            controller,
            operator.and(self.controller.admit(&said.task)),
            self.controller.admit(&said.deflections),
            self.sensor.admit(&said.command),
            self.robot.admit(&said.command),
            self.robot.admit(&said.deflections),
            self.robot.admit(&said.task),
        ]
    }

    /// Periods until all is taken.
    pub(super) fn settle(&mut self, controller: i64) -> usize {
        let settled = (0..20).find(|_| {
            let said = self.say(controller);
            self.hear(&said).iter().all(Result::is_ok)
        });
        settled.unwrap()
    }
}
