//! What is assumed of links, gears, tool and sensor as masses on springs, linear about a posture.
//!
//! Six links on elastic gears and the tool on its sensor are twelve degrees of freedom: the axes of the links (rad), and
//! the twist of the tool at s in r (m, rad). With the motors at q_m: `M q'' + K q = k q_m`, k the gears' stiffness.
//! PLANT.md sections 1 and 2, without dampings.

use nalgebra::{Cholesky, Matrix3, Matrix6, SMatrix, SVector, SymmetricEigen, Vector3};
use node::scenario::{self, Gears};
use spatial::kinematics::{Axes, Kinematics, join};
use spatial::{Pose, rotation};
use std::f64::consts::TAU;

/// Links and tool.
pub const DOFS: usize = 12;
/// What rigid gears are taken for, Hz: a thousand times the fastest swing of tool and sensor.
const RIGID_HZ: f64 = 1e5;

/// Links on gears, and the tool on the sensor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Structure {
    /// Of s, in r.
    pub jacobian: Matrix6<f64>,
    /// Inertia matrix of the links, kg m^2.
    pub links: Matrix6<f64>,
    /// Stiffness of the gears, Nm/rad.
    pub gears: Axes,
    /// Mass matrix of the tool at s.
    pub tool: Matrix6<f64>,
    /// Stiffness of the sensor.
    pub sensor: Matrix6<f64>,
    /// Compliance of the sensor.
    pub compliance: Matrix6<f64>,
    /// How a twist at s moves the tcp along the normal.
    pub normal_at_tcp: Axes,
}

/// The modes of a structure, ascending by frequency.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Modes {
    /// Squares of the angular frequencies, 1/s^2.
    pub squares: SVector<f64, DOFS>,
    /// A column for each, its mass 1.
    pub shapes: SMatrix<f64, DOFS, DOFS>,
}

impl Structure {
    /// As `controller` assumes it, with the axes of `kinematics` at `axes` (rad) and gears of the `kind`.
    pub fn new(controller: &scenario::Controller, kinematics: &Kinematics, axes: &Axes, kind: Gears) -> Self {
        let r_from_s = kinematics.forward(axes);
        let lever = r_from_s.rotation * Vector3::from(controller.tcp_in_s_m);
        let links = link_inertia(controller);
        let frequencies = match kind {
            Gears::Elastic => controller.gears.frequency_hz.into(),
            Gears::Rigid => Axes::repeat(RIGID_HZ),
        } * TAU;
        let compliance = join(
            Vector3::repeat(controller.compliance_m_per_n),
            Vector3::repeat(controller.compliance_rad_per_nm),
        );
        Self {
            jacobian: kinematics.jacobian(axes),
            links,
            gears: links
                .diagonal()
                .component_mul(&frequencies.component_mul(&frequencies)),
            tool: tool_mass(controller, &r_from_s),
            sensor: Matrix6::from_diagonal(&compliance.map(|c| 1.0 / c)),
            compliance: Matrix6::from_diagonal(&compliance),
            normal_at_tcp: join(Vector3::z(), lever.cross(&Vector3::z())),
        }
    }

    /// The same with all frequencies of the gears times `scale`.
    pub fn scaled(&self, scale: f64) -> Self {
        Self {
            gears: self.gears * (scale * scale),
            ..*self
        }
    }

    /// The modes with the motors at rest and the tcp held along the normal by a spring of `held` N/m; `None` if a mass
    /// or a stiffness is not positive.
    pub fn modes(&self, held: f64) -> Option<Modes> {
        let mut mass = SMatrix::<f64, DOFS, DOFS>::zeros();
        mass.fixed_view_mut::<6, 6>(0, 0).copy_from(&self.links);
        mass.fixed_view_mut::<6, 6>(6, 6).copy_from(&self.tool);
        let mut stiffness = SMatrix::<f64, DOFS, DOFS>::zeros();
        let coupling = -self.jacobian.tr_mul(&self.sensor);
        let on_gears = Matrix6::from_diagonal(&self.gears) - coupling * self.jacobian;
        let on_object = self.normal_at_tcp * self.normal_at_tcp.transpose() * held;
        stiffness.fixed_view_mut::<6, 6>(0, 0).copy_from(&on_gears);
        stiffness.fixed_view_mut::<6, 6>(0, 6).copy_from(&coupling);
        stiffness
            .fixed_view_mut::<6, 6>(6, 0)
            .copy_from(&coupling.transpose());
        stiffness
            .fixed_view_mut::<6, 6>(6, 6)
            .copy_from(&(self.sensor + on_object));
        // With M = L L^T and q = L^-T x: x'' + L^-1 K L^-T x = 0, which is symmetric.
        let factor = Cholesky::new(mass)?.l();
        let half = factor.solve_lower_triangular(&stiffness)?;
        let whole = factor.solve_lower_triangular(&half.transpose())?;
        let eigen = SymmetricEigen::new((whole + whole.transpose()) * 0.5);
        let mut order: [usize; DOFS] = std::array::from_fn(|i| i);
        order.sort_unstable_by(|&a, &b| eigen.eigenvalues[a].total_cmp(&eigen.eigenvalues[b]));
        let vectors = SMatrix::from_fn(|i, j| eigen.eigenvectors[(i, order[j])]);
        let squares = SVector::from_fn(|i, _| eigen.eigenvalues[order[i]]);
        (squares[0] > 0.0).then_some(Modes {
            squares,
            shapes: factor.transpose().solve_upper_triangular(&vectors)?,
        })
    }
}

impl Modes {
    /// Frequencies, ascending, Hz.
    pub fn hz(&self) -> [f64; DOFS] {
        std::array::from_fn(|i| libm::sqrt(self.squares[i]) / TAU)
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

/// The tool's mass matrix for twists at s, in r.
fn tool_mass(controller: &scenario::Controller, r_from_s: &Pose) -> Matrix6<f64> {
    let assumed = &controller.impact;
    let turned = r_from_s.rotation.to_rotation_matrix().into_inner();
    let inertia = turned * Matrix3::from_diagonal(&assumed.tool_inertia_kg_m2.into()) * turned.transpose();
    let centre = rotation::skew(turned * Vector3::from(assumed.centre_of_mass_in_s_m));
    let m = assumed.tool_mass_kg;
    let mut mass = Matrix6::from_diagonal_element(m);
    mass.fixed_view_mut::<3, 3>(0, 3).copy_from(&(centre * -m));
    mass.fixed_view_mut::<3, 3>(3, 0).copy_from(&(centre * m));
    mass.fixed_view_mut::<3, 3>(3, 3)
        .copy_from(&(inertia - centre * centre * m));
    mass
}
