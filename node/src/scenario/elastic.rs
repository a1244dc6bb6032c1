//! The sections `[controller.gears]` and `[controller.elastic]`: what is assumed of elastic gears, and the law for them.

use super::check::{Conflicts, short};
use super::{Gears, Scenario, schema};

schema::section! {
    /// What the controller assumes of the gears; motors and links are those of `[controller.servo]`.
    AssumedGears at "controller.gears" {
        /// What is assumed to join motor and link in free motion, and for the loop's margins; the law `elastic` assumes
        /// elastic gears anyway.
        kind: Gears = Gears::Rigid;
        /// Assumed natural frequency of each link on its elastic gear, motor locked.
        frequency_hz: [f64; 6] = [14.0, 14.0, 14.0, 20.0, 20.0, 20.0], in 0.5..=500.0;
        /// Assumed inertia that couples the links where the task begins: axis 1 with 2 to 6, 2 with 3 to 6, and so on.
        link_coupling_kg_m2: [f64; 15] = [0.0; 15], in -1e4..=1e4;
        /// Assumed damping ratio of the modes.
        damping_ratio: f64 = 0.02, in 0.0..=1.0;
    }
}

schema::section! {
    /// The law `elastic`: the object model behind elastic gears, along the normal.
    ElasticLaw at "controller.elastic" {
        /// Deflection that costs as much as a change of the acceleration by 1 m/s^2 within a period: the smaller, the
        /// faster.
        effort_s2: f64 = 18e-6, in 1e-7..=1e-1;
        /// How much a deviation of the contact force costs against one of the sensor's force, which lacks the tool's
        /// inertia: the more, the less the tool leaves the object.
        contact_weight: f64 = 1.0, in 0.0..=1e3;
        /// How far off its goal the regulator sees the deflection at most, as a multiple of the desired one: what is further off
        /// is led there by a goal that goes ahead, or the tool would be pulled off the object.
        linear_range: f64 = 0.9, in 0.0..=1e3;
        /// Up to which multiple of the desired deflection it may be off for that; beyond, the robot goes to where the force
        /// results as with the law `proposed`.
        governed_range: f64 = 4.5, in 0.0..=1e3;
        /// How far the gears' frequency may be from what is assumed, as a share of it: the range of the hypotheses.
        mode_spread: f64 = 0.15, in 0.0..=0.5;
        /// Noise of the deflection at the tcp, rms.
        deflection_noise_m: f64 = 20e-6, in 1e-9..=1e-3;
        /// Acceleration of links and tool that the model does not explain, rms.
        unknown_acceleration_m_per_s2: f64 = 0.12, in 1e-6..=1e3;
        /// How much of the likelihood of a hypothesis is left after a sample; 1: nothing is forgotten.
        likelihood_memory: f64 = 0.98, in 0.0..=1.0;
    }
}

impl Scenario {
    /// The links that are assumed must be masses, for the law `elastic` and for a shaped motion with elastic gears: an
    /// inertia matrix has only positive pivots.
    pub(super) fn check_links(&self, conflicts: &mut Conflicts) {
        let controller = &self.controller;
        let own = &controller.servo.link_inertia_kg_m2;
        let mut matrix = [[0.0; 6]; 6];
        let mut couplings = controller.gears.link_coupling_kg_m2.iter();
        for i in 0..6 {
            matrix[i][i] = own[i];
            for (j, coupling) in (i + 1..6).zip(&mut couplings) {
                matrix[j][i] = *coupling;
            }
        }
        // Gauss's elimination of the lower half.
        for i in 0..6 {
            let pivot = matrix[i][i];
            conflicts.require(
                pivot > 0.0,
                &[
                    "controller.gears.link_coupling_kg_m2",
                    "controller.servo.link_inertia_kg_m2",
                ],
                format!(
                    "controller.gears.link_coupling_kg_m2 leaves axis {i} no inertia ({} kg m^2 of \
                     controller.servo.link_inertia_kg_m2[{i}], {} kg m^2): couple it less",
                    short(pivot),
                    short(own[i])
                ),
            );
            if pivot <= 0.0 {
                return;
            }
            let column = std::array::from_fn::<f64, 6, _>(|k| matrix[k][i]);
            for j in i + 1..6 {
                for k in i + 1..=j {
                    matrix[j][k] -= column[j] * column[k] / pivot;
                }
            }
        }
    }
}
