//! One controller after the other, the tool being pressed against the object.

use super::authenticity::new_key;
use super::{alone, patient, until_settled};
use rustix::process::Signal;
use spatial::ports::{ControllerPhase, Fault, RobotMode, Role, TaskAction};
use std::path::Path;
use std::time::Duration;
use tests::site::{LONG, Setting, Site};
use tests::wait_for_end;

/// The first is asked to end, the second started; the robot is held in between, and follows the second. Also the peak of
/// the force before, N.
fn hand_over(key: Option<&Path>) -> (Site, f64) {
    let mut site = Site::start(&Setting { key, ..patient() }).unwrap();
    until_settled(&mut site);
    site.listen(Duration::from_millis(300));
    let impact_n = site.heard.peak_n;
    let first = site.heard.command.unwrap().stamp.boot_id;
    site.heard.mark();
    let process = site.cell.process_id(Role::Controller).unwrap();
    site.signal(Role::Controller, Signal::TERM);
    assert!(wait_for_end(process as i32, LONG));
    site.cell.kill(Role::Controller);
    let plan = site.bench.plan.clone();
    site.cell.start_another(&plan, Role::Controller).unwrap();
    let taken = site.until(LONG, |heard| {
        heard
            .robot
            .is_some_and(|robot| robot.mode == RobotMode::Following)
            && heard
                .command
                .is_some_and(|command| command.enable && command.stamp.boot_id != first)
            && heard.phase() == Some(ControllerPhase::Ready)
    });
    assert!(taken, "{:?}, {:?}", site.heard.modes, site.heard.controller);
    site.listen(Duration::from_millis(300));
    // Not by a fault: it was stopped, left, armed and followed again.
    let mut modes = site.heard.modes.clone();
    modes.retain(|mode| *mode != RobotMode::Bridging);
    modes.dedup();
    let ends = [RobotMode::Idle, RobotMode::Armed, RobotMode::Following];
    assert!(
        modes.ends_with(&ends) && !modes.contains(&RobotMode::Fault),
        "{modes:?}"
    );
    let [least_n, most_n] = site.heard.force_n;
    let speed = site.heard.set_point_rad_per_s;
    assert!(least_n > 8.0 && most_n < 12.0, "{least_n} to {most_n} N");
    assert!(speed < 2e-3, "{speed} rad/s");
    (site, impact_n)
}

#[test]
fn a_robot_in_contact_is_handed_over_without_a_bump() {
    let _alone = alone();
    hand_over(None);
}

#[test]
fn a_robot_in_contact_is_handed_over_without_a_bump_under_a_key() {
    let _alone = alone();
    let (_directory, key) = new_key();
    let (mut site, impact_n) = hand_over(Some(&key));
    // Led back, tared and pressed anew.
    site.heard.mark();
    assert!(site.ask(TaskAction::Start, |heard| heard.phase()
        != Some(ControllerPhase::Ready)));
    until_settled(&mut site);
    let peak_n = site.heard.peak_n;
    assert!(peak_n < 1.2 * impact_n, "{peak_n} N after {impact_n} N");
    let mut nodes = site.heard.nodes.iter().flatten();
    assert!(nodes.all(|status| status.fault == Fault::None));
}
