//! How motors, gears, links, sensor and tool yield between the motors and an object that the tool presses on.
//!
//! Six links on elastic gears and the tool on its sensor are twelve degrees of freedom, linear about the working
//! posture, the tcp pinned to the object: `M q'' + K q = k q_m` with the motors at q_m. In coordinates eta_i of their
//! modes, each scaled such that it is what the mode adds to the deflection of the tcp along the normal,
//! `eta_i'' + 2 zeta w_i eta_i' + w_i^2 eta_i = b_i q_m`, and the deflection is `y = sum eta_i + r q_m`: the modes that
//! do not count for much are taken as rigid (r).
//!
//! Model choice: PLANT.md sections 1 and 2, with what the controller assumes.

use super::MODES;
use nalgebra::{Cholesky, Matrix3, Matrix6, SMatrix, SVector, SymmetricEigen, Vector3};
use node::scenario;
use spatial::kinematics::{Axes, join};
use std::f64::consts::TAU;

/// The object's stiffness over the sensor's at the tcp: pinned, but for what a digit is worth.
const PINNED: f64 = 1e3;
/// Links and tool.
const DOFS: usize = 12;

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
    /// Of a robot whose sensor frame, parallel to r, moves as the `jacobian` says; all gear frequencies times `scale`.
    pub fn new(controller: &scenario::Controller, jacobian: &Matrix6<f64>, scale: f64) -> Self {
        let (gears, servo, tool) = (&controller.gears, &controller.servo, &controller.impact);
        let normal = Vector3::z();
        // Velocity of the tcp along the normal over the twist of a frame at s.
        let at_tcp = join(normal, Vector3::from(controller.tcp_in_s_m).cross(&normal));
        let tcp_per_axis = jacobian.tr_mul(&at_tcp);
        let axes_per_tcp = jacobian
            .lu()
            .solve(&join(normal, Vector3::zeros()))
            .unwrap_or_default();

        let links = link_inertia(controller);
        let gear = Axes::from_fn(|i, _| {
            let w = TAU * gears.frequency_hz[i] * scale;
            links[(i, i)] * w * w
        });
        let compliance = join(
            Vector3::repeat(controller.compliance_m_per_n),
            Vector3::repeat(controller.compliance_rad_per_nm),
        );
        let pinned = PINNED / compliance.dot(&at_tcp.component_mul(&at_tcp));
        let sensor = Matrix6::from_diagonal(&compliance.map(|c| 1.0 / c));
        let centre = Vector3::from(tool.centre_of_mass_in_s_m);
        let inertia = Matrix3::from_diagonal(&tool.tool_inertia_kg_m2.into());

        let mut mass = SMatrix::<f64, DOFS, DOFS>::zeros();
        mass.fixed_view_mut::<6, 6>(0, 0).copy_from(&links);
        mass.fixed_view_mut::<6, 6>(6, 6)
            .copy_from(&tool_inertia(tool.tool_mass_kg, &centre, &inertia));
        let mut stiffness = SMatrix::<f64, DOFS, DOFS>::zeros();
        let on_links = jacobian.tr_mul(&sensor);
        stiffness
            .fixed_view_mut::<6, 6>(0, 0)
            .copy_from(&(on_links * jacobian + Matrix6::from_diagonal(&gear)));
        stiffness.fixed_view_mut::<6, 6>(0, 6).copy_from(&-on_links);
        stiffness
            .fixed_view_mut::<6, 6>(6, 0)
            .copy_from(&-on_links.transpose());
        stiffness
            .fixed_view_mut::<6, 6>(6, 6)
            .copy_from(&(sensor + at_tcp * at_tcp.transpose() * pinned));

        let mut seen = SVector::<f64, DOFS>::zeros();
        seen.fixed_rows_mut::<6>(0).copy_from(&-tcp_per_axis);
        seen.fixed_rows_mut::<6>(6).copy_from(&at_tcp);
        let motors = Axes::from(servo.motor_inertia_kg_m2);
        let per_motor = gear.component_div(&motors);

        // What a metre along the normal adds to the deflection by each mode, the largest first.
        let (squares, shapes) = modes(&mass, &stiffness).unwrap_or_default();
        let push = |i: usize| shapes.fixed_view::<6, 1>(0, i).component_mul(&gear);
        let output = |i: usize| seen.dot(&shapes.column(i));
        let share = |i: usize| output(i) * push(i).dot(&axes_per_tcp) / squares[i];
        let mut order: [usize; DOFS] = std::array::from_fn(|i| i);
        order.sort_unstable_by(|&a, &b| share(b).abs().total_cmp(&share(a).abs()));
        let (kept, others) = order.split_at_mut(MODES);
        kept.sort_unstable();
        let force = |i: usize| -PINNED * at_tcp.dot(&shapes.fixed_view::<6, 1>(6, i));
        let (mut rigid, mut rigid_force) = (Axes::zeros(), Axes::zeros());
        let mut gears_held = Matrix6::from_diagonal(&per_motor);
        for &i in others.iter() {
            rigid += push(i) * (output(i) / squares[i]);
            rigid_force += push(i) * (force(i) / squares[i]);
            let pulls = shapes.fixed_view::<6, 1>(0, i).component_mul(&per_motor);
            gears_held -= pulls * push(i).transpose() / squares[i];
        }
        Self {
            modes: std::array::from_fn(|slot| {
                let i = kept[slot];
                Mode {
                    frequency: libm::sqrt(squares[i]),
                    push: push(i) * output(i),
                    pull: shapes.fixed_view::<6, 1>(0, i).component_mul(&per_motor) / output(i),
                    force: force(i) / output(i),
                }
            }),
            damping: gears.damping_ratio,
            rigid,
            rigid_force,
            gears: gears_held,
            feed_forward: axes_per_tcp
                .component_mul(&links.diagonal())
                .component_div(&motors),
            tcp_per_axis,
            axes_per_tcp,
        }
    }

    /// What each mode adds to the deflection at rest per metre of the motors along the normal.
    pub fn shares(&self) -> [f64; MODES] {
        self.modes
            .each_ref()
            .map(|mode| mode.push.dot(&self.axes_per_tcp) / (mode.frequency * mode.frequency))
    }
}

/// The inertia matrix of the links in the coordinates of the axes, kg m^2.
fn link_inertia(controller: &scenario::Controller) -> Matrix6<f64> {
    let mut inertia = Matrix6::from_diagonal(&controller.servo.link_inertia_kg_m2.into());
    let mut couplings = controller.gears.link_coupling_kg_m2.into_iter();
    for i in 0..6 {
        for j in i + 1..6 {
            let coupling = couplings.next().unwrap_or_default();
            (inertia[(i, j)], inertia[(j, i)]) = (coupling, coupling);
        }
    }
    inertia
}

/// The tool's mass matrix for twists of a frame at s, with its centre of mass at `centre` (m) from there.
fn tool_inertia(mass: f64, centre: &Vector3<f64>, inertia: &Matrix3<f64>) -> Matrix6<f64> {
    let across = centre.cross_matrix();
    let mut matrix = Matrix6::zeros();
    matrix.fixed_view_mut::<3, 3>(0, 0).fill_diagonal(mass);
    matrix.fixed_view_mut::<3, 3>(0, 3).copy_from(&(across * -mass));
    matrix.fixed_view_mut::<3, 3>(3, 0).copy_from(&(across * mass));
    matrix
        .fixed_view_mut::<3, 3>(3, 3)
        .copy_from(&(inertia - across * across * mass));
    matrix
}

/// The squared frequencies (1/s^2), the lowest first, and the shapes, with mass 1, of `M q'' + K q = 0`.
fn modes(
    mass: &SMatrix<f64, DOFS, DOFS>,
    stiffness: &SMatrix<f64, DOFS, DOFS>,
) -> Option<(SVector<f64, DOFS>, SMatrix<f64, DOFS, DOFS>)> {
    let factor = Cholesky::new(*mass)?.l();
    let half = factor.solve_lower_triangular(stiffness)?;
    let whole = factor.solve_lower_triangular(&half.transpose())?;
    let eigen = SymmetricEigen::new((whole + whole.transpose()) * 0.5);
    let mut order: [usize; DOFS] = std::array::from_fn(|i| i);
    order.sort_unstable_by(|&a, &b| eigen.eigenvalues[a].total_cmp(&eigen.eigenvalues[b]));
    let vectors = SMatrix::from_fn(|i, j| eigen.eigenvectors[(i, order[j])]);
    let shapes = factor.transpose().solve_upper_triangular(&vectors)?;
    Some((SVector::from_fn(|i, _| eigen.eigenvalues[order[i]]), shapes))
}
