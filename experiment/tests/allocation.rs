//! The loop does not allocate once it runs (DESIGN: invariant 8): robot, sensor and controller, tick by tick, through
//! approach, impact and regulation. In a binary of its own: it counts what its thread's allocator is asked for.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use allocation_counter::{AllocationInfo, measure};
use controller::{Controller, Heard};
use experiment::scenarios::Source;
use node::scenario::Scenario;
use robot_sim::RobotSim;
use sensor_sim::SensorSim;

/// What robot, sensor and controller allocate in a whole run, and whether there was a contact.
fn allocated(scenario: &Scenario) -> ([AllocationInfo; 3], bool) {
    let mut robot = RobotSim::new(scenario);
    let mut sensor = SensorSim::new(scenario, &robot.link_motion().motion);
    let mut controller = Controller::new(scenario);
    let mut sums = [AllocationInfo::default(); 3];
    let mut touched = false;
    for _ in 0..scenario.timing.ticks() {
        let (mut said, mut sensed, mut answer) = (None, None, None);
        sums[0] += measure(|| {
            said = Some((robot.link_motion(), robot.command_due().then(|| robot.state())));
        });
        let (link, state) = said.unwrap();
        sums[1] += measure(|| sensed = Some(sensor.advance(&link)));
        let sensed = sensed.unwrap();
        sums[2] += measure(|| {
            answer = state.map(|state| {
                // Every fifth state and every seventh command is missing.
                let lost = state.stamp.step % 20 == 16;
                let object = sensed.object_pose.as_ref();
                let complete = Heard::complete(&state, &sensed.deflections, object);
                controller.cycle(&Heard {
                    state: complete.state.filter(|_| !lost),
                    ..complete
                })
            });
        });
        // Not part of the cycle.
        controller.assess();
        let command = answer.as_ref().map(|answer| &answer.command);
        let command = command.filter(|command| command.stamp.step % 28 != 12);
        sums[0] += measure(|| robot.advance(&sensed.tool_motion, command));
        touched |= sensed.truth.first_contact_time_s > 0.0;
    }
    (sums, touched)
}

#[test]
fn the_loop_does_not_allocate() {
    for name in ["paper", "elastic", "arm", "elastic_arm"] {
        let scenario = Source::find(name).unwrap().scenario(&[]).unwrap();
        let (sums, touched) = allocated(&scenario);
        assert!(touched, "{name}: no contact");
        for (part, sum) in ["robot", "sensor", "controller"].iter().zip(sums) {
            assert_eq!((sum.count_total, sum.bytes_total), (0, 0), "{name}: {part}");
        }
    }
}

/// The counter counts.
#[test]
fn an_allocation_is_seen() {
    let seen = measure(|| {
        std::hint::black_box(vec![1_u8; 100]);
    });
    assert_eq!((seen.count_total, seen.bytes_total), (1, 100));
}
