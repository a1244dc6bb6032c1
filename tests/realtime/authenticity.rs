//! Nodes with a key, and somebody on their network who has none.

use super::{alone, patient, until_settled};
use lcmtypes::{LcmBuilder, Message, Subscription};
use node::authenticity::{KEY_BYTES, Key, Keyring, Signed};
use node::key_file;
use spatial::ports::{
    Authenticity, Command, ControllerPhase, Fault, NodeState, RobotMode, RobotState, Role, Task, TaskAction,
    TaskParameters,
};
use std::path::PathBuf;
use std::time::Duration;
use tempfile::TempDir;
use tests::Impairment;
use tests::site::{LONG, Setting, Site};

/// A key of its own.
pub(super) fn new_key() -> (TempDir, PathBuf) {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("cell.key");
    key_file::create(&path).unwrap();
    (directory, path)
}

/// A site under a key of its own, otherwise as `setting` says.
fn under_a_key(setting: Setting<'_>) -> (TempDir, Site) {
    let (directory, key) = new_key();
    let key = Some(key.as_path());
    (directory, Site::start(&Setting { key, ..setting }).unwrap())
}

/// How often everything is forged, and how many of each forgery are surely counted: datagrams may be lost.
const ROUNDS: i64 = 100;
const COUNTED: i64 = ROUNDS / 2;

/// Somebody who hears everything, and has another key.
struct Forger {
    keyring: Keyring,
    early: Vec<(RobotState, Command)>,
}

impl Forger {
    /// What was said while `site` was beginning is kept.
    fn listen(site: &mut Site) -> Self {
        let mut early = Vec::new();
        while site.heard.phase() != Some(ControllerPhase::Approach) {
            site.listen(Duration::from_millis(20));
            early.extend(site.heard.robot.zip(site.heard.command));
        }
        Self {
            keyring: Keyring::new(Key::new(&[9; KEY_BYTES]), Vec::new()),
            early,
        }
    }

    /// Say `message` as the next one of its sender: with the tag of the one before, with another key, and with none.
    fn forge<M: Signed>(&self, site: &Site, message: &M) {
        let mut forged = *message;
        forged.authenticity_mut().seq += 1;
        let _ = site.link().publish(&forged);
        let Authenticity { session, seq, .. } = *forged.authenticity();
        self.keyring.sign(&mut forged, session, seq);
        let _ = site.link().publish(&forged);
        *forged.authenticity_mut() = Authenticity::default();
        let _ = site.link().publish(&forged);
    }

    /// One round of everything; a full buffer is one more loss.
    fn say(&self, site: &Site, round: usize) {
        let heard = &site.heard;
        let (Some(state), Some(command), Some(deflections)) = (heard.robot, heard.command, heard.deflections)
        else {
            panic!("nothing was heard");
        };
        // 10 mm deeper.
        let mut pushing = command;
        pushing.stamp.step = state.stamp.step;
        for axes in &mut pushing.axis_position {
            axes.z -= 0.01;
        }
        self.forge(site, &pushing);
        let mut faulty = state;
        (faulty.fault, faulty.fault_axis, faulty.mode) = (Fault::AxisLimit, 0, RobotMode::Fault);
        self.forge(site, &faulty);
        let mut lifted = deflections;
        for sample in &mut lifted.samples {
            sample.deflection.translation.z += 1e-3;
        }
        self.forge(site, &lifted);
        let mut values = [None; TaskParameters::COUNT];
        values[0] = Some(15.0);
        let mut task = Task {
            stamp: command.stamp,
            action: if round.is_multiple_of(2) {
                TaskAction::Stop
            } else {
                TaskAction::Release
            },
            parameters: TaskParameters::from_values(values),
            authenticity: command.authenticity,
        };
        (task.stamp.step, task.authenticity.seq) = (round as i64 + 1, state.authenticity.seq);
        self.forge(site, &task);
        // Of this session and of an older one, as it was; then on another channel, and cut off.
        let (early_state, early_command) = &self.early[round % self.early.len()];
        for command in [&command, early_command] {
            let _ = site.link().publish(command);
        }
        for state in [&state, early_state] {
            let _ = site.link().publish(state);
        }
        let _ = site.link().publish(&deflections);
        let [state, deflections, command] = [state.encode(), deflections.encode(), command.encode()];
        let [state, deflections, command] = [state, deflections, command].map(Result::unwrap);
        for (channel, bytes) in [
            ("ROBOT_COMMAND", deflections.as_bytes()),
            ("SENSOR_DEFLECTION", state.as_bytes()),
            ("ROBOT_STATE", command.as_bytes()),
            (
                "ROBOT_COMMAND",
                &command.as_bytes()[..command.as_bytes().len() - 16],
            ),
        ] {
            let _ = site.link().publish_raw(channel, bytes);
        }
    }
}

/// Refused, and not decoded, by each node.
fn counts(site: &Site) -> [[i64; 2]; 3] {
    site.heard.nodes.map(|status| {
        let link = status.unwrap().link;
        [link.refused, link.undecodable]
    })
}

#[test]
fn a_forger_does_not_disturb_and_is_counted() {
    let _alone = alone();
    let (_directory, mut site) = under_a_key(patient());
    let forger = Forger::listen(&mut site);
    until_settled(&mut site);
    let before = counts(&site);
    site.heard.mark();
    for round in 0..ROUNDS {
        site.listen(Duration::from_millis(4));
        forger.say(&site, round as usize);
        let status = site.heard.controller.unwrap();
        assert!(status.force_error_n.abs() < 1.0, "{} N", status.force_error_n);
        assert_eq!((status.fault, status.desired_wrench.force.z), (Fault::None, 10.0));
        // On a busy machine it may have to settle again, but it stays in contact.
        let phase = status.phase;
        assert!(
            matches!(phase, ControllerPhase::Contact | ControllerPhase::Settled),
            "{phase:?}"
        );
    }
    site.listen(Duration::from_millis(300));
    until_settled(&mut site);
    assert_eq!(site.heard.robot.unwrap().fault, Fault::None);
    assert!(
        !site
            .heard
            .modes
            .iter()
            .any(|mode| !matches!(mode, RobotMode::Following | RobotMode::Bridging)),
        "{:?}",
        site.heard.modes
    );
    let after = counts(&site);
    // Robot: commands, deflections and requests; sensor: commands; controller: states, deflections, requests.
    for (role, kinds) in [
        (Role::Robot, [9, 2]),
        (Role::Sensor, [3, 2]),
        (Role::Controller, [9, 2]),
    ] {
        for i in 0..2 {
            let counted = after[role as usize][i] - before[role as usize][i];
            assert!(counted >= kinds[i] * COUNTED, "{role:?}: {before:?}, {after:?}");
        }
    }
    assert!(
        site.heard
            .nodes
            .iter()
            .flatten()
            .all(|status| status.fault == Fault::None && status.authenticated)
    );
    requests_are_taken_once(&mut site);
}

/// Who has the key is followed, and once.
fn requests_are_taken_once(site: &mut Site) {
    let mut link = LcmBuilder::open(&site.bench.plan.wiring.watch).unwrap();
    let asked: Subscription<Task> = link.subscribe(64);
    let _link = link.start().unwrap();
    assert!(site.ask(TaskAction::Stop, |heard| heard.phase()
        == Some(ControllerPhase::Ready)));
    assert!(site.ask(TaskAction::Start, |heard| heard.phase()
        != Some(ControllerPhase::Ready)));
    until_settled(site);
    let asked: Vec<Task> = std::iter::from_fn(|| asked.take()).map(|it| it.message).collect();
    assert!(asked.iter().any(|task| task.action == TaskAction::Stop));
    for mut task in asked {
        let _ = site.link().publish(&task);
        // As another request of somebody else.
        task.stamp.boot_id += 1;
        let _ = site.link().publish(&task);
        site.listen(Duration::from_millis(20));
        assert_ne!(site.heard.phase(), Some(ControllerPhase::Ready));
    }
}

/// One bit in every hundredth message is wrong, and nobody believes it.
#[test]
fn with_a_key_wrong_bits_are_lost_messages() {
    let _alone = alone();
    let (_directory, mut site) = under_a_key(Setting {
        impairment: Impairment {
            corruption: 0.01,
            seed: 7,
            ..Impairment::default()
        },
        ..patient()
    });
    until_settled(&mut site);
    // The contact itself rings after the impact.
    let mut force_n = 0.0;
    for _ in 0..50 {
        site.listen(Duration::from_millis(20));
        force_n += site.heard.truth.unwrap().contact_force.z / 50.0;
    }
    assert_eq!(site.heard.robot.unwrap().fault, Fault::None);
    assert!((force_n - 10.0).abs() < 0.5, "{force_n} N");
    assert!(
        counts(&site)
            .iter()
            .all(|[refused, undecodable]| refused + undecodable > 0)
    );
}

/// By name, in both directions, and until they agree.
#[test]
fn with_and_without_a_key_nodes_refuse_each_other() {
    let _alone = alone();
    let (_directory, mut site) = under_a_key(patient());
    site.cell.kill(Role::Controller);
    let with = site.bench.plan.clone();
    let mut without = with.clone();
    without.flags[Role::Controller as usize].clear();
    site.heard = Default::default();
    site.cell.start_another(&without, Role::Controller).unwrap();
    let refused = |status: &spatial::ports::NodeStatus| {
        status.state == NodeState::Fault && status.fault == Fault::HelloMismatch
    };
    let both = site.until(LONG, |heard| {
        [Role::Robot, Role::Controller]
            .iter()
            .all(|role| heard.nodes[*role as usize].as_ref().is_some_and(refused))
    });
    assert!(both, "{:?}", site.heard.nodes);
    for (role, own) in [(Role::Robot, 1), (Role::Controller, 0)] {
        let status = site.heard.nodes[role as usize].unwrap();
        assert_eq!(
            (status.fault_expected, status.fault_found),
            (own, 1 - own),
            "{role:?}"
        );
        assert_eq!(i64::from(status.authenticated), own);
    }
    assert!(site.until(LONG, |heard| heard.robot.is_some()));
    assert_eq!(site.heard.robot.unwrap().mode, RobotMode::Idle);
    site.cell.kill(Role::Controller);
    site.cell.start_another(&with, Role::Controller).unwrap();
    site.heard.controller = None;
    until_settled(&mut site);
}
