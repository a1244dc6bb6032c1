//! The dynamics of the six axes: motors, gears, links, and the sensor's reaction on the last link.

use crate::gears::Gears;
use crate::links::{Links, Posture};
use nalgebra::Vector3;
use node::scenario::Scenario;
use spatial::kinematics::{Axes, Kinematics, join};
use spatial::{GRAVITY_M_PER_S2, Motion, ToolSuspension};

/// Where motors and links are and how fast, and what the gears have dissipated; also the rates of change of all that.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct State {
    /// What the encoders see, rad.
    pub motor_position: Axes,
    /// rad/s.
    pub motor_velocity: Axes,
    /// What carries the tool, rad; with rigid gears the same as the motors'.
    pub link_position: Axes,
    /// rad/s.
    pub link_velocity: Axes,
    /// Energy dissipated in the gears since start, J.
    pub dissipated_j: f64,
}

impl State {
    /// At rest at `axes` (rad), the gears relaxed.
    pub fn at_rest(axes: Axes) -> Self {
        Self {
            motor_position: axes,
            motor_velocity: Axes::zeros(),
            link_position: axes,
            link_velocity: Axes::zeros(),
            dissipated_j: 0.0,
        }
    }

    /// Each part of `self` combined with that of `other`.
    fn zip(
        &self,
        other: &Self,
        axes: impl Fn(&Axes, &Axes) -> Axes,
        scalar: impl Fn(f64, f64) -> f64,
    ) -> Self {
        Self {
            motor_position: axes(&self.motor_position, &other.motor_position),
            motor_velocity: axes(&self.motor_velocity, &other.motor_velocity),
            link_position: axes(&self.link_position, &other.link_position),
            link_velocity: axes(&self.link_velocity, &other.link_velocity),
            dissipated_j: scalar(self.dissipated_j, other.dissipated_j),
        }
    }

    /// The state after `time` s of changing with `rate`.
    fn moved(&self, rate: &Self, time: f64) -> Self {
        self.zip(rate, |x, r| x + r * time, |x, r| x + r * time)
    }
}

/// What moves, and what it carries.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dynamics {
    /// From axes to the sensor frame.
    pub kinematics: Kinematics,
    /// Inertia of the motors, kg m^2.
    pub motor_inertia: Axes,
    /// What the motors move.
    pub links: Links,
    /// What joins both; `None`: rigid.
    pub gears: Option<Gears>,
    suspension: ToolSuspension,
    tool_mass: f64,
    tool_centre_of_mass: Vector3<f64>,
}

impl Dynamics {
    /// The robot of a scenario with the sensor and tool that hang on it.
    pub fn new(scenario: &Scenario) -> Self {
        let (robot, sensor, tool) = (&scenario.robot, &scenario.sensor, &scenario.tool);
        let links = Links::new(robot);
        Self {
            kinematics: robot.kinematics(),
            motor_inertia: robot.drives().motor_inertia_kg_m2,
            links,
            gears: Gears::new(robot, &links.axis_inertia()),
            suspension: sensor.suspension(),
            tool_mass: tool.mass_kg,
            tool_centre_of_mass: tool.centre_of_mass_in_s_m.into(),
        }
    }

    /// What the links' positions and velocities in `state` make of the equations of motion.
    pub fn posture(&self, state: &State) -> Posture {
        // The motors turn with the links where the gears are rigid.
        let rotors = self.gears.map_or(self.motor_inertia, |_| Axes::zeros());
        self.links.at(&state.link_position, &state.link_velocity, &rotors)
    }

    /// Motion of s with the accelerations that `torque` (Nm) and the tool cause.
    pub fn link_motion(&self, state: &State, posture: &Posture, torque: &Axes, tool: &Motion) -> Motion {
        posture.motion(&self.rate(state, posture, torque, tool).link_velocity)
    }

    /// One step of the classical Runge-Kutta method over `step` s, from `time` s after the tick at which `tool`
    /// was known; returns the motors' work (J) too. `posture` is that of `state`.
    pub fn integrate(
        &self,
        state: &State,
        posture: &Posture,
        torque: &Axes,
        tool: &Motion,
        [time, step]: [f64; 2],
    ) -> (State, f64) {
        let half = 0.5 * step;
        let rate = |state: &State, tool: &Motion| self.rate(state, &self.posture(state), torque, tool);
        let k1 = self.rate(state, posture, torque, &tool.extrapolate(time));
        let tool_at_middle = tool.extrapolate(time + half);
        let k2 = rate(&state.moved(&k1, half), &tool_at_middle);
        let k3 = rate(&state.moved(&k2, half), &tool_at_middle);
        let k4 = rate(&state.moved(&k3, step), &tool.extrapolate(time + step));
        let ends = k1.zip(
            &k2.zip(&k3, |a, b| (a + b) * 2.0, |a, b| (a + b) * 2.0),
            |a, b| a + b,
            |a, b| a + b,
        );
        let mean = ends.zip(&k4, |a, b| (a + b) / 6.0, |a, b| (a + b) / 6.0);
        let end = state.moved(&mean, step);
        (end, torque.dot(&(end.motor_position - state.motor_position)))
    }

    /// Kinetic energy of motors and links, J.
    pub fn kinetic_energy(&self, state: &State, posture: &Posture) -> f64 {
        let links = posture.kinetic_energy(&state.link_velocity);
        match self.gears {
            None => links,
            Some(_) => {
                let square = state.motor_velocity.component_mul(&state.motor_velocity);
                0.5 * self.motor_inertia.dot(&square) + links
            }
        }
    }

    /// Elastic energy of the gears, J.
    pub fn elastic_energy(&self, state: &State) -> f64 {
        self.gears.map_or(0.0, |gears| {
            gears.energy(&(state.motor_position - state.link_position))
        })
    }

    /// How the state changes under the motors' `torque` (Nm) and the tool.
    ///
    /// Rigid gears: `(M(q) + m_m) q'' + c(q, q') = u + J^T reaction`. Elastic ones: `m_m q_m'' = u - F`,
    /// `M(q) q'' + c(q, q') = F + J^T reaction` (PLANT.md section 2; a motor turns about its own joint only).
    fn rate(&self, state: &State, posture: &Posture, torque: &Axes, tool: &Motion) -> State {
        let reaction = self.reaction(posture, tool);
        let (motor_acceleration, link_acceleration, dissipation) = match self.gears {
            None => {
                let both = posture.acceleration(&(torque + reaction));
                (both, both, 0.0)
            }
            Some(gears) => {
                let wind_up = state.motor_position - state.link_position;
                let slip = state.motor_velocity - state.link_velocity;
                let through = gears.torque(&wind_up, &slip);
                (
                    (torque - through).component_div(&self.motor_inertia),
                    posture.acceleration(&(through + reaction)),
                    gears.dissipation(&slip),
                )
            }
        };
        State {
            motor_position: state.motor_velocity,
            motor_velocity: motor_acceleration,
            link_position: state.link_velocity,
            link_velocity: link_acceleration,
            dissipated_j: dissipation,
        }
    }

    /// The sensor's reaction on the axes, Nm: the force `-F - M g` and the moment `-T - (p_s1 - p_s) x F - (R c) x M g`
    /// about s, through J^T. The tool's static weight is compensated by the robot (PLANT.md section 2), so that the
    /// reaction of a tool at rest is zero.
    fn reaction(&self, posture: &Posture, tool: &Motion) -> Axes {
        let link = &posture.link;
        let on_tool = self.suspension.wrench_on_tool(link, tool);
        let weight = Vector3::new(0.0, 0.0, -GRAVITY_M_PER_S2 * self.tool_mass);
        let arm = tool.pose.translation.vector - link.pose.translation.vector;
        let com = tool.pose.rotation * self.tool_centre_of_mass;
        let reaction = join(
            -on_tool.force - weight,
            -on_tool.moment - arm.cross(&on_tool.force) - com.cross(&weight),
        );
        posture.jacobian.tr_mul(&reaction)
    }
}
