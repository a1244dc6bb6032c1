//! The command `touchdown` where things go wrong: it says why, and leaves nothing running.

use lcmtypes::LcmBuilder;
use rustix::process::Signal;
use spatial::ports::Task;
use std::fs;
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};
use std::time::Duration;
use tests::{Bench, processes_naming, programs, signal, touchdown, wait_for_end};

const LIMIT: Duration = Duration::from_secs(10);

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

/// Start an endless run.
fn endless(directory: &Path) -> Child {
    let mut command = run_into(directory);
    command.args(["--set", "timing.duration_s=86400", "--laws", "proposed"]);
    command
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap()
}

/// Wait until `count` nodes of the run are there, and until `ready` says so.
fn nodes(run: &mut Child, directory: &Path, count: usize, ready: impl Fn() -> bool) -> Vec<i32> {
    loop {
        assert!(run.try_wait().unwrap().is_none(), "the run ended on its own");
        let nodes: Vec<i32> = processes_naming(directory.to_str().unwrap())
            .into_iter()
            .filter(|id| *id != run.id() as i32)
            .collect();
        if nodes.len() >= count && ready() {
            return nodes;
        }
        std::thread::yield_now();
    }
}

/// Start an endless run and wait until its nodes are at work.
fn started(directory: &Path) -> (Child, Vec<i32>) {
    let mut child = endless(directory);
    let recorded = || {
        let entries = fs::read_dir(directory).into_iter().flatten().flatten();
        entries
            .into_iter()
            .any(|entry| entry.path().join("robot-sim.lcmlog").exists())
    };
    let nodes = nodes(&mut child, directory, 3, recorded);
    (child, nodes)
}

fn assert_interrupted(run: Child, directory: &Path, nodes: Vec<i32>) {
    signal(run.id(), Signal::INT);
    let output = run.wait_with_output().unwrap();
    let message = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(130), "{message}");
    assert!(
        message.ends_with("error: interrupted; all nodes are stopped\n"),
        "{message}"
    );
    assert!(nodes.into_iter().all(|id| wait_for_end(id, LIMIT)));
    assert_eq!(processes_naming(directory.to_str().unwrap()), Vec::<i32>::new());
    assert_eq!(fs::read_dir(directory).unwrap().count(), 0);
}

#[test]
fn an_interrupted_run_leaves_nothing() {
    let directory = tempfile::tempdir().unwrap();
    let (child, nodes) = started(directory.path());
    assert_interrupted(child, directory.path(), nodes);
}

#[test]
fn a_run_interrupted_while_it_starts_leaves_nothing() {
    for count in 1..=3 {
        let directory = tempfile::tempdir().unwrap();
        let mut child = endless(directory.path());
        let nodes = nodes(&mut child, directory.path(), count, || true);
        assert_interrupted(child, directory.path(), nodes);
    }
}

#[test]
fn an_interrupted_bench_says_so() {
    let scratch = tempfile::tempdir().unwrap();
    let mut command = touchdown();
    command
        .args(["bench", "network", "--set", "timing.duration_s=86400"])
        .env("TMPDIR", scratch.path());
    let mut child = command
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let nodes = nodes(&mut child, scratch.path(), 3, || true);
    assert_interrupted(child, scratch.path(), nodes);
}

#[test]
fn a_latched_fault_is_no_good_run() {
    for (changes, fault) in [
        (
            // The controller takes the range for wider than it is.
            &[
                "robot.gantry.axis_maximum_rad=[1.0,1.0,1.0,1.5,0.001,1.5]",
                "controller.limits.axis_margin_rad=-0.1",
            ] as &[&str],
            "robot-sim latched AxisLimit at tick ",
        ),
        (&["object.height_m=-0.5"], "controller latched NoContact at tick "),
    ] {
        let directory = tempfile::tempdir().unwrap();
        let changes = changes.iter().flat_map(|change| ["--set", change]);
        let (code, message) = failed(
            run_into(directory.path())
                .args(["--laws", "proposed"])
                .args(changes),
        );
        assert_eq!(code, 1, "{message}");
        assert!(message.contains(fault), "{message}");
        assert!(directory.path().join("proposed.csv").exists());
    }
}

#[test]
fn a_killed_launcher_takes_its_nodes_along() {
    let directory = tempfile::tempdir().unwrap();
    let (mut child, nodes) = started(directory.path());
    child.kill().unwrap();
    child.wait().unwrap();
    assert!(nodes.into_iter().all(|id| wait_for_end(id, LIMIT)));
}
