//! How motors, gears, links, sensor and tool yield between the motors and an object that the tool presses on.
//!
//! Six links on elastic gears and the tool on its sensor are twelve degrees of freedom, linear about the working
//! posture: `M q'' + K q = k e u`, the motors moving the tcp by u along the normal (`e = J^-1 n` of the axes), the tcp
//! pinned to the object. In coordinates eta_i of their modes, each scaled such that it follows u at rest,
//! `eta_i'' + 2 zeta w_i eta_i' + w_i^2 eta_i = w_i^2 u`, and what the sensor shows of the tcp is
//! `y = sum r_i eta_i + r u`, the modes that do not count for much taken as rigid (`r`).
//!
//! Model choice: PLANT.md sections 1 and 2, with what the controller assumes.

use super::MODES;
use crate::Settings;
use nalgebra::{Cholesky, Matrix3, Matrix6, SMatrix, SVector, SymmetricEigen, Vector3};
use spatial::kinematics::{Axes, join};
use std::f64::consts::TAU;

/// The object's stiffness over the sensor's at the tcp: pinned, but for what a digit is worth.
const PINNED: f64 = 1e3;
/// Links and tool.
const DOFS: usize = 12;

/// One mode as motors and sensor see it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Mode {
    /// w, rad/s.
    pub frequency: f64,
    /// r: how much of the motors' way it takes from the sensor's deflection.
    pub share: f64,
    /// How much of its way it pulls at the motors, 1/s^2.
    pub pull: f64,
}

/// What the tcp sees along the normal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Flexibility {
    /// Those that count most, by frequency.
    pub modes: [Mode; MODES],
    /// zeta of all of them.
    pub damping: f64,
    /// The share of the modes that do not count.
    pub rigid_share: f64,
    /// How much of their own way the motors are pulled back by all gears, 1/s^2.
    pub pull: f64,
    /// What the servos feed forward of an acceleration for the links, as a share of the motors' inertia.
    pub feed_forward: f64,
    /// What the tcp moves per rad of each axis, m.
    pub tcp_per_axis: Axes,
    /// How the axes move the tcp by one metre along the normal, rad.
    pub axes_per_tcp: Axes,
}

impl Flexibility {
    /// Of the robot at `axes`, with the hanging tcp at `lever` (m, in r) from the sensor frame; all gear frequencies
    /// times `scale`.
    pub(crate) fn new(settings: &Settings, axes: &Axes, lever: &Vector3<f64>, scale: f64) -> Self {
        let controller = &settings.controller;
        let (gears, servo, tool) = (&controller.gears, &controller.servo, &controller.impact);
        let jacobian = settings.kinematics.jacobian(axes);
        let rotation = settings
            .kinematics
            .forward(axes)
            .rotation
            .to_rotation_matrix()
            .into_inner();
        let normal = Vector3::z();
        // Velocity of the tcp along the normal over the twist of a frame at s.
        let at_tcp = join(normal, lever.cross(&normal));
        let tcp_per_axis = jacobian.tr_mul(&at_tcp);
        let axes_per_tcp = jacobian
            .lu()
            .solve(&join(normal, Vector3::zeros()))
            .unwrap_or_default();

        let links = Matrix6::from_diagonal(&servo.link_inertia_kg_m2.into());
        let gear = Axes::from_fn(|i, _| {
            let w = TAU * gears.frequency_hz[i] * scale;
            links[(i, i)] * w * w
        });
        let sensor = join(
            Vector3::repeat(1.0 / controller.compliance_m_per_n),
            Vector3::repeat(1.0 / controller.compliance_rad_per_nm),
        );
        let centre = rotation * Vector3::from(tool.centre_of_mass_in_s_m);
        let inertia =
            rotation * Matrix3::from_diagonal(&tool.tool_inertia_kg_m2.into()) * rotation.transpose();
        let sensor = Matrix6::from_diagonal(&sensor);
        let contact = at_tcp * at_tcp.transpose() * (PINNED / settings.normal_compliance(lever));

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
            .copy_from(&(sensor + contact));

        let pushed = gear.component_mul(&axes_per_tcp);
        let pull_of_link =
            tcp_per_axis.zip_zip_map(&gear, &Axes::from(servo.motor_inertia_kg_m2), |g, k, m| g * k / m);
        let mut seen = SVector::<f64, DOFS>::zeros();
        seen.fixed_rows_mut::<6>(0).copy_from(&-tcp_per_axis);
        seen.fixed_rows_mut::<6>(6).copy_from(&at_tcp);

        let mut all = [Mode::default(); DOFS];
        if let Some((frequencies, shapes)) = modes(&mass, &stiffness) {
            for (mode, (square, shape)) in all.iter_mut().zip(frequencies.iter().zip(shapes.column_iter())) {
                let link = shape.fixed_rows::<6>(0);
                let way = link.dot(&pushed) / square;
                *mode = Mode {
                    frequency: libm::sqrt(*square),
                    share: way * seen.dot(&shape),
                    pull: way * link.dot(&pull_of_link),
                };
            }
        }
        all.sort_unstable_by(|a, b| b.share.abs().total_cmp(&a.share.abs()));
        let mut kept = [Mode::default(); MODES];
        let (counting, others) = all.split_at(MODES);
        kept.copy_from_slice(counting);
        kept.sort_unstable_by(|a, b| a.frequency.total_cmp(&b.frequency));
        Self {
            modes: kept,
            damping: gears.damping_ratio,
            rigid_share: others.iter().map(|mode| mode.share).sum(),
            pull: pull_of_link.dot(&axes_per_tcp) - others.iter().map(|mode| mode.pull).sum::<f64>(),
            feed_forward: (0..6)
                .map(|i| tcp_per_axis[i] * axes_per_tcp[i] * links[(i, i)] / servo.motor_inertia_kg_m2[i])
                .sum(),
            tcp_per_axis,
            axes_per_tcp,
        }
    }

    /// What the deflection is at rest per way of the motors.
    pub fn share(&self) -> f64 {
        self.modes.iter().map(|mode| mode.share).sum::<f64>() + self.rigid_share
    }
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

/// The squared frequencies (1/s^2) and the shapes, with mass 1, of `M q'' + K q = 0`.
fn modes(
    mass: &SMatrix<f64, DOFS, DOFS>,
    stiffness: &SMatrix<f64, DOFS, DOFS>,
) -> Option<(SVector<f64, DOFS>, SMatrix<f64, DOFS, DOFS>)> {
    let factor = Cholesky::new(*mass)?.l();
    let half = factor.solve_lower_triangular(stiffness)?;
    let whole = factor.solve_lower_triangular(&half.transpose())?;
    let eigen = SymmetricEigen::new((whole + whole.transpose()) * 0.5);
    let shapes = factor.transpose().solve_upper_triangular(&eigen.eigenvectors)?;
    Some((eigen.eigenvalues, shapes))
}
