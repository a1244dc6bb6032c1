//! A round hole with a conical chamfer of 45 degrees: what a peg is put into.
//!
//! Seen along the axis, the solid around the hole is what lies below the surface, outside the chamfer's cone *and*
//! outside the wall's cylinder: in the half plane (rho, z) the intersection of three half planes. The indentation
//! of a point is the shortest way out, the smallest of its depths below the three; the normal is that border's.
//! Edges are sharp (Model choice).

use nalgebra::Vector3;
use node::scenario;
use std::f64::consts::FRAC_1_SQRT_2;

/// The hole, its axis along z of the object.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Hole {
    radius: f64,
    chamfer: f64,
    depth: f64,
}

impl Hole {
    /// The hole of a scenario's object, if it has one.
    pub(super) fn new(object: &scenario::Object) -> Option<Self> {
        (object.hole_radius_m > 0.0).then_some(Self {
            radius: object.hole_radius_m,
            chamfer: object.hole_chamfer_m,
            depth: object.hole_depth_m,
        })
    }

    /// Indentation (m; negative: at least that far away) of `point` (m) and the outward normal there, both in the
    /// object's frame.
    pub(super) fn probe(&self, point: &Vector3<f64>) -> (f64, Vector3<f64>) {
        let rho = (point.x * point.x + point.y * point.y).sqrt();
        let inwards = if rho > 0.0 {
            Vector3::new(-point.x / rho, -point.y / rho, 0.0)
        } else {
            Vector3::x()
        };
        let wall = rho - self.radius;
        let surface = -point.z;
        let cone = (wall - self.chamfer - point.z) * FRAC_1_SQRT_2;
        let bottom = -self.depth - point.z;

        let (around, normal) = if surface <= wall && surface <= cone {
            (surface, Vector3::z())
        } else if cone <= wall {
            (cone, (inwards + Vector3::z()) * FRAC_1_SQRT_2)
        } else {
            (wall, inwards)
        };
        if bottom > around {
            (bottom, Vector3::z())
        } else {
            (around, normal)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_border_is_found_from_within() {
        let hole = Hole {
            radius: 0.010,
            chamfer: 0.002,
            depth: 0.030,
        };
        let depth = 1e-5;
        let slanted = Vector3::new(-FRAC_1_SQRT_2, 0.0, FRAC_1_SQRT_2);
        for (on_border, normal) in [
            (Vector3::new(0.020, 0.0, 0.0), Vector3::z()),
            (Vector3::new(0.011, 0.0, -0.001), slanted),
            (Vector3::new(0.010, 0.0, -0.010), -Vector3::x()),
            (Vector3::new(0.005, 0.0, -0.030), Vector3::z()),
        ] {
            for h in [depth, -depth] {
                let (found, direction) = hole.probe(&(on_border - normal * h));
                assert!((found - h).abs() < 1e-15, "{found}");
                assert!((direction - normal).norm() < 1e-15, "{direction}");
            }
        }
        assert!(hole.probe(&Vector3::new(0.0, 0.0, -0.02)).0 < 0.0);
    }
}
