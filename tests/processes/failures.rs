//! What goes wrong at the start or in the middle ends with a clear message, and nothing is left running.

use experiment::launch::{self, Cell, LaunchError};
use lcmtypes::LcmBuilder;
use rustix::process::{Pid, Signal, kill_process};
use spatial::ports::{Fault, Role, Task};
use std::fs;
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::time::Duration;
use tests::{Bench, processes_naming, programs, touchdown, wait_for_end};

const LIMIT: Duration = Duration::from_secs(10);

/// An experiment that lasts until somebody ends it.
fn endless() -> Bench {
    Bench::new(&["timing.duration_s=86400"]).unwrap()
}

fn signal(id: u32, signal: Signal) {
    kill_process(Pid::from_raw(id as i32).unwrap(), signal).unwrap();
}

/// Watch a cell that is hurt once its robot has reached tick 250; the error it ends with.
fn hurt(bench: &Bench, mut injure: impl FnMut(&Cell)) -> LaunchError {
    let never = crossbeam::channel::never();
    let mut cell = Cell::start(&bench.plan).unwrap();
    let (sender, reached) = crossbeam::channel::bounded(1);
    // Interrupt the watch once, to be able to use the cell.
    let progress = |tick: i64| {
        if tick >= 250 {
            let _ = sender.try_send(());
        }
    };
    assert!(matches!(
        cell.watch(&reached, progress),
        Err(LaunchError::Interrupted)
    ));
    injure(&cell);
    let error = cell.watch(&never, |_| ()).unwrap_err();
    drop(cell);
    assert_eq!(
        processes_naming(bench.directory.path().to_str().unwrap()),
        Vec::<i32>::new()
    );
    error
}

#[test]
fn a_killed_node_names_itself() {
    for (role, name) in [
        (Role::Robot, "robot-sim"),
        (Role::Sensor, "sensor-sim"),
        (Role::Controller, "controller"),
    ] {
        let error = hurt(&endless(), |cell| {
            signal(cell.process_id(role).unwrap(), Signal::KILL)
        });
        let message = error.to_string();
        assert!(
            message.starts_with(&format!("{name} died (signal 9) at tick ")),
            "{message}"
        );
    }
}

#[test]
fn a_frozen_peer_is_named_by_the_robot() {
    for role in [Role::Sensor, Role::Controller] {
        let error = hurt(&endless(), |cell| {
            signal(cell.process_id(role).unwrap(), Signal::STOP)
        });
        match error {
            LaunchError::Faulty {
                role: Role::Robot,
                fault: Fault::PeerSilent,
                peer,
                ..
            } => assert_eq!(peer, role),
            LaunchError::Silent {
                role: Role::Robot, ..
            } => {}
            other => panic!("{other}"),
        }
    }
}

#[test]
fn a_second_robot_on_the_same_port_is_refused_by_run_id() {
    let bench = endless();
    let mut other = endless();
    other.plan.wiring = bench.plan.wiring.clone();
    let _first = Cell::start(&bench.plan).unwrap();
    let never = crossbeam::channel::never();
    let mut second = Cell::start(&other.plan).unwrap();
    let error = second.watch(&never, |_| ()).unwrap_err();
    assert!(
        matches!(
            error,
            LaunchError::Faulty {
                fault: Fault::HelloMismatch,
                ..
            }
        ),
        "{error}"
    );
}

#[test]
fn nodes_with_different_configurations_refuse_each_other_with_both_values() {
    let bench = Bench::new(&[]).unwrap();
    let wiring = &bench.plan.wiring;
    let node = |name: &str, role: usize, change: &[&str]| {
        let mut command = Command::new(programs().join(name));
        command
            .arg("--scenario")
            .arg(&bench.plan.scenario)
            .args(["--url", &wiring.device[role]]);
        command
            .args(["--sim-url", &wiring.world[role], "--with-parent"])
            .args(change);
        command.stderr(Stdio::piped()).spawn().unwrap()
    };
    let sensor = node("sensor-sim", 1, &["--set", "sensor.delay_ticks=8"]);
    let controller = node("controller", 2, &[]);
    let robot = node("robot-sim", 0, &[]);
    let mut watch = LcmBuilder::open(&wiring.watch).unwrap();
    let statuses = watch.subscribe::<spatial::ports::NodeStatus>(64);
    let watch = watch.start().unwrap();
    let refused = std::iter::from_fn(|| statuses.receiver().recv_timeout(LIMIT).ok())
        .map(|received| received.message)
        .find(|status| status.role == Role::Robot && status.fault != Fault::None)
        .expect("the robot says why it does not run");
    assert_eq!(
        (refused.fault, refused.fault_peer),
        (Fault::HelloMismatch, Role::Sensor)
    );
    assert_eq!(refused.fault_expected, refused.hello.configuration_hash);
    assert_ne!(refused.fault_found, refused.fault_expected);
    drop(watch);
    for child in [sensor, controller, robot] {
        signal(child.id(), Signal::TERM);
        child.wait_with_output().unwrap();
    }
}

fn failed(command: &mut Command) -> (i32, String) {
    let Output {
        status,
        stdout,
        stderr,
    } = command.output().unwrap();
    assert!(
        stdout.is_empty(),
        "data on stdout: {}",
        String::from_utf8_lossy(&stdout)
    );
    (status.code().unwrap(), String::from_utf8(stderr).unwrap())
}

fn run_into(directory: &Path) -> Command {
    let mut command = touchdown();
    command.args(["run", "--out"]).arg(directory);
    command
}

#[test]
fn a_broken_scenario_is_refused_with_file_line_and_remedy() {
    let directory = tempfile::tempdir().unwrap();
    let file = directory.path().join("broken.toml");
    fs::write(&file, "[robot]\nfilter_frequency_hz = 1500\nmotor_mass = 3\n").unwrap();
    let (code, message) = failed(run_into(directory.path()).arg(&file));
    assert_eq!(code, 2, "{message}");
    let path = file.display();
    assert!(
        message.contains(&format!("{path}:2:")) && message.contains("1500 Hz"),
        "{message}"
    );
    assert!(
        message.contains(&format!("{path}:3:")) && message.contains("motor_mass"),
        "{message}"
    );
}

#[test]
fn a_missing_program_is_named() {
    let mut bench = Bench::new(&[]).unwrap();
    let programs = tempfile::tempdir().unwrap();
    std::os::unix::fs::symlink(
        bench.plan.programs.join("sensor-sim"),
        programs.path().join("sensor-sim"),
    )
    .unwrap();
    bench.plan.programs = programs.path().to_owned();
    let error = launch::run(&bench.plan, &crossbeam::channel::never(), |_| ())
        .unwrap_err()
        .to_string();
    assert!(
        error.starts_with("can't start ") && error.contains("controller"),
        "{error}"
    );
    assert_eq!(
        processes_naming(bench.directory.path().to_str().unwrap()),
        Vec::<i32>::new()
    );
}

#[test]
fn a_port_with_foreign_traffic_and_a_locked_one_are_refused() {
    let mut bench = Bench::new(&[]).unwrap();
    let port = bench.port().to_string();
    let (code, message) = failed(run_into(bench.directory.path()).args(["--port", &port]));
    assert_eq!(code, 1);
    assert!(
        message.contains(&port) && message.contains("another run"),
        "{message}"
    );

    let url = bench.plan.wiring.watch.clone();
    bench.release_ports();
    let foreign = LcmBuilder::open(&url).unwrap().start().unwrap();
    let (done, ended) = crossbeam::channel::bounded::<()>(0);
    let chatter = std::thread::spawn(move || {
        while ended.recv_timeout(Duration::from_millis(20))
            == Err(crossbeam::channel::RecvTimeoutError::Timeout)
        {
            foreign.publish(&Task::default()).unwrap();
        }
    });
    let (code, message) = failed(run_into(bench.directory.path()).args(["--port", &port]));
    drop(done);
    chatter.join().unwrap();
    assert_eq!(code, 1);
    assert!(message.contains(&port) && message.contains("TASK"), "{message}");
}

/// In a network namespace of its own without a route for multicast.
#[test]
fn without_a_multicast_route_the_remedy_is_named() {
    let isolated = |line: &str| {
        let mut command = Command::new("unshare");
        command.args(["--user", "--map-root-user", "--net", "sh", "-c", line]);
        command
    };
    if !isolated("true").status().is_ok_and(|status| status.success()) {
        eprintln!("SKIPPED: this host does not allow network namespaces (unshare --user --net)");
        return;
    }
    let directory = tempfile::tempdir().unwrap();
    let program = programs().join("touchdown");
    let line = format!(
        "ip link set lo up && exec {} run --out {}",
        program.display(),
        directory.path().display()
    );
    let (code, message) = failed(&mut isolated(&line));
    assert_eq!(code, 1, "{message}");
    assert!(message.contains("ip route add 224.0.0.0/4 dev lo"), "{message}");
}

/// Start an endless run and wait until its nodes are there.
fn started(directory: &Path) -> (std::process::Child, Vec<i32>) {
    let mut command = run_into(directory);
    command.args(["--set", "timing.duration_s=86400", "--laws", "proposed"]);
    let mut child = command
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    // The records appear when the nodes have started; there is nothing to wait for but their processes.
    loop {
        assert!(child.try_wait().unwrap().is_none(), "the run ended on its own");
        let nodes: Vec<i32> = processes_naming(directory.to_str().unwrap())
            .into_iter()
            .filter(|id| *id != child.id() as i32)
            .collect();
        if nodes.len() == 3 && directory.join("robot-sim.lcmlog").exists() {
            return (child, nodes);
        }
        std::thread::yield_now();
    }
}

#[test]
fn an_interrupted_run_stops_its_nodes() {
    let directory = tempfile::tempdir().unwrap();
    let (child, nodes) = started(directory.path());
    signal(child.id(), Signal::INT);
    let output = child.wait_with_output().unwrap();
    assert_eq!(
        output.status.code(),
        Some(130),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    assert!(nodes.into_iter().all(|id| wait_for_end(id, LIMIT)));
}

#[test]
fn a_killed_launcher_takes_its_nodes_along() {
    let directory = tempfile::tempdir().unwrap();
    let (mut child, nodes) = started(directory.path());
    child.kill().unwrap();
    child.wait().unwrap();
    assert!(nodes.into_iter().all(|id| wait_for_end(id, LIMIT)));
}
