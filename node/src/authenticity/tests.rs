use super::*;
use crate::scenario::Scenario;
use lcmtypes::Encoded;
use spatial::kinematics::Axes;
use spatial::ports::{
    ClockEcho, DeflectionSample, ENCODER_SAMPLES, Fault, HORIZON, RobotMode, Stamp, TaskAction,
};

/// 0, 1, 2, ...
fn secret() -> [u8; KEY_BYTES] {
    std::array::from_fn(|i| i as u8)
}

fn keyring(secret: [u8; KEY_BYTES]) -> Keyring {
    Keyring::new(Key::new(&secret), Vec::new())
}

fn stamp(step: i64, boot_id: i64) -> Stamp {
    Stamp {
        step,
        utime: 1000 * step,
        boot_id,
    }
}

fn state(step: i64, boot_id: i64) -> RobotState {
    RobotState {
        stamp: stamp(step, boot_id),
        sample_count: 1,
        axis_position: [Axes::repeat(0.25); ENCODER_SAMPLES],
        axis_velocity: Axes::zeros(),
        axis_setpoint: Axes::zeros(),
        mode: RobotMode::Idle,
        fault: Fault::None,
        fault_axis: -1,
        command_step: -1,
        missed_commands: 0,
        echo: ClockEcho::default(),
        authenticity: Authenticity::default(),
    }
}

fn deflections(step: i64, boot_id: i64) -> Deflections {
    Deflections {
        stamp: stamp(step, boot_id),
        samples: [DeflectionSample::default(); 8],
        echo: ClockEcho::default(),
        authenticity: Authenticity::default(),
    }
}

fn command(step: i64, boot_id: i64) -> Command {
    Command {
        stamp: stamp(step, boot_id),
        enable: true,
        axis_position: [Axes::repeat(0.25); HORIZON],
        send_utime: 1000 * step,
        authenticity: Authenticity::default(),
    }
}

fn task(step: i64, boot_id: i64) -> Task {
    Task {
        stamp: stamp(step, boot_id),
        action: TaskAction::Start,
        ..Task::default()
    }
}

/// A cell whose nodes have the boot ids 1, 2, 3, and somebody who asks, with 4.
struct Cell {
    robot: Gate,
    sensor: Gate,
    controller: Gate,
    operator: Gate,
    step: i64,
}

/// What is said in a period.
struct Said {
    state: RobotState,
    command: Command,
    deflections: Deflections,
    task: Task,
}

impl Cell {
    fn new() -> Self {
        let keyring = keyring(secret());
        Self {
            robot: Gate::of_robot(keyring.clone(), &[7; KEY_BYTES]),
            sensor: Gate::new(keyring.clone(), Author::Sensor),
            controller: Gate::new(keyring.clone(), Author::Controller),
            operator: Gate::of_operator(keyring, 1_000_000),
            step: 0,
        }
    }

    /// Everybody speaks once, in the order of a period, `controller` as that process; nobody listens yet.
    fn say(&mut self, controller: i64) -> Said {
        self.step += 4;
        let mut state = state(self.step, 1);
        self.robot.sign(&mut state);
        let mut command = command(self.step, controller);
        self.controller.sign(&mut command);
        let mut deflections = deflections(self.step, 2);
        self.sensor.sign(&mut deflections);
        let mut task = task(self.step, 4);
        self.operator.sign(&mut task);
        Said {
            state,
            command,
            deflections,
            task,
        }
    }

    /// Everybody hears; whether each took what it should.
    fn hear(&mut self, said: &Said) -> [Result<(), Refusal>; 7] {
        let states = [&mut self.controller, &mut self.operator].map(|gate| gate.admit(&said.state));
        let [controller, operator] = states;
        [
            controller,
            operator.and(self.controller.admit(&said.task)),
            self.controller.admit(&said.deflections),
            self.sensor.admit(&said.command),
            self.robot.admit(&said.command),
            self.robot.admit(&said.deflections),
            self.robot.admit(&said.task),
        ]
    }

    /// Periods until all is taken.
    fn settle(&mut self, controller: i64) -> usize {
        let settled = (0..20).find(|_| {
            let said = self.say(controller);
            self.hear(&said).iter().all(Result::is_ok)
        });
        settled.unwrap()
    }
}

/// `UPDATE_GOLDEN=1 cargo test -p node` writes them anew; then nobody's keys agree any more.
#[test]
fn the_tags_are_those_of_the_contract() {
    fn line<M: Signed>(message: M) -> String {
        let mut message = message;
        keyring(secret()).sign(&mut message, 0x0123_4567_89ab_cdef, 42);
        let hex = |bytes: &[u8]| bytes.iter().map(|byte| format!("{byte:02x}")).collect::<String>();
        format!("{} {}\n", M::CHANNEL, hex(message.encode().unwrap().as_bytes()))
    }
    let found = [
        format!("key_id {}\n", Key::new(&secret()).id()),
        line(state(4, 1)),
        line(deflections(4, 2)),
        line(command(4, 3)),
        line(task(4, 4)),
    ]
    .concat();
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../lcmtypes/tests/golden/tags");
    if std::env::var_os("UPDATE_GOLDEN").is_some() {
        std::fs::write(path, &found).unwrap();
    }
    assert_eq!(found, std::fs::read_to_string(path).unwrap());
}

/// Every bit of every message of some periods.
#[test]
fn no_bit_can_be_changed() {
    fn flip<M: Signed>(gate: &Gate, message: &M) {
        let encoded: Encoded = message.encode().unwrap();
        assert_eq!(gate.clone().admit(message), Ok(()));
        for bit in 0..8 * encoded.as_bytes().len() {
            let mut bytes = encoded.as_bytes().to_vec();
            bytes[bit / 8] ^= 1 << (bit % 8);
            // What can be decoded is another message, or the same one said otherwise.
            if let Ok(altered) = M::decode(&bytes) {
                assert_eq!(
                    altered.encode().unwrap().as_bytes(),
                    bytes,
                    "{} bit {bit}",
                    M::CHANNEL
                );
                let refused = gate.clone().admit(&altered);
                assert!(
                    matches!(refused, Err(Refusal::Tag | Refusal::Key { .. })),
                    "{} bit {bit}: {refused:?}",
                    M::CHANNEL
                );
            }
        }
        for length in 0..encoded.as_bytes().len() {
            assert!(M::decode(&encoded.as_bytes()[..length]).is_err());
        }
    }
    let mut cell = Cell::new();
    cell.settle(3);
    for _ in 0..2 {
        let said = cell.say(3);
        flip(&cell.controller, &said.state);
        flip(&cell.robot, &said.command);
        flip(&cell.sensor, &said.command);
        flip(&cell.controller, &said.deflections);
        flip(&cell.robot, &said.task);
        assert!(cell.hear(&said).iter().all(Result::is_ok));
    }
}

#[test]
fn a_cell_begins_within_some_periods_and_nothing_is_taken_twice() {
    let mut cell = Cell::new();
    assert!(cell.settle(3) <= 4);
    let mut said = Vec::new();
    for period in 0..50 {
        if period == 20 {
            // Armed: the others follow within a period or two, and nothing is lost meanwhile.
            cell.robot.renew();
        }
        let now = cell.say(3);
        assert_eq!(cell.hear(&now), [Ok(()); 7], "period {period}");
        said.push(now);
    }
    for old in &said {
        assert!(
            cell.hear(old).iter().all(Result::is_err),
            "step {}",
            old.state.stamp.step
        );
    }
}

#[test]
fn a_replay_is_refused_by_its_session_however_the_receiver_counts() {
    let mut cell = Cell::new();
    cell.settle(3);
    let old = cell.say(3);
    cell.robot.renew();
    assert_eq!(cell.robot.admit(&old.command), Ok(()), "the session before");
    let old = cell.say(3);
    cell.robot.renew();
    cell.robot.renew();
    assert!(matches!(
        cell.robot.admit(&old.command),
        Err(Refusal::Session { .. })
    ));
    assert!(matches!(
        cell.robot.admit(&old.task),
        Err(Refusal::Session { .. })
    ));
    assert!(matches!(
        cell.robot.admit(&old.deflections),
        Err(Refusal::Session { .. })
    ));
}

/// Another controller takes over; whoever then has the first one's process id believed in gets nothing executed.
#[test]
fn what_an_earlier_process_has_said_is_not_executed_again() {
    let mut cell = Cell::new();
    cell.settle(3);
    let early: Vec<_> = (0..10).map(|_| cell.say(3)).collect();
    assert!(early.iter().all(|said| cell.hear(said)[4].is_ok()));
    cell.controller = Gate::new(keyring(secret()), Author::Controller);
    assert!(cell.settle(33) <= 4);
    for said in &early {
        assert!(cell.robot.admit(&said.command).is_err());
    }
    // Nor when the robot has heard nothing of it yet.
    let mut restarted = Gate::of_robot(keyring(secret()), &[8; KEY_BYTES]);
    for said in &early {
        assert!(restarted.admit(&said.command).is_err());
        assert!(restarted.admit(&said.task).is_err());
    }
}

#[test]
fn another_tag_another_key_and_none_are_refused() {
    let mut cell = Cell::new();
    cell.settle(3);
    let said = cell.say(3);
    let mut forged = said.command;
    forged.authenticity.tag = said.deflections.authenticity.tag;
    assert_eq!(cell.robot.admit(&forged), Err(Refusal::Tag));
    let key = |first: u8| keyring([first; KEY_BYTES]);
    let mut foreign = said.command;
    key(9).sign(&mut foreign, cell.robot.session(), 1_000);
    assert!(
        matches!(cell.robot.admit(&foreign), Err(Refusal::Key { found }) if found == key(9).ids().next().unwrap())
    );
    let unsigned = command(cell.step, 3);
    assert_eq!(cell.robot.admit(&unsigned), Err(Refusal::Key { found: 0 }));
    assert_eq!(cell.hear(&said), [Ok(()); 7], "none of these has counted");
}

#[test]
fn keys_change_one_node_at_a_time() {
    let [old, new] = [1, 2].map(|i| Key::new(&[i; KEY_BYTES]));
    let (both, newer) = (
        Keyring::new(old.clone(), vec![new.clone()]),
        Keyring::new(new.clone(), vec![old.clone()]),
    );
    let (before, after) = (Keyring::new(old, Vec::new()), Keyring::new(new, Vec::new()));
    let takes = |from: &Keyring, to: &Keyring| {
        let mut message = command(4, 3);
        from.sign(&mut message, 1, 1);
        to.verify(&message).is_ok()
    };
    for stage in [[&before, &both], [&both, &newer], [&newer, &after]] {
        let [a, b] = stage;
        assert!(takes(a, b) && takes(b, a) && takes(a, a) && takes(b, b));
    }
    assert!(!takes(&before, &after) && !takes(&after, &before));
}

/// Guessing does not move the robot either: a scenario's worth of unsigned traffic.
#[test]
fn a_robot_with_a_key_that_hears_forgeries_alone_stays_idle() {
    let scenario = Scenario::default();
    let axes = scenario.start_axes().unwrap();
    let mut robot = crate::commanded::Commanded::new(&scenario, axes);
    let mut gate = Gate::of_robot(keyring(secret()), &[7; KEY_BYTES]);
    for tick in 0..400 {
        let mut forged = command(tick, 3);
        forged.axis_position = [axes; HORIZON];
        forged.authenticity = Authenticity {
            session: gate.session(),
            seq: tick + 1,
            key_id: Key::new(&secret()).id(),
            tag: [tick as u8; 16],
        };
        if gate.admit(&forged).is_ok() {
            robot.hear(tick, &forged);
        }
        robot.begin(tick);
        robot.pass(true);
    }
    assert_eq!(robot.states().mode(), RobotMode::Idle);
}
