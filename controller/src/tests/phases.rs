//! The phases of DESIGN.md section 6 and when they begin, and the limits that bind.

use super::*;
use ControllerPhase::{Approach, Contact, Init, Ready, Settled, Sync};
use spatial::ports::LIMIT_HOLD;

/// C of the tcp along z (PLANT.md section 5), m/N.
const COMPLIANCE: f64 = 28.267e-6;

/// The cycles at which a phase begins, on a robot that stands still while the sensor shows `force` (N, by tick).
fn phases(scenario: &Scenario, force: impl Fn(i64) -> f64) -> Vec<(i64, ControllerPhase)> {
    let mut controller = Controller::new(scenario);
    let axes = scenario.start_axes().unwrap();
    let mut phases = vec![(0, controller.status(0).phase)];
    for tick in (0..=800).step_by(4) {
        let deflections = sensed(tick, 0, |sampled| lifted(COMPLIANCE * force(sampled)));
        let status = controller
            .cycle(&Heard::complete(&state(tick, axes), &deflections, None))
            .status;
        assert_eq!(status.fault, Fault::None);
        if phases.last().is_some_and(|(_, phase)| *phase != status.phase) {
            phases.push((tick, status.phase));
        }
    }
    phases
}

/// Tare 0.2 s, standstill 0.25 s, contact with the first sample above the threshold, settled after 50 ms within
/// 0.5 N in a row, which are 13 cycles of 4 ms; one cycle outside starts them anew, and ends what had settled.
#[test]
fn each_phase_begins_in_its_cycle() {
    let found = phases(&weightless(), |tick| match tick {
        ..400 => 0.0,
        400..440 => 5.0,
        480..484 => 10.6,
        600..604 => 9.4,
        _ if tick / 4 % 2 == 0 => 10.4,
        _ => 9.6,
    });
    let expected = [
        (0, Init),
        (0, Sync),
        (200, Ready),
        (252, Approach),
        (400, Contact),
        (484 + 48, Settled),
        (600, Contact),
        (604 + 48, Settled),
    ];
    assert_eq!(found, expected);
}

/// A force that is there before the approach is none of its contacts, and counts once the approach begins.
#[test]
fn only_the_approach_meets_an_object() {
    let found = phases(&weightless(), |tick| if tick < 230 { 0.0 } else { 3.0 });
    assert_eq!(
        found,
        [
            (0, Init),
            (0, Sync),
            (200, Ready),
            (252, Approach),
            (256, Contact)
        ]
    );
}

#[test]
fn without_a_valid_sample_it_stays_in_sync() {
    let scenario = weightless();
    let mut controller = Controller::new(&scenario);
    let axes = scenario.start_axes().unwrap();
    for tick in (0..=400).step_by(4) {
        let outputs = controller.cycle(&Heard::complete(
            &state(tick, axes),
            &sensed(tick, 1000, |_| lifted(1.0)),
            None,
        ));
        assert_eq!(outputs.status.phase, Sync);
        assert_eq!(outputs.command.axis_position, [axes; HORIZON]);
    }
}

/// The way from 30 mm above to 5 mm below the expected height takes 1.75 s at 20 mm/s and 0.123 s for its ramps. Then
/// the fault stays, whatever comes, and the robot where it is.
#[test]
fn a_search_that_ends_latches_no_contact_and_holds() {
    let scenario = weightless();
    let mut controller = Controller::new(&scenario);
    let mut axes = scenario.start_axes().unwrap();
    let bottom = axes.z - 0.035;
    let mut fault_axes = None;
    for tick in (0..=2600).step_by(4) {
        let late = if tick < 2300 { 0.0 } else { 10.0 };
        let Outputs { command, status } = controller.cycle(&Heard::complete(
            &state(tick, axes),
            &sensed(tick, 0, |_| lifted(COMPLIANCE * late)),
            None,
        ));
        axes = command.axis_position[0];
        let ended = (tick - 252) as f64 * TICK_S > 1.877;
        let expected = if ended {
            (ControllerPhase::Fault, Fault::NoContact)
        } else {
            (status.phase, Fault::None)
        };
        assert_eq!((status.phase, status.fault), expected, "tick {tick}");
        assert!(!status.object_known && status.phase != Contact);
        if ended {
            for held in &command.axis_position {
                assert!((held.z - bottom).abs() < 1e-6, "{held} at tick {tick}");
                assert!(
                    fault_axes.is_none_or(|axes| axes == *held),
                    "it moved at tick {tick}"
                );
                fault_axes = Some(*held);
            }
        }
    }
}

/// `max_lead_m` = 3 mm ahead of a robot that is stuck, and no more; said with bit 1, until the robot follows.
#[test]
fn the_lead_is_bounded_and_its_bit_says_so() {
    let scenario = weightless();
    let mut controller = Controller::new(&scenario);
    let mut axes = scenario.start_axes().unwrap();
    let mut bound_ticks = Vec::new();
    for tick in (0..=1000).step_by(4) {
        let Outputs { command, status } =
            controller.cycle(&Heard::complete(&state(tick, axes), &undeflected(tick), None));
        let leads = command.axis_position.map(|next| axes.z - next.z);
        assert!(
            leads.iter().all(|lead| *lead < 3e-3 + 1e-12),
            "{leads:?} at tick {tick}"
        );
        assert_eq!(
            status.limits,
            i32::from(leads[0] > 3e-3 - 1e-12),
            "{leads:?} at tick {tick}"
        );
        if status.limits != 0 {
            bound_ticks.push(tick);
        }
        if tick > 600 {
            axes = command.axis_position[0];
        }
    }
    // 3 mm at 20 mm/s take 150 ms and half the ramp of 123 ms, less the feed-forward's 2 zeta / w = 17 ms: 252 + 194.
    let (first, last) = (bound_ticks[0], bound_ticks[bound_ticks.len() - 1]);
    assert!((444..=452).contains(&first), "{first}");
    assert!((600..640).contains(&last), "{last}");
    // The way waits, so that the bound is hardly ever left in between.
    assert!(
        bound_ticks.len() as i64 > (last - first) / 4 - 5,
        "{bound_ticks:?}"
    );
}

/// Bit 32: the newest sample is at the end of its range.
#[test]
fn a_saturated_deflection_is_said() {
    let scenario = weightless();
    let mut controller = Controller::new(&scenario);
    let axes = scenario.start_axes().unwrap();
    for tick in (0..=400).step_by(4) {
        let mut deflections = undeflected(tick);
        let saturated = (300..360).contains(&tick);
        deflections.samples[0].flags.saturated = saturated;
        let status = controller
            .cycle(&Heard::complete(&state(tick, axes), &deflections, None))
            .status;
        assert_eq!(status.limits, 32 * i32::from(saturated), "tick {tick}");
    }
}

/// A sensor that brings nothing new for more than 3 T, 12 ms, but speaks again before that is a fault: on its way down the
/// robot is held so long, says so, and goes on.
#[test]
fn a_sensor_that_is_silent_for_a_moment_holds_the_robot() {
    let scenario = weightless();
    let mut controller = Controller::new(&scenario);
    let mut axes = scenario.start_axes().unwrap();
    let (mut held, mut at) = (Vec::new(), Vec::new());
    for tick in (0..=800).step_by(4) {
        let mut deflections = undeflected(tick);
        for sample in &mut deflections.samples {
            sample.flags.valid &= !(501..517).contains(&(sample.utime / spatial::TICK_US));
        }
        let Outputs { command, status } =
            controller.cycle(&Heard::complete(&state(tick, axes), &deflections, None));
        axes = command.axis_position[0];
        at.push((tick, axes.z));
        assert_eq!(status.fault, Fault::None, "tick {tick}");
        if status.limits & LIMIT_HOLD != 0 {
            held.push(tick);
        }
    }
    assert_eq!(held, [516]);
    let moved = |from: usize, to: usize| (at[to / 4].1 - at[from / 4].1).abs();
    assert!(moved(512, 516) < 0.5 * moved(508, 512), "{at:?}");
    assert!(moved(600, 700) > 1e-3, "it goes on");
}

/// A sensor whose newest sample is 48 ms old is late, one of 52 ms too late.
#[test]
fn a_sensor_that_is_too_late_is_a_fault() {
    for (delay, fault) in [(48, Fault::None), (52, Fault::SensorStale)] {
        let scenario = weightless();
        let mut controller = Controller::new(&scenario);
        let axes = scenario.start_axes().unwrap();
        let last = (0..=400).step_by(4).map(|tick| {
            let deflections = sensed(tick, delay, |_| Deflection::default());
            controller
                .cycle(&Heard::complete(&state(tick, axes), &deflections, None))
                .status
        });
        assert_eq!(last.last().unwrap().fault, fault, "{delay} ms");
    }
}

/// A sensor that brings nothing new for 20 ms is a fault; the axes stay where they were sent, also when it speaks again.
#[test]
fn a_silent_sensor_is_a_fault_and_holds() {
    let scenario = weightless();
    let mut controller = Controller::new(&scenario);
    let mut axes = scenario.start_axes().unwrap();
    let mut held = None;
    for tick in (0..=800).step_by(4) {
        let mut deflections = undeflected(tick);
        let silent = (500..700).contains(&tick);
        for sample in &mut deflections.samples {
            sample.flags.valid &= !silent;
        }
        let Outputs { command, status } =
            controller.cycle(&Heard::complete(&state(tick, axes), &deflections, None));
        axes = command.axis_position[0];
        if tick <= 496 + 20 {
            assert_eq!(status.fault, Fault::None, "tick {tick}");
        } else {
            assert_eq!(
                (status.phase, status.fault),
                (ControllerPhase::Fault, Fault::SensorStale)
            );
            assert_eq!(
                command.axis_position,
                [*held.get_or_insert(axes); HORIZON],
                "tick {tick}"
            );
        }
    }
}
