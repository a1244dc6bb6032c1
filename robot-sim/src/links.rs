//! What the motors move: decoupled masses, or the links of an arm.

use crate::arm_links::ArmLinks;
use nalgebra::{Cholesky, Matrix6};
use node::scenario::{self, Kinematics};
use spatial::kinematics::{Arm, Axes};

/// The link side of the six axes. `rotors` are inertias (kg m^2) that turn with the axes: the motors' where the
/// gears are rigid.
#[derive(Clone, Copy, Debug, PartialEq)]
#[expect(
    clippy::large_enum_variant,
    reason = "there is one per robot, and it is not moved"
)]
pub enum Links {
    /// One inertia per axis, kg m^2.
    Gantry(Axes),
    /// Six coupled bodies.
    Arm(ArmLinks),
}

impl Links {
    /// The links of a scenario's robot.
    pub fn new(robot: &scenario::Robot) -> Self {
        match robot.kinematics {
            Kinematics::Gantry => Self::Gantry(robot.gantry.link_inertia_kg_m2.into()),
            Kinematics::Arm => Self::Arm(ArmLinks::new(&robot.arm)),
        }
    }

    /// The mass matrix, kg m^2.
    pub fn mass_matrix(&self, position: &Axes) -> Matrix6<f64> {
        match self {
            Self::Gantry(inertia) => Matrix6::from_diagonal(inertia),
            Self::Arm(links) => links.mass_matrix(position),
        }
    }

    /// What each axis moves with all others locked, kg m^2; of the arm in its working posture.
    pub fn axis_inertia(&self) -> Axes {
        match self {
            Self::Gantry(inertia) => *inertia,
            Self::Arm(links) => links.mass_matrix(&Arm::WORKING).diagonal(),
        }
    }

    /// The accelerations (rad/s^2) that `torque` (Nm) causes.
    pub fn acceleration(&self, position: &Axes, velocity: &Axes, rotors: &Axes, torque: &Axes) -> Axes {
        match self {
            Self::Gantry(inertia) => torque.component_div(&(rotors + inertia)),
            Self::Arm(links) => {
                let (mass, bias) = links.mass_and_bias(position, velocity);
                let driven = mass + Matrix6::from_diagonal(rotors);
                // Positive definite, unless it is not a number; then neither is the acceleration.
                Cholesky::new(driven).map_or(Axes::repeat(f64::NAN), |factor| factor.solve(&(torque - bias)))
            }
        }
    }

    /// Kinetic energy, J.
    pub fn kinetic_energy(&self, position: &Axes, velocity: &Axes, rotors: &Axes) -> f64 {
        match self {
            Self::Gantry(inertia) => 0.5 * (rotors + inertia).dot(&velocity.component_mul(velocity)),
            Self::Arm(links) => {
                let driven = links.mass_matrix(position) + Matrix6::from_diagonal(rotors);
                0.5 * velocity.dot(&(driven * velocity))
            }
        }
    }
}
