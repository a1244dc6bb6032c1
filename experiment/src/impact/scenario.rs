//! A scenario as a question: what strikes, and what is struck.

use super::report::Question;
use controller::impact::{ImpactError, KicksLaw, Rebound, Surface, ToolInertia};
use nalgebra::Vector3;
use node::scenario::{Scenario, ToolShape};
use sensor_sim::object::Object;
use sensor_sim::tool::Body;
use spatial::TICK_S;
use spatial::kinematics::Unreachable;

/// Why a scenario is no question.
#[derive(Debug, thiserror::Error)]
pub enum NoQuestion {
    /// Its values are outside what the assessment holds for.
    #[error("the impact in the scenario can't be assessed: {0}")]
    Value(#[from] ImpactError),
    /// The robot can't take the start posture.
    #[error("the start of the scenario can't be reached: {0}; check task.start_position_m")]
    Unreachable(#[from] Unreachable),
}

/// The impact of the first contact of `scenario`: with what is (`[tool]`, `[object]`), not what is assumed.
///
/// The tool strikes in the orientation in which it hangs, along the normal of the object at rest.
pub fn question(scenario: &Scenario, name: &str) -> Result<Question, NoQuestion> {
    let object = &scenario.object;
    Ok(Question {
        name: name.to_owned(),
        surface: Surface {
            law: KicksLaw::new(object.indentation_n_per_m, object.exponent)?,
            rebound: Rebound::new(object.rebound_ratio)?,
        },
        effective_modulus_pa: None,
        effective_mass_kg: effective_mass_kg(scenario)?,
        speed_m_per_s: scenario.task.approach_speed_m_per_s * along_normal(scenario),
        sampling_time_s: scenario.timing.command_period_ticks as f64 * TICK_S,
        controlled_peak_n: None,
        allowed_force_n: (scenario.task.max_impact_force_n > 0.0).then_some(scenario.task.max_impact_force_n),
        allowed_remaining_depth_m: None,
        transient: None,
    })
}

/// What of the approach, straight down, goes along the object's normal.
fn along_normal(scenario: &Scenario) -> f64 {
    Object::new(&scenario.object).normal().z
}

/// Paper (17) needs this mass: of the tool as it hangs, at its tcp, along the object's normal, kg.
pub fn effective_mass_kg(scenario: &Scenario) -> Result<f64, NoQuestion> {
    let tool = &scenario.tool;
    let r_from_s = scenario.robot.kinematics().forward(&scenario.start_axes()?);
    let hanging = Body::new(tool, &scenario.sensor).hanging(&r_from_s);
    let normal = Object::new(&scenario.object).normal();
    let inertia = ToolInertia::new(tool.mass_kg, tool.inertia_kg_m2, tool.centre_of_mass_in_s_m)?;
    let tcp: Vector3<f64> = tool.tcp_in_s_m.into();
    Ok(inertia.at_tcp_kg(tcp, hanging.rotation.inverse() * normal))
}

/// What of a scenario the assessment leaves out, in words.
pub fn left_out(scenario: &Scenario) -> Vec<&'static str> {
    let object = &scenario.object;
    let moves = object.velocity_m_per_s != [0.0; 3]
        || object.swing_amplitude_m != [0.0; 3]
        || !object.profile_time_s.is_empty();
    let found = [
        (
            moves,
            "the object moves: its own speed comes on top of that of the approach",
        ),
        (
            object.support_n_per_m > 0.0,
            "the object yields: what moves of it takes part in the impact",
        ),
        (
            scenario.tool.shape != ToolShape::Point,
            "the tool touches with more than a point: its points share the coefficient, one after the other",
        ),
        (
            object.friction > 0.0,
            "friction: it turns the force away from the normal",
        ),
        (
            object.hole_radius_m > 0.0,
            "the hole: its chamfer has another normal",
        ),
    ];
    found
        .into_iter()
        .filter_map(|(applies, text)| applies.then_some(text))
        .collect()
}
