use super::*;
use node::clock;
use node::health::Health;
use spatial::ports::Hello;
use std::path::Path;

const CELL: &str = "scenario = \"paper\"\nset = [\"timing.mode=realtime\"]\nrun_id = 7\n\
                    url = \"udpm://239.255.76.67:7667?ttl=1\"\n[controller]\nhost = \"control-pc\"\n\
                    [robot-sim]\nhost = \"robot-pc\"\n";

struct Heard {
    watch: Watch,
    start: Instant,
}

impl Heard {
    fn new() -> Self {
        let cell = CellConfig::parse("cell.toml", CELL, Path::new(".")).unwrap();
        let start = clock::now();
        Self {
            watch: Watch::new(&cell, start),
            start,
        }
    }

    fn at(&self, ms: u64) -> Instant {
        self.start + Duration::from_millis(ms)
    }

    fn hear(&mut self, status: &NodeStatus, ms: u64) -> Vec<String> {
        let now = self.at(ms);
        texts(self.watch.hear(status, now))
    }

    fn look(&mut self, ms: u64) -> Vec<String> {
        let now = self.at(ms);
        texts(self.watch.look(now))
    }
}

fn texts(events: Vec<Event>) -> Vec<String> {
    events
        .into_iter()
        .map(|event| format!("{}: {}", event.node, event.event))
        .collect()
}

fn status(role: Role, boot_id: i64, state: NodeState) -> NodeStatus {
    let hello = Hello {
        run_id: 7,
        ..Hello::default()
    };
    let mut status = Health::new(role, hello).status();
    status.stamp.boot_id = boot_id;
    status.state = state;
    status
}

#[test]
fn one_line_per_change() {
    let mut heard = Heard::new();
    let running = |role, boot_id| status(role, boot_id, NodeState::Running);
    assert_eq!(
        heard.hear(&status(Role::Robot, 1, NodeState::Starting), 0),
        ["robot-sim: heard: starting"]
    );
    assert_eq!(heard.hear(&running(Role::Robot, 1), 100), ["robot-sim: running"]);
    assert!(heard.hear(&running(Role::Robot, 1), 200).is_empty());
    assert_eq!(
        heard.hear(&running(Role::Sensor, 2), 200),
        ["sensor-sim: heard: running"]
    );
    assert_eq!(
        heard.hear(&running(Role::Controller, 3), 200),
        [
            "controller: heard: running",
            "cell: all nodes work with each other"
        ]
    );
    assert!(heard.hear(&running(Role::Controller, 3), 300).is_empty());
}

#[test]
fn silence_a_restart_and_a_second_process_are_told_once() {
    let mut heard = Heard::new();
    let robot = |boot_id| status(Role::Robot, boot_id, NodeState::Running);
    heard.hear(&robot(1), 0);
    assert!(heard.look(1900).is_empty());
    assert_eq!(heard.look(2000), ["robot-sim: silent for 2 s"]);
    assert!(heard.look(2100).is_empty());
    assert_eq!(heard.hear(&robot(1), 2200), ["robot-sim: heard again: running"]);
    assert_eq!(
        heard.hear(&robot(2), 2300),
        ["robot-sim: a second process plays this role; end one of them"]
    );
    assert!(heard.hear(&robot(2), 2400).is_empty());
    assert_eq!(heard.hear(&robot(3), 2800), ["robot-sim: started anew: running"]);
}

#[test]
fn who_does_not_come_is_asked_for_with_the_command_that_starts_it() {
    let mut heard = Heard::new();
    heard.hear(&status(Role::Robot, 1, NodeState::Running), 4900);
    assert!(heard.look(4990).is_empty());
    let asked = heard.look(5000);
    assert_eq!(asked.len(), 2, "{asked:?}");
    assert!(asked[0].starts_with("sensor-sim: not heard for 5 s; start what plays this role"));
    assert!(
        asked[1].contains("start it there: touchdown up cell.toml --host control-pc"),
        "{asked:?}"
    );
    assert!(heard.look(5100).is_empty());
}

#[test]
fn another_cell_is_told_and_not_listened_to() {
    let mut heard = Heard::new();
    let mut foreign = status(Role::Robot, 1, NodeState::Running);
    foreign.hello.run_id = 8;
    let told = heard.hear(&foreign, 0);
    assert!(told[0].contains("belongs to run 8, not to 7"), "{told:?}");
    assert!(heard.hear(&foreign, 100).is_empty());
    assert!(heard.look(3000).is_empty());
}

#[test]
fn a_mismatch_names_what_differs() {
    let mut heard = Heard::new();
    heard.hear(&status(Role::Robot, 1, NodeState::Running), 0);
    let mut controller = status(Role::Controller, 2, NodeState::Fault);
    controller.hello.seed = 5;
    controller.fault = Fault::HelloMismatch;
    controller.fault_peer = Role::Robot;
    let told = heard.hear(&controller, 100);
    assert_eq!(
        told,
        [
            "controller: heard: fault: hello mismatch: robot-sim has seed 0, here it is 5; start all nodes with the same \
          scenario file and the same --set"
        ]
    );
}
