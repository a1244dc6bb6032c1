//! Where the tool touches the object: the points that may, each with its contact and its memory.

use crate::contact::{Contact, Piece};
use crate::object::{Base, Object};
use crate::swing::{self, Course};
use crate::tool::{Rates, State};
use nalgebra::{Rotation3, Vector3};
use node::scenario::{self, ToolShape};
use spatial::Pose;
use std::f64::consts::{FRAC_PI_2, TAU};

/// Points on each ring of a peg.
const RING: usize = 8;

/// The most points that a tool has.
pub const POINTS: usize = 2 * RING;

/// For each point the piece of its contact's law that holds.
pub type Pieces = [Piece; POINTS];

/// All that is known at one instant.
#[derive(Clone, Copy, Debug)]
pub struct Moment<'a> {
    /// The tool.
    pub state: &'a State,
    /// How it changes.
    pub rates: &'a Rates,
    /// The object.
    pub base: &'a Base,
}

/// What smooth contacts have done within a while.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pressing {
    /// The largest force, N.
    pub largest_force_n: f64,
    /// Growth of the energy in the contacts' springs, J.
    pub stored_j: f64,
}

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
    /// The part of it that indents the surface, W.
    pub indenting_power: f64,
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
        self.load_on(None, state, r_from_s1, base)
    }

    /// The same with the formulas of `pieces` in the laws' place.
    pub fn load_on(
        &self,
        pieces: Option<&Pieces>,
        state: &State,
        r_from_s1: &Rotation3<f64>,
        base: &Base,
    ) -> Load {
        let mut load = Load::default();
        for (i, Point { offset, contact }) in self.points.iter().enumerate() {
            let piece = pieces.map(|pieces| pieces[i]);
            if piece == Some(Piece::Off) {
                continue;
            }
            let lever = r_from_s1 * offset;
            let (h, normal) = self.object.probe(base, &state.surface, &state.position, &lever);
            let pressure = contact.force_on(piece.unwrap_or_else(|| contact.piece(h).0), h);
            if pressure != 0.0 {
                let velocity = state.velocity + state.angular_velocity.cross(&lever);
                let sliding = velocity - self.surface_velocity(state, base);
                let force = normal * pressure + self.object.friction(pressure, &normal, &sliding);
                load.force += force;
                load.moment += lever.cross(&force);
                load.power -= force.dot(&velocity);
                load.indenting_power -= pressure * normal.dot(&sliding);
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

    /// The piece of its law that each point is on, if all these are smooth for a while: the object is away from it, or
    /// the contact is no more than another linear spring.
    pub fn pieces(&self, state: &State, base: &Base) -> Option<Pieces> {
        let r_from_s1 = state.rotation.to_rotation_matrix();
        let mut pieces = Pieces::default();
        for (piece, Point { offset, contact }) in pieces.iter_mut().zip(&self.points) {
            let lever = r_from_s1 * offset;
            let (h, _) = self.object.probe(base, &state.surface, &state.position, &lever);
            *piece = contact.piece(h).0;
            if *piece != Piece::Off && !self.object.is_linear() {
                return None;
            }
        }
        Some(pieces)
    }

    /// The points that press on the surface: lever from the centre of mass, m in r, and stiffness, N/m.
    pub fn springs(
        &self,
        pieces: &Pieces,
        r_from_s1: &Rotation3<f64>,
    ) -> impl Iterator<Item = (usize, Vector3<f64>, f64)> {
        let points = self.points.iter().zip(pieces).enumerate();
        points
            .filter(|(_, (_, piece))| **piece != Piece::Off)
            .map(move |(i, (point, piece))| (i, r_from_s1 * point.offset, point.contact.stiffness_on(*piece)))
    }

    /// Whether all points stayed on their `pieces` from `start` to `end`, `time` s later, each swinging with its
    /// angular frequency of `swings` (rad/s) as long as it presses.
    ///
    /// Then: the largest force in between, N (of several points the sum of their largest), and by how much the energy
    /// of their springs has grown, J.
    pub fn stayed(
        &self,
        pieces: &Pieces,
        [start, end]: [&Moment<'_>; 2],
        swings: &[f64; POINTS],
        time: f64,
    ) -> Option<Pressing> {
        let rotations = [start, end].map(|moment| moment.state.rotation.to_rotation_matrix());
        let mut pressing = Pressing::default();
        for (i, point) in self.points.iter().enumerate() {
            let from = self.course(point, start, &rotations[0]);
            let to = self.course(point, end, &rotations[1]);
            let (contact, remaining) = (&point.contact, point.contact.remaining_m());
            let (stayed, deepest) = match pieces[i] {
                Piece::Off => {
                    let no_dip = from.rate <= 0.0 || to.rate >= 0.0;
                    let far = remaining - from.value > from.rate * time;
                    (to.value < remaining && (no_dip || far), to.value)
                }
                // A quarter of a period, so that it can't turn and turn back.
                Piece::Loading => {
                    let inwards = from.rate > 0.0 && to.rate > 0.0;
                    (inwards && swings[i] * time < FRAC_PI_2, to.value)
                }
                Piece::Rebound => {
                    let (least, most) = swing::range([&from, &to], swings[i], time);
                    (least > remaining && most < contact.deepest_m(), most)
                }
            };
            if !stayed {
                return None;
            }
            if pieces[i] != Piece::Off {
                let energy = |h: f64| {
                    let force = contact.force_on(pieces[i], h);
                    0.5 * force * force / contact.stiffness_on(pieces[i])
                };
                pressing.largest_force_n += contact.force_on(pieces[i], deepest);
                pressing.stored_j += energy(to.value) - energy(from.value);
            }
        }
        Some(pressing)
    }

    /// How a point's indentation changes, m, m/s, m/s^2, the object's acceleration neglected.
    fn course(&self, point: &Point, moment: &Moment<'_>, r_from_s1: &Rotation3<f64>) -> Course {
        let Moment { state, rates, base } = moment;
        let (w, lever) = (state.angular_velocity, r_from_s1 * point.offset);
        let (h, normal) = self.object.probe(base, &state.surface, &state.position, &lever);
        let (spin, turn) = (w.cross(&lever), rates.angular_acceleration.cross(&lever));
        let sliding = state.velocity + spin - self.surface_velocity(state, base);
        Course {
            value: h,
            rate: -normal.dot(&sliding),
            change: -normal.dot(&(rates.acceleration + turn + w.cross(&spin))) - rates.surface.rate,
        }
    }

    fn surface_velocity(&self, state: &State, base: &Base) -> Vector3<f64> {
        base.velocity - self.object.normal() * state.surface.rate
    }

    /// `r_from_o`: where the object is with its surface, which has yielded.
    pub fn object_pose(&self, state: &State, base: &Base) -> Pose {
        self.object.pose(base, &state.surface)
    }
}
