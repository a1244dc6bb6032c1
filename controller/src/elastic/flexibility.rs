//! How motors, gears, links, sensor and tool yield between the motors and an object that the tool presses on.
//!
//! The assumed structure (`structure.rs`) with the tcp pinned to the object. In coordinates eta_i of its modes, each scaled such that it is what the mode adds to the deflection of the tcp along the normal,
//! `eta_i'' + 2 zeta w_i eta_i' + w_i^2 eta_i = b_i q_m`, and the deflection is `y = sum eta_i + r q_m`: the modes that
//! do not count for much are taken as rigid (r).
//!
//! Model choice: PLANT.md sections 1 and 2, with what the controller assumes.

use super::MODES;
use crate::structure::{DOFS, Modes, Structure};
use nalgebra::{Matrix6, SVector, Vector3};
use node::scenario;
use spatial::kinematics::{Axes, join};

/// The object's stiffness over the sensor's at the tcp: pinned, but for what a digit is worth.
const PINNED: f64 = 1e3;

/// A mode with less of a share takes no part.
const UNSEEN: f64 = 1e-6;

/// One mode as motors and sensor see it, in a coordinate that is what it adds to the deflection, m.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Mode {
    /// w, rad/s.
    pub frequency: f64,
    /// Acceleration per way of each motor, m/s^2 per rad.
    pub push: Axes,
    /// Acceleration of each motor per coordinate, rad/s^2 per m.
    pub pull: Axes,
    /// What it adds to the contact force times the sensor's compliance at the tcp, per coordinate: inertia counts here.
    pub force: f64,
}

/// What is between the motors and the tcp along the normal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Flexibility {
    /// Those that count most, by frequency.
    pub modes: [Mode; MODES],
    /// zeta of all of them.
    pub damping: f64,
    /// What all others add to the deflection per way of each motor, m/rad.
    pub rigid: Axes,
    /// What all others add to the contact force times compliance per way of each motor, m/rad.
    pub rigid_force: Axes,
    /// Acceleration of the motors per way of the motors, the links held by the modes that count, 1/s^2.
    pub gears: Matrix6<f64>,
    /// What the servos feed forward for the links, rad/s^2 per acceleration of the tcp.
    pub feed_forward: Axes,
    /// What the tcp moves along the normal per way of each axis, m/rad.
    pub tcp_per_axis: Axes,
    /// How the axes move the tcp along the normal, rad/m.
    pub axes_per_tcp: Axes,
}

impl Flexibility {
    /// Of a `structure` that stands on an object, behind motors as `controller` assumes them; `None` if its modes are not
    /// those of masses on springs.
    pub fn new(controller: &scenario::Controller, structure: &Structure) -> Option<Self> {
        let Structure {
            jacobian,
            links,
            gears,
            compliance,
            normal_at_tcp,
            ..
        } = structure;
        let tcp_per_axis = jacobian.tr_mul(normal_at_tcp);
        let axes_per_tcp = jacobian.lu().solve(&join(Vector3::z(), Vector3::zeros()))?;
        let held = PINNED / normal_at_tcp.dot(&(compliance * normal_at_tcp));
        let Modes { squares, shapes } = structure.modes(held)?;
        let mut seen = SVector::<f64, DOFS>::zeros();
        seen.fixed_rows_mut::<6>(0).copy_from(&-tcp_per_axis);
        seen.fixed_rows_mut::<6>(6).copy_from(normal_at_tcp);
        let motors = Axes::from(controller.servo.motor_inertia_kg_m2);
        let per_motor = gears.component_div(&motors);

        // What a metre along the normal adds to the deflection by each mode, the largest first.
        let push = |i: usize| shapes.fixed_view::<6, 1>(0, i).component_mul(gears);
        let output = |i: usize| seen.dot(&shapes.column(i));
        let share = |i: usize| output(i) * push(i).dot(&axes_per_tcp) / squares[i];
        let mut order: [usize; DOFS] = std::array::from_fn(|i| i);
        order.sort_unstable_by(|&a, &b| share(b).abs().total_cmp(&share(a).abs()));
        let (kept, others) = order.split_at_mut(MODES);
        kept.sort_unstable();
        let force = |i: usize| -PINNED * normal_at_tcp.dot(&shapes.fixed_view::<6, 1>(6, i));
        let (mut rigid, mut rigid_force) = (Axes::zeros(), Axes::zeros());
        let mut gears_held = Matrix6::from_diagonal(&per_motor);
        for &i in others.iter() {
            rigid += push(i) * (output(i) / squares[i]);
            rigid_force += push(i) * (force(i) / squares[i]);
            let pulls = shapes.fixed_view::<6, 1>(0, i).component_mul(&per_motor);
            gears_held -= pulls * push(i).transpose() / squares[i];
        }
        Some(Self {
            modes: std::array::from_fn(|slot| {
                let i = kept[slot];
                let frequency = libm::sqrt(squares[i]);
                if libm::fabs(share(i)) < UNSEEN {
                    // Its own may be that of the contact, faster than the steps of the model.
                    return Mode {
                        frequency: libm::sqrt(squares[0]),
                        ..Mode::default()
                    };
                }
                Mode {
                    frequency,
                    push: push(i) * output(i),
                    pull: shapes.fixed_view::<6, 1>(0, i).component_mul(&per_motor) / output(i),
                    force: force(i) / output(i),
                }
            }),
            damping: controller.gears.damping_ratio,
            rigid,
            rigid_force,
            gears: gears_held,
            feed_forward: axes_per_tcp
                .component_mul(&links.diagonal())
                .component_div(&motors),
            tcp_per_axis,
            axes_per_tcp,
        })
    }
}
