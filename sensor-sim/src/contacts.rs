//! Where the tool touches the object: the points that may, each with its contact and its memory.

use crate::contact::{Contact, Piece};
use crate::object::{Base, Object};
use crate::tool::State;
use nalgebra::{Rotation3, Vector3};
use node::scenario::{self, ToolShape};
use spatial::Pose;
use std::f64::consts::TAU;

/// Points on each ring of a peg.
const RING: usize = 8;

/// The tool's contact points on one object.
///
/// Model choice: the points of a face (of a peg's end) share its stiffness equally, so that the whole of it has
/// the coefficient c_in of the scenario. The memory of the deepest indentation belongs to the tool's point.
#[derive(Clone, Debug, PartialEq)]
pub struct Contacts {
    object: Object,
    points: Vec<Point>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Point {
    /// From the centre of mass, in s', m.
    offset: Vector3<f64>,
    contact: Contact,
}

/// What the object exerts on the tool.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Load {
    /// Force in r, N.
    pub force: Vector3<f64>,
    /// Moment in r about the tool's centre of mass, Nm.
    pub moment: Vector3<f64>,
    /// Power that the tool feeds into the object, W.
    pub power: f64,
}

/// The point that is deepest inside the object.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Deepest {
    /// Its indentation, m; negative: at least that far away.
    pub indentation_m: f64,
    /// Its remaining indentation, m.
    pub remaining_m: f64,
}

impl Contacts {
    /// The points of `tool` on `object`, untouched.
    pub fn new(tool: &scenario::Tool, object: &scenario::Object) -> Self {
        let centre = Vector3::from(tool.tcp_in_s_m) - Vector3::from(tool.centre_of_mass_in_s_m);
        let [a, b] = tool.face_size_m.map(|size| 0.5 * size);
        let ring = |height: f64| {
            (0..RING).map(move |i| {
                let (sine, cosine) = libm::sincos(TAU * i as f64 / RING as f64);
                Vector3::new(tool.peg_radius_m * cosine, tool.peg_radius_m * sine, height)
            })
        };
        let (offsets, sharing): (Vec<Vector3<f64>>, usize) = match tool.shape {
            ToolShape::Point => (vec![Vector3::zeros()], 1),
            ToolShape::Face => (
                [(a, b), (-a, b), (-a, -b), (a, -b)]
                    .map(|(x, y)| Vector3::new(x, y, 0.0))
                    .into(),
                4,
            ),
            ToolShape::Peg => (ring(0.0).chain(ring(tool.peg_length_m)).collect(), RING),
        };
        let contact = Contact::new(object, 1.0 / sharing as f64);
        let point = |offset| Point {
            offset: centre + offset,
            contact,
        };
        Self {
            object: Object::new(object),
            points: offsets.into_iter().map(point).collect(),
        }
    }

    /// The object.
    pub fn object(&self) -> &Object {
        &self.object
    }

    /// The load on the tool in `state`, whose orientation is `r_from_s1`; memories stay as they are.
    pub fn load(&self, state: &State, r_from_s1: &Rotation3<f64>, base: &Base) -> Load {
        let mut load = Load::default();
        for Point { offset, contact } in &self.points {
            let lever = r_from_s1 * offset;
            let (h, normal) = self.object.probe(base, &state.surface, &state.position, &lever);
            let pressure = contact.force(h);
            if pressure > 0.0 {
                let velocity = state.velocity + state.angular_velocity.cross(&lever);
                let surface = self.surface_velocity(state, base);
                let force =
                    normal * pressure + self.object.friction(pressure, &normal, &(velocity - surface));
                load.force += force;
                load.moment += lever.cross(&force);
                load.power -= force.dot(&velocity);
            }
        }
        load
    }

    /// The deepest point of the tool in `state`.
    pub fn deepest(&self, state: &State, base: &Base) -> Deepest {
        let r_from_s1 = state.rotation.to_rotation_matrix();
        let mut deepest = Deepest {
            indentation_m: f64::NEG_INFINITY,
            remaining_m: 0.0,
        };
        for Point { offset, contact } in &self.points {
            let lever = r_from_s1 * offset;
            let (h, _) = self.object.probe(base, &state.surface, &state.position, &lever);
            if h > deepest.indentation_m {
                deepest = Deepest {
                    indentation_m: h,
                    remaining_m: contact.remaining_m(),
                };
            }
        }
        deepest
    }

    /// Remember the indentations reached at the end of an integration step; returns the deepest one, m.
    pub fn remember(&mut self, state: &State, base: &Base) -> f64 {
        let r_from_s1 = state.rotation.to_rotation_matrix();
        let mut deepest = f64::NEG_INFINITY;
        for Point { offset, contact } in &mut self.points {
            let lever = r_from_s1 * *offset;
            let (h, _) = self.object.probe(base, &state.surface, &state.position, &lever);
            contact.remember(h);
            deepest = deepest.max(h);
        }
        deepest
    }

    /// Whether the contact was smooth while the tool went from `start` to `end` within `time` s: no point met a kink
    /// of its law, nor was about to.
    pub fn stayed_smooth(&self, start: (&State, &Base), end: (&State, &Base), time: f64) -> bool {
        let rotations = [start.0, end.0].map(|state| state.rotation.to_rotation_matrix());
        self.points.iter().all(|Point { offset, contact }| {
            let [(h, rate), (h_end, _)] =
                [(start, rotations[0]), (end, rotations[1])].map(|((state, base), r)| {
                    let lever = r * offset;
                    let (h, normal) = self.object.probe(base, &state.surface, &state.position, &lever);
                    let velocity = state.velocity + state.angular_velocity.cross(&lever);
                    (h, normal.dot(&(velocity - self.surface_velocity(state, base))))
                });
            let (piece, room) = contact.piece(h);
            let allowed = piece == Piece::Off || (piece == Piece::Rebound && self.object.is_linear());
            allowed && room > rate.abs() * time && contact.piece(h_end).0 == piece
        })
    }

    fn surface_velocity(&self, state: &State, base: &Base) -> Vector3<f64> {
        base.velocity - self.object.normal() * state.surface.rate
    }

    /// `r_from_o`: where the object is with its surface, which has yielded.
    pub fn object_pose(&self, state: &State, base: &Base) -> Pose {
        self.object.pose(base, &state.surface)
    }
}
