//! The tool: a rigid body that hangs on the sensor and touches the object.

use crate::contacts::{Contacts, Pieces};
use crate::object::{Base, Yielding};
use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use node::scenario;
use spatial::{GRAVITY_M_PER_S2, Motion, Pose, ToolSuspension, Wrench, rotation};

/// What the tool is made of and hangs on. Vectors in s', the sensor frame on the tool plate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Body {
    /// M, kg.
    pub mass: f64,
    /// Principal moments of inertia about the centre of mass, along the axes of s', kg m^2.
    pub inertia: Vector3<f64>,
    /// Their inverses, and that of the mass: a division takes as long as ten products.
    pub(crate) inertia_inverse: Vector3<f64>,
    pub(crate) mass_inverse: f64,
    /// c, from the origin of s' to the centre of mass, m.
    pub centre_of_mass: Vector3<f64>,
    /// d, from the origin of s' to the tcp, m.
    pub tcp: Vector3<f64>,
    /// The compliant sensor.
    pub suspension: ToolSuspension,
    /// M g in r, N.
    pub weight: Vector3<f64>,
}

/// Position, velocity, orientation and angular velocity of the tool, in r, at its centre of mass, and how far the
/// object's surface yields.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct State {
    /// Centre of mass, m.
    pub position: Vector3<f64>,
    /// Its velocity, m/s.
    pub velocity: Vector3<f64>,
    /// `r_from_s1`'s rotation.
    pub rotation: UnitQuaternion<f64>,
    /// Angular velocity, rad/s.
    pub angular_velocity: Vector3<f64>,
    /// The object's surface.
    pub surface: Yielding,
}

/// Energies that have crossed the tool's borders since start, J.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Work {
    /// Done by the link on the tool, through the sensor.
    pub by_link: f64,
    /// Dissipated in the sensor.
    pub dissipated: f64,
    /// Done by the tool on the object.
    pub on_object: f64,
}

/// What moves as it does whatever the tool does, at one instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Instant {
    /// The link.
    pub link: Motion,
    /// The object.
    pub base: Base,
}

/// The time derivative of a [`State`] and of the [`Work`].
#[derive(Clone, Copy, Debug)]
pub struct Rates {
    /// m/s.
    pub velocity: Vector3<f64>,
    /// m/s^2.
    pub acceleration: Vector3<f64>,
    quaternion: Quaternion<f64>,
    /// rad/s^2.
    pub angular_acceleration: Vector3<f64>,
    /// Of the object's surface.
    pub surface: Yielding,
    /// Powers, W.
    pub work: Work,
    /// The part of the power on the object that indents it, W.
    pub indenting_power: f64,
}

impl Body {
    /// The tool and sensor of a scenario.
    pub fn new(tool: &scenario::Tool, sensor: &scenario::Sensor) -> Self {
        Self {
            mass: tool.mass_kg,
            inertia: tool.inertia_kg_m2.into(),
            inertia_inverse: Vector3::from(tool.inertia_kg_m2).map(|i| 1.0 / i),
            mass_inverse: 1.0 / tool.mass_kg,
            centre_of_mass: tool.centre_of_mass_in_s_m.into(),
            tcp: tool.tcp_in_s_m.into(),
            suspension: sensor.suspension(),
            weight: Vector3::new(0.0, 0.0, -GRAVITY_M_PER_S2 * tool.mass_kg),
        }
    }

    /// The state in which the tool hangs at rest, gravity and sensor in balance, on a link at rest at `r_from_s`.
    ///
    /// `K_p p = R_s^T M g`; `K_phi phi = R_s^T ((R c) x M g)` by fixed-point iteration: each step shrinks the
    /// error by `M g |c| / K_phi`, which the limit on the sag keeps small.
    pub fn hanging(&self, r_from_s: &Pose) -> State {
        let into_s = r_from_s.rotation.inverse();
        let p = into_s * self.weight / self.suspension.stiffness_n_per_m;
        let mut phi = Vector3::zeros();
        for _ in 0..60 {
            let rotation = r_from_s.rotation * rotation::exp(phi);
            let moment = (rotation * self.centre_of_mass).cross(&self.weight);
            phi = into_s * moment / self.suspension.stiffness_nm_per_rad;
        }
        let rotation = r_from_s.rotation * rotation::exp(phi);
        State {
            position: (r_from_s * nalgebra::Point3::from(p)).coords + rotation * self.centre_of_mass,
            velocity: Vector3::zeros(),
            rotation,
            angular_velocity: Vector3::zeros(),
            surface: Yielding::default(),
        }
    }

    /// Motion of s' without its accelerations.
    pub fn plate(&self, state: &State) -> Motion {
        self.plate_behind(state, &-(state.rotation * self.centre_of_mass))
    }

    /// The same, with the `lever` from the centre of mass to s' in r.
    fn plate_behind(&self, state: &State, lever: &Vector3<f64>) -> Motion {
        Motion {
            pose: Pose::from_parts((state.position + lever).into(), state.rotation),
            velocity: state.velocity + state.angular_velocity.cross(lever),
            angular_velocity: state.angular_velocity,
            acceleration: Vector3::zeros(),
            angular_acceleration: Vector3::zeros(),
        }
    }

    /// Motion of s' with its accelerations.
    pub fn plate_motion(&self, state: &State, rates: &Rates) -> Motion {
        let lever = -(state.rotation * self.centre_of_mass);
        let w = state.angular_velocity;
        Motion {
            acceleration: rates.acceleration
                + rates.angular_acceleration.cross(&lever)
                + w.cross(&w.cross(&lever)),
            angular_acceleration: rates.angular_acceleration,
            ..self.plate(state)
        }
    }

    /// Pose `r_from_ta1` of the real tcp and its velocity, m/s.
    pub fn tcp_motion(&self, state: &State) -> (Pose, Vector3<f64>) {
        let lever = state.rotation * (self.tcp - self.centre_of_mass);
        let pose = Pose::from_parts((state.position + lever).into(), state.rotation);
        (pose, state.velocity + state.angular_velocity.cross(&lever))
    }

    /// Kinetic energy, J.
    pub fn kinetic_energy(&self, state: &State) -> f64 {
        let w = state.rotation.inverse() * state.angular_velocity;
        0.5 * (self.mass * state.velocity.norm_squared() + w.dot(&self.inertia.component_mul(&w)))
    }

    /// Potential energy in gravity, J; zero with the centre of mass at z = 0.
    pub fn gravity_energy(&self, state: &State) -> f64 {
        -self.weight.dot(&state.position)
    }

    /// One step of the classical Runge-Kutta method of fourth order over `step` s, with what moves by itself at the
    /// step's start, middle and end; the contacts' memory stays frozen inside.
    pub fn integrate(
        &self,
        state: &State,
        [start, middle, end]: [&Instant; 3],
        contacts: &Contacts,
        step: f64,
    ) -> (State, Work) {
        let half = 0.5 * step;
        let k1 = self.rates(state, start, contacts);
        let k2 = self.rates(&state.advanced(&k1, half), middle, contacts);
        let k3 = self.rates(&state.advanced(&k2, half), middle, contacts);
        let k4 = self.rates(&state.advanced(&k3, step), end, contacts);
        let rates = Rates::mean(&k1, &k2, &k3, &k4);
        (state.advanced(&rates, step), rates.work.over(step))
    }

    /// The equations of motion (PLANT.md section 1).
    pub fn rates(&self, state: &State, now: &Instant, contacts: &Contacts) -> Rates {
        self.rates_on(None, state, now, contacts)
    }

    /// The same with `pieces` of the contacts' laws in the laws' place.
    pub fn rates_on(
        &self,
        pieces: Option<&Pieces>,
        state: &State,
        now: &Instant,
        contacts: &Contacts,
    ) -> Rates {
        let Instant { link, base } = now;
        let rotation = state.rotation.to_rotation_matrix();
        let com = rotation * self.centre_of_mass;
        let plate = self.plate_behind(state, &-com);
        let Wrench { force, moment } = self.suspension.wrench_on_tool(link, &plate);
        let contact = contacts.load_on(pieces, state, &rotation, base);

        let w = state.angular_velocity;
        let torque = rotation.inverse_transform_vector(&(moment - com.cross(&force) + contact.moment));
        let w_body = rotation.inverse_transform_vector(&w);
        let gyroscopic = w_body.cross(&self.inertia.component_mul(&w_body));
        let arm = plate.pose.translation.vector - link.pose.translation.vector;
        Rates {
            velocity: state.velocity,
            acceleration: (force + contact.force + self.weight) * self.mass_inverse,
            // q' = (0, w) q / 2 for w in r.
            quaternion: Quaternion::from_imag(w * 0.5) * state.rotation.into_inner(),
            angular_acceleration: rotation * (torque - gyroscopic).component_mul(&self.inertia_inverse),
            surface: contacts.object().yielding_rates(&state.surface, &contact.force),
            work: Work {
                by_link: force.dot(&link.velocity) + (moment + arm.cross(&force)).dot(&link.angular_velocity),
                dissipated: self.suspension.dissipation(link, &plate),
                on_object: contact.power,
            },
            indenting_power: contact.indenting_power,
        }
    }
}

impl Rates {
    /// The mean over a step of the classical Runge-Kutta method, `(k1 + 2 (k2 + k3) + k4) / 6`.
    pub fn mean(k1: &Self, k2: &Self, k3: &Self, k4: &Self) -> Self {
        const SIXTH: f64 = 1.0 / 6.0;
        let mean = |f: fn(&Rates) -> Vector3<f64>| (f(k1) + (f(k2) + f(k3)) * 2.0 + f(k4)) * SIXTH;
        let scalar = |f: fn(&Rates) -> f64| (f(k1) + (f(k2) + f(k3)) * 2.0 + f(k4)) * SIXTH;
        Self {
            velocity: mean(|k| k.velocity),
            acceleration: mean(|k| k.acceleration),
            quaternion: (k1.quaternion + (k2.quaternion + k3.quaternion) * 2.0 + k4.quaternion) * SIXTH,
            angular_acceleration: mean(|k| k.angular_acceleration),
            surface: Yielding {
                depth: scalar(|k| k.surface.depth),
                rate: scalar(|k| k.surface.rate),
            },
            work: Work {
                by_link: scalar(|k| k.work.by_link),
                dissipated: scalar(|k| k.work.dissipated),
                on_object: scalar(|k| k.work.on_object),
            },
            indenting_power: scalar(|k| k.indenting_power),
        }
    }
}

impl Work {
    /// What these powers, W, do in `time` s.
    pub(crate) fn over(&self, time: f64) -> Self {
        Self {
            by_link: self.by_link * time,
            dissipated: self.dissipated * time,
            on_object: self.on_object * time,
        }
    }

    /// Adds what has crossed the borders since.
    pub fn add(&mut self, more: &Self) {
        self.by_link += more.by_link;
        self.dissipated += more.dissipated;
        self.on_object += more.on_object;
    }
}

impl State {
    /// The state after `time` s at constant `rates`.
    pub fn advanced(&self, rates: &Rates, time: f64) -> Self {
        let turned = self.rotation.into_inner() + rates.quaternion * time;
        Self {
            position: self.position + rates.velocity * time,
            velocity: self.velocity + rates.acceleration * time,
            rotation: UnitQuaternion::new_unchecked(turned * (1.0 / turned.norm())),
            angular_velocity: self.angular_velocity + rates.angular_acceleration * time,
            surface: Yielding {
                depth: self.surface.depth + rates.surface.depth * time,
                rate: self.surface.rate + rates.surface.rate * time,
            },
        }
    }
}

#[cfg(test)]
mod tests;
