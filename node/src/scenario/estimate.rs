//! First-order estimates of how a scenario's tool behaves, for the checks.

use super::{Scenario, ToolShape};
use spatial::GRAVITY_M_PER_S2;

impl Scenario {
    /// Translation, m, and rotation, rad, of the sensor at rest, to first order, while the object presses upwards
    /// on the tcp with `force`, N.
    pub(super) fn deflection_under(&self, force: f64) -> ([f64; 3], [f64; 3]) {
        let Self { sensor, tool, .. } = self;
        let weight = GRAVITY_M_PER_S2 * tool.mass_kg;
        let ([cx, cy, _], [dx, dy, _]) = (tool.centre_of_mass_in_s_m, tool.tcp_in_s_m);
        let moment = [dy * force - cy * weight, cx * weight - dx * force, 0.0];
        let translation = [0.0, 0.0, (force - weight) / sensor.stiffness_n_per_m];
        (
            translation,
            moment.map(|moment| moment / sensor.stiffness_nm_per_rad),
        )
    }

    /// An upper bound of the tool's angular frequencies and decay rates between sensor and object, rad/s: the sum
    /// of what each spring (each damper) alone would cause.
    ///
    /// The contact counts for exponent 1 only; for others its stiffness depends on the impact.
    pub(super) fn fastest_rad_per_s(&self) -> f64 {
        let Self {
            sensor, tool, object, ..
        } = self;
        let ([cx, cy, cz], [dx, dy, dz]) = (tool.centre_of_mass_in_s_m, tool.tcp_in_s_m);
        let [jx, jy, jz] = tool.inertia_kg_m2;
        let smallest = jx.min(jy).min(jz);
        // What a force moves, 1/kg: at s in any direction at most, and at the tcp along z.
        let at_s = 1.0 / tool.mass_kg + (cx * cx + cy * cy + cz * cz) / smallest;
        let [wide_x, wide_y, high] = match tool.shape {
            ToolShape::Point => [0.0; 3],
            ToolShape::Face => [0.5 * tool.face_size_m[0], 0.5 * tool.face_size_m[1], 0.0],
            ToolShape::Peg => [tool.peg_radius_m, tool.peg_radius_m, tool.peg_length_m],
        };
        let [x, y] = [(dx - cx).abs() + wide_x, (dy - cy).abs() + wide_y];
        let z = (dz - cz).abs().max((dz - cz + high).abs());
        let only_along_z =
            object.hole_radius_m == 0.0 && object.rotation_rad == [0.0; 3] && object.friction == 0.0;
        let at_tcp = if only_along_z {
            1.0 / tool.mass_kg + y * y / jx + x * x / jy
        } else {
            1.0 / tool.mass_kg + (x * x + y * y + z * z) / smallest
        };
        let contact = if object.exponent == 1.0 {
            object.indentation_n_per_m * object.rebound_ratio
        } else {
            0.0
        };
        let at_support = if object.support_n_per_m > 0.0 {
            1.0 / object.support_mass_kg
        } else {
            0.0
        };
        // Friction is a damper for what slides slowly: as strong as the contact is pressed, in the impact of (17)
        // or later.
        let impact = self.task.approach_speed_m_per_s * (object.indentation_n_per_m / at_tcp).sqrt();
        let friction =
            object.friction * impact.max(self.task.desired_force_n) / object.friction_speed_m_per_s;
        let springs = (sensor.stiffness_n_per_m + sensor.end_stop_n_per_m) * at_s
            + (sensor.stiffness_nm_per_rad + sensor.end_stop_nm_per_rad) / smallest
            + contact * (at_tcp + at_support)
            + object.support_n_per_m * at_support;
        let dampers = sensor.damping_ns_per_m * at_s
            + sensor.damping_nms_per_rad / smallest
            + friction * at_tcp
            + object.support_ns_per_m * at_support;
        springs.sqrt().max(dampers)
    }

    /// Height in r, m, of the object's origin at the start.
    pub(super) fn object_height_at_start_m(&self) -> f64 {
        let object = &self.object;
        object.height_m
            + object.swing_amplitude_m[2] * libm::sin(object.swing_phase_rad)
            + object.profile_height_m.first().unwrap_or(&0.0)
    }

    /// Height in r, m, of the tcp at the start, with the tool hanging freely.
    pub fn hanging_tcp_height_m(&self) -> f64 {
        let ([_, _, sag], [turn_x, turn_y, _]) = self.deflection_under(0.0);
        let [x, y, _] = self.tool.tcp_in_s_m;
        self.task.start_position_m[2] + sag + turn_x * y - turn_y * x
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The values of the linear model in the specification of the plant.
    #[test]
    fn the_reference_plant_sags_and_yields_as_specified() {
        let scenario = Scenario::default();
        let ([_, _, p], [_, phi, _]) = scenario.deflection_under(0.0);
        assert!(
            (p + 130.8e-6).abs() < 0.1e-6 && (phi - 2.935e-3).abs() < 1e-6,
            "{p} {phi}"
        );
        assert!((scenario.hanging_tcp_height_m() - (0.030 - 424e-6)).abs() < 1e-6);

        let ([_, _, pressed], [_, turned, _]) = scenario.deflection_under(10.0);
        assert!((pressed - p - 33.3e-6).abs() < 0.1e-6 && (turned - phi + 2.493e-3).abs() < 1e-6);
    }

    /// Contact with 64 MN/m of rebound on 1.798 kg alone: 5966 rad/s.
    #[test]
    fn the_contact_is_the_fastest_motion() {
        let fastest = Scenario::default().fastest_rad_per_s();
        assert!((5966.0..6100.0).contains(&fastest), "{fastest}");
    }
}
