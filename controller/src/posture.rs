//! The posture in which the tool keeps its orientation although the sensor yields (Fig. 5).
//!
//! Only what is selected follows a force law. The other degrees of freedom have no reference in the contact (a vertex
//! contact shows no orientation): there the reference pose is composed with the inverse of the desired deflection,
//! T_td'^-1.

use crate::dofs::{Dofs, displacement};
use crate::transform::{deflection_at_tcp, desired_pose, object_pose, wrench_at_sensor};
use nalgebra::{UnitQuaternion, Vector3};
use node::scenario::Transform;
use spatial::kinematics::join;
use spatial::{Compliance, Deflection, Pose, Wrench, rotation};

/// Between the pose of the sensor frame and that of the tcp: hanging, deflected, desired.
///
/// *Hanging* means deflected as the tare was: under the tool's weight alone. The laws speak of the hanging tcp,
/// which is where the tcp would be without contact.
#[derive(Clone, Copy, Debug)]
pub struct Posture {
    transform: Transform,
    s_from_t: Pose,
    /// From the nominal to the hanging tcp, `t_from_t1` under the tare.
    t_from_hanging: Pose,
    /// Deflection at s without contact.
    tare: Deflection,
    /// Deflection at s under the desired wrench.
    desired: Deflection,
    /// `r_from_td1`: the deflected tcp as it is to be where no force law acts.
    r_from_tcp: Pose,
}

impl Posture {
    /// The posture for the desired wrench (of the environment on the tool, at the tcp, in r), for a tool that
    /// hangs with the deflection `tare` on a sensor at `r_from_s` and whose orientation there is to be kept.
    ///
    /// Paper (9), (10). Deviates with [`Transform::Exact`]: the lever is that of the deflected tool, `Exp(phi) d`, and
    /// the composition is exact (footnotes 5 and 7); the twist form would press with 10.08 instead of 10 N.
    pub fn new(
        transform: Transform,
        compliance: &Compliance,
        d: Vector3<f64>,
        tare: Deflection,
        r_from_s: &Pose,
        desired_in_r: &Wrench,
    ) -> Self {
        let s_from_t = Pose::translation(d.x, d.y, d.z);
        let t_from_hanging = at_tcp(transform, &tare, &s_from_t);
        let r_from_tcp = r_from_s * s_from_t * t_from_hanging;
        let mut posture = Self {
            transform,
            s_from_t,
            t_from_hanging,
            tare,
            desired: tare,
            r_from_tcp,
        };
        posture.plan(compliance, desired_in_r);
        posture
    }

    /// Plan for another wrench, or another compliance.
    pub fn plan(&mut self, compliance: &Compliance, desired_in_r: &Wrench) {
        let d = self.s_from_t.translation.vector;
        let under = |into_s: UnitQuaternion<f64>, lever| {
            let wrench_at_t = Wrench {
                force: into_s * desired_in_r.force,
                moment: into_s * desired_in_r.moment,
            };
            self.tare + *compliance * wrench_at_sensor(&wrench_at_t, lever)
        };
        self.desired = match self.transform {
            Transform::Twist => under(self.r_from_t().inverse(), d),
            Transform::Exact => {
                // The tool is to keep its orientation in r; the lever turns with the deflection sought, which shrinks
                // an error by that angle.
                let into_tool = self.r_from_tcp.rotation.inverse();
                (0..8).fold(self.tare, |desired, _| {
                    let s_from_tool = rotation::exp(desired.rotation);
                    under(s_from_tool * into_tool, s_from_tool * d)
                })
            }
        };
    }

    /// Orientation of the nominal tcp, which is that of the sensor, at the start.
    fn r_from_t(&self) -> UnitQuaternion<f64> {
        self.r_from_tcp.rotation * self.t_from_hanging.rotation.inverse()
    }

    /// Where the hanging tcp has to be for the deflected one to keep its reference, `shift` (m, in r) away, with the
    /// share `tilt` (0 to 1) of the posture taken.
    ///
    /// Paper (11): the desired pose is the object's composed with T_td'^-1. The share is spread over time by
    /// the caller: a step would cost about 2 N of peak.
    pub fn reference(&self, shift: Vector3<f64>, tilt: f64) -> Pose {
        let deflection = self.tare + (self.desired - self.tare) * tilt;
        let mut r_from_o = self.r_from_tcp;
        r_from_o.translation.vector += shift;
        desired_pose(&r_from_o, &at_tcp(self.transform, &deflection, &self.s_from_t)) * self.t_from_hanging
    }

    /// How far the desired wrench displaces the tcp, in r (m, rad): `C f_d`; exactly, in the posture taken for it.
    pub fn desired_displacement(&self) -> Dofs {
        let t_from_td1 = at_tcp(self.transform, &self.desired, &self.s_from_t);
        match self.transform {
            Transform::Exact => {
                let hanging = self.reference(Vector3::zeros(), 1.0);
                displacement(&hanging, &(hanging * self.t_from_hanging.inverse() * t_from_td1))
            }
            // Paper (11): a difference of deflections, turned into r.
            Transform::Twist => {
                let r_from_t = self.r_from_t();
                let difference =
                    Deflection::from_pose(&t_from_td1) - Deflection::from_pose(&self.t_from_hanging);
                join(r_from_t * difference.translation, r_from_t * difference.rotation)
            }
        }
    }

    /// `r_from_s` for the hanging tcp at `r_from_hanging`.
    pub fn sensor_pose(&self, r_from_hanging: &Pose) -> Pose {
        r_from_hanging * self.t_from_hanging.inverse() * self.s_from_t.inverse()
    }

    /// Where the tcp would be without contact: `r_from_t1` under the tare's deflection.
    pub fn hanging_tcp(&self, r_from_s: &Pose) -> Pose {
        r_from_s * self.s_from_t * self.t_from_hanging
    }

    /// Paper (12): `r_from_ta1 = r_from_o`, where the deflected tcp is.
    pub fn deflected_tcp(&self, r_from_s: &Pose, deflection: &Deflection) -> Pose {
        object_pose(
            &(r_from_s * self.s_from_t),
            &at_tcp(self.transform, deflection, &self.s_from_t),
        )
    }

    /// The lever d in r of the hanging tool whose orientation is kept.
    pub fn lever(&self) -> Vector3<f64> {
        self.r_from_tcp.rotation * self.s_from_t.translation.vector
    }
}

/// `t_from_t1` of a deflection at s: footnote 5, or (7), (8).
fn at_tcp(transform: Transform, deflection_at_s: &Deflection, s_from_t: &Pose) -> Pose {
    match transform {
        Transform::Exact => deflection_at_s.seen_from(s_from_t).to_pose(),
        Transform::Twist => deflection_at_tcp(deflection_at_s, s_from_t.translation.vector).to_pose(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dofs::NORMAL;

    const START: Vector3<f64> = Vector3::new(-0.10, 0.0, 0.18);

    fn posture(transform: Transform, force_n: f64) -> Posture {
        let wrench = Wrench {
            force: Vector3::new(0.0, 0.0, force_n),
            moment: Vector3::zeros(),
        };
        Posture::new(
            transform,
            &Compliance::isotropic(1.0 / 300e3, 1.0 / 401.07),
            Vector3::new(0.10, 0.0, -0.15),
            Deflection {
                translation: Vector3::new(0.0, 0.0, -130.7e-6),
                rotation: Vector3::new(0.0, 2.918e-3, 0.0),
            },
            &Pose::translation(START.x, START.y, START.z),
            &wrench,
        )
    }

    #[test]
    fn without_tilt_the_sensor_stays_where_it_was() {
        for transform in [Transform::Exact, Transform::Twist] {
            let posture = posture(transform, 10.0);
            let pose = posture.sensor_pose(&posture.reference(Vector3::zeros(), 0.0));
            assert!(pose.rotation.angle() < 1e-12);
            assert!((pose.translation.vector - START).norm() < 1e-15);
        }
    }

    #[test]
    fn sensor_pose_and_hanging_tcp_are_inverse() {
        let posture = posture(Transform::Exact, 10.0);
        let pose = spatial::pose(Vector3::new(0.3, -0.2, 0.1), Vector3::new(0.2, 0.1, -0.3));
        let back = posture.hanging_tcp(&posture.sensor_pose(&pose));
        assert!(displacement(&pose, &back).norm() < 1e-14);
    }

    /// The hanging tool's lever, 0.0996 instead of 0.10 m, gives 2.482 instead of 2.493 mrad.
    #[test]
    fn the_full_posture_turns_against_the_deflection() {
        let posture = posture(Transform::Exact, 10.0);
        let pose = posture.sensor_pose(&posture.reference(Vector3::zeros(), 1.0));
        let turned = rotation::log(&pose.rotation).y;
        let expected = 10.0 * posture.lever().x / 401.07;
        assert!(
            (turned - expected).abs() < 1e-8 && (turned - 2.482e-3).abs() < 1e-6,
            "{turned}"
        );
        let real = posture.deflected_tcp(&pose, &posture.desired);
        assert!(displacement(&posture.r_from_tcp, &real).norm() < 1e-12);
    }

    /// PLANT.md section 5: linear 282.7 um; with gravity and exact rotations 280.4 um, and 280.0 um where the sensor
    /// has turned by 2.48 mrad to keep the tool's orientation, which shortens the mean lever by 0.15 m / 2 of that.
    #[test]
    fn the_twist_form_asks_for_more_deflection_than_10_n_give() {
        for (transform, expected) in [(Transform::Exact, 280.0e-6), (Transform::Twist, 282.7e-6)] {
            let found = posture(transform, 10.0).desired_displacement()[NORMAL];
            assert!((found - expected).abs() < 0.1e-6, "{transform:?}: {found} m");
        }
    }
}
