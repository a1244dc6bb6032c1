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
use crate::structure::{DOFS, Structure};
use nalgebra::Vector3;
use node::scenario::{self, Gears};
use spatial::kinematics::{Axes, Kinematics, join, split};

/// The assumed model along the normal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Swing {
    /// How far the hanging tcp has to lead, by the acceleration along z of r: m and rad per m/s^2.
    acceleration: Dofs,
    /// Frequencies of the modes, ascending, Hz.
    modes_hz: [f64; DOFS],
    gears: Gears,
}

impl Swing {
    /// Of what `controller` assumes, with the axes of `kinematics` at `start` (rad).
    pub fn new(controller: &scenario::Controller, kinematics: &Kinematics, start: &Axes) -> Self {
        let gears = controller.gears.kind;
        let structure = Structure::new(controller, kinematics, start, gears);
        let lever = kinematics.forward(start).rotation * Vector3::from(controller.tcp_in_s_m);
        let normal = join(Vector3::z(), Vector3::zeros());
        let reaction = structure.tool * normal;
        let axes = structure.jacobian.lu().solve(&normal).unwrap_or_default();
        let torque = structure.links * axes + structure.jacobian.tr_mul(&reaction);
        let at_s =
            structure.compliance * reaction + structure.jacobian * torque.component_div(&structure.gears);
        let (translation, turn) = split(&at_s);
        Self {
            acceleration: join(translation + turn.cross(&lever), turn),
            modes_hz: structure
                .modes(0.0)
                .map_or([f64::INFINITY; DOFS], |modes| modes.hz()),
            gears,
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
        match self.gears {
            Gears::Rigid => 1.0,
            Gears::Elastic => 2.0,
        }
    }

    /// All modes, ascending, Hz; with rigid gears the last six are far above all others.
    pub fn modes_hz(&self) -> &[f64; DOFS] {
        &self.modes_hz
    }
}
