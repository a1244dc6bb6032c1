//! Nodes started by hand, without a launcher: their faults are named in NODE_STATUS.

use super::watch::terminal;
use lcmtypes::{EventLogReader, Lcm, LcmBuilder, Subscription};
use node::clock;
use rustix::process::Signal;
use spatial::ports::{Fault, NodeStatus, Role};
use std::io::{BufRead, BufReader};
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::time::Duration;
use tests::{Bench, programs, signal, wait_for_end};

const LIMIT: Duration = Duration::from_secs(10);
const DAY: [&str; 2] = ["--set", "timing.duration_s=86400"];

/// A node; dropping it ends it.
struct Node(Child);

impl Node {
    fn start(bench: &Bench, role: Role, arguments: &[&str]) -> Self {
        Self::start_with(bench, role, arguments, Stdio::null())
    }

    fn start_with(bench: &Bench, role: Role, arguments: &[&str], stderr: Stdio) -> Self {
        let program = Command::new(program(role));
        Self(
            Self::of(program, bench, role, arguments)
                .stderr(stderr)
                .spawn()
                .unwrap(),
        )
    }

    /// `program`, or what starts it, with the arguments of a node.
    fn of(mut command: Command, bench: &Bench, role: Role, arguments: &[&str]) -> Command {
        let wiring = &bench.plan.wiring;
        command
            .arg("--scenario")
            .arg(&bench.plan.scenario)
            .args(["--url", &wiring.device[role as usize]])
            .args(["--sim-url", &wiring.world[role as usize]])
            .args(["--with-parent", &std::process::id().to_string()])
            .args(arguments);
        command
    }
}

fn program(role: Role) -> PathBuf {
    programs().join(node::greeting::role_name(role))
}

impl Drop for Node {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// What the nodes of a bench say of themselves.
struct Watch {
    _link: Lcm,
    statuses: Subscription<NodeStatus>,
}

impl Watch {
    fn start(bench: &Bench) -> Self {
        let mut link = LcmBuilder::open(&bench.plan.wiring.watch).unwrap();
        let statuses = link.subscribe(64);
        Self {
            _link: link.start().unwrap(),
            statuses,
        }
    }

    /// The first status of `role` that is `wanted`.
    fn until(&self, role: Role, wanted: impl Fn(&NodeStatus) -> bool) -> NodeStatus {
        let give_up = clock::now() + LIMIT;
        std::iter::from_fn(|| self.statuses.receiver().recv_deadline(give_up).ok())
            .map(|received| received.message)
            .find(|status| status.role == role && wanted(status))
            .expect("the node says what is wrong")
    }

    fn fault(&self, role: Role) -> NodeStatus {
        self.until(role, |status| status.fault != Fault::None)
    }
}

#[test]
fn nodes_with_different_configurations_refuse_each_other_with_both_values() {
    let bench = Bench::new(&[]).unwrap();
    let watch = Watch::start(&bench);
    let _nodes = [
        Node::start(&bench, Role::Sensor, &["--set", "sensor.delay_ticks=8"]),
        Node::start(&bench, Role::Controller, &[]),
        Node::start(&bench, Role::Robot, &[]),
    ];
    let refused = watch.fault(Role::Robot);
    assert_eq!(
        (refused.fault, refused.fault_peer),
        (Fault::HelloMismatch, Role::Sensor)
    );
    assert_eq!(refused.fault_expected, refused.hello.configuration_hash);
    assert_ne!(refused.fault_found, refused.fault_expected);
}

/// A robot that has given up tells it now and then, and does not flood the network.
#[test]
fn a_lone_robot_names_who_is_missing_and_keeps_calm() {
    let bench = Bench::new(&[]).unwrap();
    let watch = Watch::start(&bench);
    let _robot = Node::start(&bench, Role::Robot, &[]);
    let alone = watch.fault(Role::Robot);
    assert_eq!((alone.fault, alone.fault_peer), (Fault::PeerSilent, Role::Sensor));
    let end = clock::now() + Duration::from_secs(1);
    let count = std::iter::from_fn(|| watch.statuses.receiver().recv_deadline(end).ok()).count();
    assert!((1..=20).contains(&count), "{count} statuses in a second");
}

/// In real time nodes start in any order: who is missing is told, and waited for.
#[test]
fn a_lone_node_in_real_time_names_who_is_missing_and_waits() {
    let bench = Bench::new(&[]).unwrap();
    let watch = Watch::start(&bench);
    let real = ["--set", "timing.mode=realtime"];
    let mut controller = Node::start_with(&bench, Role::Controller, &real, Stdio::piped());
    let (sender, lines) = crossbeam::channel::unbounded();
    let stderr = BufReader::new(controller.0.stderr.take().unwrap());
    std::thread::spawn(move || {
        stderr
            .lines()
            .map_while(Result::ok)
            .try_for_each(|line| sender.send(line))
    });
    let give_up = clock::now() + LIMIT;
    let told = std::iter::from_fn(|| lines.recv_deadline(give_up).ok())
        .any(|line| line.contains("no answer to the greeting from robot-sim and sensor-sim for 3 s"));
    assert!(told);
    let _others = [Role::Sensor, Role::Robot].map(|role| Node::start(&bench, role, &real));
    watch.until(Role::Robot, |status| status.stamp.step >= 250);
    let waited = watch.until(Role::Controller, |status| status.stamp.step >= 250);
    assert_eq!(waited.fault, Fault::None);
}

#[test]
fn a_sensor_restarted_in_the_middle_is_refused() {
    let bench = Bench::new(&[]).unwrap();
    let watch = Watch::start(&bench);
    let [sensor, _controller, _robot] =
        [Role::Sensor, Role::Controller, Role::Robot].map(|role| Node::start(&bench, role, &DAY));
    watch.until(Role::Robot, |status| status.stamp.step >= 250);
    drop(sensor);
    let _restarted = Node::start(&bench, Role::Sensor, &DAY);
    let broken = watch.fault(Role::Robot);
    assert_eq!(
        (broken.fault, broken.fault_peer),
        (Fault::LockstepBroken, Role::Sensor)
    );
    assert!(broken.fault_step >= 250, "{broken:?}");
}

#[test]
fn a_full_disk_is_a_named_fault_of_the_node_that_records() {
    let bench = Bench::new(&[]).unwrap();
    let watch = Watch::start(&bench);
    let _nodes = [
        Node::start(
            &bench,
            Role::Sensor,
            &[&DAY[..], &["--record", "/dev/full"]].concat(),
        ),
        Node::start(&bench, Role::Controller, &DAY),
        Node::start(&bench, Role::Robot, &DAY),
    ];
    let full = watch.fault(Role::Sensor);
    assert_eq!((full.fault, full.fault_peer), (Fault::RecordFailed, Role::Sensor));
}

/// By each signal that a person, a supervisor or a terminal sends, and not by that of a pipe without a reader.
#[test]
fn a_node_that_is_asked_to_end_ends_well() {
    let bench = Bench::new(&[]).unwrap();
    let watch = Watch::start(&bench);
    let [mut sensor, mut controller, mut robot] =
        [Role::Sensor, Role::Controller, Role::Robot].map(|role| Node::start(&bench, role, &DAY));
    watch.until(Role::Robot, |status| status.stamp.step >= 250);
    for node in [&robot, &controller, &sensor] {
        signal(node.0.id(), Signal::PIPE);
    }
    watch.until(Role::Robot, |status| status.stamp.step >= 750);
    for (node, asked) in [
        (&mut robot, Signal::TERM),
        (&mut controller, Signal::INT),
        (&mut sensor, Signal::HUP),
    ] {
        signal(node.0.id(), asked);
        assert!(node.0.wait().unwrap().success());
    }
}

/// A terminal, or a pipe, that is gone: what would be told there is lost, and nothing else.
#[test]
fn a_node_whose_stderr_is_gone_works() {
    let bench = Bench::new(&[]).unwrap();
    let watch = Watch::start(&bench);
    let gone = || {
        let (reader, writer) = std::io::pipe().unwrap();
        drop(reader);
        Stdio::from(writer)
    };
    let mut nodes = [Role::Sensor, Role::Controller, Role::Robot]
        .map(|role| Node::start_with(&bench, role, &DAY, gone()));
    watch.until(Role::Robot, |status| status.stamp.step >= 250);
    for node in &mut nodes {
        signal(node.0.id(), Signal::TERM);
        assert!(node.0.wait().unwrap().success());
    }
}

/// A robot in a terminal of its own, which is closed: it ends as if it had been asked to, and its record is whole.
#[test]
fn a_node_whose_terminal_is_closed_ends_well() {
    let bench = Bench::new(&[]).unwrap();
    let watch = Watch::start(&bench);
    let _others = [Role::Sensor, Role::Controller].map(|role| Node::start(&bench, role, &DAY));
    let (seen, given) = terminal();
    let directory = tempfile::tempdir().unwrap();
    let record = directory.path().join("robot.lcmlog");
    // The leader of a session is whom the kernel tells that its terminal is gone.
    let mut in_terminal = Command::new("setsid");
    in_terminal.arg("--ctty").arg(program(Role::Robot));
    let arguments = [&DAY[..], &["--record", record.to_str().unwrap()]].concat();
    let mut in_terminal = Node::of(in_terminal, &bench, Role::Robot, &arguments);
    in_terminal
        .stdin(given.try_clone().unwrap())
        .stdout(given.try_clone().unwrap())
        .stderr(given);
    let mut robot = Node(in_terminal.spawn().unwrap());
    drop(in_terminal);
    watch.until(Role::Robot, |status| status.stamp.step >= 250);
    drop(seen);
    assert!(wait_for_end(robot.0.id() as i32, LIMIT), "its terminal is gone");
    assert!(robot.0.wait().unwrap().success());
    let events: Vec<_> = EventLogReader::open(&record)
        .unwrap()
        .map(Result::unwrap)
        .collect();
    assert!(events.len() > 250, "{}", events.len());
}
