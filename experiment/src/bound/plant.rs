//! The simulated plant after the first contact, linear, with all that is real of it: from the acceleration of the command
//! filters along the normal to the force.
//!
//! Motors, links and tool as in PLANT.md sections 1 and 2, with all dampings; the tcp is pinned to an object that does
//! not move. Linear: small motions about the start of the task, no limit of the servos' integral parts, and a tool that
//! never leaves the object. The servos act continuously, not at 1 kHz.

use controller::structure::Structure;
use nalgebra::{DMatrix, DVector, Matrix6, RowDVector, Vector3};
use node::scenario::{Gears, Kinematics, Scenario};
use robot_sim::arm_links::ArmLinks;
use robot_sim::links::Links;
use spatial::kinematics::{Axes, join};
use std::f64::consts::TAU;

/// The step of the grid that responses are sampled on, s.
pub const STEP_S: f64 = 1e-4;

/// The linear plant on the grid of [`STEP_S`].
#[derive(Clone, Debug, PartialEq)]
pub struct Plant {
    /// Transition over a step, with the filters' acceleration linear.
    transition: DMatrix<f64>,
    /// What a slope of that acceleration of 1 m/s^3 adds in a step.
    slope: DVector<f64>,
    /// The force that the deflection of the tcp stands for, N.
    force: RowDVector<f64>,
    /// The force between tool and object, N: the tool's inertia counts.
    contact: RowDVector<f64>,
    /// After the impact, which takes the tcp's speed away at once.
    start: DVector<f64>,
    /// Frequencies of links and tool with the motors at rest and the tcp pinned, ascending, Hz.
    pub pinned_hz: Vec<f64>,
    /// How far the tcp yields along the normal, m/N.
    pub compliance: f64,
    /// The largest acceleration of the command filters along the normal, m/s^2.
    pub acceleration_limit: f64,
}

/// Masses, dampings and stiffnesses, and how the servos push.
struct Mechanics {
    mass: DMatrix<f64>,
    damping: DMatrix<f64>,
    stiffness: DMatrix<f64>,
    /// Of the links, of the motors where the gears are rigid.
    link: usize,
    tool: usize,
}

impl Plant {
    /// Of the robot, sensor and tool of `scenario` that are real; `None` if a mass or a stiffness is not positive, or the
    /// robot is not able to move the tcp along the normal.
    pub fn new(scenario: &Scenario) -> Option<Self> {
        let structure = real(scenario)?;
        let Mechanics {
            mass,
            damping,
            stiffness,
            link,
            tool,
        } = mechanics(scenario, &structure);
        let normal = structure.normal_at_tcp;
        let compliance = normal.dot(&(structure.compliance * normal));
        let axes_per_tcp = structure
            .jacobian
            .lu()
            .solve(&join(Vector3::z(), Vector3::zeros()))?;
        let free = mass.nrows();

        // Pinned: the tool's way along z follows from its turns, `normal . twist = 0`; the normal's z is 1.
        let kept: Vec<usize> = (0..free).filter(|&i| i != tool + 2).collect();
        let mut pin = DMatrix::<f64>::zeros(free, free - 1);
        for (column, &i) in kept.iter().enumerate() {
            pin[(i, column)] = 1.0;
            if i > tool + 2 {
                pin[(tool + 2, column)] = -normal[i - tool];
            }
        }
        let reduced = |whole: &DMatrix<f64>| pin.transpose() * whole * &pin;
        let factor = reduced(&mass).cholesky()?;
        let accelerated = |forces: &DMatrix<f64>| factor.solve(&(pin.transpose() * forces));
        let held = accelerated(&(&stiffness * &pin));
        let damped = accelerated(&(&damping * &pin));

        // States: coordinates, rates, torques of the integral parts, the filters' way, speed and acceleration.
        let n = free - 1;
        let (integral, way) = (2 * n, 2 * n + 6);
        let (speed, acceleration) = (way + 1, way + 2);
        let states = way + 3;
        let robot = &scenario.robot;
        let motors: Axes = robot.drives().motor_inertia_kg_m2;
        let inertia = motors + Links::new(robot).axis_inertia();
        let mut servo = DMatrix::<f64>::zeros(free, states);
        let mut rates = DMatrix::<f64>::zeros(states, states);
        for axis in 0..6 {
            let gain = motors[axis] * TAU * robot.velocity_bandwidth_hz;
            let k = robot.position_gain_per_s;
            // e = v_f + k (x_f - x_m) - v_m
            let error = [
                (speed, axes_per_tcp[axis]),
                (way, k * axes_per_tcp[axis]),
                (axis, -k),
                (n + axis, -1.0),
            ];
            for (state, factor) in error {
                servo[(axis, state)] += gain * factor;
                rates[(integral + axis, state)] += gain / robot.velocity_integral_time_s * factor;
            }
            servo[(axis, integral + axis)] += 1.0;
            servo[(axis, acceleration)] += inertia[axis] * axes_per_tcp[axis];
        }
        let pushed = accelerated(&servo);
        rates.view_mut((0, n), (n, n)).fill_with_identity();
        rates.view_mut((n, 0), (n, states)).copy_from(&pushed);
        let mut own = rates.view_mut((n, 0), (n, n));
        own -= &held;
        let mut own = rates.view_mut((n, n), (n, n));
        own -= &damped;
        (rates[(way, speed)], rates[(speed, acceleration)]) = (1.0, 1.0);

        // What the object must add along z for the tool to move as it does.
        let changes = &pin * rates.rows(n, n);
        let mut forces = &mass * &changes;
        forces.columns_mut(0, n).add_assign_product(&stiffness, &pin);
        forces.columns_mut(n, n).add_assign_product(&damping, &pin);
        let contact = forces.row(tool + 2).into_owned();
        let tcp_per_axis = structure.jacobian.tr_mul(&normal);
        let mut force = RowDVector::zeros(states);
        for axis in 0..6 {
            force[link + axis] = -tcp_per_axis[axis] / compliance;
        }

        let mut before = DVector::zeros(free);
        let down = -scenario.task.approach_speed_m_per_s;
        for axis in 0..6 {
            before[axis] = axes_per_tcp[axis] * down;
            before[link + axis] = axes_per_tcp[axis] * down;
        }
        before[tool + 2] = down;
        let after = factor.solve(&(pin.transpose() * (&mass * before)));
        let mut start = DVector::zeros(states);
        start.rows_mut(n, n).copy_from(&after);
        start[speed] = down;

        let mut with_slope = DMatrix::zeros(states + 1, states + 1);
        with_slope.view_mut((0, 0), (states, states)).copy_from(&rates);
        with_slope[(acceleration, states)] = 1.0;
        let over = (with_slope * STEP_S).exp();
        let limits = robot.drives().acceleration_limit_rad_per_s2;
        Some(Self {
            transition: over.view((0, 0), (states, states)).into_owned(),
            slope: over.view((0, states), (states, 1)).column(0).into_owned(),
            force,
            contact,
            start,
            pinned_hz: pinned_hz(&reduced(&mass), &reduced(&stiffness), link)?,
            compliance,
            acceleration_limit: (0..6)
                .map(|i| limits[i] / axes_per_tcp[i].abs().max(1e-9))
                .fold(f64::INFINITY, f64::min),
        })
    }

    /// Force and contact force (N) at `steps` instants [`STEP_S`] apart from the contact on, if no command ever acts.
    pub fn coasting(&self, steps: usize) -> [Vec<f64>; 2] {
        self.respond(self.start.clone(), steps, |_| 0.0)
    }

    /// The same from rest for an acceleration that rises to 1 m/s^2 within `rise` steps and falls again within as many.
    pub fn hat(&self, rise: usize, steps: usize) -> [Vec<f64>; 2] {
        let slope = 1.0 / (rise as f64 * STEP_S);
        self.respond(DVector::zeros(self.start.len()), steps, |step| match step {
            step if step < rise => slope,
            step if step < 2 * rise => -slope,
            _ => 0.0,
        })
    }

    fn respond(&self, mut state: DVector<f64>, steps: usize, slope: impl Fn(usize) -> f64) -> [Vec<f64>; 2] {
        let (mut force, mut contact) = (Vec::with_capacity(steps), Vec::with_capacity(steps));
        for step in 0..steps {
            force.push((&self.force * &state)[0]);
            contact.push((&self.contact * &state)[0]);
            state = &self.transition * state + &self.slope * slope(step);
        }
        [force, contact]
    }
}

/// `self += a b` for views.
trait AddAssignProduct {
    fn add_assign_product(&mut self, a: &DMatrix<f64>, b: &DMatrix<f64>);
}

impl AddAssignProduct for nalgebra::DMatrixViewMut<'_, f64> {
    fn add_assign_product(&mut self, a: &DMatrix<f64>, b: &DMatrix<f64>) {
        self.gemm(1.0, a, b, 1.0);
    }
}

/// Links, tool and sensor as they are: the controller's structure with the real values for its assumptions.
fn real(scenario: &Scenario) -> Option<Structure> {
    let mut known = scenario.controller.clone();
    let (sensor, tool) = (&scenario.sensor, &scenario.tool);
    known.compliance_m_per_n = 1.0 / sensor.stiffness_n_per_m;
    known.compliance_rad_per_nm = 1.0 / sensor.stiffness_nm_per_rad;
    known.tcp_in_s_m = tool.tcp_in_s_m;
    known.impact.tool_mass_kg = tool.mass_kg;
    known.impact.tool_inertia_kg_m2 = tool.inertia_kg_m2;
    known.impact.centre_of_mass_in_s_m = tool.centre_of_mass_in_s_m;
    let robot = &scenario.robot;
    let axes = scenario.start_axes().ok()?;
    let links = Links::new(robot);
    let elastic = robot_sim::gears::Gears::new(robot, &links.axis_inertia());
    Some(Structure {
        links: match robot.kinematics {
            Kinematics::Gantry => Matrix6::from_diagonal(&links.axis_inertia()),
            Kinematics::Arm => ArmLinks::new(&robot.arm).mass_matrix(&axes),
        },
        gears: elastic.map_or(Axes::zeros(), |gears| gears.stiffness),
        ..Structure::new(&known, &robot.kinematics(), &axes, Gears::Elastic)
    })
}

/// Motors (where the gears are elastic), links and tool, unpinned; the motors' or the axes' coordinates come first.
fn mechanics(scenario: &Scenario, structure: &Structure) -> Mechanics {
    let robot = &scenario.robot;
    let motors = Matrix6::from_diagonal(&robot.drives().motor_inertia_kg_m2);
    let gears = robot_sim::gears::Gears::new(robot, &Links::new(robot).axis_inertia());
    let link = if gears.is_some() { 6 } else { 0 };
    let (tool, free) = (link + 6, link + 12);
    let mut mass = DMatrix::zeros(free, free);
    mass.view_mut((0, 0), (6, 6)).copy_from(&motors);
    let mut links = mass.view_mut((link, link), (6, 6));
    links += structure.links;
    mass.view_mut((tool, tool), (6, 6)).copy_from(&structure.tool);

    let sensor = &scenario.sensor;
    let dampers = Matrix6::from_diagonal(&join(
        Vector3::repeat(sensor.damping_ns_per_m),
        Vector3::repeat(sensor.damping_nms_per_rad),
    ));
    let joined = |between: &Matrix6<f64>, geared: Option<&Axes>| {
        let mut whole = DMatrix::zeros(free, free);
        let coupling = -structure.jacobian.tr_mul(between);
        whole
            .view_mut((link, link), (6, 6))
            .copy_from(&(-coupling * structure.jacobian));
        whole.view_mut((link, tool), (6, 6)).copy_from(&coupling);
        whole
            .view_mut((tool, link), (6, 6))
            .copy_from(&coupling.transpose());
        whole.view_mut((tool, tool), (6, 6)).copy_from(between);
        for axis in 0..6 {
            let Some(geared) = geared.map(|geared| geared[axis]) else {
                continue;
            };
            whole[(axis, axis)] += geared;
            whole[(link + axis, link + axis)] += geared;
            whole[(axis, link + axis)] -= geared;
            whole[(link + axis, axis)] -= geared;
        }
        whole
    };
    Mechanics {
        damping: joined(&dampers, gears.as_ref().map(|gears| &gears.damping)),
        stiffness: joined(&structure.sensor, gears.as_ref().map(|gears| &gears.stiffness)),
        mass,
        link,
        tool,
    }
}

/// Frequencies with the motors at rest, Hz, ascending: those that follow the first `motors` coordinates.
fn pinned_hz(mass: &DMatrix<f64>, stiffness: &DMatrix<f64>, motors: usize) -> Option<Vec<f64>> {
    let skip = if motors == 0 { 6 } else { motors };
    let n = mass.nrows() - skip;
    // With M = L L^T and q = L^-T x: x'' + L^-1 K L^-T x = 0.
    let factor = mass.view((skip, skip), (n, n)).into_owned().cholesky()?.l();
    let half = factor.solve_lower_triangular(&stiffness.view((skip, skip), (n, n)).into_owned())?;
    let whole = factor.solve_lower_triangular(&half.transpose())?;
    let squares = ((&whole + whole.transpose()) * 0.5).symmetric_eigenvalues();
    let mut hz: Vec<f64> = squares.iter().map(|square| libm::sqrt(*square) / TAU).collect();
    hz.sort_unstable_by(f64::total_cmp);
    Some(hz)
}
