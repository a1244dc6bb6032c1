//! Robot, sensor, tool and contact as the controller sees them, over frequency.

use super::complex::exp;
use nalgebra::{Complex, Matrix6, Vector6};
use spatial::TICK_S;
use spatial::kinematics::Axes;

type C = Complex<f64>;

/// What the controller sees of a command that moves the tcp by 1 m along the normal, at one frequency.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seen {
    /// The hanging tcp by the newest encoder values.
    pub actual: C,
    /// The same as it is paired with a sample.
    pub paired: C,
    /// The tcp's deflection as the controller has it, m.
    pub deflection: C,
}

/// The position controller of an axis within its limits: command filter, position and velocity loop, feed-forward
/// (PLANT.md section 2).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Servo {
    /// Natural frequency of the command filter, rad/s.
    pub filter_rad_per_s: f64,
    /// Its damping ratio.
    pub filter_damping: f64,
    /// Gain from position error to velocity, 1/s.
    pub position_gain: f64,
    /// K_v, Nm s/rad.
    pub velocity_gain: f64,
    /// Integral time of the velocity loop, s.
    pub integral_time_s: f64,
    /// Inertia that the feed-forward accelerates: motor and link, kg m^2.
    pub inertia: f64,
}

/// A linear spring and damper between motor and link of each axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GearSprings {
    /// Nm/rad.
    pub stiffness: Axes,
    /// Nms/rad.
    pub damping: Axes,
}

/// The linear plant about the resting contact.
#[derive(Clone, Debug, PartialEq)]
pub struct Plant {
    /// T, s.
    pub period_s: f64,
    /// From a command to its effect, s.
    pub command_delay_s: f64,
    /// Of the axes.
    pub servos: [Servo; 6],
    /// Inertia of each motor, kg m^2.
    pub motors: Axes,
    /// Between motors and links; `None`: rigid.
    pub gears: Option<GearSprings>,
    /// Inertia matrix of the links, kg m^2.
    pub links: Matrix6<f64>,
    /// Of s, in r.
    pub jacobian: Matrix6<f64>,
    /// What moves the tcp by 1 m along the normal and does not turn it, rad/m.
    pub command: Axes,
    /// Stiffness of the sensor along (N/m) and about an axis (Nm/rad).
    pub sensor_stiffness: [f64; 2],
    /// Its damping, Ns/m and Nms/rad.
    pub sensor_damping: [f64; 2],
    /// Mass matrix of the tool for twists at s, in r.
    pub tool: Matrix6<f64>,
    /// The normal motion of the tcp by a twist of s'.
    pub normal: Vector6<f64>,
    /// What small motions feel of the object along the normal, N/m.
    pub contact_n_per_m: f64,
    /// Weights of translation and rotation in the deflection that the controller has: 1 for the sensor's own.
    pub shown: [f64; 2],
    /// Age of a sample, s.
    pub sensor_delay_s: f64,
    /// Delay of the sensor's low pass, of first order, s.
    pub sensor_lag_s: f64,
    /// Delay of the encoder values that a sample is paired with, s.
    pub paired_delay_s: f64,
}

impl Plant {
    /// What is seen at `s`; `None` where the equations have no solution.
    ///
    /// Motors (which drive nothing but their own axis), links and tool in turn:
    /// `(M s^2 + U + G) q_m - G q_l = u`, `-G q_m + (L s^2 + G + J' S J) q_l - J' S t = 0`,
    /// `-S J q_l + (T s^2 + S + n n' c) t = 0`, with the servo's torque `u - U q_m`, gear G, sensor S, contact c. Motors
    /// and tool are eliminated. Rigid gears: `q_m = q_l`.
    pub fn seen(&self, s: C) -> Option<Seen> {
        let (jacobian, square) = (self.jacobian.map(C::from), s * s);
        let z = exp(s * TICK_S);
        // The torque is held over a tick.
        let held = (C::from(1.0) - z.inv()) / (s * TICK_S);
        let spring = Vector6::from_fn(|i, _| self.sensor_damping[i / 3] * s + self.sensor_stiffness[i / 3]);
        let contact = self.normal * self.normal.transpose() * self.contact_n_per_m;
        let tool = self.tool.map(C::from) * square + Matrix6::from_diagonal(&spring) + contact.map(C::from);
        // S J, and with it the twist of the tool by the links.
        let pulls = Matrix6::from_fn(|i, j| spring[i] * self.jacobian[(i, j)]);
        let carried_along = tool.lu().solve(&pulls)?;
        let transposed = jacobian.transpose();
        let mut links = self.links.map(C::from) * square
            + transposed * (pulls - Matrix6::from_fn(|i, j| spring[i] * carried_along[(i, j)]));
        let mut drive = Vector6::<C>::zeros();
        // Of each motor, by its own drive and by its link.
        let mut motors = [(C::from(0.0), C::from(1.0)); 6];
        for (i, servo) in self.servos.iter().enumerate() {
            let answer = ServoAnswer::new(servo, s, z);
            let motor = square * self.motors[i] + held * answer.by_motor;
            let push = held * answer.by_command * self.command[i];
            match &self.gears {
                None => {
                    links[(i, i)] += motor;
                    drive[i] = push;
                }
                Some(gears) => {
                    let gear = s * gears.damping[i] + gears.stiffness[i];
                    let share = gear / (motor + gear);
                    links[(i, i)] += gear - gear * share;
                    drive[i] = push * share;
                    motors[i] = (push / (motor + gear), share);
                }
            }
        }
        let moved = links.lu().solve(&drive)?;
        let motors = Vector6::from_fn(|i, _| motors[i].0 + motors[i].1 * moved[i]);
        let (hanging, carried, tool) = (jacobian * motors, jacobian * moved, carried_along * moved);
        let along = |twist: &Vector6<C>, weights: [f64; 2]| {
            (0..6).fold(C::from(0.0), |sum, i| {
                sum + twist[i] * (self.normal[i] * weights[i / 3])
            })
        };
        let path = self.command_path(s);
        let late = |delay_s: f64| exp(-s * delay_s);
        let low_pass = C::from(1.0) / (C::from(1.0) + s * self.sensor_lag_s);
        let actual = path * along(&hanging, [1.0, 1.0]);
        Some(Seen {
            actual,
            paired: actual * late(self.paired_delay_s),
            deflection: path * along(&(tool - carried), self.shown) * low_pass * late(self.sensor_delay_s),
        })
    }

    /// Dead time, and linear interpolation between set-points: a triangle of two periods for each.
    fn command_path(&self, s: C) -> C {
        let period = s * self.period_s;
        let ramp = (C::from(1.0) - exp(-period)) / period;
        exp(-s * self.command_delay_s) * ramp * ramp
    }
}

/// A servo's torque by the set-point and by minus the motor's position.
struct ServoAnswer {
    by_command: C,
    by_motor: C,
}

impl ServoAnswer {
    /// PLANT.md section 2, tick by tick: `a = w^2 (x_c - x_f) - 2 zeta w v_f`; `e = v_f + k (x_f - x_m) - v_m`;
    /// `u = K_v e + K_v / T_i integral(e) + m a`. The error uses the filter's state before it is advanced.
    fn new(p: &Servo, s: C, z: C) -> Self {
        let (one, h, w) = (C::from(1.0), TICK_S, p.filter_rad_per_s);
        let velocity_by_acceleration = one / (z - one) * h;
        let position_by_acceleration = (z + one) / ((z - one) * (z - one)) * (0.5 * h * h);
        let acceleration = C::from(w * w)
            / (one
                + position_by_acceleration * (w * w)
                + velocity_by_acceleration * (2.0 * p.filter_damping * w));
        let (velocity, position) = (
            acceleration * velocity_by_acceleration,
            acceleration * position_by_acceleration,
        );
        let loop_gain = (one + z / (z - one) * (h / p.integral_time_s)) * p.velocity_gain;
        Self {
            by_command: loop_gain * (velocity + position * p.position_gain) + acceleration * p.inertia,
            by_motor: loop_gain * (s + p.position_gain),
        }
    }
}

/// What small motions about a `force` (N) feel of an object, N/m: its rebound branch, `f = c_re (h - h_rem)^n`, with c_re
/// in `rebound` (N/m^n) and n in `exponent`.
pub fn contact_stiffness(rebound: f64, exponent: f64, force: f64) -> f64 {
    let depth = libm::pow(force.max(1e-3) / rebound, 1.0 / exponent);
    exponent * rebound * libm::pow(depth, exponent - 1.0)
}
