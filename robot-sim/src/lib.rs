//! A position controlled industrial robot: the inner loop of the paper's Fig. 2.
//!
//! Pure: a [`RobotSim`] says at each tick where its encoders and its last link are, and takes the tool's motion
//! and the controller's commands for the coming tick. The encoders see the motor side; the link's motion travels
//! to the sensor's simulator only.

pub mod arm_links;
pub mod command_path;
pub mod dynamics;
pub mod gears;
pub mod guard;
pub mod links;
pub mod servo;

use command_path::CommandPath;
use dynamics::{Dynamics, State};
use guard::Guard;
use links::Posture;
use node::robot_states::{Answer, Heard, Patience, RobotStates};
use node::scenario::{Drives, Robot, Scenario};
use servo::{Servo, ServoParameters};
use spatial::kinematics::Axes;
use spatial::ports::{
    Authenticity, ClockEcho, Command, ENCODER_SAMPLES, Fault, LinkMotion, RobotState, Role, Stamp, ToolMotion,
};
use spatial::{Motion, TICK_S};
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
    guard: Guard,
    state: State,
    servos: [Servo; 6],
    path: CommandPath,
    encoder: [Axes; ENCODER_SAMPLES],
    setpoint: Axes,
    /// That of `state`.
    posture: Posture,
    link: Motion,
    motor_work_j: f64,
    patience: Patience,
    states: RobotStates,
    command_step: i64,
    /// A command has been taken in this period.
    answered: bool,
    missed_commands: i64,
}

/// Slower than this an axis stands, rad/s.
const STANDING_RAD_PER_S: f64 = 2e-3;

impl RobotSim {
    /// The scenario's robot at rest at its start pose, tick 0.
    ///
    /// Where it can't reach that pose (which reading a scenario refuses), it stands at home with the fault latched.
    pub fn new(scenario: &Scenario) -> Self {
        let robot = &scenario.robot;
        let start = scenario.start_axes();
        let patience = patience(scenario);
        let mut states = RobotStates::new(&patience);
        if start.is_err() {
            states.latch(Fault::Unreachable, -1);
            states.pass(&patience, true);
        }
        let dynamics = Dynamics::new(scenario);
        let position = start.unwrap_or_else(|_| dynamics.kinematics.home());
        let (drives, link_inertia) = (robot.drives(), dynamics.links.axis_inertia());
        let steps = libm::rint(TICK_S / robot.integration_step_s).max(1.0);
        let period = scenario.timing.command_period_ticks;
        let state = State::at_rest(position);
        let posture = dynamics.posture(&state);
        Self {
            seed: scenario.timing.seed,
            tick: 0,
            period,
            link: posture.link,
            posture,
            dynamics,
            step_s: TICK_S / steps,
            steps_per_tick: steps as usize,
            guard: Guard::new(scenario),
            state,
            servos: std::array::from_fn(|axis| {
                let parameters = servo_parameters(robot, &drives, axis, link_inertia[axis]);
                Servo::new(parameters, position[axis])
            }),
            path: CommandPath::new(period, robot.command_delay_periods, position),
            encoder: [position; ENCODER_SAMPLES],
            setpoint: position,
            motor_work_j: 0.0,
            patience,
            states,
            command_step: -1,
            answered: false,
            missed_commands: 0,
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
            kinetic_energy_j: self.dynamics.kinetic_energy(&self.state, &self.posture),
            elastic_energy_j: self.dynamics.elastic_energy(&self.state),
            motor_work_j: self.motor_work_j,
            dissipated_energy_j: self.state.dissipated_j,
        }
    }

    /// What the encoders and the servo say, now.
    pub fn state(&self) -> RobotState {
        RobotState {
            stamp: self.stamp(),
            sample_count: (self.tick + 1).clamp(1, ENCODER_SAMPLES as i64) as i32,
            axis_position: self.encoder,
            axis_velocity: self.state.motor_velocity,
            axis_setpoint: self.setpoint,
            mode: self.states.mode(),
            fault: self.states.fault(),
            fault_axis: self.states.fault_axis(),
            command_step: self.command_step,
            missed_commands: self.missed_commands,
            echo: ClockEcho::default(),
            authenticity: Authenticity::default(),
        }
    }

    /// Integrate over the coming tick, with the tool's motion now and the command, if one has come (more than one:
    /// [`Self::hear`]).
    pub fn advance(&mut self, tool: &ToolMotion, command: Option<&Command>) {
        if let Some(command) = command {
            self.hear(command);
        }
        if self.command_due() && !std::mem::take(&mut self.answered) {
            self.missed_commands += 1;
        }
        self.setpoint = self.path.at(self.tick);
        let torque = Axes::from_fn(|axis, _| {
            self.servos[axis].torque(
                self.setpoint[axis],
                self.state.motor_position[axis],
                self.state.motor_velocity[axis],
            )
        });
        for i in 0..self.steps_per_tick {
            let time = i as f64 * self.step_s;
            let (state, work) = self.dynamics.integrate(
                &self.state,
                &self.posture,
                &torque,
                &tool.motion,
                [time, self.step_s],
            );
            self.state = state;
            self.posture = self.dynamics.posture(&state);
            self.motor_work_j += work;
        }
        let tool_then = tool.motion.extrapolate(TICK_S);
        self.link = self
            .dynamics
            .link_motion(&self.state, &self.posture, &torque, &tool_then);
        let standing = self.state.motor_velocity.amax() < STANDING_RAD_PER_S;
        self.states.pass(&self.patience, standing);
        self.tick += 1;
        self.encoder.rotate_right(1);
        self.encoder[0] = self.state.motor_position;
    }

    /// Take a command; says whether it counts.
    ///
    /// One that can't be executed ([`guard`]) is not executed in part either: the fault latches, and the robot follows the
    /// last good command's horizon to its end and holds. The servo's command filter keeps to the axes' acceleration then
    /// as always: it is what brakes.
    pub fn hear(&mut self, command: &Command) -> Answer {
        let step = command.stamp.step;
        let heard = Heard {
            age: self.tick - step,
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
            self.path.accept(self.tick, command);
        }
        answer
    }

    /// Brake and latch `fault`, which comes from elsewhere.
    pub fn latch(&mut self, fault: Fault) {
        self.states.latch(fault, -1);
    }

    /// Clear a fault; `false`: not while the robot moves, or while somebody asks for motion.
    pub fn reset(&mut self) -> bool {
        self.states.reset(&self.patience, true)
    }

    fn stamp(&self) -> Stamp {
        Stamp::lockstep(self.tick, self.seed, Role::Robot)
    }
}

fn patience(scenario: &Scenario) -> Patience {
    let ticks = |seconds: f64| libm::rint(seconds / TICK_S) as i64;
    let (robot, timing) = (&scenario.robot, &scenario.timing);
    Patience::new(
        timing.command_period_ticks,
        robot.command_delay_periods,
        ticks(robot.arming_s),
        ticks(robot.command_gap_s),
    )
}

fn servo_parameters(robot: &Robot, drives: &Drives, axis: usize, link_inertia: f64) -> ServoParameters {
    let motor = drives.motor_inertia_kg_m2[axis];
    ServoParameters {
        filter_rad_per_s: TAU * robot.filter_frequency_hz,
        filter_damping: robot.filter_damping,
        acceleration_limit: drives.acceleration_limit_rad_per_s2[axis],
        velocity_limit: drives.velocity_limit_rad_per_s[axis],
        position_gain: robot.position_gain_per_s,
        velocity_gain: ServoParameters::velocity_gain(motor, robot.velocity_bandwidth_hz),
        integral_time_s: robot.velocity_integral_time_s,
        inertia: motor + link_inertia,
    }
}

#[cfg(test)]
mod tests;
