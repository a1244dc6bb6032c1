//! An attacker beside the nodes, and a machine that gives them too little.

use crate::{alone, patient};
use lcmtypes::EventLogReader;
use spatial::ports::{ControllerPhase, Fault, NodeState, Role};
use std::time::Duration;
use tests::Attack;
use tests::hostile::{again, files, memory_kib, pressing, under_attack};
use tests::site::{LONG, Setting, Site};

/// A sample of `make hostile`, and of `make soak`: a little of each attack on the same nodes, then the experiment once more.
#[test]
fn no_attack_ends_a_node_or_makes_it_grow() {
    let _alone = alone();
    let mut site = pressing(&patient()).unwrap();
    let before = (memory_kib(&site), files(&site));
    site.listen(Duration::from_secs(1));
    let after = (memory_kib(&site), files(&site));
    for i in 0..3 {
        assert!(
            after.0[i] <= before.0[i] + 256 && after.1[i] == before.1[i],
            "{before:?} {after:?}"
        );
    }
    // What the robot can't tell from its controller stops it: that comes last.
    let mut attacks = Attack::ALL;
    attacks.sort_by_key(|attack| matches!(attack, Attack::FarSteps | Attack::Everything));
    for (seed, attack) in (1..).zip(attacks) {
        let endured = under_attack(&mut site, attack, Duration::from_millis(100), seed).unwrap();
        assert_eq!(endured.broken(), None, "{attack}: {endured:?}");
        assert!(endured.sent > 0, "{attack}: {endured:?}");
        let counted = endured.counted;
        if attack.is_unusable() {
            // Those that a node does not subscribe to it does not look into.
            assert!(
                counted.unusable > (endured.sent / 4) as i64,
                "{attack}: {endured:?}"
            );
        }
    }
    let again_n = again(&mut site).unwrap();
    assert!((again_n - 10.0).abs() < 0.5, "{again_n} N");
}

/// The controller's disk is full once the force has settled (a file may have 2 MB): control goes on, the user is told on stderr,
/// in the status and by the exit code, and what has been written can be read.
#[test]
fn a_disk_that_is_full_costs_the_record_alone() {
    let _alone = alone();
    let mut site = Site::start(&Setting {
        through: [&[], &[], &["prlimit", "--fsize=2000000"]],
        ..patient()
    })
    .unwrap();
    let told = |site: &Site| {
        let status = site.heard.nodes[Role::Controller as usize];
        status.is_some_and(|it| it.fault == Fault::RecordFailed && it.state == NodeState::Running)
    };
    assert!(site.until(LONG, |heard| {
        heard.nodes[Role::Controller as usize].is_some_and(|it| it.fault != Fault::None)
    }));
    assert!(told(&site), "{:?}", site.heard.nodes);
    let settled = |site: &mut Site| {
        site.heard.controller = None;
        site.until(LONG, |heard| heard.phase() == Some(ControllerPhase::Settled))
    };
    assert!(settled(&mut site));
    site.listen(Duration::from_millis(300));
    assert!(settled(&mut site) && told(&site));
    assert_eq!(site.heard.robot.unwrap().fault, Fault::None);
    let record = site.bench.plan.record(Role::Controller);
    let Site { cell, bench, .. } = site;
    let error = cell.stop().unwrap_err().to_string();
    assert!(
        error.starts_with("controller died (exit code 1)") && error.contains("File too large"),
        "{error}"
    );
    let mut events = 0;
    for event in EventLogReader::open(record).unwrap().map_while(Result::ok) {
        lcmtypes::check(experiment::log::said_on(&event.channel), &event.bytes).unwrap();
        events += 1;
    }
    assert!(events > 1000, "{events}");
    drop(bench);
}
