//! The rigid gantry's dynamics: six decoupled axes that carry the sensor and feel its reaction.

use nalgebra::Vector3;
use node::scenario::Scenario;
use spatial::kinematics::{Axes, Gantry, join};
use spatial::{GRAVITY_M_PER_S2, Motion, ToolSuspension};

/// Axis positions (rad) and velocities (rad/s).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct State {
    /// rad.
    pub position: Axes,
    /// rad/s.
    pub velocity: Axes,
}

/// What moves, and what it carries.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dynamics {
    /// Motor and link together, kg m^2 (rigid gears).
    pub inertia: Axes,
    suspension: ToolSuspension,
    tool_mass: f64,
    tool_centre_of_mass: Vector3<f64>,
    gantry: Gantry,
}

impl Dynamics {
    /// The gantry of a scenario with the sensor and tool that hang on it.
    pub fn new(scenario: &Scenario) -> Self {
        let (robot, sensor, tool) = (&scenario.robot, &scenario.sensor, &scenario.tool);
        Self {
            inertia: Axes::from(robot.motor_inertia_kg_m2) + Axes::from(robot.link_inertia_kg_m2),
            suspension: sensor.suspension(),
            tool_mass: tool.mass_kg,
            tool_centre_of_mass: tool.centre_of_mass_in_s_m.into(),
            gantry: Gantry,
        }
    }

    /// Motion of s with the accelerations that `torque` (Nm) and the tool cause.
    pub fn link_motion(&self, state: &State, torque: &Axes, tool: &Motion) -> Motion {
        let acceleration = self.acceleration(state, torque, tool);
        self.gantry
            .motion(&state.position, &state.velocity, &acceleration)
    }

    /// One step of the classical Runge-Kutta method over `step` s, from `time` s after the tick at which `tool`
    /// was known; returns the motors' work (J) too.
    pub fn integrate(
        &self,
        state: &State,
        torque: &Axes,
        tool: &Motion,
        time: f64,
        step: f64,
    ) -> (State, f64) {
        let half = 0.5 * step;
        let rate = |state: &State, time: f64| State {
            position: state.velocity,
            velocity: self.acceleration(state, torque, &tool.extrapolate(time)),
        };
        let moved = |rate: &State, time: f64| State {
            position: state.position + rate.position * time,
            velocity: state.velocity + rate.velocity * time,
        };
        let k1 = rate(state, time);
        let k2 = rate(&moved(&k1, half), time + half);
        let k3 = rate(&moved(&k2, half), time + half);
        let k4 = rate(&moved(&k3, step), time + step);
        let mean = State {
            position: (k1.position + (k2.position + k3.position) * 2.0 + k4.position) / 6.0,
            velocity: (k1.velocity + (k2.velocity + k3.velocity) * 2.0 + k4.velocity) / 6.0,
        };
        let end = moved(&mean, step);
        (end, torque.dot(&(end.position - state.position)))
    }

    /// Kinetic energy, J.
    pub fn kinetic_energy(&self, state: &State) -> f64 {
        0.5 * self.inertia.dot(&state.velocity.component_mul(&state.velocity))
    }

    /// `m q'' = u + J^T reaction`, axis by axis. The reaction of the sensor on the link is `-F - M g` with the
    /// moment `-T - (p_s1 - p_s) x F - (R c) x M g` about s: the tool's static weight is compensated by the
    /// robot (PLANT.md section 2).
    fn acceleration(&self, state: &State, torque: &Axes, tool: &Motion) -> Axes {
        let link = self
            .gantry
            .motion(&state.position, &state.velocity, &Axes::zeros());
        let on_tool = self.suspension.wrench_on_tool(&link, tool);
        let weight = Vector3::new(0.0, 0.0, -GRAVITY_M_PER_S2 * self.tool_mass);
        let arm = tool.pose.translation.vector - link.pose.translation.vector;
        let com = tool.pose.rotation * self.tool_centre_of_mass;
        let reaction = join(
            -on_tool.force - weight,
            -on_tool.moment - arm.cross(&on_tool.force) - com.cross(&weight),
        );
        (torque + self.gantry.jacobian(&state.position).tr_mul(&reaction)).component_div(&self.inertia)
    }
}
