//! The tool against analytic values and PLANT.md section 5.

use super::*;
use nalgebra::{Matrix3, Matrix6};
use scenario::{Object, Sensor, Tool};
use spatial::MotionSegment;
use std::f64::consts::{PI, TAU};

const STEP: f64 = 20e-6;

fn undamped() -> Sensor {
    Sensor {
        damping_ns_per_m: 0.0,
        damping_nms_per_rad: 0.0,
        ..Default::default()
    }
}

/// A link at rest at the origin.
fn still() -> Motion {
    Motion::at_rest(Pose::identity())
}

/// An object far below.
fn nothing_near() -> Contacts {
    Contacts::new(&Tool::default(), &at_height(Object::default(), -1.0))
}

fn at_height(object: Object, height_m: f64) -> Object {
    Object { height_m, ..object }
}

/// Integrate over `steps` and show each state with its indentation and contact force.
fn simulate(
    body: &Body,
    mut state: State,
    contacts: &mut Contacts,
    (step, steps): (f64, usize),
    mut see: impl FnMut(&State, f64, f64),
) -> State {
    let now = at_rest(contacts);
    for _ in 0..steps {
        state = body.integrate(&state, [&now; 3], contacts, step).0;
        let force = contacts
            .load(&state, &state.rotation.to_rotation_matrix(), &now.base)
            .force;
        see(&state, contacts.deepest(&state, &now.base).indentation_m, force.z);
        contacts.remember(&state, &now.base);
    }
    state
}

/// Link and object at rest.
fn at_rest(contacts: &Contacts) -> Instant {
    Instant {
        link: still(),
        base: contacts.object().base(0.0),
    }
}

/// Stiffness K and mass M of small motions (position of the centre of mass, rotation vector), by differences.
fn linearised(body: &Body) -> (Matrix6<f64>, Matrix6<f64>) {
    let link = still();
    let rest = body.hanging(&link.pose);
    let contacts = nothing_near();
    let now = at_rest(&contacts);
    let mut mass = Matrix6::identity() * body.mass;
    let rotation = rest.rotation.to_rotation_matrix();
    mass.fixed_view_mut::<3, 3>(3, 3)
        .copy_from(&(rotation * Matrix3::from_diagonal(&body.inertia) * rotation.inverse()));
    let h = 1e-6;
    let acceleration = |axis: usize, h: f64| {
        let mut state = rest;
        if axis < 3 {
            state.position[axis] += h;
        } else {
            state.rotation = rotation::exp(Vector3::ith(axis - 3, h)) * state.rotation;
        }
        let rates = body.rates(&state, &now, &contacts);
        spatial::kinematics::join(rates.acceleration, rates.angular_acceleration)
    };
    let mut gradient = Matrix6::zeros();
    for axis in 0..6 {
        gradient.set_column(
            axis,
            &((acceleration(axis, -h) - acceleration(axis, h)) / (2.0 * h)),
        );
    }
    (mass * gradient, mass)
}

fn frequencies(dynamic: nalgebra::DMatrix<f64>) -> Vec<f64> {
    let mut all: Vec<f64> = dynamic
        .complex_eigenvalues()
        .iter()
        .map(|l| l.re.sqrt() / TAU)
        .collect();
    all.sort_by(f64::total_cmp);
    all
}

fn assert_frequencies(found: &[f64], expected: &[f64]) {
    assert_eq!(found.len(), expected.len());
    for (found, expected) in found.iter().zip(expected) {
        assert!(
            (found / expected - 1.0).abs() < 1e-3,
            "{found} Hz, expected {expected} Hz"
        );
    }
}

#[test]
fn free_and_pinned_modes() {
    // Without gravity, as the linear model that the reference values come from.
    let mut body = Body::new(&Tool::default(), &undamped());
    body.weight = Vector3::zeros();
    let (stiffness, mass) = linearised(&body);
    let inverse = mass.try_inverse().unwrap();
    let free = nalgebra::DMatrix::from_column_slice(6, 6, (inverse * stiffness).as_slice());
    assert_frequencies(&frequencies(free), &[16.56, 17.52, 31.28, 43.59, 66.31, 73.76]);

    // The tcp's height fixed: dz + (w x l)_z = 0 with the lever l from the centre of mass to the tcp.
    let lever = body.tcp - body.centre_of_mass;
    let row = [0.0, 0.0, 1.0, lever.y, -lever.x, 0.0];
    let mut basis = nalgebra::DMatrix::zeros(6, 5);
    for (column, axis) in [0, 1, 3, 4, 5].into_iter().enumerate() {
        basis[(axis, column)] = 1.0;
        basis[(2, column)] = -row[axis];
    }
    let reduce = |m: &Matrix6<f64>| {
        basis.transpose() * nalgebra::DMatrix::from_column_slice(6, 6, m.as_slice()) * &basis
    };
    let pinned = reduce(&mass).try_inverse().unwrap() * reduce(&stiffness);
    assert_frequencies(&frequencies(pinned), &[17.52, 31.28, 34.27, 62.56, 73.77]);
}

/// Exact sag: 2.918 mrad, tcp (-438, 0, -422) um.
#[test]
fn the_tool_hangs_in_balance() {
    let body = Body::new(&Tool::default(), &Sensor::default());
    let link = still();
    let rest = body.hanging(&link.pose);
    let contacts = nothing_near();
    let rates = body.rates(&rest, &at_rest(&contacts), &contacts);
    assert!(rates.acceleration.norm() < 1e-12 && rates.angular_acceleration.norm() < 1e-10);
    assert!((rotation::log(&rest.rotation).y - 2.918e-3).abs() < 0.001e-3);
    let sag = body.tcp_motion(&rest).0.translation.vector - body.tcp;
    assert!((sag - Vector3::new(-438e-6, 0.0, -422e-6)).norm() < 1e-6, "{sag}");
}

/// 10 N at the tcp: -2.477 mrad, tcp (372.0, 0, 280.4) um with gravity and exact rotations.
#[test]
fn the_static_deflection_under_ten_newton() {
    let body = Body::new(&Tool::default(), &Sensor::default());
    let rest = body.hanging(&Pose::identity());
    let hanging = body.tcp_motion(&rest).0;
    let height = hanging.translation.vector.z + 280.4e-6 + 10.0 / 16e6;
    let mut contacts = Contacts::new(&Tool::default(), &at_height(Object::default(), height));
    let mut force = 0.0;
    let end = simulate(&body, rest, &mut contacts, (STEP, 150_000), |_, _, f| force = f);
    // The plane was in the tool's way from the start: it has jumped out and come back, so what counts is where
    // it rests, on the rebound's stiffer line.
    let moved = body.tcp_motion(&end).0.translation.vector - hanging.translation.vector;
    let turned = rotation::log(&(end.rotation * rest.rotation.inverse())).y;
    assert!((force - moved.z / 28.04e-6).abs() < 0.02, "{force} N at {moved}");
    assert!((turned / force - -2.477e-4).abs() < 0.002e-4, "{turned}");
    assert!((moved.x / force - 37.2e-6).abs() < 0.1e-6);
}

#[test]
fn energy_is_conserved_without_damping_and_the_method_is_of_fourth_order() {
    let body = Body::new(&Tool::default(), &undamped());
    let link = still();
    let mut start = body.hanging(&link.pose);
    start.velocity = Vector3::new(0.02, -0.01, 0.03);
    start.angular_velocity = Vector3::new(0.3, 0.2, -0.4);
    let energy = |state: &State| {
        body.kinetic_energy(state)
            + body.gravity_energy(state)
            + body.suspension.energy(&link, &body.plate(state))
    };
    let run =
        |step: f64, steps: usize| simulate(&body, start, &mut nothing_near(), (step, steps), |_, _, _| ());
    let drift = (energy(&run(STEP, 50_000)) - energy(&start)) / body.kinetic_energy(&start);
    assert!(drift.abs() < 1e-8, "{drift}");

    let exact = run(25e-6, 4_000);
    let error = |step: f64, steps: usize| (run(step, steps).position - exact.position).norm();
    let order = libm::log2(error(400e-6, 250) / error(200e-6, 500));
    assert!((3.7..4.3).contains(&order), "order {order}");
}

#[test]
fn energy_is_conserved_in_the_end_stops() {
    let sensor = Sensor {
        end_stop_m: 0.2e-3,
        end_stop_n_per_m: 1e6,
        end_stop_rad: 4e-3,
        end_stop_nm_per_rad: 2e3,
        ..undamped()
    };
    let body = Body::new(&Tool::default(), &sensor);
    let link = still();
    let mut start = body.hanging(&link.pose);
    start.velocity = Vector3::new(0.1, -0.05, 0.15);
    start.angular_velocity = Vector3::new(0.9, 0.6, -1.2);
    let energy = |state: &State| {
        body.kinetic_energy(state)
            + body.gravity_energy(state)
            + body.suspension.energy(&link, &body.plate(state))
    };
    let mut furthest = 0.0_f64;
    let end = simulate(
        &body,
        start,
        &mut nothing_near(),
        (STEP, 10_000),
        |state, _, _| {
            furthest = furthest.max(body.plate(state).pose.translation.vector.norm());
        },
    );
    let drift = (energy(&end) - energy(&start)) / body.kinetic_energy(&start);
    // The spring's kink costs the method its order, not the energy its account.
    assert!(furthest > 0.25e-3 && drift.abs() < 1e-5, "{furthest} m, {drift}");
}

/// The accelerations of s' are the rates of change of its velocities, for a tool that tumbles on a link that moves:
/// what the robot's side extrapolates with (PLANT.md section 4).
#[test]
fn the_accelerations_of_the_plate_are_the_derivatives_of_its_velocities() {
    let body = Body::new(&Tool::default(), &Sensor::default());
    let start = Motion {
        velocity: Vector3::new(0.1, -0.05, -0.02),
        angular_velocity: Vector3::new(0.2, 0.1, -0.3),
        ..Motion::at_rest(spatial::pose(
            Vector3::new(0.1, 0.2, 0.3),
            Vector3::new(0.2, -0.1, 0.3),
        ))
    };
    let end = Motion {
        pose: start.extrapolate(1e-3).pose,
        velocity: Vector3::new(0.1, -0.04, -0.03),
        ..start
    };
    let segment = MotionSegment::new(start, end, 1e-3);
    let contacts = nothing_near();
    let at = |time: f64| Instant {
        link: segment.at(time),
        base: contacts.object().base(time),
    };
    let mut state = body.hanging(&start.pose);
    state.velocity = start.velocity;
    // Turning fast: both w x (w x r) and dw/dt x r are felt.
    state.angular_velocity = Vector3::new(-4.0, 3.0, 5.0);
    let step = 5e-6;
    let motions: Vec<Motion> = (0..100)
        .map(|i| {
            let time = f64::from(i) * step;
            let instants = [at(time), at(time + 0.5 * step), at(time + step)];
            let motion = body.plate_motion(&state, &body.rates(&state, &instants[0], &contacts));
            state = body.integrate(&state, instants.each_ref(), &contacts, step).0;
            motion
        })
        .collect();
    for around in motions.windows(3) {
        let slope = |of: fn(&Motion) -> Vector3<f64>| (of(&around[2]) - of(&around[0])) / (2.0 * step);
        let motion = &around[1];
        assert!((slope(|m| m.pose.translation.vector) - motion.velocity).norm() < 1e-6);
        assert!((slope(|m| m.velocity) - motion.acceleration).norm() < 1e-3);
        assert!((slope(|m| m.angular_velocity) - motion.angular_acceleration).norm() < 1e-2);
        assert!(motion.acceleration.norm() > 1.0 && motion.angular_acceleration.norm() > 10.0);
    }
}

/// A tool thrown at the object, its sensor cut off and without weight.
/// Peak (N), depth (m), duration (s), rebound (m/s), impulse (Ns) and loss of energy (J).
fn thrown(tool: &Tool, object: &Object) -> (f64, f64, f64, f64, f64, f64) {
    let mut body = Body::new(tool, &undamped());
    body.weight = Vector3::zeros();
    body.suspension.stiffness_n_per_m = 0.0;
    body.suspension.stiffness_nm_per_rad = 0.0;
    let start = State {
        position: body.centre_of_mass,
        velocity: Vector3::new(0.0, 0.0, -0.02),
        rotation: UnitQuaternion::identity(),
        angular_velocity: Vector3::zeros(),
        surface: Yielding::default(),
    };
    let (mut peak, mut depth, mut impulse, mut ticks) = (0.0f64, 0.0f64, 0.0, 0);
    let step = 2e-6;
    let mut contacts = Contacts::new(tool, &at_height(object.clone(), body.tcp.z));
    let end = simulate(&body, start, &mut contacts, (step, 2_000), |_, h, f| {
        peak = peak.max(f);
        depth = depth.max(h);
        impulse += f * step;
        ticks += usize::from(f > 0.0);
    });
    let rebound = body.tcp_motion(&end).1.z;
    let loss = body.kinetic_energy(&start) - body.kinetic_energy(&end);
    (peak, depth, ticks as f64 * step, rebound, impulse, loss)
}

/// 160.000 N, 10.000 um, 1.571 ms: the paper's (15) to (18) for the centre of mass on the normal.
#[test]
fn a_central_impact_is_the_papers() {
    let tool = Tool {
        centre_of_mass_in_s_m: [0.0, 0.0, -0.06],
        tcp_in_s_m: [0.0, 0.0, -0.15],
        ..Default::default()
    };
    let object = Object {
        rebound_ratio: 1.0,
        ..Default::default()
    };
    let (peak, depth, duration, rebound, impulse, loss) = thrown(&tool, &object);
    assert!((peak / 160.0 - 1.0).abs() < 0.0005, "{peak} N");
    assert!((depth / 10e-6 - 1.0).abs() < 0.0005, "{depth} m");
    assert!((duration - PI / 2000.0).abs() <= 4e-6, "{duration} s");
    assert!((rebound / 0.02 - 1.0).abs() < 1e-3 && (impulse / 0.16 - 1.0).abs() < 1e-3);
    assert!(loss.abs() < 1e-9);
}

/// The default geometry: 107.264 N with the effective mass 1 / (1/M + (r x n) J^-1 (r x n)) = 1.798 kg; a stiffer
/// rebound shortens the impact, loses energy and leaves a dent.
#[test]
fn an_eccentric_impact_has_the_effective_mass() {
    let effective = 1.0 / (1.0 / 4.0 + 0.07 * 0.07 / 0.016);
    assert!((effective - 1.798f64).abs() < 0.001);
    for ratio in [1.0, 4.0] {
        let object = Object {
            rebound_ratio: ratio,
            ..Default::default()
        };
        let (peak, _, duration, rebound, impulse, loss) = thrown(&Tool::default(), &object);
        let w = (16e6 / effective).sqrt();
        let restitution = (1.0 / ratio).sqrt();
        assert!((peak / 107.264 - 1.0).abs() < 0.0005, "{peak} N");
        assert!(
            (duration - PI / 2.0 / w * (1.0 + restitution)).abs() <= 4e-6,
            "{duration} s"
        );
        assert!(
            (rebound / (0.02 * restitution) - 1.0).abs() < 2e-3,
            "{rebound} m/s"
        );
        assert!((impulse / (effective * 0.02 * (1.0 + restitution)) - 1.0).abs() < 2e-3);
        let expected = 0.5 * effective * 0.02 * 0.02 * (1.0 - restitution * restitution);
        assert!((loss - expected).abs() < 2e-3 * expected + 1e-8, "{loss} J");
    }
}
