//! What the motors move: decoupled masses, or the links of an arm.

use crate::arm_links::ArmLinks;
use nalgebra::{Cholesky, Const, Matrix6};
use node::scenario::{self, Kinematics};
use spatial::Motion;
use spatial::kinematics::{Arm, Axes, Gantry, split};

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

    /// What each axis moves with all others locked, kg m^2; of the arm in its working posture.
    pub fn axis_inertia(&self) -> Axes {
        match self {
            Self::Gantry(inertia) => *inertia,
            Self::Arm(links) => links.mass_matrix(&Arm::WORKING).diagonal(),
        }
    }

    /// All that the equations of motion need at `position` (rad) and `velocity` (rad/s).
    pub fn at(&self, position: &Axes, velocity: &Axes, rotors: &Axes) -> Posture {
        match self {
            Self::Gantry(inertia) => {
                let link = Gantry.motion(position, velocity, &Axes::zeros());
                Posture {
                    link,
                    jacobian: Gantry.jacobian(position),
                    inertia: Inertia::Decoupled(rotors + inertia),
                }
            }
            Self::Arm(links) => {
                let coupled = links.at(position, velocity);
                let mass = coupled.mass + Matrix6::from_diagonal(rotors);
                Posture {
                    link: coupled.link,
                    jacobian: coupled.jacobian,
                    inertia: Inertia::Coupled {
                        factor: Cholesky::new(mass),
                        bias: coupled.bias,
                    },
                }
            }
        }
    }
}

/// The link side at one instant.
#[derive(Clone, Debug)]
pub struct Posture {
    /// Motion of s, with the accelerations that it has while the axes keep their velocities.
    pub link: Motion,
    /// Of s, in r.
    pub jacobian: Matrix6<f64>,
    inertia: Inertia,
}

/// What torques have to overcome.
#[derive(Clone, Debug)]
#[expect(
    clippy::large_enum_variant,
    reason = "there are a few at a time, and they are not moved"
)]
enum Inertia {
    /// Of each axis, kg m^2.
    Decoupled(Axes),
    /// Mass matrix and the torque (Nm) that keeps the velocities.
    Coupled {
        /// Cholesky's factor of the mass matrix, which is positive definite, unless it is not a number.
        factor: Option<Cholesky<f64, Const<6>>>,
        bias: Axes,
    },
}

impl Posture {
    /// The accelerations (rad/s^2) that `torque` (Nm) causes.
    pub fn acceleration(&self, torque: &Axes) -> Axes {
        match &self.inertia {
            Inertia::Decoupled(inertia) => torque.component_div(inertia),
            Inertia::Coupled { factor, bias } => match factor {
                Some(factor) => factor.solve(&(torque - bias)),
                None => Axes::repeat(f64::NAN),
            },
        }
    }

    /// Kinetic energy at `velocity` (rad/s), J.
    pub fn kinetic_energy(&self, velocity: &Axes) -> f64 {
        match &self.inertia {
            Inertia::Decoupled(inertia) => 0.5 * inertia.dot(&velocity.component_mul(velocity)),
            // M = L L^T.
            Inertia::Coupled { factor, .. } => factor.as_ref().map_or(f64::NAN, |factor| {
                0.5 * factor.l().tr_mul(velocity).norm_squared()
            }),
        }
    }

    /// Motion of s while the axes accelerate by `changes` (rad/s^2).
    pub fn motion(&self, changes: &Axes) -> Motion {
        let (acceleration, angular_acceleration) = split(&(self.jacobian * changes));
        Motion {
            acceleration: self.link.acceleration + acceleration,
            angular_acceleration: self.link.angular_acceleration + angular_acceleration,
            ..self.link
        }
    }
}
