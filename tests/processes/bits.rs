//! Three processes in lockstep say bit for bit what the loop in one process says (DESIGN.md, invariant 4).

use experiment::launch;
use experiment::transcript::{self, Entry};
use spatial::ports::{ControllerStatus, ObjectPose};
use tests::{Bench, Impairment, Relay};

/// Returns what was said.
fn assert_same_bits(bench: &Bench) -> Vec<Entry> {
    let never = crossbeam::channel::never();
    let said = launch::run(&bench.plan, &never, |_| ()).unwrap();
    let expected = transcript::in_process(&bench.scenario).unwrap();
    assert!(expected.len() > 3 * 900);
    assert_eq!(transcript::first_difference(&said, &expected), None);
    said
}

/// The same while a relay loses 5 % of all datagrams and doubles 5 %.
fn assert_same_bits_on_a_bad_network(changes: &[&str], seed: u64) -> Vec<Entry> {
    let seeded = format!("timing.seed={seed}");
    let changes: Vec<_> = changes.iter().copied().chain([seeded.as_str()]).collect();
    let mut bench = Bench::new(&changes).unwrap();
    let ports = bench.separate().unwrap();
    let impairment = Impairment {
        loss: 0.05,
        duplication: 0.05,
        seed,
        ..Impairment::default()
    };
    let relay = Relay::start(&ports, 0, impairment).unwrap();
    let said = assert_same_bits(&bench);
    assert!(relay.lost() > 100, "the relay has lost only {}", relay.lost());
    said
}

#[test]
fn the_proposed_law() {
    assert_same_bits(&Bench::new(&[]).unwrap());
}

#[test]
fn the_pd_law_with_another_period_and_seed() {
    let changes = [
        "controller.law=pd",
        "timing.command_period_ticks=3",
        "timing.seed=42",
    ];
    assert_same_bits(&Bench::new(&changes).unwrap());
}

/// Messages that liblcm receives instead of the own socket.
#[test]
fn through_liblcm() {
    let mut bench = Bench::new(&[]).unwrap();
    let wiring = &mut bench.plan.wiring;
    for url in wiring.device.iter_mut().chain(&mut wiring.world) {
        url.push_str("&receive=liblcm");
    }
    assert_same_bits(&bench);
}

/// Two cells on the same ports, told apart by the names of their channels.
#[test]
fn beside_another_cell_on_the_same_ports() {
    let bench = Bench::new(&[]).unwrap();
    let mut other = Bench::new(&["timing.seed=2"]).unwrap();
    other.plan.wiring = bench.plan.wiring.clone();
    let wiring = &mut other.plan.wiring;
    for url in wiring
        .device
        .iter_mut()
        .chain(&mut wiring.world)
        .chain([&mut wiring.watch])
    {
        url.push_str("&suffix=_B");
    }
    std::thread::scope(|scope| {
        scope.spawn(|| assert_same_bits(&bench));
        assert_same_bits(&other);
    });
}

/// What is learnt in contact goes back into the law.
#[test]
fn an_adapted_compliance() {
    let changes = [
        "sensor.wrench_measured=true",
        "controller.adaptation.enabled=true",
        "controller.compliance_rad_per_nm=5e-3",
        "task.start_position_m=[0, 0, 0.014]",
    ];
    let said = assert_same_bits(&Bench::new(&changes).unwrap());
    let last = transcript::messages::<ControllerStatus>(&said).last().unwrap();
    assert!(last.compliance_confidence > 0.9 && last.compliance.rotation[(1, 1)] < 2.6e-3);
}

#[test]
fn with_five_percent_of_all_datagrams_lost_and_five_doubled() {
    for seed in 1..=4 {
        assert_same_bits_on_a_bad_network(&[], seed);
    }
}

/// A moving object is seen at every third cycle, by a sensor whose delay is no multiple of anything.
#[test]
fn with_a_non_contact_sensor_on_a_good_and_on_a_bad_network() {
    let changes = [
        "object_sensor.enabled=true",
        "object_sensor.period_ticks=12",
        "object_sensor.delay_ticks=7",
        "object.swing_amplitude_m=[0.001, 0.0, 0.0005]",
    ];
    let good = assert_same_bits(&Bench::new(&changes).unwrap());
    let bad = assert_same_bits_on_a_bad_network(&changes, 2);
    for said in [good, bad] {
        let steps = transcript::messages::<ObjectPose>(&said).map(|pose| pose.stamp.step);
        assert!(steps.eq((0..=900).step_by(12)));
    }
}
