//! `touchdown up`: a cell from one file, on one host and on two.

use lcmtypes::LcmBuilder;
use node::clock;
use rustix::process::Signal;
use spatial::ports::{RobotMode, RobotState};
use std::fs;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::Duration;
use tests::{Bench, processes_naming, signal, touchdown, wait_for_end};

/// How long something may take that has to come.
const LONG: Duration = Duration::from_secs(30);
const WHOLE: &str = "all nodes work with each other";

/// A `touchdown up` and what it says.
struct Up {
    child: Child,
    lines: crossbeam::channel::Receiver<String>,
}

impl Up {
    fn start(mut command: Command) -> Self {
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
    fn until(&self, text: &str) -> String {
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
    fn end(mut self) -> i32 {
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
fn cell(bench: &Bench, name: &str, run_id: i64) -> PathBuf {
    let file = bench.directory.path().join(name);
    let (device, world) = (&bench.plan.wiring.device[0], &bench.plan.wiring.world[0]);
    let nodes = ["robot-sim", "sensor-sim", "controller"].map(|node| format!("[{node}]\nhost = \"here\"\n"));
    let text = format!(
        "scenario = \"paper\"\nset = [\"timing.mode=realtime\", \"robot.command_gap_s=0.25\"]\nrun_id = {run_id}\n\
         url = \"{device}\"\nsim_url = \"{world}\"\n{}",
        nodes.concat()
    );
    fs::write(&file, text).unwrap();
    file
}

fn up(file: &Path, arguments: &[&str]) -> Up {
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

/// Two hosts as nearly as one host has them: namespaces of network and name, joined by a cable.
#[test]
fn a_cell_on_two_hosts_from_one_file() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path();
    let text = "scenario = \"paper\"\nset = [\"timing.mode=realtime\", \"robot.command_gap_s=0.25\"]\nrun_id = 7\n\
                url = \"udpm://239.255.76.67:7667?ttl=1\"\n[robot-sim]\nhost = \"robot-pc\"\n[sensor-sim]\n\
                host = \"robot-pc\"\n[controller]\nhost = \"control-pc\"\n";
    fs::write(path.join("cell.toml"), text).unwrap();
    let script = "set -e\n\
         mount -t tmpfs tmpfs /run\n\
         mkdir /run/netns\n\
         hostname robot-pc\n\
         ip link set lo up\n\
         ip netns add other\n\
         ip link add veth0 type veth peer name veth1 netns other\n\
         ip addr add 10.77.0.1/24 dev veth0\n\
         ip link set veth0 up\n\
         ip route add 224.0.0.0/4 dev veth0\n\
         ip netns exec other sh -ec 'ip link set lo up; ip addr add 10.77.0.2/24 dev veth1; ip link set veth1 up; \
         ip route add 224.0.0.0/4 dev veth1'\n\
         echo ready\n\
         ip netns exec other unshare --uts sh -c 'hostname control-pc; exec \"$0\" up \"$1\"' \"$1\" \"$2\" >control.txt 2>&1 &\n\
         other=$!\n\
         \"$1\" up \"$2\" &\n\
         own=$!\n\
         read -r _\n\
         ip netns exec other \"$1\" task stop --cell \"$2\" && echo 'answered from there'\n\
         read -r _\n\
         kill $other $own\n\
         wait $other && wait $own && echo 'ended well'\n";
    let mut command = Command::new("unshare");
    command
        .args([
            "-Urnmp",
            "--uts",
            "--fork",
            "--kill-child",
            "sh",
            "-c",
            script,
            "sh",
        ])
        .arg(tests::programs().join("touchdown"))
        .arg("cell.toml")
        .current_dir(path)
        .stdin(Stdio::piped());
    let mut hosts = Up::start(command);
    let first = hosts.lines.recv_timeout(LONG);
    if first.as_deref() != Ok("ready") {
        assert!(
            std::env::var_os("CI").is_none(),
            "namespaces are not allowed here"
        );
        eprintln!(
            "SKIPPED: this host does not allow namespaces joined by a veth (unshare -Urnmp --uts, ip link add)"
        );
        return;
    }
    hosts.until("here, on robot-pc: sensor-sim, robot-sim");
    hosts.until("on control-pc, for controller: touchdown up cell.toml --host control-pc");
    hosts.until("controller  control-pc    heard");
    hosts.until(WHOLE);
    let mut input = hosts.child.stdin.take().unwrap();
    std::io::Write::write_all(&mut input, b"\n").unwrap();
    hosts.until("answered from there");
    std::io::Write::write_all(&mut input, b"\n").unwrap();
    hosts.until("ended well");
    assert_eq!(hosts.child.wait().unwrap().code(), Some(0));
    let control = fs::read_to_string(path.join("control.txt")).unwrap();
    assert!(control.contains(WHOLE), "{control}");
}
