//! Plant and law as the controller assumes them.

use super::{ElasticModel, GearSprings, LawModel, Plant, Servo, contact_stiffness};
use crate::elastic::Design;
use crate::structure::Structure;
use nalgebra::Vector3;
use node::scenario::{Controller, Gears, Law, Pairing};
use spatial::TICK_S;
use spatial::kinematics::{Axes, Kinematics, join};
use std::f64::consts::TAU;

/// What is known beside `[controller]`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Situation<'a> {
    pub(super) kinematics: &'a Kinematics,
    /// Where the task begins, rad.
    pub(super) axes: &'a Axes,
    pub(super) period_s: f64,
    /// Age of the sensor's samples as it is measured, s.
    pub(super) sensor_delay_s: f64,
    /// What the object is pressed with, N.
    pub(super) force_n: f64,
}

impl Situation<'_> {
    /// The plant: `[controller]` and `[controller.servo]`, `[controller.gears]` with the damping ratio of the modes, of
    /// tool and sensor too, `[controller.impact]` for tool and contact. `None`: a posture in which the tcp can't be moved
    /// along the normal.
    ///
    /// A sensor that puts out forces is taken to be as stiff as it is assumed.
    pub(super) fn plant(&self, controller: &Controller) -> Option<Plant> {
        let (assumed, impact) = (&controller.servo, &controller.impact);
        let kind = match controller.law {
            Law::Elastic => Gears::Elastic,
            _ => controller.gears.kind,
        };
        let structure = Structure::new(controller, self.kinematics, self.axes, kind);
        let motors = Axes::from(assumed.motor_inertia_kg_m2);
        let inertia = structure.links.diagonal();
        let servo = |axis: usize| Servo {
            filter_rad_per_s: TAU * controller.filter_frequency_hz,
            filter_damping: controller.filter_damping,
            position_gain: assumed.position_gain_per_s,
            velocity_gain: motors[axis] * TAU * assumed.velocity_bandwidth_hz,
            integral_time_s: assumed.velocity_integral_time_s,
            inertia: motors[axis] + inertia[axis],
        };
        // d = 2 zeta sqrt(k m).
        let damping = |stiffness: f64, mass: f64| {
            2.0 * controller.gears.damping_ratio * libm::sqrt((stiffness * mass).max(0.0))
        };
        let sensor_stiffness = [
            1.0 / controller.compliance_m_per_n,
            1.0 / controller.compliance_rad_per_nm,
        ];
        let about_s = structure.tool.fixed_view::<3, 3>(3, 3).trace() / 3.0;
        let lag_s = 1.0 / (TAU * controller.sensor_bandwidth_hz);
        Some(Plant {
            period_s: self.period_s,
            command_delay_s: controller.command_delay_periods as f64 * self.period_s,
            servos: std::array::from_fn(servo),
            motors,
            gears: (kind == Gears::Elastic).then(|| GearSprings {
                stiffness: structure.gears,
                damping: structure.gears.zip_map(&inertia, damping),
            }),
            links: structure.links,
            jacobian: structure.jacobian,
            command: structure
                .jacobian
                .lu()
                .solve(&join(Vector3::z(), Vector3::zeros()))?,
            sensor_stiffness,
            sensor_damping: [
                damping(sensor_stiffness[0], impact.tool_mass_kg),
                damping(sensor_stiffness[1], about_s),
            ],
            tool: structure.tool,
            normal: structure.normal_at_tcp,
            contact_n_per_m: contact_stiffness(
                impact.indentation_n_per_m * impact.rebound_ratio,
                impact.exponent,
                self.force_n,
            ),
            shown: [1.0, 1.0],
            sensor_delay_s: self.sensor_delay_s,
            sensor_lag_s: lag_s,
            paired_delay_s: match controller.pairing {
                Pairing::Sampling => self.sensor_delay_s + lag_s,
                Pairing::Arrival => 0.0,
            },
        })
    }

    /// The law, `elastic` with its `design`: the hypothesis that the gears are as assumed. `None`: there is no design.
    pub(super) fn law(&self, controller: &Controller, design: Option<&Design>) -> Option<LawModel> {
        let elastic = |design| ElasticModel::new(design, controller, 1.0, self.period_s, self.sensor_delay_s);
        LawModel::new(controller, self.period_s, design.map(elastic))
    }
}

/// Ticks in seconds.
pub(super) fn seconds(ticks: i64) -> f64 {
    ticks as f64 * TICK_S
}
