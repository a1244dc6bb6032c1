//! What swings when the robot accelerates, as far as it is assumed: the tool on the sensor, and the links on their gears.
//!
//! A linear model in the posture of the start, without dampings. Inverted: a tool of mass M and centre of mass c, both
//! assumed, that moves by y along the normal and does not turn needs the wrench `R y'' = (M n, c x M n) y''` at s, and the
//! sensor frame at `x_s = n y + C R y''`; the motors, with K_g the gears' stiffness, at
//! `q_m = q_l + K_g^-1 (M_l q_l'' + J^T R y'')`, `J q_l = x_s`.
//!
//! Model choice: of `q_l''` the part by y'' only. The rest, by the fourth derivative of y, changes what is left swinging by
//! less than the dampings do, which are not known at all.

use crate::dofs::Dofs;
use nalgebra::{Cholesky, Matrix3, Matrix6, SMatrix, Vector3};
use node::scenario::{self, Gears};
use spatial::kinematics::{Axes, Kinematics, join, split};
use spatial::{Compliance, Pose, rotation};
use std::f64::consts::TAU;

/// The assumed model along the normal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Swing {
    /// How far the hanging tcp has to lead, by the acceleration along z of r: m and rad per m/s^2.
    acceleration: Dofs,
    /// Frequencies of the modes, ascending, Hz; of rigid gears the first six.
    modes_hz: [f64; 12],
}

impl Swing {
    /// Of what `controller` assumes, with the axes of `kinematics` at `start` (rad).
    pub fn new(controller: &scenario::Controller, kinematics: &Kinematics, start: &Axes) -> Self {
        let r_from_s = kinematics.forward(start);
        let jacobian = kinematics.jacobian(start);
        let lever = r_from_s.rotation * Vector3::from(controller.tcp_in_s_m);
        let tool = Tool::new(controller, &r_from_s);
        let at_tcp = |at_s: &Dofs| {
            let (translation, turn) = split(at_s);
            join(translation + turn.cross(&lever), turn)
        };
        let normal = join(Vector3::z(), Vector3::zeros());
        let reaction = tool.mass * normal;
        let sensor = tool.compliance * reaction;
        let links = Links::new(controller);
        let inverse = jacobian.try_inverse();
        let Some((links, inverse)) = links.zip(inverse) else {
            return Self {
                acceleration: at_tcp(&sensor),
                modes_hz: tool.modes_hz(),
            };
        };
        let torque = links.inertia.component_mul(&(inverse * normal)) + jacobian.tr_mul(&reaction);
        let gears = jacobian * torque.component_div(&links.stiffness);
        Self {
            acceleration: at_tcp(&(sensor + gears)),
            modes_hz: tool.modes_on(&links, &jacobian),
        }
    }

    /// How far (m and rad) the hanging tcp has to lead the deflected one which moves along z of r with `acceleration`
    /// (m/s^2).
    pub fn lead(&self, acceleration: f64) -> Dofs {
        self.acceleration * acceleration
    }

    /// How far the tcp stays behind per acceleration, m per m/s^2.
    pub fn yields_by_s2(&self) -> f64 {
        split(&self.acceleration).0.norm()
    }

    /// The lowest mode, Hz.
    pub fn lowest_hz(&self) -> f64 {
        self.modes_hz[0]
    }

    /// How many springs there are between motors and tool: the sensor, and the gears unless they are rigid.
    pub fn springs(&self) -> f64 {
        if self.modes_hz[6].is_finite() { 2.0 } else { 1.0 }
    }

    /// All modes, ascending, Hz; with rigid gears the last six are infinite.
    pub fn modes_hz(&self) -> &[f64; 12] {
        &self.modes_hz
    }
}

/// The tool on the sensor, at s and along the axes of r.
struct Tool {
    mass: Matrix6<f64>,
    compliance: Matrix6<f64>,
    stiffness: Matrix6<f64>,
}

impl Tool {
    fn new(controller: &scenario::Controller, r_from_s: &Pose) -> Self {
        let compliance =
            Compliance::isotropic(controller.compliance_m_per_n, controller.compliance_rad_per_nm);
        let assumed = &controller.impact;
        let turned = r_from_s.rotation.to_rotation_matrix().into_inner();
        let in_r = |matrix: &Matrix3<f64>| turned * matrix * turned.transpose();
        let inertia = in_r(&Matrix3::from_diagonal(&assumed.tool_inertia_kg_m2.into()));
        let centre = rotation::skew(turned * Vector3::from(assumed.centre_of_mass_in_s_m));
        let m = assumed.tool_mass_kg;
        let mut mass = Matrix6::from_diagonal_element(m);
        mass.fixed_view_mut::<3, 3>(0, 3).copy_from(&(centre * -m));
        mass.fixed_view_mut::<3, 3>(3, 0).copy_from(&(centre * m));
        mass.fixed_view_mut::<3, 3>(3, 3)
            .copy_from(&(inertia - centre * centre * m));
        let blocks = |translation: Matrix3<f64>, rotation: Matrix3<f64>| {
            let mut matrix = Matrix6::zeros();
            matrix.fixed_view_mut::<3, 3>(0, 0).copy_from(&translation);
            matrix.fixed_view_mut::<3, 3>(3, 3).copy_from(&rotation);
            matrix
        };
        let (translation, rotation) = (in_r(&compliance.translation), in_r(&compliance.rotation));
        let stiff = |compliance: &Matrix3<f64>| compliance.try_inverse().unwrap_or_default();
        Self {
            mass,
            compliance: blocks(translation, rotation),
            stiffness: blocks(stiff(&translation), stiff(&rotation)),
        }
    }

    /// On a robot that does not yield, Hz.
    fn modes_hz(&self) -> [f64; 12] {
        let squares = Cholesky::new(self.mass)
            .and_then(|factor| factor.l().try_inverse())
            .map(|inverse| (inverse * self.stiffness * inverse.transpose()).symmetric_eigenvalues());
        ascending_hz(squares.iter().flat_map(|squares| squares.iter()))
    }

    /// On links that yield, the motors at rest, Hz.
    fn modes_on(&self, links: &Links, jacobian: &Matrix6<f64>) -> [f64; 12] {
        let mut mass = SMatrix::<f64, 12, 12>::zeros();
        mass.fixed_view_mut::<6, 6>(0, 0)
            .copy_from(&Matrix6::from_diagonal(&links.inertia));
        mass.fixed_view_mut::<6, 6>(6, 6).copy_from(&self.mass);
        let coupling = -self.stiffness * jacobian;
        let held = Matrix6::from_diagonal(&links.stiffness) - jacobian.transpose() * coupling;
        let mut stiffness = SMatrix::<f64, 12, 12>::zeros();
        stiffness.fixed_view_mut::<6, 6>(0, 0).copy_from(&held);
        stiffness
            .fixed_view_mut::<6, 6>(0, 6)
            .copy_from(&coupling.transpose());
        stiffness.fixed_view_mut::<6, 6>(6, 0).copy_from(&coupling);
        stiffness.fixed_view_mut::<6, 6>(6, 6).copy_from(&self.stiffness);
        let squares = Cholesky::new(mass)
            .and_then(|factor| factor.l().try_inverse())
            .map(|inverse| (inverse * stiffness * inverse.transpose()).symmetric_eigenvalues());
        ascending_hz(squares.iter().flat_map(|squares| squares.iter()))
    }
}

/// The links on their gears, axis by axis.
struct Links {
    /// kg m^2.
    inertia: Axes,
    /// Nm/rad.
    stiffness: Axes,
}

impl Links {
    /// As `controller` assumes them; `None`: the gears are rigid.
    fn new(controller: &scenario::Controller) -> Option<Self> {
        let inertia = Axes::from(controller.servo.link_inertia_kg_m2);
        let frequencies = Axes::from(controller.gears.frequency_hz) * TAU;
        (controller.gears.kind == Gears::Elastic).then(|| Self {
            inertia,
            stiffness: inertia.component_mul(&frequencies.component_mul(&frequencies)),
        })
    }
}

/// Frequencies (Hz) from squares of angular frequencies, ascending; infinite beyond them.
fn ascending_hz<'a>(squares: impl Iterator<Item = &'a f64>) -> [f64; 12] {
    let mut hz = [f64::INFINITY; 12];
    for (hz, square) in hz.iter_mut().zip(squares) {
        *hz = libm::sqrt(square.max(0.0)) / TAU;
    }
    hz.sort_unstable_by(f64::total_cmp);
    hz
}
