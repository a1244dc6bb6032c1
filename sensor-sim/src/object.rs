//! The object: where it is, what it is shaped like, how it is held and how rough it is.

mod hole;
mod movement;

pub use movement::Base;

use hole::Hole;
use movement::Movement;
use nalgebra::{Matrix3, UnitQuaternion, Vector3};
use node::scenario;
use spatial::{Pose, rotation};

/// A plane, possibly with a hole, that moves as prescribed and yields along its normal if it is held elastically.
#[derive(Clone, Debug, PartialEq)]
pub struct Object {
    movement: Movement,
    orientation: UnitQuaternion<f64>,
    /// The same as a matrix.
    r_from_o: Matrix3<f64>,
    hole: Option<Hole>,
    friction: f64,
    friction_speed: f64,
    support: Option<Support>,
    linear: bool,
}

/// An elastic support: the surface is a mass on a spring and a damper along its normal.
///
/// Model choice: with a mass instead of a massless spring the contact stays an explicit force law.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Support {
    mass: f64,
    stiffness: f64,
    damping: f64,
}

/// How far the surface has yielded into the object, m, and how fast it does, m/s.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Yielding {
    /// m.
    pub depth: f64,
    /// m/s.
    pub rate: f64,
}

impl Object {
    /// The object of a scenario.
    pub fn new(object: &scenario::Object) -> Self {
        let orientation = rotation::exp(object.rotation_rad.into());
        Self {
            movement: Movement::new(object),
            orientation,
            r_from_o: orientation.to_rotation_matrix().into_inner(),
            hole: Hole::new(object),
            friction: object.friction,
            friction_speed: object.friction_speed_m_per_s,
            support: (object.support_n_per_m > 0.0).then_some(Support {
                mass: object.support_mass_kg,
                stiffness: object.support_n_per_m,
                damping: object.support_ns_per_m,
            }),
            linear: object.exponent == 1.0 && object.friction == 0.0 && object.hole_radius_m == 0.0,
        }
    }

    /// Where the object is at `time`, s after the start, its surface unloaded.
    pub fn base(&self, time: f64) -> Base {
        self.movement.at(time)
    }

    /// `r_from_o` while its surface has yielded: the origin lies in the surface and goes with it.
    pub fn pose(&self, base: &Base, yielding: &Yielding) -> Pose {
        let position = base.position - self.normal() * yielding.depth;
        Pose::from_parts(position.into(), self.orientation)
    }

    /// Whether a contact that rebounds is no more than another linear spring.
    pub fn is_linear(&self) -> bool {
        self.linear
    }

    /// The surface's outward normal in r: the object's z axis.
    pub fn normal(&self) -> Vector3<f64> {
        self.r_from_o.column(2).into_owned()
    }

    /// Indentation (m; negative: at least that far away) of the point at `position + lever` (m, in r), and the
    /// outward normal there in r.
    pub fn probe(
        &self,
        base: &Base,
        yielding: &Yielding,
        position: &Vector3<f64>,
        lever: &Vector3<f64>,
    ) -> (f64, Vector3<f64>) {
        let normal = self.normal();
        match &self.hole {
            None => {
                let h = normal.dot(&(base.position - position)) - normal.dot(lever) - yielding.depth;
                (h, normal)
            }
            Some(hole) => {
                let point = self.r_from_o.tr_mul(&(position + lever - base.position));
                let (h, normal) = hole.probe(&(point + Vector3::z() * yielding.depth));
                (h, self.r_from_o * normal)
            }
        }
    }

    /// The friction (N) on a point that `pressure` (N) presses against the surface along `normal` while it moves
    /// with `velocity` (m/s) against it: `-mu f v_t / sqrt(|v_t|^2 + v_0^2)`, Coulomb's law regularised.
    pub fn friction(&self, pressure: f64, normal: &Vector3<f64>, velocity: &Vector3<f64>) -> Vector3<f64> {
        if self.friction == 0.0 {
            return Vector3::zeros();
        }
        let sliding = velocity - normal * normal.dot(velocity);
        let speed = (sliding.norm_squared() + self.friction_speed * self.friction_speed).sqrt();
        sliding * (-self.friction * pressure / speed)
    }

    /// The surface's rate of change while the object presses on the tool with `force` (N, in r).
    pub fn yielding_rates(&self, yielding: &Yielding, force: &Vector3<f64>) -> Yielding {
        match &self.support {
            None => Yielding::default(),
            Some(support) => Yielding {
                depth: yielding.rate,
                rate: (force.dot(&self.normal())
                    - support.stiffness * yielding.depth
                    - support.damping * yielding.rate)
                    / support.mass,
            },
        }
    }
}
