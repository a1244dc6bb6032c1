//! The arm's six rigid links: mass matrix, velocity terms and gravity.
//!
//! Everything is taken about the origin of r and in r: bodies then add up without transformations (e.g.
//! Featherstone, Rigid Body Dynamics Algorithms, chapters 5 and 6).

use nalgebra::{Matrix3, Matrix6, Vector3};
use node::scenario;
use spatial::kinematics::{Arm, Axes, Joint, jacobian_of, sensor_pose};
use spatial::{Motion, Pose};

/// A rigid body in the frame of its joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Link {
    /// kg.
    pub mass: f64,
    /// Centre of mass, m.
    pub centre: Vector3<f64>,
    /// Principal moments of inertia about the centre of mass, along the frame's axes, kg m^2.
    pub inertia: Vector3<f64>,
}

/// The links of the arm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ArmLinks {
    /// How they are joined.
    pub arm: Arm,
    /// From the base to the flange.
    pub links: [Link; 6],
    /// Gravity that the joints feel, m/s^2 in r. Zero: compensated, by counterweight and motors' static torque.
    pub gravity: Vector3<f64>,
}

/// The links of the arm at given positions and velocities of its joints.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coupled {
    /// Motion of s, with the accelerations that it has while the joints keep their velocities.
    pub link: Motion,
    /// Of s, in r.
    pub jacobian: Matrix6<f64>,
    /// The mass matrix M(q), kg m^2.
    pub mass: Matrix6<f64>,
    /// The torque (Nm) that keeps all velocities as they are: Coriolis and centrifugal terms and gravity.
    pub bias: Axes,
}

/// A link in r.
#[derive(Clone, Copy)]
struct Body {
    mass: f64,
    centre: Vector3<f64>,
    /// About the centre of mass.
    inertia: Matrix3<f64>,
}

impl ArmLinks {
    /// The links of a scenario's arm, gravity compensated (PLANT.md section 2).
    pub fn new(arm: &scenario::Arm) -> Self {
        let links = std::array::from_fn(|i| Link {
            mass: arm.link_mass_kg[i],
            centre: Vector3::new(
                arm.link_centre_x_m[i],
                arm.link_centre_y_m[i],
                arm.link_centre_z_m[i],
            ),
            inertia: Vector3::new(
                arm.link_inertia_x_kg_m2[i],
                arm.link_inertia_y_kg_m2[i],
                arm.link_inertia_z_kg_m2[i],
            ),
        });
        Self {
            arm: Arm {
                base_in_r: arm.base_position_m.into(),
            },
            links,
            gravity: Vector3::zeros(),
        }
    }

    /// The mass matrix M(q), kg m^2.
    pub fn mass_matrix(&self, position: &Axes) -> Matrix6<f64> {
        let joints = self.arm.joints(position);
        mass_matrix(&joints, &self.bodies(&joints))
    }

    /// All that the equations of motion need, from one look at the joints.
    pub fn at(&self, position: &Axes, velocity: &Axes) -> Coupled {
        let joints = self.arm.joints(position);
        let bodies = self.bodies(&joints);
        let pose = sensor_pose(&joints[5]);
        let (bias, mut link) = bias(&joints, &bodies, velocity, self.gravity);
        link.carry(pose.translation.vector);
        Coupled {
            link: Motion { pose, ..link },
            jacobian: jacobian_of(&joints, &pose),
            mass: mass_matrix(&joints, &bodies),
            bias,
        }
    }

    /// Potential energy (J) in the gravity that the joints feel; zero at the origin of r.
    pub fn potential_energy(&self, position: &Axes) -> f64 {
        let bodies = self.bodies(&self.arm.joints(position));
        -bodies
            .iter()
            .map(|body| body.mass * self.gravity.dot(&body.centre))
            .sum::<f64>()
    }

    fn bodies(&self, joints: &[Joint; 6]) -> [Body; 6] {
        std::array::from_fn(|i| {
            let (joint, link) = (&joints[i], &self.links[i]);
            let rotation = joint.rotation.to_rotation_matrix();
            let matrix = rotation.matrix();
            Body {
                mass: link.mass,
                centre: joint.origin + rotation * link.centre,
                inertia: matrix * Matrix3::from_diagonal(&link.inertia) * matrix.transpose(),
            }
        })
    }
}

/// Velocity of the body's point at the origin of r while the joint turns with 1 rad/s, m/s.
fn velocity_at_origin(joint: &Joint) -> Vector3<f64> {
    joint.origin.cross(&joint.axis)
}

/// Composite bodies: a joint's column is the momentum of everything that it moves.
fn mass_matrix(joints: &[Joint; 6], bodies: &[Body; 6]) -> Matrix6<f64> {
    let mut matrix = Matrix6::zeros();
    let (mut mass, mut first_moment, mut second_moment) = (0.0, Vector3::zeros(), Matrix3::zeros());
    for i in (0..6).rev() {
        let body = &bodies[i];
        let c = body.centre;
        mass += body.mass;
        first_moment += c * body.mass;
        second_moment +=
            body.inertia + (Matrix3::identity() * c.norm_squared() - c * c.transpose()) * body.mass;
        let (axis, velocity) = (joints[i].axis, velocity_at_origin(&joints[i]));
        let momentum = velocity * mass + axis.cross(&first_moment);
        let angular_momentum = second_moment * axis + first_moment.cross(&velocity);
        for j in 0..=i {
            let shared =
                joints[j].axis.dot(&angular_momentum) + velocity_at_origin(&joints[j]).dot(&momentum);
            matrix[(i, j)] = shared;
            matrix[(j, i)] = shared;
        }
    }
    matrix
}

/// Newton and Euler's recursion without joint accelerations: out to the flange with the motion, which it returns too,
/// and back with the forces.
fn bias(joints: &[Joint; 6], bodies: &[Body; 6], velocity: &Axes, gravity: Vector3<f64>) -> (Axes, Motion) {
    let mut motion = Motion::at_rest(Pose::identity());
    let mut wrenches = [(Vector3::zeros(), Vector3::zeros()); 6];
    for i in 0..6 {
        motion.carry(joints[i].origin);
        motion.turn(joints[i].axis, velocity[i], 0.0);
        let mut at_centre = motion;
        at_centre.carry(bodies[i].centre);
        let (spin, spin_up) = (motion.angular_velocity, motion.angular_acceleration);
        let force = (at_centre.acceleration - gravity) * bodies[i].mass;
        let moment = bodies[i].inertia * spin_up + spin.cross(&(bodies[i].inertia * spin));
        wrenches[i] = (force, moment + bodies[i].centre.cross(&force));
    }
    let mut torque = Axes::zeros();
    let (mut force, mut moment) = (Vector3::zeros(), Vector3::zeros());
    for i in (0..6).rev() {
        force += wrenches[i].0;
        moment += wrenches[i].1;
        torque[i] = joints[i].axis.dot(&moment) + velocity_at_origin(&joints[i]).dot(&force);
    }
    (torque, motion)
}
