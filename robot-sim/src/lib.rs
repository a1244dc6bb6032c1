//! A position controlled industrial robot: the inner loop of the paper's Fig. 2.
//!
//! Pure: a [`RobotSim`] says at each tick where its encoders and its last link are, and takes the tool's motion
//! and the controller's commands for the coming tick. The encoders see the motor side; the link's motion travels
//! to the sensor's simulator only.

pub mod arm_links;
pub mod dynamics;
pub mod gears;
pub mod links;
pub mod servo;

use dynamics::{Dynamics, State};
use links::Posture;
use node::commanded::{Commanded, STANDING_RAD_PER_S};
use node::robot_states::Answer;
use node::scenario::{Drives, Robot, Scenario};
use servo::{Servo, ServoParameters};
use spatial::kinematics::Axes;
use spatial::ports::{
    Authenticity, ClockEcho, Command, Deflections, ENCODER_SAMPLES, Fault, LinkMotion, RobotState, Role,
    Stamp, ToolMotion,
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
    commanded: Commanded,
    state: State,
    servos: [Servo; 6],
    encoder: [Axes; ENCODER_SAMPLES],
    setpoint: Axes,
    /// That of `state`.
    posture: Posture,
    link: Motion,
    motor_work_j: f64,
}

impl RobotSim {
    /// The scenario's robot at rest at its start pose, tick 0.
    ///
    /// Where it can't reach that pose (which reading a scenario refuses), it stands at home with the fault latched.
    pub fn new(scenario: &Scenario) -> Self {
        let robot = &scenario.robot;
        let start = scenario.start_axes();
        let dynamics = Dynamics::new(scenario);
        let position = start.unwrap_or_else(|_| dynamics.kinematics.home());
        let mut commanded = Commanded::new(scenario, position);
        if start.is_err() {
            commanded.latch(Fault::Unreachable, -1);
            commanded.pass(true);
        }
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
            commanded,
            state,
            servos: std::array::from_fn(|axis| {
                let parameters = servo_parameters(robot, &drives, axis, link_inertia[axis]);
                Servo::new(parameters, position[axis])
            }),
            encoder: [position; ENCODER_SAMPLES],
            setpoint: position,
            motor_work_j: 0.0,
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
            mode: self.commanded.states().mode(),
            fault: self.commanded.states().fault(),
            fault_axis: self.commanded.states().fault_axis(),
            command_step: self.commanded.command_step(),
            missed_commands: self.commanded.missed_commands(),
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
        self.setpoint = self.commanded.begin(self.tick);
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
        self.commanded.pass(standing);
        self.tick += 1;
        self.encoder.rotate_right(1);
        self.encoder[0] = self.state.motor_position;
    }

    /// Take a command; says whether it counts. What brakes is the servo's command filter, which keeps to the axes'
    /// acceleration then as always.
    pub fn hear(&mut self, command: &Command) -> Answer {
        self.commanded.hear(self.tick, command)
    }

    /// From now on no motion begins without a fresh sensor ([`Self::sense`]).
    pub fn require_sensor(&mut self) {
        self.commanded.require_sensor();
    }

    /// Hear what the sensor says.
    pub fn sense(&mut self, deflections: &Deflections) {
        self.commanded.sense(self.tick, deflections);
    }

    /// Brake and latch `fault`, which comes from elsewhere.
    pub fn latch(&mut self, fault: Fault) {
        self.commanded.latch(fault, -1);
    }

    /// Clear a fault; `false`: not while the robot moves, or while somebody asks for motion.
    pub fn reset(&mut self) -> bool {
        self.commanded.reset(true)
    }

    fn stamp(&self) -> Stamp {
        Stamp::lockstep(self.tick, self.seed, Role::Robot)
    }
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
