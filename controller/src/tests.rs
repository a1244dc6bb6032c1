//! The controller on a robot and a sensor that do as the test says.

mod compliance;
mod impact;
mod laws;
mod limits;
mod losses;
mod phases;
mod protection;
mod readiness;
mod release;
mod samples;

use super::*;
use nalgebra::Vector3;
use node::scenario::{self, Pairing, SensorOutput, TaskKind};
use spatial::ports::{
    Authenticity, ClockEcho, DeflectionSample, Deflections, ENCODER_SAMPLES, HORIZON, ObjectPose, RobotMode,
    Role, SampleFlags, Stamp,
};
use spatial::{Compliance, Deflection, TICK_US, Wrench};
use std::f64::consts::TAU;

fn state(tick: i64, axes: Axes) -> RobotState {
    RobotState {
        stamp: Stamp::lockstep(tick, 1, Role::Robot),
        sample_count: 1,
        axis_position: [axes; ENCODER_SAMPLES],
        axis_velocity: Axes::zeros(),
        axis_setpoint: axes,
        mode: RobotMode::Following,
        fault: Fault::None,
        fault_axis: -1,
        command_step: -1,
        missed_commands: 0,
        echo: ClockEcho::default(),
        authenticity: Authenticity::default(),
    }
}

/// What the sensor says at `tick`: its last eight samples, which come through a delay of `delay` ticks.
fn sensed(tick: i64, delay: i64, at: impl Fn(i64) -> Deflection) -> Deflections {
    let samples = std::array::from_fn(|age| {
        let sampled = tick - delay - age as i64;
        DeflectionSample {
            utime: sampled * spatial::TICK_US,
            deflection: at(sampled),
            flags: SampleFlags {
                valid: sampled >= 0,
                ..SampleFlags::default()
            },
            ..DeflectionSample::default()
        }
    });
    Deflections {
        stamp: Stamp::lockstep(tick, 1, Role::Sensor),
        samples,
        echo: ClockEcho::default(),
        authenticity: Authenticity::default(),
    }
}

/// The paper's scenario with a tool of which nothing is known: it may weigh nothing.
fn weightless() -> Scenario {
    let mut scenario = Scenario::default();
    scenario.controller.tool_mass_kg = 0.0;
    scenario
}

fn undeflected(tick: i64) -> Deflections {
    sensed(tick, 0, |_| Deflection::default())
}

/// A deflection along z, m.
fn lifted(z: f64) -> Deflection {
    Deflection {
        translation: Vector3::new(0.0, 0.0, z),
        rotation: Vector3::zeros(),
    }
}

/// On the way down, forearm and tool align 0.83 m below the start (a wrist singularity): it stops before, and says why.
#[test]
fn what_the_arm_cannot_reach_is_a_fault_and_it_holds() {
    let mut scenario = Scenario::default();
    scenario.robot.kinematics = scenario::Kinematics::Arm;
    scenario.task.expected_height_m = -2.0;
    scenario.controller.tool_mass_kg = 0.0;
    scenario.task.approach_speed_m_per_s = 0.5;
    scenario.controller.max_lead_m = 0.1;
    let mut controller = Controller::new(&scenario);
    let mut axes = scenario.start_axes().unwrap();
    let kinematics = scenario.robot.kinematics();
    let mut fault_tick = None;
    for tick in (0..8000).step_by(4) {
        let outputs = controller.cycle(&Heard::complete(&state(tick, axes), &undeflected(tick), None));
        let [next, .., last] = outputs.command.axis_position;
        assert!(
            (next - axes).amax() < 0.1,
            "tick {tick}: a jump of {} rad",
            (next - axes).amax()
        );
        if outputs.status.fault != Fault::None {
            assert_eq!(outputs.status.fault, Fault::Unreachable);
            assert_eq!(outputs.status.phase, ControllerPhase::Fault);
            let since = tick - *fault_tick.get_or_insert(tick);
            // It brakes from 0.5 m/s within its limits, and then stands.
            assert!(since < 60 || (next == axes && next == last), "{since} ticks");
        }
        axes = next;
    }
    let height = kinematics.forward(&axes).translation.vector.z;
    assert!(
        fault_tick.is_some() && (-0.66..-0.64).contains(&height),
        "{height} m"
    );
}
