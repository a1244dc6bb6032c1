//! What linear theory predicts of a scenario, to be held against simulations.
//!
//! The equations are the controller's ([`controller::margins`]), which publishes the margins of what it *assumes*. Here
//! robot, gears, servos, sensor and tool are what *is*, the law what the controller assumes.

pub use controller::margins::{Answer, Loop, Margins, Plant, Point, Response, Seen};

use controller::elastic::Design;
use controller::margins::{ElasticModel, GearSprings, LawModel, Servo, contact_stiffness};
use nalgebra::{Matrix3, Matrix6, Vector3, Vector6};
use node::scenario::{Gears, Law, Pairing, Scenario, SensorOutput};
use robot_sim::links::Links;
use robot_sim::servo::ServoParameters;
use spatial::TICK_S;
use std::f64::consts::TAU;

/// The loop of `scenario` in contact; `None` for a law that can't be regulated as it is assumed, or a robot that does not
/// reach the object.
pub fn closed(scenario: &Scenario) -> Option<Loop> {
    Some(Loop::close(&response(scenario)?, &law(scenario)?))
}

/// What any law sees of the plant of `scenario` in contact; `None` for a robot that does not reach the object.
pub fn response(scenario: &Scenario) -> Option<Response> {
    Response::new(&plant(scenario)?)
}

/// The law of `scenario`; `None`: what it assumes can't be regulated.
pub fn law(scenario: &Scenario) -> Option<LawModel> {
    let controller = &scenario.controller;
    let elastic = match controller.law {
        Law::Elastic => Some(ElasticModel::new(
            &Design::new(scenario)?,
            controller,
            gear_ratio(scenario),
            period_s(scenario),
            sensor_delay_s(scenario),
        )),
        _ => None,
    };
    LawModel::new(controller, period_s(scenario), elastic)
}

/// The plant of `scenario` in contact; `None`: its robot does not reach the start pose.
pub fn plant(scenario: &Scenario) -> Option<Plant> {
    let (robot, sensor, tool) = (&scenario.robot, &scenario.sensor, &scenario.tool);
    let controller = &scenario.controller;
    let position = scenario.start_axes().ok()?;
    let links = Links::new(robot);
    let inertia = links.axis_inertia();
    let posture = links.at(&position, &Vector6::zeros(), &Vector6::zeros());
    let mass = match &links {
        Links::Gantry(inertia) => Matrix6::from_diagonal(inertia),
        Links::Arm(links) => links.mass_matrix(&position),
    };
    let motors = robot.drives().motor_inertia_kg_m2;
    let servo = |axis: usize| Servo {
        filter_rad_per_s: TAU * robot.filter_frequency_hz,
        filter_damping: robot.filter_damping,
        position_gain: robot.position_gain_per_s,
        velocity_gain: ServoParameters::velocity_gain(motors[axis], robot.velocity_bandwidth_hz),
        integral_time_s: robot.velocity_integral_time_s,
        inertia: motors[axis] + inertia[axis],
    };
    let turned = posture.link.pose.rotation.to_rotation_matrix().into_inner();
    let centre = turned * Vector3::from(tool.centre_of_mass_in_s_m);
    let tcp: Vector3<f64> = turned * Vector3::from(tool.tcp_in_s_m);
    let lag_s = |bandwidth_hz: f64| 1.0 / (TAU * bandwidth_hz);
    Some(Plant {
        period_s: period_s(scenario),
        command_delay_s: (robot.command_delay_periods * scenario.timing.command_period_ticks) as f64 * TICK_S,
        servos: std::array::from_fn(servo),
        motors,
        gears: robot_sim::gears::Gears::new(robot, &inertia).map(|gears| GearSprings {
            stiffness: gears.stiffness,
            damping: gears.damping,
        }),
        links: mass,
        jacobian: posture.jacobian,
        command: posture.jacobian.lu().solve(&Vector6::ith(2, 1.0))?,
        sensor_stiffness: [sensor.stiffness_n_per_m, sensor.stiffness_nm_per_rad],
        sensor_damping: [sensor.damping_ns_per_m, sensor.damping_nms_per_rad],
        tool: tool_at_s(tool.mass_kg, &centre, &turned, &tool.inertia_kg_m2.into()),
        normal: Vector6::new(0.0, 0.0, 1.0, tcp.y, -tcp.x, 0.0),
        contact_n_per_m: contact(scenario),
        shown: match controller.sensor_output {
            SensorOutput::Deflection => [1.0, 1.0],
            SensorOutput::Force => [
                controller.compliance_m_per_n * sensor.stiffness_n_per_m,
                controller.compliance_rad_per_nm * sensor.stiffness_nm_per_rad,
            ],
        },
        sensor_delay_s: sensor_delay_s(scenario),
        sensor_lag_s: lag_s(sensor.bandwidth_hz),
        paired_delay_s: match controller.pairing {
            Pairing::Sampling => sensor_delay_s(scenario) + lag_s(controller.sensor_bandwidth_hz),
            Pairing::Arrival => 0.0,
        },
    })
}

/// The tool's mass matrix for twists at s, from its mass (kg), the way to its centre (m) and its principal moments of
/// inertia (kg m^2) along axes that are `turned`.
fn tool_at_s(
    mass_kg: f64,
    centre: &Vector3<f64>,
    turned: &Matrix3<f64>,
    moments: &Vector3<f64>,
) -> Matrix6<f64> {
    let cross = centre.cross_matrix();
    let about_s = turned * Matrix3::from_diagonal(moments) * turned.transpose() - cross * cross * mass_kg;
    let mut at_s = Matrix6::from_diagonal_element(mass_kg);
    at_s.fixed_view_mut::<3, 3>(0, 3).copy_from(&(-cross * mass_kg));
    at_s.fixed_view_mut::<3, 3>(3, 0).copy_from(&(cross * mass_kg));
    at_s.fixed_view_mut::<3, 3>(3, 3).copy_from(&about_s);
    at_s
}

/// What small motions about the desired force feel of the object, N/m, in series with what holds its surface.
fn contact(scenario: &Scenario) -> f64 {
    let object = &scenario.object;
    let surface = contact_stiffness(
        object.indentation_n_per_m * object.rebound_ratio,
        object.exponent,
        scenario.task.pressing_force_n(),
    );
    match object.support_n_per_m {
        0.0 => surface,
        support => 1.0 / (1.0 / surface + 1.0 / support),
    }
}

/// The first gear's real frequency over the assumed one; rigid gears are stiffer than anything assumed.
fn gear_ratio(scenario: &Scenario) -> f64 {
    match scenario.robot.gears {
        Gears::Rigid => f64::INFINITY,
        Gears::Elastic => {
            scenario.robot.drives().gear_frequency_hz[0] / scenario.controller.gears.frequency_hz[0]
        }
    }
}

fn period_s(scenario: &Scenario) -> f64 {
    scenario.timing.command_period_ticks as f64 * TICK_S
}

fn sensor_delay_s(scenario: &Scenario) -> f64 {
    scenario.sensor.delay_ticks as f64 * TICK_S
}

#[cfg(test)]
mod tests;
