//! Robot, sensor, tool and contact as the controller sees them, over frequency.

use nalgebra::{Complex, Matrix3, Matrix6, SMatrix, SVector, Vector3, Vector6};
use node::scenario::{Pairing, Scenario, SensorOutput};
use robot_sim::gears::Gears;
use robot_sim::links::Links;
use robot_sim::servo::ServoParameters;
use spatial::TICK_S;
use std::f64::consts::TAU;

type C = Complex<f64>;
type Stiffness = SMatrix<C, 18, 18>;

/// What the controller sees of a command that moves the tcp by 1 m along the normal, at one frequency.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Seen {
    /// The hanging tcp by the newest encoder values.
    pub(super) actual: C,
    /// The same as it is paired with a sample.
    pub(super) paired: C,
    /// The tcp's deflection as the controller has it, m.
    pub(super) deflection: C,
}

/// The linear plant about the resting contact.
#[derive(Clone, Debug)]
pub(super) struct Plant {
    period_s: f64,
    command_delay_s: f64,
    servos: [ServoParameters; 6],
    motor: Vector6<f64>,
    gears: Option<Gears>,
    mass: Matrix6<f64>,
    jacobian: Matrix6<f64>,
    /// What moves the tcp by 1 m along the normal and does not turn it.
    command: Vector6<f64>,
    sensor: [f64; 4],
    tool: Matrix6<f64>,
    /// The normal motion of the tcp by a twist of s'.
    normal: Vector6<f64>,
    contact_n_per_m: f64,
    /// Weights of translation and rotation in the deflection that the controller has.
    shown: [f64; 2],
    sensor_delay_s: f64,
    sensor_lag_s: f64,
    /// Delay of the encoder values that a sample is paired with, s.
    paired_delay_s: f64,
}

impl Plant {
    /// The plant of `scenario`; `None`: its robot does not reach the start pose.
    pub(super) fn new(scenario: &Scenario) -> Option<Self> {
        let (robot, sensor, tool) = (&scenario.robot, &scenario.sensor, &scenario.tool);
        let controller = &scenario.controller;
        let position = scenario.start_axes().ok()?;
        let links = Links::new(robot);
        let inertia = links.axis_inertia();
        let posture = links.at(&position, &Vector6::zeros(), &Vector6::zeros());
        let mass = match &links {
            Links::Gantry(inertia) => Matrix6::from_diagonal(inertia),
            Links::Arm(links) => links.mass_matrix(&position),
        };
        let drives = robot.drives();
        let servos = std::array::from_fn(|axis| ServoParameters {
            filter_rad_per_s: TAU * robot.filter_frequency_hz,
            filter_damping: robot.filter_damping,
            acceleration_limit: f64::INFINITY,
            velocity_limit: f64::INFINITY,
            position_gain: robot.position_gain_per_s,
            velocity_gain: ServoParameters::velocity_gain(
                drives.motor_inertia_kg_m2[axis],
                robot.velocity_bandwidth_hz,
            ),
            integral_time_s: robot.velocity_integral_time_s,
            inertia: drives.motor_inertia_kg_m2[axis] + inertia[axis],
        });
        let turned = posture.link.pose.rotation.to_rotation_matrix().into_inner();
        let centre = turned * Vector3::from(tool.centre_of_mass_in_s_m);
        let tcp: Vector3<f64> = turned * Vector3::from(tool.tcp_in_s_m);
        let cross = centre.cross_matrix();
        let about_s = turned * Matrix3::from_diagonal(&tool.inertia_kg_m2.into()) * turned.transpose()
            - cross * cross * tool.mass_kg;
        let mut at_s = Matrix6::zeros();
        at_s.fixed_view_mut::<3, 3>(0, 0)
            .copy_from(&(Matrix3::identity() * tool.mass_kg));
        at_s.fixed_view_mut::<3, 3>(0, 3)
            .copy_from(&(-cross * tool.mass_kg));
        at_s.fixed_view_mut::<3, 3>(3, 0)
            .copy_from(&(cross * tool.mass_kg));
        at_s.fixed_view_mut::<3, 3>(3, 3).copy_from(&about_s);
        let shown = match controller.sensor_output {
            SensorOutput::Deflection => [1.0, 1.0],
            SensorOutput::Force => [
                controller.compliance_m_per_n * sensor.stiffness_n_per_m,
                controller.compliance_rad_per_nm * sensor.stiffness_nm_per_rad,
            ],
        };
        let delay_s = sensor.delay_ticks as f64 * TICK_S;
        Some(Self {
            period_s: scenario.timing.command_period_ticks as f64 * TICK_S,
            command_delay_s: (robot.command_delay_periods * scenario.timing.command_period_ticks) as f64
                * TICK_S,
            servos,
            motor: drives.motor_inertia_kg_m2,
            gears: Gears::new(robot, &inertia),
            mass,
            jacobian: posture.jacobian,
            command: posture.jacobian.lu().solve(&Vector6::ith(2, 1.0))?,
            sensor: [
                sensor.stiffness_n_per_m,
                sensor.damping_ns_per_m,
                sensor.stiffness_nm_per_rad,
                sensor.damping_nms_per_rad,
            ],
            tool: at_s,
            normal: Vector6::new(0.0, 0.0, 1.0, tcp.y, -tcp.x, 0.0),
            contact_n_per_m: contact_stiffness(scenario),
            shown,
            sensor_delay_s: delay_s,
            sensor_lag_s: 1.0 / (TAU * sensor.bandwidth_hz),
            paired_delay_s: match controller.pairing {
                Pairing::Sampling => delay_s + 1.0 / (TAU * controller.sensor_bandwidth_hz),
                Pairing::Arrival => 0.0,
            },
        })
    }

    /// What is seen at `s`; `None` where the equations have no solution.
    pub(super) fn seen(&self, s: C) -> Option<Seen> {
        let (jacobian, square) = (self.jacobian.map(C::from), s * s);
        let z = (s * TICK_S).exp();
        // The torque is held over a tick.
        let held = (C::from(1.0) - z.inv()) / (s * TICK_S);
        let mut matrix = Stiffness::zeros();
        let mut right = SVector::<C, 18>::zeros();
        let [kp, dp, kr, dr] = self.sensor.map(C::from);
        let spring = Matrix6::from_diagonal(&Vector6::from_fn(
            |i, _| if i < 3 { kp + dp * s } else { kr + dr * s },
        ));
        let by_link = jacobian.transpose() * spring * jacobian;
        let by_tool = jacobian.transpose() * spring;
        let link = self.mass.map(C::from) * square + by_link;
        // Rows: motors, links, tool; columns: motors, links, twist of s'.
        let gears = self.gears.map(|gears| {
            let torque = |i: usize| C::from(gears.stiffness[i]) + s * gears.damping[i];
            Matrix6::from_diagonal(&Vector6::from_fn(|i, _| torque(i)))
        });
        let mut motors = Matrix6::<C>::zeros();
        for (i, servo) in self.servos.iter().enumerate() {
            let answer = ServoAnswer::new(servo, s, z);
            motors[(i, i)] = square * self.motor[i] + held * answer.by_motor;
            right[i] = held * answer.by_command * self.command[i];
        }
        let blocks: [(usize, usize, Matrix6<C>); 8] = match gears {
            Some(gears) => [
                (0, 0, motors + gears),
                (0, 6, -gears),
                (6, 0, -gears),
                (6, 6, link + gears),
                (6, 12, -by_tool),
                (12, 6, -spring * jacobian),
                (12, 12, self.tool_matrix(square, &spring)),
                (0, 12, Matrix6::zeros()),
            ],
            // Motors and links together, then that they are the same.
            None => [
                (0, 0, motors),
                (0, 6, link),
                (0, 12, -by_tool),
                (6, 0, -Matrix6::identity()),
                (6, 6, Matrix6::identity()),
                (12, 6, -spring * jacobian),
                (12, 12, self.tool_matrix(square, &spring)),
                (6, 12, Matrix6::zeros()),
            ],
        };
        for (row, column, block) in blocks {
            matrix.fixed_view_mut::<6, 6>(row, column).copy_from(&block);
        }
        let moved = matrix.lu().solve(&right)?;
        let twist = |first: usize| moved.fixed_rows::<6>(first).into_owned();
        let (hanging, carried, tool) = (jacobian * twist(0), jacobian * twist(6), twist(12));
        let along = |twist: &Vector6<C>, weights: [f64; 2]| {
            (0..6).fold(C::from(0.0), |sum, i| {
                sum + twist[i] * (self.normal[i] * weights[i / 3])
            })
        };
        let path = self.command_path(s);
        let late = |delay_s: f64| (-s * delay_s).exp();
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
        let ramp = (C::from(1.0) - (-period).exp()) / period;
        (-s * self.command_delay_s).exp() * ramp * ramp
    }

    fn tool_matrix(&self, square: C, spring: &Matrix6<C>) -> Matrix6<C> {
        let contact = self.normal * self.normal.transpose() * self.contact_n_per_m;
        self.tool.map(C::from) * square + spring + contact.map(C::from)
    }
}

/// A servo's torque by the set-point and by minus the motor's position.
struct ServoAnswer {
    by_command: C,
    by_motor: C,
}

impl ServoAnswer {
    /// The difference equations of [`robot_sim::servo::Servo::torque`] within its limits.
    fn new(p: &ServoParameters, s: C, z: C) -> Self {
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

/// What small motions about the desired force feel of the object, N/m: its rebound branch, `f = c_re (h - h_rem)^n`,
/// in series with what holds its surface.
fn contact_stiffness(scenario: &Scenario) -> f64 {
    let object = &scenario.object;
    let (n, c) = (object.exponent, object.indentation_n_per_m * object.rebound_ratio);
    let depth = libm::pow(scenario.task.pressing_force_n().max(1e-3) / c, 1.0 / n);
    let surface = n * c * libm::pow(depth, n - 1.0);
    match object.support_n_per_m {
        0.0 => surface,
        support => 1.0 / (1.0 / surface + 1.0 / support),
    }
}
