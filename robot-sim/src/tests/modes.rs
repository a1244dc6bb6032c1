//! Compliance and modes of robot, sensor and tool as a linear model, against PLANT.md sections 2 and 5.

use super::*;
use nalgebra::{Cholesky, Matrix3, Matrix6, SMatrix};
use node::scenario::{Gears, Kinematics};
use spatial::kinematics::join;

/// The decoupled variant: each axis by itself.
struct Decoupled {
    inertia: Axes,
    gears: gears::Gears,
    /// Of s, at the start.
    jacobian: Matrix6<f64>,
}

impl Decoupled {
    fn new(kinematics: Kinematics, inertia: [f64; 6]) -> Self {
        let mut scenario = Scenario::default();
        scenario.robot.gears = Gears::Elastic;
        scenario.robot.kinematics = kinematics;
        let inertia = Axes::from(inertia);
        Self {
            inertia,
            gears: gears::Gears::new(&scenario.robot, &inertia).unwrap(),
            jacobian: scenario
                .robot
                .kinematics()
                .jacobian(&scenario.start_axes().unwrap()),
        }
    }

    fn arm() -> Self {
        Self::new(Kinematics::Arm, [50.0, 50.0, 25.0, 1.2, 1.2, 0.5])
    }

    fn gantry() -> Self {
        Self::new(Kinematics::Gantry, [60.0, 60.0, 60.0, 2.0, 2.0, 2.0])
    }

    /// Compliance of the gears along a force through `lever` (m, from s), m/N.
    fn compliance(&self, direction: Vector3<f64>, lever: Vector3<f64>) -> f64 {
        let torque = self.jacobian.tr_mul(&join(direction, lever.cross(&direction)));
        torque.dot(&torque.component_div(&self.gears.stiffness))
    }

    /// Modes in Hz with the default tool on the default sensor, motors locked.
    fn modes(&self) -> Vec<f64> {
        let scenario = Scenario::default();
        let (tool, sensor) = (&scenario.tool, &scenario.sensor);
        let c = spatial::rotation::skew(Vector3::from(tool.centre_of_mass_in_s_m));
        // Velocity of the tool's centre of mass and its angular velocity, from the motion of s'.
        let mut to_centre = Matrix6::identity();
        to_centre.fixed_view_mut::<3, 3>(0, 3).copy_from(&-c);
        let mut inertia = Matrix6::from_diagonal_element(tool.mass_kg);
        let own = Matrix3::from_diagonal(&Vector3::from(tool.inertia_kg_m2));
        inertia.fixed_view_mut::<3, 3>(3, 3).copy_from(&own);
        let (translation, rotation) = (sensor.stiffness_n_per_m, sensor.stiffness_nm_per_rad);
        let spring = Matrix6::from_diagonal(&join(Vector3::repeat(translation), Vector3::repeat(rotation)));
        let mut mass = SMatrix::<f64, 12, 12>::zeros();
        let mut stiffness = mass;
        let block = |matrix: &mut SMatrix<f64, 12, 12>, i, j, part: Matrix6<f64>| {
            matrix.fixed_view_mut::<6, 6>(i, j).copy_from(&part);
        };
        let j = self.jacobian;
        block(&mut mass, 0, 0, Matrix6::from_diagonal(&self.inertia));
        block(&mut mass, 6, 6, to_centre.transpose() * inertia * to_centre);
        let gears = Matrix6::from_diagonal(&self.gears.stiffness);
        block(&mut stiffness, 0, 0, gears + j.transpose() * spring * j);
        block(&mut stiffness, 0, 6, -j.transpose() * spring);
        block(&mut stiffness, 6, 0, -spring * j);
        block(&mut stiffness, 6, 6, spring);
        let inverse = Cholesky::new(mass).unwrap().l().try_inverse().unwrap();
        let squares = (inverse * stiffness * inverse.transpose()).symmetric_eigenvalues();
        let mut modes: Vec<f64> = squares.iter().map(|square| square.sqrt() / TAU).collect();
        modes.sort_by(f64::total_cmp);
        modes
    }
}

#[test]
fn the_gears_of_the_gantry_yield_at_the_tcp() {
    let at_tcp = Decoupled::gantry().compliance(Vector3::z(), Vector3::new(0.10, 0.0, -0.15));
    assert!((at_tcp - 2.47e-6).abs() < 0.01e-6, "{at_tcp}");
}

#[test]
fn the_gears_of_the_arm_yield_at_flange_and_tcp() {
    let arm = Decoupled::arm();
    for (direction, expected) in [
        (Vector3::x(), 1.93e-6),
        (Vector3::y(), 3.21e-6),
        (Vector3::z(), 2.19e-6),
    ] {
        let found = arm.compliance(direction, Vector3::zeros());
        assert!((found / expected - 1.0).abs() < 0.005, "{found} {expected}");
    }
    let at_tcp = arm.compliance(Vector3::z(), Vector3::new(0.10, 0.0, -0.15));
    assert!((at_tcp / 3.40e-6 - 1.0).abs() < 0.005, "{at_tcp}");
}

#[test]
fn the_modes_of_the_decoupled_arm_with_sensor_and_tool() {
    let modes = Decoupled::arm().modes();
    let expected = [13.0, 14.1, 14.9, 16.7, 17.8, 21.9, 23.3, 24.7];
    for (found, expected) in modes.iter().zip(expected) {
        assert!((found - expected).abs() < 0.06, "{modes:?}");
    }
    assert!(modes[8] > 31.5, "{modes:?}");
}

#[test]
fn the_modes_of_the_gantry_with_sensor_and_tool() {
    let modes = Decoupled::gantry().modes();
    assert!(
        modes[0] > 10.0 && modes[0] < 14.0 && modes[11] > 66.0,
        "{modes:?}"
    );
}
