//! No sequence of inputs makes the command leave its limits or jump: random and adversarial ones, with drop-outs.

use super::*;
use nalgebra::Vector3;
use proptest::prelude::*;
use spatial::ports::{LIMIT_ACCELERATION, LIMIT_AXIS, LIMIT_VELOCITY, LIMIT_WORKSPACE, Law};

/// What robot and sensor say for a while.
#[derive(Clone, Copy, Debug)]
struct Stretch {
    cycles: usize,
    /// How the robot moves: follows, stands, jumps to and fro, turns up anywhere.
    robot: u8,
    /// What the sensor shows: nothing, a force, noise, the ends of its range, silence, a bouncing tool.
    sensor: u8,
    /// Whether every now and then a cycle is missed, and how many in a row.
    missed: i64,
    size: f64,
}

fn stretch() -> impl Strategy<Value = Stretch> {
    (1_usize..80, 0_u8..4, 0_u8..6, 0_i64..12, -1.0_f64..1.0).prop_map(
        |(cycles, robot, sensor, missed, size)| Stretch {
            cycles,
            robot,
            sensor,
            missed,
            size,
        },
    )
}

fn scenario(law: usize, arm: bool, tight: bool) -> Scenario {
    let mut scenario = weightless();
    let laws = [Law::Pd, Law::PdReset, Law::Literal, Law::Proposed, Law::Impedance];
    scenario.controller.law = laws[law];
    // Faults would end most stretches.
    scenario.controller.collision.enabled = false;
    scenario.task.max_contact_force_n = 1e5;
    scenario.controller.stale_fault_s = 10.0;
    scenario.controller.max_sensor_delay_s = 10.0;
    scenario.controller.expected.search_speed_m_per_s = 0.2;
    scenario.task.approach_speed_m_per_s = 0.2;
    if arm {
        scenario.robot.kinematics = scenario::Kinematics::Arm;
        scenario.controller.acceleration_limit_rad_per_s2 = [7.5, 7.5, 10.0, 30.0, 30.0, 45.0];
    }
    if tight {
        let limits = &mut scenario.controller.limits;
        limits.velocity_ratio = 0.05;
        limits.lead_ratio = 0.0;
        limits.reversal_ratio = 0.2;
        limits.workspace_minimum_m = [-0.002, -0.002, 0.015];
        limits.workspace_maximum_m = [0.002, 0.002, 0.040];
        if !arm {
            limits.axis_margin_rad = 0.8;
        }
    }
    scenario
}

/// Velocity, acceleration and jerk of what the robot is sent, and ranges and workspace, from the scenario's words.
struct Judge {
    scenario: Scenario,
    sent: [Axes; 4],
}

impl Judge {
    fn new(scenario: &Scenario) -> Self {
        Self {
            scenario: scenario.clone(),
            sent: [scenario.start_axes().unwrap(); 4],
        }
    }

    fn take(&mut self, next: &Axes) {
        self.sent.rotate_right(1);
        self.sent[0] = *next;
        let (drives, controller) = (self.scenario.robot.drives(), &self.scenario.controller);
        let limits = &controller.limits;
        let [a, b, c, d] = self.sent;
        let t = 4e-3;
        let w_t = TAU * controller.filter_frequency_hz * t;
        for i in 0..6 {
            let most = controller.acceleration_limit_rad_per_s2[i] * (1.0 + limits.lead_ratio / (w_t * w_t));
            let [velocity, acceleration, jerk] = [
                (a - b)[i] / t,
                (a - b * 2.0 + c)[i] / (t * t),
                (a - b * 3.0 + c * 3.0 - d)[i] / (t * t * t),
            ]
            .map(f64::abs);
            let more = 1.0 + 1e-6;
            let fastest = limits.velocity_ratio * drives.velocity_limit_rad_per_s[i];
            assert!(
                velocity <= more * fastest,
                "axis {i}: {velocity} rad/s, limit {fastest}"
            );
            assert!(
                acceleration <= more * most,
                "axis {i}: {acceleration} rad/s^2, limit {most}"
            );
            let hardest = limits.reversal_ratio * most / t;
            assert!(
                jerk <= more * hardest,
                "axis {i}: {jerk} rad/s^3, limit {hardest}"
            );
            let margin = limits.axis_margin_rad;
            let range = drives.axis_minimum_rad[i] + margin..=drives.axis_maximum_rad[i] - margin;
            assert!(
                range.contains(&next[i]),
                "axis {i}: {} rad, range {range:?}",
                next[i]
            );
        }
        // The tool does not sag here.
        let d: Vector3<f64> = controller.tcp_in_s_m.into();
        let tcp = self.scenario.robot.kinematics().forward(next) * nalgebra::Point3::from(d);
        for i in 0..3 {
            let walls = limits.workspace_minimum_m[i] - 1e-9..=limits.workspace_maximum_m[i] + 1e-9;
            assert!(
                walls.contains(&tcp[i]),
                "the tcp is at {tcp}, beyond its workspace"
            );
        }
    }
}

/// Run `stretches`; the bits of the limits that bound.
fn run(scenario: &Scenario, stretches: &[Stretch]) -> i32 {
    let mut controller = Controller::new(scenario);
    let mut judge = Judge::new(scenario);
    let start = scenario.start_axes().unwrap();
    let (mut axes, mut tick, mut bits) = (start, 0, 0);
    let rest = Stretch {
        cycles: 66,
        robot: 0,
        sensor: 0,
        missed: 0,
        size: 0.0,
    };
    for stretch in std::iter::once(&rest).chain(stretches) {
        for cycle in 0..stretch.cycles {
            let flips = if cycle % 2 == 0 { 1.0 } else { -1.0 };
            let size = stretch.size;
            let robot = match stretch.robot {
                0 | 1 => axes,
                2 => start + Axes::repeat(0.05 * size * flips),
                _ => start + Axes::from_fn(|i, _| 3.0 * size * libm::sin((tick * (1 + i as i64)) as f64)),
            };
            let shown = |sampled: i64| {
                let noise = libm::sin((sampled * sampled) as f64);
                match stretch.sensor {
                    1 => lifted(2e-4 * size.abs()),
                    2 => lifted(1e-4 * noise),
                    3 => Deflection {
                        translation: Vector3::repeat(1.5e-3 * flips),
                        rotation: Vector3::repeat(0.026 * size * flips),
                    },
                    5 => lifted(if sampled / 50 % 2 == 0 { 1e-4 } else { -1e-5 }),
                    _ => Deflection::default(),
                }
            };
            let delay = if stretch.sensor == 4 { 100_000 } else { 4 };
            let outputs = controller.cycle(&Heard::complete(
                &state(tick, robot),
                &sensed(tick, delay, shown),
                None,
            ));
            bits |= outputs.status.limits;
            let missed = if cycle % 10 == 9 { stretch.missed } else { 0 };
            // The horizon too, as far as it is followed and beyond.
            let mut ahead = Judge {
                sent: judge.sent,
                scenario: scenario.clone(),
            };
            for (i, set_point) in (0..).zip(&outputs.command.axis_position) {
                ahead.take(set_point);
                if i <= missed {
                    judge.take(set_point);
                }
            }
            // Where the horizon ends, the robot stands: its own affair.
            if missed >= HORIZON as i64 {
                judge.sent = [outputs.command.axis_position[HORIZON - 1]; 4];
            }
            if stretch.robot == 0 {
                axes = outputs.command.axis_position[0];
            }
            tick += 4 * (1 + missed);
        }
    }
    bits
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 150, ..ProptestConfig::default() })]

    #[test]
    fn no_input_makes_the_command_leave_its_limits(
        stretches in proptest::collection::vec(stretch(), 1..12),
        law in 0_usize..5,
        arm in any::<bool>(),
        tight in any::<bool>(),
    ) {
        run(&scenario(law, arm, tight), &stretches);
    }
}

/// Each limit binds, and says so with its bit: in the approach, at a wall, at the end of an axis.
#[test]
fn each_limit_that_binds_is_said() {
    let follow = [Stretch {
        cycles: 400,
        robot: 0,
        sensor: 0,
        missed: 0,
        size: 0.0,
    }];
    let with = |change: &dyn Fn(&mut Scenario)| {
        let mut scenario = scenario(3, false, false);
        scenario.task.approach_speed_m_per_s = 0.02;
        change(&mut scenario);
        run(&scenario, &follow)
    };
    assert_eq!(with(&|_| ()), 0);
    let slow = with(&|scenario| scenario.controller.limits.velocity_ratio = 0.01);
    assert_eq!(slow & (LIMIT_VELOCITY | LIMIT_AXIS), LIMIT_VELOCITY);
    let gentle = with(&|scenario| {
        scenario.controller.limits.lead_ratio = 0.0;
        scenario.controller.acceleration_limit_rad_per_s2 = [0.2; 6];
    });
    assert_eq!(gentle & (LIMIT_ACCELERATION | LIMIT_VELOCITY), LIMIT_ACCELERATION);
    let walled = with(&|scenario| scenario.controller.limits.workspace_minimum_m[2] = 0.010);
    assert_eq!(walled & (LIMIT_WORKSPACE | LIMIT_AXIS), LIMIT_WORKSPACE);
    let short = with(&|scenario| scenario.robot.gantry.axis_minimum_rad[2] = 0.170);
    assert_eq!(short & (LIMIT_AXIS | LIMIT_WORKSPACE), LIMIT_AXIS);
}
