//! Ways that a program's steps lead: straight ones, and the spiral of a search.

use crate::approach::Approach;
use crate::shaping::Shape;
use nalgebra::Vector3;
use std::f64::consts::TAU;

/// A straight way from rest to rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Travel {
    direction: Vector3<f64>,
    profile: Approach,
    pub(super) start_tick: i64,
}

/// The least way worth speaking of, m.
const SHORTEST_M: f64 = 1e-6;

impl Travel {
    /// Along `way` (m) with at most `speed` (m/s) from the cycle at `tick` on.
    pub(super) fn new(shape: Shape, way: Vector3<f64>, speed: f64, tick: i64) -> Self {
        let length = way.norm();
        Self {
            direction: if length > SHORTEST_M {
                way / length
            } else {
                Vector3::zeros()
            },
            profile: Approach::new(shape, length.max(SHORTEST_M), speed),
            start_tick: tick,
        }
    }

    /// How far it leads within `time` (s), m in r.
    pub(super) fn at(&self, time: f64) -> Vector3<f64> {
        self.direction * self.profile.at(time).distance
    }

    /// s.
    pub(super) fn duration_s(&self) -> f64 {
        self.profile.duration()
    }
}

/// An Archimedean spiral in the horizontal plane, `rho = pitch phi / (2 pi)`, from its centre on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Spiral {
    pitch_m: f64,
    radius_m: f64,
    profile: Approach,
    pub(super) start_tick: i64,
}

impl Spiral {
    /// With turns `pitch_m` (m) apart out to `radius_m` (m), at `speed` (m/s), from the cycle at `tick` on.
    pub(super) fn new(shape: Shape, pitch_m: f64, radius_m: f64, speed: f64, tick: i64) -> Self {
        Self {
            pitch_m,
            radius_m,
            // The arc's length from the centre is pitch phi^2 / (4 pi) = pi rho^2 / pitch, but for the innermost turn.
            profile: Approach::new(shape, 0.5 * TAU * radius_m * radius_m / pitch_m, speed),
            start_tick: tick,
        }
    }

    /// Where it leads within `time` (s), m in r from its centre.
    ///
    /// Near the centre the arc is taken a quarter of a turn longer than it is, which keeps the acceleration there
    /// finite: the radius grows with the way, not with its root.
    pub(super) fn at(&self, time: f64) -> Vector3<f64> {
        let distance = self.profile.at(time).distance;
        // phi with pitch / (4 pi) ((phi + b)^2 - b^2) = distance.
        let b = 0.25 * TAU;
        let phi = (b * b + 2.0 * TAU * distance / self.pitch_m).sqrt() - b;
        let rho = (self.pitch_m * phi / TAU).min(self.radius_m);
        let (sine, cosine) = libm::sincos(phi);
        Vector3::new(rho * cosine, rho * sine, 0.0)
    }

    /// s.
    pub(super) fn duration_s(&self) -> f64 {
        self.profile.duration()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shape() -> Shape {
        Shape::smooth(0.25, 10.0, 0.1)
    }

    #[test]
    fn a_travel_leads_from_rest_to_rest() {
        let way = Vector3::new(0.03, -0.01, 0.005);
        let travel = Travel::new(shape(), way, 0.1, 0);
        assert_eq!(travel.at(0.0), Vector3::zeros());
        assert!((travel.at(travel.duration_s()) - way).norm() < 1e-12);
        assert_eq!(
            Travel::new(shape(), Vector3::zeros(), 0.1, 0).at(1.0),
            Vector3::zeros()
        );
    }

    /// Its turns are a pitch apart, its speed is the one asked for within 60 %, and it reaches its radius.
    #[test]
    fn a_spiral_fills_its_circle() {
        let spiral = Spiral::new(shape(), 0.5e-3, 2e-3, 5e-3, 0);
        let h = 1e-3;
        let count = (spiral.duration_s() / h) as i32;
        let points: Vec<_> = (0..=count).map(|i| spiral.at(f64::from(i) * h)).collect();
        for three in points.windows(3) {
            let speed = (three[1] - three[0]).norm() / h;
            let change = (three[2] - three[1] * 2.0 + three[0]).norm() / (h * h);
            assert!(speed < 5e-3 * 1.01 && change < 0.1, "{speed} m/s, {change} m/s^2");
        }
        assert!(
            points[count as usize].norm() > 1.85e-3,
            "{}",
            points[count as usize]
        );
        // Whatever lies within its radius is within half a pitch of it.
        for at in [[0.4e-3, 0.9e-3], [-1.2e-3, 0.3e-3], [0.0, -1.6e-3]] {
            let hole = Vector3::new(at[0], at[1], 0.0);
            let nearest = points
                .iter()
                .map(|point| (point - hole).norm())
                .fold(1.0, f64::min);
            assert!(nearest < 0.26e-3, "{nearest}");
        }
    }
}
