//! `touchdown up`: a cell from one file, on one host and on two.

use lcmtypes::LcmBuilder;
use node::clock;
use rustix::process::Signal;
use spatial::ports::{RobotMode, RobotState, Role};
use std::fs;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::Duration;
use tests::hosts::on_hosts;
use tests::{Bench, processes_naming, programs, signal, touchdown, wait_for_end};

/// How long something may take that has to come.
pub(crate) const LONG: Duration = Duration::from_secs(30);
pub(crate) const WHOLE: &str = "all nodes work with each other";

/// A `touchdown up` (or another program that runs until it is told to end) and what it says.
pub(crate) struct Up {
    child: Child,
    lines: crossbeam::channel::Receiver<String>,
}

impl Up {
    pub(crate) fn start(mut command: Command) -> Self {
        let mut child = command
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let (sender, lines) = crossbeam::channel::unbounded();
        let stdout = child.stdout.take().unwrap();
        std::thread::spawn(move || {
            for line in BufReader::new(stdout).lines().map_while(Result::ok) {
                let _ = sender.send(line);
            }
        });
        Self { child, lines }
    }

    /// Read until a line contains `text`; that line.
    pub(crate) fn until(&self, text: &str) -> String {
        let give_up = clock::now() + LONG;
        let mut all = Vec::new();
        while let Ok(line) = self.lines.recv_deadline(give_up) {
            if line.contains(text) {
                return line;
            }
            all.push(line);
        }
        panic!("no line with {text:?} in {all:#?}");
    }

    /// Ask it to end; its exit code.
    pub(crate) fn end(mut self) -> i32 {
        signal(self.child.id(), Signal::TERM);
        self.child.wait().unwrap().code().unwrap()
    }
}

impl Drop for Up {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// A cell on the ports of `bench`, in a file of its directory; all nodes on the host `here`.
pub(crate) fn cell(bench: &Bench, name: &str, run_id: i64) -> PathBuf {
    let file = bench.directory.path().join(name);
    let (device, world) = (&bench.plan.wiring.device[0], &bench.plan.wiring.world[0]);
    let nodes = ["robot-sim", "sensor-sim", "controller"].map(|node| format!("[{node}]\nhost = \"here\"\n"));
    let text = format!(
        "scenario = \"paper\"\nset = [\"timing.mode=realtime\", \"robot.command_gap_s=0.25\", \"controller.stale_fault_s=0.25\"]\nrun_id = {run_id}\n\
         url = \"{device}\"\nsim_url = \"{world}\"\n{}",
        nodes.concat()
    );
    fs::write(&file, text).unwrap();
    file
}

pub(crate) fn up(file: &Path, arguments: &[&str]) -> Up {
    let mut command = touchdown();
    command
        .arg("up")
        .arg(file)
        .args(["--host", "here"])
        .args(arguments);
    Up::start(command)
}

fn task(file: &Path, action: &str) -> Output {
    let mut command = touchdown();
    command
        .args(["task", action, "--cell"])
        .arg(file)
        .output()
        .unwrap()
}

/// Wait until the robot follows commands: only then it misses them.
fn until_following(bench: &Bench) {
    let mut link = LcmBuilder::open(&bench.plan.wiring.watch).unwrap();
    let states = link.subscribe::<RobotState>(64);
    let _link = link.start().unwrap();
    let give_up = clock::now() + LONG;
    let follows = std::iter::from_fn(|| states.receiver().recv_deadline(give_up).ok())
        .any(|received| received.message.mode == RobotMode::Following);
    assert!(follows);
}

/// The process of `node` in the cell on the port of `bench`.
fn process(bench: &Bench, node: &str) -> u32 {
    let url = &bench.plan.wiring.device[0];
    let named = processes_naming(url).into_iter().find(|id| {
        let program = fs::read_link(format!("/proc/{id}/exe")).unwrap_or_default();
        program.ends_with(node)
    });
    named.expect("the node runs") as u32
}

#[test]
fn a_cell_comes_up_is_asked_and_ends() {
    let bench = Bench::new(&[]).unwrap();
    let file = cell(&bench, "cell.toml", 7);
    let cell_up = up(&file, &[]);
    cell_up.until("here, on here: sensor-sim, controller, robot-sim");
    cell_up.until(WHOLE);

    // The controller pauses: the robot stops, and stays where it is until it is reset, and so does the controller.
    until_following(&bench);
    let controller = process(&bench, "controller");
    signal(controller, Signal::STOP);
    cell_up.until("fault: command gap");
    signal(controller, Signal::CONT);
    let stopped = task(&file, "start");
    assert_eq!(stopped.status.code(), Some(1), "{stopped:?}");
    // Once, as people do: it asks again by itself as long as the robot is not at rest.
    let reset = task(&file, "reset");
    assert_eq!(reset.status.code(), Some(0), "{reset:?}");
    cell_up.until(WHOLE);

    // Another cell on the same port by mistake.
    let other = up(&cell(&bench, "other.toml", 8), &["--node", "controller"]);
    cell_up.until("belongs to run 8, not to 7");
    other.until("belongs to run 7, not to 8");
    drop(other);

    let nodes = processes_naming(&bench.plan.wiring.device[0]);
    assert!(nodes.len() >= 3, "{nodes:?}");
    assert_eq!(cell_up.end(), 0);
    assert!(nodes.into_iter().all(|id| wait_for_end(id, LONG)));
}

#[test]
fn a_node_that_dies_is_told_taken_back_and_shows_in_the_exit_code() {
    let bench = Bench::new(&[]).unwrap();
    let file = cell(&bench, "cell.toml", 7);
    let most = up(&file, &[]);
    most.until(WHOLE);
    signal(process(&bench, "controller"), Signal::KILL);
    most.until("controller  here          has died (signal 9)");
    // A supervisor starts it again.
    let again = up(&file, &["--node", "controller"]);
    again.until("here, on here: controller");
    most.until("started anew");
    assert_eq!(again.end(), 0);
    assert_eq!(most.end(), 1);
}

#[test]
fn without_nodes_it_ends_by_itself() {
    let bench = Bench::new(&[]).unwrap();
    let mut alone = up(&cell(&bench, "cell.toml", 7), &["--node", "sensor-sim"]);
    alone.until("sensor-sim");
    alone.until("heard: starting");
    signal(process(&bench, "sensor-sim"), Signal::KILL);
    alone.until("has died (signal 9)");
    assert_eq!(alone.child.wait().unwrap().code(), Some(1));
}

#[test]
fn a_cell_on_two_hosts_from_one_file() {
    on_hosts("up::a_cell_on_two_hosts_from_one_file", |hosts| {
        let directory = tempfile::tempdir().unwrap();
        let file = directory.path().join("cell.toml");
        let text = "scenario = \"paper\"\nset = [\"timing.mode=realtime\", \"robot.command_gap_s=0.25\"]\nrun_id = 7\n\
                    url = \"udpm://239.255.76.67:7667?ttl=1\"\n[robot-sim]\nhost = \"robot\"\n[sensor-sim]\n\
                    host = \"robot\"\n[controller]\nhost = \"controller\"\n";
        fs::write(&file, text).unwrap();
        let touchdown = programs().join("touchdown");
        let up = |role| {
            let mut command = hosts.command(role, &touchdown);
            command.arg("up").arg(&file);
            Up::start(command)
        };
        let robots = up(Role::Robot);
        robots.until("here, on robot: sensor-sim, robot-sim");
        robots.until("on controller, for controller: touchdown up");
        let controllers = up(Role::Controller);
        robots.until("controller  controller    heard");
        robots.until(WHOLE);
        controllers.until(WHOLE);
        let mut stop = hosts.command(Role::Controller, &touchdown);
        let answer = stop.args(["task", "stop", "--cell"]).arg(&file).output().unwrap();
        assert_eq!(answer.status.code(), Some(0), "{answer:?}");
        assert_eq!([robots.end(), controllers.end()], [0, 0]);
    });
}
