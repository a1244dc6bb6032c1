//! Whether a start can be answered for: fresh, consistent and plausible data of robot and sensor, or why not.

use crate::settings::Settings;
use nalgebra::{Matrix3, Vector3};
use node::scenario::TaskKind;
use spatial::ports::{Fault, ParameterAnswer, RobotState};
use spatial::{Deflection, GRAVITY_M_PER_S2, Pose};

/// Why nothing begins, and the limit that was left, in the unit that [`ParameterAnswer`] says.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Refusal {
    pub(crate) answer: ParameterAnswer,
    pub(crate) limit: f64,
}

/// What is known of robot and sensor when a start is asked for.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Evidence<'a> {
    pub(crate) state: &'a RobotState,
    /// Since the robot's sampling stamp advanced, s.
    pub(crate) state_age_s: f64,
    /// Since the sensor brought a valid sample that is newer than all before, s.
    pub(crate) sensor_age_s: f64,
    /// Whether the sensor is, or was during the tare, at the end of its range.
    pub(crate) saturated: bool,
    /// How far the robot is from where it was sent, m.
    pub(crate) lead_m: f64,
    /// What the sensor shows at rest.
    pub(crate) tare: Deflection,
    /// Where it was tared.
    pub(crate) r_from_s: Pose,
    /// Whether the object that is expected is known.
    pub(crate) object_known: bool,
    /// The robot is to be led back to its start.
    pub(crate) away: bool,
}

/// Periods T within which robot and sensor must have brought something new.
const FRESH_PERIODS: f64 = 3.0;
/// The least distance of the centre of mass from the vertical through s that tells the sensor's frame about it, m.
const TELLING_LEVER_M: f64 = 0.005;

/// `Ok`, or the first reason not to begin.
pub(crate) fn check(settings: &Settings, evidence: &Evidence<'_>) -> Result<(), Refusal> {
    let fresh_s = FRESH_PERIODS * settings.period_s();
    let (state, max_lead_m) = (evidence.state, settings.controller.max_lead_m);
    let fails = state.fault != Fault::None || !crate::follows(state);
    let reasons = [
        (
            evidence.state_age_s > fresh_s,
            ParameterAnswer::RobotStale,
            fresh_s,
        ),
        (fails, ParameterAnswer::RobotNotReady, 0.0),
        // Farther away than that it can't be for long: the set-point is kept that near.
        (
            evidence.lead_m > 0.99 * max_lead_m,
            ParameterAnswer::RobotNotReady,
            max_lead_m,
        ),
        (
            evidence.sensor_age_s > fresh_s,
            ParameterAnswer::SensorStale,
            fresh_s,
        ),
        (evidence.saturated, ParameterAnswer::SensorSaturated, 0.0),
    ];
    if let Some((_, answer, limit)) = reasons.into_iter().find(|(holds, ..)| *holds) {
        return Err(Refusal { answer, limit });
    }
    // Away from the start nobody knows what the tare means; it is taken anew there.
    if evidence.away {
        return Ok(());
    }
    // A calibration is made to find out what the tare means.
    if settings.task.kind != TaskKind::Calibrate {
        plausible(settings, &evidence.tare, &evidence.r_from_s)?;
    }
    if evidence.object_known {
        Ok(())
    } else {
        Err(Refusal {
            answer: ParameterAnswer::ObjectUnknown,
            limit: 0.0,
        })
    }
}

/// Whether the `tare` of a sensor at `r_from_s` is the weight of the tool that is known, as far as one is: by (3), (4)
/// with the assumed compliance, whose error scales what is compared and does not turn it.
fn plausible(settings: &Settings, tare: &Deflection, r_from_s: &Pose) -> Result<(), Refusal> {
    let controller = &settings.controller;
    let (mass, most_turned) = (controller.tool_mass_kg, controller.plausible_turn_rad);
    let bears =
        |c: &Matrix3<f64>, x: Vector3<f64>| c.try_inverse().map_or(Vector3::zeros(), |inverse| inverse * x);
    let force = r_from_s.rotation * bears(&settings.compliance.translation, tare.translation);
    let moment = r_from_s.rotation * bears(&settings.compliance.rotation, tare.rotation);
    let weight = Vector3::new(0.0, 0.0, -GRAVITY_M_PER_S2 * mass);
    let known = r_from_s.rotation * Vector3::from(controller.tool_centre_of_mass_in_s_m);
    let refuse = |holds: bool, answer, limit| {
        if holds {
            Err(Refusal { answer, limit })
        } else {
            Ok(())
        }
    };
    if mass > 0.0 {
        let least = GRAVITY_M_PER_S2 * mass / controller.plausible_mass_ratio;
        refuse(
            force.norm() < least,
            ParameterAnswer::ToolMass,
            mass / controller.plausible_mass_ratio,
        )?;
        refuse(
            turned(&force, &weight) > most_turned,
            ParameterAnswer::SensorFrame,
            most_turned,
        )?;
        if known.xy().norm() > TELLING_LEVER_M {
            let turn = turned(&moment, &known.cross(&weight));
            refuse(turn > most_turned, ParameterAnswer::SensorFrame, most_turned)?;
        }
        let most = mass * controller.plausible_mass_ratio;
        refuse(
            -force.z > GRAVITY_M_PER_S2 * most,
            ParameterAnswer::ToolMass,
            most,
        )?;
    }
    let bias = controller.plausible_bias_n;
    refuse(force.xy().amax() > bias, ParameterAnswer::SensorBias, bias)
}

/// The angle between two vectors, rad; as far as can be if one of them vanishes.
fn turned(a: &Vector3<f64>, b: &Vector3<f64>) -> f64 {
    let lengths = a.norm() * b.norm();
    if lengths > 0.0 {
        libm::acos((a.dot(b) / lengths).clamp(-1.0, 1.0))
    } else {
        std::f64::consts::PI
    }
}
