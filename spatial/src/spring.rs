//! The compliant element between the robot's last link and the tool plate.
//!
//! Both simulators evaluate it, each with its own side integrated and the other side's motion received
//! (PLANT.md section 4): the one piece of physics that lies on the border between two processes.

use crate::{Motion, Wrench, rotation};
use nalgebra::Vector3;

/// A linear visco-elastic suspension of the tool plate (frame s') on the last link (frame s), with end stops.
///
/// An end stop adds a spring beyond a deflection: along p it pushes back with `K_stop (|p| - p_stop)`, about phi
/// alike. It dissipates nothing (Model choice).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ToolSuspension {
    /// Translational stiffness K_p, N/m.
    pub stiffness_n_per_m: f64,
    /// Rotational stiffness K_phi, Nm/rad.
    pub stiffness_nm_per_rad: f64,
    /// Translational damping D_p, N s/m.
    pub damping_ns_per_m: f64,
    /// Rotational damping D_phi, Nm s/rad.
    pub damping_nms_per_rad: f64,
    /// Deflection |p| at which the translational end stop begins, m.
    pub end_stop_m: f64,
    /// Stiffness that it adds, N/m; 0: none.
    pub end_stop_n_per_m: f64,
    /// Deflection |phi| at which the rotational end stop begins, rad.
    pub end_stop_rad: f64,
    /// Stiffness that it adds, Nm/rad; 0: none.
    pub end_stop_nm_per_rad: f64,
}

impl ToolSuspension {
    /// The wrench on the tool at s', in r, from the motions of the link's frame s and of the tool plate s1.
    ///
    /// With `p = R_s^T (p_s1 - p_s)`, `phi = Log(R_s^T R_s1)` and their rates seen in s:
    /// `F = R_s (-K_p p - D_p pdot)`, `T = R_s (-K_phi phi - D_phi w_rel)` (PLANT.md section 1). All four constants
    /// are isotropic: everything is evaluated in r, without turning into s and back
    /// (`R_s Log(R_s^T R_s1) = Log(R_s1 R_s^T)`), and T is the exact gradient of `K_phi |phi|^2 / 2`, so that energy
    /// is conserved.
    #[inline]
    pub fn wrench_on_tool(&self, link: &Motion, plate: &Motion) -> Wrench {
        let p = plate.pose.translation.vector - link.pose.translation.vector;
        let phi = rotation::log(&(plate.pose.rotation * link.pose.rotation.inverse()));
        let (p_rate, w_rel) = rates(link, plate, &p);
        let mut force = -self.stiffness_n_per_m * p - self.damping_ns_per_m * p_rate;
        let mut moment = -self.stiffness_nm_per_rad * phi - self.damping_nms_per_rad * w_rel;
        if p.norm_squared() > self.end_stop_m * self.end_stop_m {
            force -= p * (self.end_stop_n_per_m * (1.0 - self.end_stop_m / p.norm()));
        }
        if phi.norm_squared() > self.end_stop_rad * self.end_stop_rad {
            moment -= phi * (self.end_stop_nm_per_rad * (1.0 - self.end_stop_rad / phi.norm()));
        }
        Wrench { force, moment }
    }

    /// Whether the end stops, if there are any, are further away than the plate gets within `time` s at its present
    /// speed against the link.
    pub fn clear_of_stops(&self, link: &Motion, plate: &Motion, time: f64) -> bool {
        if self.end_stop_n_per_m == 0.0 && self.end_stop_nm_per_rad == 0.0 {
            return true;
        }
        let p = plate.pose.translation.vector - link.pose.translation.vector;
        let phi = rotation::log(&(plate.pose.rotation * link.pose.rotation.inverse()));
        let (p_rate, w_rel) = rates(link, plate, &p);
        p.norm() + p_rate.norm() * time < self.end_stop_m
            && phi.norm() + w_rel.norm() * time < self.end_stop_rad
    }

    /// The elastic energy stored, J.
    pub fn energy(&self, link: &Motion, plate: &Motion) -> f64 {
        let lever: Vector3<f64> = plate.pose.translation.vector - link.pose.translation.vector;
        let phi = rotation::log(&(link.pose.rotation.inverse() * plate.pose.rotation));
        let past = (lever.norm() - self.end_stop_m).max(0.0);
        let turned_past = (phi.norm() - self.end_stop_rad).max(0.0);
        let stops =
            self.end_stop_n_per_m * past * past + self.end_stop_nm_per_rad * turned_past * turned_past;
        let springs =
            self.stiffness_n_per_m * lever.norm_squared() + self.stiffness_nm_per_rad * phi.norm_squared();
        0.5 * (springs + stops)
    }

    /// The power that the dampers dissipate, W.
    #[inline]
    pub fn dissipation(&self, link: &Motion, plate: &Motion) -> f64 {
        let lever = plate.pose.translation.vector - link.pose.translation.vector;
        let (p_rate, w_rel) = rates(link, plate, &lever);
        self.damping_ns_per_m * p_rate.norm_squared() + self.damping_nms_per_rad * w_rel.norm_squared()
    }
}

/// Rate (m/s) of the `lever` (m) from link to plate as seen from the link, and the angular velocity (rad/s) between
/// the two, in r.
#[inline]
fn rates(link: &Motion, plate: &Motion, lever: &Vector3<f64>) -> (Vector3<f64>, Vector3<f64>) {
    (
        plate.velocity - link.velocity - link.angular_velocity.cross(lever),
        plate.angular_velocity - link.angular_velocity,
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pose;

    #[test]
    fn the_wrench_is_the_gradient_of_the_energy() {
        let suspension = ToolSuspension {
            stiffness_n_per_m: 300e3,
            stiffness_nm_per_rad: 401.07,
            damping_ns_per_m: 0.0,
            damping_nms_per_rad: 0.0,
            // Deflected by 0.37 mm and 37 mrad: both stops are hit.
            end_stop_m: 0.2e-3,
            end_stop_n_per_m: 3e6,
            end_stop_rad: 0.03,
            end_stop_nm_per_rad: 4000.0,
        };
        let link = Motion::at_rest(pose(Vector3::new(0.2, -0.1, 0.5), Vector3::new(0.3, 0.8, -0.4)));
        let plate_at = |dp: Vector3<f64>, dphi: Vector3<f64>| {
            let mut plate = link;
            plate.pose.translation.vector += Vector3::new(1e-4, -2e-4, 3e-4) + dp;
            plate.pose.rotation =
                rotation::exp(dphi) * rotation::exp(Vector3::new(0.02, -0.03, 0.01)) * plate.pose.rotation;
            plate
        };
        let wrench = suspension.wrench_on_tool(&link, &plate_at(Vector3::zeros(), Vector3::zeros()));
        let h = 1e-6;
        for axis in 0..3 {
            let d = Vector3::ith(axis, h);
            let slope = |minus: Motion, plus: Motion| {
                (suspension.energy(&link, &plus) - suspension.energy(&link, &minus)) / (2.0 * h)
            };
            let force = -slope(plate_at(-d, Vector3::zeros()), plate_at(d, Vector3::zeros()));
            let moment = -slope(plate_at(Vector3::zeros(), -d), plate_at(Vector3::zeros(), d));
            assert!(
                (wrench.force[axis] - force).abs() < 1e-3,
                "{} {force}",
                wrench.force[axis]
            );
            assert!(
                (wrench.moment[axis] - moment).abs() < 1e-5,
                "{} {moment}",
                wrench.moment[axis]
            );
        }
    }
}
