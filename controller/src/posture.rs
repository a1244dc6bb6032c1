//! The posture in which the tool keeps its orientation although the sensor yields (Fig. 5).
//!
//! Only the contact's normal follows a force law. The other degrees of freedom have no reference in a vertex
//! contact: there the reference pose is composed with the inverse of the desired deflection, T_td'^-1.

use crate::transform::{desired_pose, wrench_at_sensor};
use nalgebra::Vector3;
use spatial::{Compliance, Deflection, Pose, Wrench, rotation};

/// From the height that the law asks for, and how far the posture has been taken, to the pose of the sensor frame.
///
/// *Hanging* means deflected as the tare was: under the tool's weight alone. The law speaks of the hanging tcp,
/// which is where the tcp would be without contact.
#[derive(Clone, Copy, Debug)]
pub struct Posture {
    s_from_t: Pose,
    /// Deflection at s without contact.
    tare: Deflection,
    /// Deflection at s under the desired wrench.
    desired: Deflection,
    /// `r_from_td1`: the deflected tcp as it is to be, its height excepted.
    r_from_tcp: Pose,
}

impl Posture {
    /// The posture for the desired wrench (of the environment on the tool, at the tcp, in r), for a tool that
    /// hangs with the deflection `tare` on a sensor at `r_from_s` and whose orientation there is to be kept.
    ///
    /// Paper (9), (10). Deviates: the lever is that of the deflected tool, `Exp(phi) d`, and the composition is
    /// exact (footnotes 5 and 7); the twist form would press with 10.08 instead of 10 N.
    pub fn new(
        compliance: &Compliance,
        d: Vector3<f64>,
        tare: Deflection,
        r_from_s: &Pose,
        desired_in_r: &Wrench,
    ) -> Self {
        let s_from_t = Pose::translation(d.x, d.y, d.z);
        let r_from_tcp = r_from_s * tare.to_pose() * s_from_t;
        let into_tool = r_from_tcp.rotation.inverse();
        let mut desired = tare;
        // The lever turns with the deflection sought: a contraction by the deflection's angle.
        for _ in 0..8 {
            let s_from_tool = rotation::exp(desired.rotation);
            let wrench_at_t = Wrench {
                force: s_from_tool * (into_tool * desired_in_r.force),
                moment: s_from_tool * (into_tool * desired_in_r.moment),
            };
            desired = tare + *compliance * wrench_at_sensor(&wrench_at_t, s_from_tool * d);
        }
        Self {
            s_from_t,
            tare,
            desired,
            r_from_tcp,
        }
    }

    /// `r_from_s` for the hanging tcp at `height` (m), with the share `tilt` (0 to 1) of the posture taken.
    ///
    /// Paper (11): the desired pose is the object's composed with T_td'^-1. The share is spread over time by
    /// the caller: a step would cost about 2 N of peak.
    pub fn sensor_pose(&self, height: f64, tilt: f64) -> Pose {
        let deflection = self.tare + (self.desired - self.tare) * tilt;
        let td_from_td1 = deflection.seen_from(&self.s_from_t).to_pose();
        let mut r_from_s = desired_pose(&self.r_from_tcp, &td_from_td1) * self.s_from_t.inverse();
        r_from_s.translation.vector.z += height - self.hanging_tcp(&r_from_s).translation.vector.z;
        r_from_s
    }

    /// Where the tcp would be without contact: `r_from_t1` under the tare's deflection.
    pub fn hanging_tcp(&self, r_from_s: &Pose) -> Pose {
        self.deflected_tcp(r_from_s, &self.tare)
    }

    /// Paper (12): `r_from_ta1 = r_from_o`, where the deflected tcp is; exact (footnote 5).
    pub fn deflected_tcp(&self, r_from_s: &Pose, deflection: &Deflection) -> Pose {
        r_from_s * deflection.to_pose() * self.s_from_t
    }

    /// The lever d in r of the hanging tool whose orientation is kept.
    pub fn lever(&self) -> Vector3<f64> {
        self.r_from_tcp.rotation * self.s_from_t.translation.vector
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn posture(force_n: f64) -> Posture {
        let wrench = Wrench {
            force: Vector3::new(0.0, 0.0, force_n),
            moment: Vector3::zeros(),
        };
        Posture::new(
            &Compliance::isotropic(1.0 / 300e3, 1.0 / 401.07),
            Vector3::new(0.10, 0.0, -0.15),
            Deflection {
                translation: Vector3::new(0.0, 0.0, -130.7e-6),
                rotation: Vector3::new(0.0, 2.918e-3, 0.0),
            },
            &Pose::translation(-0.10, 0.0, 0.18),
            &wrench,
        )
    }

    #[test]
    fn without_tilt_the_orientation_is_the_reference_and_the_height_as_asked() {
        let pose = posture(10.0).sensor_pose(0.025, 0.0);
        assert!(pose.rotation.angle() < 1e-12);
        assert!((posture(10.0).hanging_tcp(&pose).translation.vector.z - 0.025).abs() < 1e-15);
    }

    /// The hanging tool's lever, 0.0996 instead of 0.10 m, gives 2.482 instead of 2.493 mrad.
    #[test]
    fn the_full_posture_turns_against_the_deflection() {
        let posture = posture(10.0);
        let pose = posture.sensor_pose(0.025, 1.0);
        let turned = rotation::log(&pose.rotation).y;
        let expected = 10.0 * posture.lever().x / 401.07;
        assert!(
            (turned - expected).abs() < 1e-8 && (turned - 2.482e-3).abs() < 1e-6,
            "{turned}"
        );
        let real = posture.deflected_tcp(&pose, &posture.desired);
        assert!(rotation::log(&(real.rotation * posture.r_from_tcp.rotation.inverse())).norm() < 1e-12);
        let sideways = real.translation.vector - posture.r_from_tcp.translation.vector;
        assert!(sideways.xy().norm() < 1e-12);
    }
}
