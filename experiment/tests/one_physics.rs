//! One physics in two processes (PLANT.md section 4): robot and sensor, which exchange motions once per tick,
//! against one integration of the same equations as a whole, in the hard case: the tool in line with the sensor.
//!
//! There everything moves along z, so that the robot is one mass. All runs replay the commands of the first one:
//! a contact shifted by 20 us would otherwise flip a sample and move the IAE by 3 %.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use experiment::in_process::{self, Tick};
use experiment::metrics::{Metrics, Recording};
use nalgebra::Vector3;
use node::command_path::CommandPath;
use node::scenario::Scenario;
use robot_sim::servo::{Servo, ServoParameters};
use sensor_sim::contacts::Contacts;
use sensor_sim::object::Base;
use sensor_sim::tool::{Body, Instant, Rates, State};
use spatial::kinematics::Axes;
use spatial::ports::{Command, Truth};
use spatial::{Deflection, Motion, Pose, TICK_S};
use std::f64::consts::TAU;

/// Steps of the whole's integration per tick: 10 us each.
const STEPS: usize = 100;
const STEP_S: f64 = TICK_S / STEPS as f64;

/// The experiment of the paper with the tool in line: 300 instead of 35 N/mm at the tcp. There the sensor's noise
/// would be 0.6 N, so that it is left out.
fn in_line() -> Scenario {
    let overrides = [
        "sensor.noise_translation_m=0",
        "sensor.noise_rotation_rad=0",
        "tool.centre_of_mass_in_s_m=[0, 0, -0.06]",
        "tool.tcp_in_s_m=[0, 0, -0.15]",
        "controller.tcp_in_s_m=[0, 0, -0.15]",
        "controller.tool_centre_of_mass_in_s_m=[0, 0, -0.06]",
    ];
    Scenario::default().with(&overrides.map(String::from)).unwrap()
}

/// Robot and tool as one system along z.
struct Whole {
    scenario: Scenario,
    body: Body,
    contacts: Contacts,
    servo: Servo,
    path: CommandPath,
    /// Of s, whose position (m) and velocity (m/s) along z are the robot's.
    link: Motion,
    inertia: f64,
    tool: State,
    first_contact_s: f64,
}

impl Whole {
    fn new(scenario: &Scenario) -> Self {
        let robot = &scenario.robot;
        let start = Vector3::from(scenario.task.start_position_m) - Vector3::from(scenario.tool.tcp_in_s_m);
        let link = Motion::at_rest(Pose::from_parts(start.into(), Default::default()));
        let body = Body::new(&scenario.tool, &scenario.sensor);
        let inertia = robot.gantry.motor_inertia_kg_m2[2] + robot.gantry.link_inertia_kg_m2[2];
        let servo = ServoParameters {
            filter_rad_per_s: TAU * robot.filter_frequency_hz,
            filter_damping: robot.filter_damping,
            acceleration_limit: robot.gantry.acceleration_limit_rad_per_s2[2],
            velocity_limit: robot.gantry.velocity_limit_rad_per_s[2],
            position_gain: robot.position_gain_per_s,
            velocity_gain: ServoParameters::velocity_gain(
                robot.gantry.motor_inertia_kg_m2[2],
                robot.velocity_bandwidth_hz,
            ),
            integral_time_s: robot.velocity_integral_time_s,
            inertia,
        };
        let mut axes = Axes::zeros();
        axes.fixed_rows_mut::<3>(0).copy_from(&start);
        Self {
            scenario: scenario.clone(),
            contacts: Contacts::new(&scenario.tool, &scenario.object),
            servo: Servo::new(servo, start.z),
            path: CommandPath::new(
                scenario.timing.command_period_ticks,
                robot.command_delay_periods,
                axes,
            ),
            tool: body.hanging(&link.pose),
            body,
            link,
            inertia,
            first_contact_s: -1.0,
        }
    }

    /// The servo's output (N) for the tick that begins.
    fn torque(&mut self, tick: i64, command: Option<&Command>) -> f64 {
        if let Some(command) = command {
            self.path.accept(tick, command);
        }
        let setpoint = self.path.at(tick).z;
        self.servo.torque(
            setpoint,
            self.link.pose.translation.vector.z,
            self.link.velocity.z,
        )
    }

    /// The sensor's force (N) on the tool along z.
    fn sensor_force(&self, link: &Motion, tool: &State) -> f64 {
        let plate = self.body.plate(tool);
        self.body.suspension.wrench_on_tool(link, &plate).force.z
    }

    /// The link's acceleration (m/s^2) under the servo's and the sensor's force (N); the tool's weight is
    /// compensated.
    fn acceleration(&self, torque: f64, sensor_force: f64) -> f64 {
        (torque - sensor_force - self.body.weight.z) / self.inertia
    }

    /// One tick of the whole: the classical Runge-Kutta method on robot and tool together.
    fn advance_together(&mut self, tick: i64, command: Option<&Command>) {
        let torque = self.torque(tick, command);
        for i in 0..STEPS {
            let (link, tool) = (self.link, self.tool);
            let moved = |(rate, change, rates): &(f64, f64, Rates), time: f64| {
                (
                    shifted(&link, rate * time, change * time),
                    tool.advanced(rates, time),
                )
            };
            let rates = |(link, tool): &(Motion, State)| {
                let force = self.sensor_force(link, tool);
                let rates = self.body.rates(tool, &self.instant(link), &self.contacts);
                (link.velocity.z, self.acceleration(torque, force), rates)
            };
            let k1 = rates(&(link, tool));
            let k2 = rates(&moved(&k1, 0.5 * STEP_S));
            let k3 = rates(&moved(&k2, 0.5 * STEP_S));
            let k4 = rates(&moved(&k3, STEP_S));
            let mean = |a: f64, b: f64, c: f64, d: f64| (a + 2.0 * (b + c) + d) / 6.0;
            let k = (
                mean(k1.0, k2.0, k3.0, k4.0),
                mean(k1.1, k2.1, k3.1, k4.1),
                Rates::mean(&k1.2, &k2.2, &k3.2, &k4.2),
            );
            (self.link, self.tool) = moved(&k, STEP_S);
            self.remember(tick, i);
        }
    }

    /// One tick of the scheme that does not work: the sensor's force is held over `HELD` steps, in which both
    /// sides move on their own. It acts like a negative damping of `w h / 4` (w the tool's frequency, h the time
    /// of holding): 7 % at 1 ms against the sensor's 3 %.
    fn advance_with_held_force<const HELD: usize>(&mut self, tick: i64, command: Option<&Command>) {
        let torque = self.torque(tick, command);
        for exchange in 0..STEPS / HELD {
            let force = self.sensor_force(&self.link, &self.tool);
            let acceleration = self.acceleration(torque, force);
            let mut alone = self.body;
            alone.suspension.stiffness_n_per_m = 0.0;
            alone.suspension.damping_ns_per_m = 0.0;
            alone.weight.z += force;
            for i in 0..HELD {
                let now = self.instant(&self.link);
                self.tool = alone.integrate(&self.tool, [&now; 3], &self.contacts, STEP_S).0;
                self.remember(tick, exchange * HELD + i);
            }
            let time = HELD as f64 * STEP_S;
            let shift = (self.link.velocity.z + 0.5 * acceleration * time) * time;
            self.link = shifted(&self.link, shift, acceleration * time);
        }
    }

    /// The object, which is at rest.
    fn base(&self) -> Base {
        self.contacts.object().base(0.0)
    }

    fn instant(&self, link: &Motion) -> Instant {
        Instant {
            link: *link,
            base: self.base(),
        }
    }

    fn remember(&mut self, tick: i64, step: usize) {
        let base = self.base();
        let h = self.contacts.deepest(&self.tool, &base).indentation_m;
        if h > 0.0 && self.first_contact_s < 0.0 {
            self.first_contact_s = tick as f64 * TICK_S + step as f64 * STEP_S;
        }
        self.contacts.remember(&self.tool, &base);
    }

    /// The truth now, as far as the figures need it.
    fn truth(&self, template: &Truth) -> Truth {
        let tcp_pose = self.body.tcp_motion(&self.tool).0;
        let s_from_t = Pose::from_parts(self.body.tcp.into(), Default::default());
        Truth {
            tcp_pose,
            tcp_deflection: Deflection::from_pose(&((self.link.pose * s_from_t).inverse() * tcp_pose)),
            contact_force: self
                .contacts
                .load(&self.tool, &self.tool.rotation.to_rotation_matrix(), &self.base())
                .force,
            first_contact_time_s: self.first_contact_s,
            ..*template
        }
    }

    /// The figures of a run in which `advance` makes the ticks and the commands are those of `ticks`.
    fn figures(mut self, ticks: &[Tick], advance: fn(&mut Self, i64, Option<&Command>)) -> Metrics {
        let mut recording = Recording::new(&self.scenario);
        for (n, tick) in ticks.iter().enumerate() {
            recording.push(&self.truth(&tick.sensor.truth));
            let command = tick.controller.as_ref().map(|answer| &answer.command);
            advance(&mut self, n as i64, command);
        }
        recording.metrics().unwrap()
    }
}

fn shifted(link: &Motion, shift: f64, change: f64) -> Motion {
    let mut link = *link;
    link.pose.translation.vector.z += shift;
    link.velocity.z += change;
    link
}

/// The larger of the relative errors of peak and IAE.
fn error(found: &Metrics, exact: &Metrics) -> f64 {
    let peak = (found.peak_n / exact.peak_n - 1.0).abs();
    peak.max((found.iae_n_s / exact.iae_n_s - 1.0).abs())
}

#[test]
fn two_processes_are_one_physics_and_held_forces_are_not() {
    let scenario = in_line();
    let mut ticks = Vec::new();
    in_process::run(&scenario, |tick| ticks.push(*tick));
    let mut recording = Recording::new(&scenario);
    ticks.iter().for_each(|tick| recording.push(&tick.sensor.truth));
    let pair = recording.metrics().unwrap();
    let whole = Whole::new(&scenario).figures(&ticks, Whole::advance_together);
    let held = Whole::new(&scenario).figures(&ticks, Whole::advance_with_held_force::<STEPS>);
    let (motions, forces) = (error(&pair, &whole), error(&held, &whole));
    // The scheme is what fails, not this test's version of it: it converges to the truth.
    let hardly_held = Whole::new(&scenario).figures(&ticks, Whole::advance_with_held_force::<2>);
    let converged = error(&hardly_held, &whole);
    println!(
        "error of exchanged motions {motions:.2e}, of held forces {forces:.2e}, held for 20 us {converged:.2e}"
    );
    assert!(motions < 0.01, "{pair:?} against {whole:?}");
    assert!(forces > 0.01, "{held:?} against {whole:?}");
    assert!(converged < 0.01, "{hardly_held:?} against {whole:?}");
}

/// What the robot gives away is what the tool receives: the energy that the exchange makes or loses is below 1 %
/// of the kinetic energy at contact, at every tick.
#[test]
fn the_exchange_neither_makes_nor_loses_energy() {
    let scenario = in_line();
    let weight = spatial::GRAVITY_M_PER_S2 * scenario.tool.mass_kg;
    let mut start = None;
    let (mut at_contact, mut worst) = (0.0, 0.0_f64);
    in_process::run(&scenario, |tick| {
        let (link, truth) = (&tick.link_motion, &tick.sensor.truth);
        let height = link.motion.pose.translation.vector.z;
        let (start_height, start_energy) = *start.get_or_insert((
            height,
            truth.kinetic_energy_j + truth.gravity_energy_j + truth.elastic_energy_j,
        ));
        let given = link.motor_work_j + weight * (height - start_height) - link.kinetic_energy_j;
        let received = truth.kinetic_energy_j + truth.gravity_energy_j + truth.elastic_energy_j
            - start_energy
            + truth.dissipated_energy_j
            + truth.contact_work_j;
        worst = worst.max((given - received).abs());
        if truth.first_contact_time_s < 0.0 {
            at_contact = link.kinetic_energy_j + truth.kinetic_energy_j;
        }
    });
    println!("largest error {worst:.2e} J, kinetic energy at contact {at_contact:.2e} J");
    assert!(
        at_contact > 0.03 && worst < 0.01 * at_contact,
        "{worst} J of {at_contact} J"
    );
}
