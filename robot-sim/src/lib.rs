//! A position controlled industrial robot: the inner loop of the paper's Fig. 2.
//!
//! Pure: a [`RobotSim`] says at each tick where its encoders and its last link are, and takes the tool's motion
//! and the controller's commands for the coming tick. The encoders see the motor side; the link's motion travels
//! to the sensor's simulator only.

pub mod command_path;
pub mod gantry;
pub mod servo;

use command_path::CommandPath;
use gantry::{Dynamics, State};
use node::scenario::{self, Scenario};
use servo::{Servo, ServoParameters};
use spatial::kinematics::{Axes, Gantry};
use spatial::ports::{
    Authenticity, Check, ClockEcho, Command, ENCODER_SAMPLES, Fault, LinkMotion, RobotMode, RobotState, Role,
    Stamp, ToolMotion,
};
use spatial::{Motion, Pose, TICK_S};
use std::f64::consts::TAU;

/// The robot at one tick.
#[derive(Clone, Debug)]
pub struct RobotSim {
    seed: i64,
    tick: i64,
    period: i64,
    dynamics: Dynamics,
    step_s: f64,
    steps_per_tick: usize,
    axis_minimum: Axes,
    axis_maximum: Axes,
    state: State,
    servos: [Servo; 6],
    path: CommandPath,
    encoder: [Axes; ENCODER_SAMPLES],
    setpoint: Axes,
    link: Motion,
    motor_work_j: f64,
    command_step: i64,
    missed_commands: i64,
    mode: RobotMode,
    fault: Fault,
    fault_axis: i32,
}

impl RobotSim {
    /// The scenario's robot at rest at its start pose, tick 0.
    pub fn new(scenario: &Scenario) -> Self {
        let robot = &scenario.robot;
        let position = start_axes(scenario);
        let state = State {
            position,
            velocity: Axes::zeros(),
        };
        let steps = libm::rint(TICK_S / robot.integration_step_s).max(1.0);
        let period = scenario.timing.command_period_ticks;
        Self {
            seed: scenario.timing.seed,
            tick: 0,
            period,
            dynamics: Dynamics::new(scenario),
            step_s: TICK_S / steps,
            steps_per_tick: steps as usize,
            axis_minimum: robot.axis_minimum_rad.into(),
            axis_maximum: robot.axis_maximum_rad.into(),
            state,
            servos: std::array::from_fn(|axis| Servo::new(servo_parameters(robot, axis), position[axis])),
            path: CommandPath::new(period, robot.command_delay_periods, position),
            encoder: [position; ENCODER_SAMPLES],
            setpoint: position,
            link: Motion::at_rest(Gantry.forward(&position)),
            motor_work_j: 0.0,
            command_step: -1,
            missed_commands: 0,
            mode: RobotMode::Idle,
            fault: Fault::None,
            fault_axis: -1,
        }
    }

    /// The tick now.
    pub fn tick(&self) -> i64 {
        self.tick
    }

    /// Whether the controller is to answer this tick with a command.
    pub fn command_due(&self) -> bool {
        self.tick % self.period == 0
    }

    /// The robot's half of the physics, now.
    pub fn link_motion(&self) -> LinkMotion {
        LinkMotion {
            stamp: self.stamp(),
            motion: self.link,
            kinetic_energy_j: self.dynamics.kinetic_energy(&self.state),
            elastic_energy_j: 0.0,
            motor_work_j: self.motor_work_j,
            dissipated_energy_j: 0.0,
        }
    }

    /// What the encoders and the servo say, now.
    pub fn state(&self) -> RobotState {
        RobotState {
            stamp: self.stamp(),
            sample_count: (self.tick + 1).clamp(1, ENCODER_SAMPLES as i64) as i32,
            axis_position: self.encoder,
            axis_velocity: self.state.velocity,
            axis_setpoint: self.setpoint,
            mode: self.mode,
            fault: self.fault,
            fault_axis: self.fault_axis,
            command_step: self.command_step,
            missed_commands: self.missed_commands,
            echo: ClockEcho::default(),
            authenticity: Authenticity::default(),
        }
    }

    /// Integrate over the coming tick, with the tool's motion now and the command, if one has come.
    ///
    /// A command that is not finite or leaves the axis limits is not executed: the fault latches, the robot
    /// holds the last good set-point.
    pub fn advance(&mut self, tool: &ToolMotion, command: Option<&Command>) {
        match command {
            Some(command) => self.take(command),
            None if self.command_due() => self.missed_commands += 1,
            None => {}
        }
        self.setpoint = self.path.at(self.tick);
        let torque = Axes::from_fn(|axis, _| {
            self.servos[axis].torque(
                self.setpoint[axis],
                self.state.position[axis],
                self.state.velocity[axis],
            )
        });
        for i in 0..self.steps_per_tick {
            let time = i as f64 * self.step_s;
            let (state, work) =
                self.dynamics
                    .integrate(&self.state, &torque, &tool.motion, time, self.step_s);
            self.state = state;
            self.motor_work_j += work;
        }
        self.link = self
            .dynamics
            .link_motion(&self.state, &torque, &tool.motion.extrapolate(TICK_S));
        self.tick += 1;
        self.encoder.rotate_right(1);
        self.encoder[0] = self.state.position;
    }

    fn take(&mut self, command: &Command) {
        if self.mode == RobotMode::Fault || !command.enable {
            return;
        }
        if let Some(axis) = self.refused_axis(command) {
            self.mode = RobotMode::Fault;
            self.fault = Fault::CommandInvalid;
            self.fault_axis = axis;
            return;
        }
        self.mode = RobotMode::Following;
        self.command_step = command.stamp.step;
        self.path.accept(self.tick, command);
    }

    /// The first axis whose set-points can't be executed.
    fn refused_axis(&self, command: &Command) -> Option<i32> {
        let finite = command.check().is_ok();
        (0..6)
            .find(|&axis| {
                let limits = self.axis_minimum[axis]..=self.axis_maximum[axis];
                !finite
                    || command
                        .axis_position
                        .iter()
                        .any(|setpoint| !limits.contains(&setpoint[axis]))
            })
            .map(|axis| axis as i32)
    }

    fn stamp(&self) -> Stamp {
        Stamp::lockstep(self.tick, self.seed, Role::Robot)
    }
}

/// The axes at which the nominal tcp is at the task's start position, s parallel to r.
pub fn start_axes(scenario: &Scenario) -> Axes {
    let tcp: nalgebra::Vector3<f64> = scenario.tool.tcp_in_s_m.into();
    let start: nalgebra::Vector3<f64> = scenario.task.start_position_m.into();
    Gantry.inverse(&Pose::translation(
        start.x - tcp.x,
        start.y - tcp.y,
        start.z - tcp.z,
    ))
}

fn servo_parameters(robot: &scenario::Robot, axis: usize) -> ServoParameters {
    let motor = robot.motor_inertia_kg_m2[axis];
    ServoParameters {
        filter_rad_per_s: TAU * robot.filter_frequency_hz,
        filter_damping: robot.filter_damping,
        acceleration_limit: robot.acceleration_limit_rad_per_s2[axis],
        velocity_limit: robot.velocity_limit_rad_per_s[axis],
        position_gain: robot.position_gain_per_s,
        velocity_gain: ServoParameters::velocity_gain(motor, robot.velocity_bandwidth_hz),
        integral_time_s: robot.velocity_integral_time_s,
        inertia: motor + robot.link_inertia_kg_m2[axis],
    }
}

#[cfg(test)]
mod tests;
