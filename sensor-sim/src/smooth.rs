//! The tool as a linear system, for as long as its contacts stay on a smooth piece of their law: suspension and
//! contacts are then springs and dampers, and only rotations bend it.

use crate::contacts::{Contacts, POINTS, Pieces};
use crate::exponential::{Operator, Phi, Vector};
use crate::object::Yielding;
use crate::tool::{Body, Rates, State};
use nalgebra::{Matrix3, Matrix3x6, Matrix6, Rotation3, UnitQuaternion, Vector3, Vector6};
use spatial::kinematics::join;
use spatial::rotation::{self, skew};

/// How far the tool turns before the linear system is taken anew, rad. What the explicit part of the method has to
/// bear of the contact's stiffness is about that share of it.
const TURN_RAD: f64 = 2e-3;

/// Linear systems that are remembered. A point that touches needs three: off, loading, rebound.
const REMEMBERED: usize = 3;

/// The linear systems that were needed last.
#[derive(Clone, Debug)]
pub struct Smooth {
    longest_s: f64,
    systems: Vec<Linear>,
    oldest: usize,
}

/// The tool, linear about one orientation, its contacts on certain pieces of their laws.
#[derive(Clone, Debug)]
pub struct Linear {
    pieces: Pieces,
    /// None yet, or that of the tool.
    r_from_s1: Option<UnitQuaternion<f64>>,
    /// L of [`crate::exponential`], for y = (position, rotation vector, velocity, angular velocity, surface).
    pub operator: Operator,
    /// For the longest step, for half of it, ...
    pub levels: Vec<Phi>,
    /// Of each point that presses, the angular frequency of its contact, rad/s.
    pub swings: [f64; POINTS],
}

impl Smooth {
    /// For steps of `longest_s` s that are halved up to `halvings` times.
    pub fn new(longest_s: f64, halvings: usize) -> Self {
        let none = Linear {
            pieces: Pieces::default(),
            r_from_s1: None,
            operator: Operator::zeros(),
            levels: vec![Phi::zero(); halvings + 1],
            swings: [0.0; POINTS],
        };
        Self {
            longest_s,
            systems: vec![none; REMEMBERED],
            oldest: 0,
        }
    }

    /// The linear system for the tool in `state` on `pieces`.
    pub fn about(&mut self, body: &Body, contacts: &Contacts, state: &State, pieces: &Pieces) -> &Linear {
        let known = self.systems.iter().position(|system| system.pieces == *pieces);
        let index = known.unwrap_or_else(|| {
            self.oldest = (self.oldest + 1) % REMEMBERED;
            self.oldest
        });
        let system = &mut self.systems[index];
        if known.is_none() || !system.is_about(&state.rotation) {
            system.pieces = *pieces;
            system.linearise(&state.rotation, body, contacts);
            Phi::fill(&mut system.levels, &system.operator, self.longest_s);
        }
        &self.systems[index]
    }
}

impl Linear {
    fn is_about(&self, r_from_s1: &UnitQuaternion<f64>) -> bool {
        self.r_from_s1.is_some_and(|known| {
            let half_turn = (r_from_s1 * known.inverse()).imag();
            4.0 * half_turn.norm_squared() <= TURN_RAD * TURN_RAD
        })
    }

    /// With generalised coordinates q = (x, v) of the centre of mass, `M q'' = -K q - D q'`: the suspension is
    /// deflected by `x + c x v` (c: from s' to the centre of mass), a point at lever l indents the surface by
    /// `-n (x + v x l)` less the surface's own yielding.
    fn linearise(&mut self, r_from_s1: &UnitQuaternion<f64>, body: &Body, contacts: &Contacts) {
        self.r_from_s1 = Some(*r_from_s1);
        let rotation = r_from_s1.to_rotation_matrix();
        let Body { suspension, .. } = body;
        let mut reach = Matrix3x6::identity();
        reach
            .fixed_view_mut::<3, 3>(0, 3)
            .copy_from(&skew(rotation * body.centre_of_mass));
        let spring = |along: f64, about: f64| {
            let turning = Vector6::new(0.0, 0.0, 0.0, about, about, about);
            reach.transpose() * reach * along + Matrix6::from_diagonal(&turning)
        };
        let mut stiffness = spring(suspension.stiffness_n_per_m, suspension.stiffness_nm_per_rad);
        let damping = spring(suspension.damping_ns_per_m, suspension.damping_nms_per_rad);
        let mobility = mobility(body, &rotation);

        let object = contacts.object();
        let (normal, none) = (object.normal(), Vector3::zeros());
        let yields = |depth: f64, rate: f64| object.yielding_rates(&Yielding { depth, rate }, &none);
        let yields_to_1_n = object.yielding_rates(&Yielding::default(), &normal).rate;
        let mut on_surface = Vector6::zeros();
        let mut surface_stiffness = 0.0;
        for (i, lever, k) in contacts.springs(&self.pieces, &rotation) {
            let indentation = join(-normal, -lever.cross(&normal));
            stiffness += indentation * indentation.transpose() * k;
            on_surface += indentation * k;
            surface_stiffness += k;
            let mobility = indentation.dot(&(mobility * indentation)) + yields_to_1_n;
            self.swings[i] = (k * mobility).sqrt();
        }

        let l = &mut self.operator;
        l.fill(0.0);
        l.fixed_view_mut::<6, 6>(0, 6).fill_with_identity();
        l.fixed_view_mut::<6, 6>(6, 0).copy_from(&(-mobility * stiffness));
        l.fixed_view_mut::<6, 6>(6, 6).copy_from(&(-mobility * damping));
        l.fixed_view_mut::<6, 1>(6, 12)
            .copy_from(&(mobility * on_surface));
        l.fixed_view_mut::<1, 6>(13, 0)
            .copy_from(&(on_surface.transpose() * yields_to_1_n));
        l[(12, 13)] = yields(0.0, 1.0).depth;
        l[(13, 12)] = yields(1.0, 0.0).rate - surface_stiffness * yields_to_1_n;
        l[(13, 13)] = yields(0.0, 1.0).rate;
    }
}

impl State {
    /// The state changed by position, rotation vector, velocity, angular velocity and surface, one below the other.
    pub(crate) fn changed(&self, by: &Vector) -> Self {
        let rows = |first: usize| Vector3::new(by[first], by[first + 1], by[first + 2]);
        Self {
            position: self.position + rows(0),
            velocity: self.velocity + rows(6),
            rotation: rotation::exp(rows(3)) * self.rotation,
            angular_velocity: self.angular_velocity + rows(9),
            surface: Yielding {
                depth: self.surface.depth + by[12],
                rate: self.surface.rate + by[13],
            },
        }
    }
}

impl Rates {
    /// As the rates of change of a change (see [`State::changed`]) whose rotation vector is `turn`, rad:
    /// `w = J(v) v'`.
    pub(crate) fn of_change(&self, angular_velocity: &Vector3<f64>, turn: &Vector3<f64>) -> Vector {
        let turning = rotation::rate_of_change(*turn, *angular_velocity);
        let mut vector = Vector::zeros();
        vector.fixed_rows_mut::<3>(0).copy_from(&self.velocity);
        vector.fixed_rows_mut::<3>(3).copy_from(&turning);
        vector.fixed_rows_mut::<3>(6).copy_from(&self.acceleration);
        vector
            .fixed_rows_mut::<3>(9)
            .copy_from(&self.angular_acceleration);
        vector[12] = self.surface.depth;
        vector[13] = self.surface.rate;
        vector
    }
}

/// The inverse of the tool's mass matrix in r about its centre of mass.
fn mobility(body: &Body, r_from_s1: &Rotation3<f64>) -> Matrix6<f64> {
    let mut mobility = Matrix6::from_diagonal_element(body.mass_inverse);
    let turning: Matrix3<f64> =
        r_from_s1.matrix() * Matrix3::from_diagonal(&body.inertia_inverse) * r_from_s1.matrix().transpose();
    mobility.fixed_view_mut::<3, 3>(3, 3).copy_from(&turning);
    mobility
}
