mod cell;
mod recorded;

use super::*;
use crate::scenario::Scenario;
use cell::{Cell, command, deflections, keyring, secret, state, task};
use spatial::ports::{HORIZON, RobotMode};

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

/// Of a process that came and went before, where the robot has not noticed or is not heard.
#[test]
fn a_sensor_that_was_replaced_is_not_heard_again() {
    let mut cell = Cell::new();
    cell.settle(3);
    let mut early = cell.say(3).deflections;
    cell.sensor.sign(&mut early);
    let mut sensor = Gate::new(keyring(secret()), Author::Sensor);
    std::mem::swap(&mut sensor, &mut cell.sensor);
    let mut from_another = || {
        cell.step += 4;
        let mut command = command(cell.step, 3);
        cell.controller.sign(&mut command);
        cell.sensor.admit(&command).unwrap();
        let mut deflections = deflections(cell.step, 22);
        cell.sensor.sign(&mut deflections);
        let mut state = state(cell.step, 1);
        cell.robot.sign(&mut state);
        cell.controller.admit(&state).unwrap();
        [
            cell.robot.admit(&deflections),
            cell.controller.admit(&deflections),
        ]
    };
    assert!((0..4).any(|_| from_another() == [Ok(()); 2]));
    let refused = cell.controller.admit(&early);
    assert!(matches!(refused, Err(Refusal::Session { .. })), "{refused:?}");
    assert!(cell.robot.admit(&early).is_err());
}

#[test]
fn who_asks_is_heard_beside_others_and_after_another_robot_has_come() {
    let mut cell = Cell::new();
    cell.settle(3);
    let mut second = Gate::new(keyring(secret()), Author::Operator);
    for _ in 0..100 {
        let said = cell.say(3);
        assert_eq!(cell.hear(&said), [Ok(()); 7]);
        second.admit(&said.state).unwrap();
    }
    let mut asked = task(1, 5);
    second.sign(&mut asked);
    let said = cell.say(3);
    assert_eq!(cell.hear(&said), [Ok(()); 7]);
    // Asked in the same period as the first one, it has to be repeated.
    assert!(matches!(cell.controller.admit(&asked), Err(Refusal::Old { .. })));
    second.admit(&said.state).unwrap();
    second.sign(&mut asked);
    second.sign(&mut asked);
    assert_eq!(
        [cell.controller.admit(&asked), cell.robot.admit(&asked)],
        [Ok(()); 2]
    );

    cell.robot = Gate::of_robot(keyring(secret()), &[8; KEY_BYTES]);
    let robot = 11;
    let period = |cell: &mut Cell| {
        let mut said = cell.say(3);
        said.state.stamp.boot_id = robot;
        cell.robot.sign(&mut said.state);
        cell.hear(&said).iter().all(Result::is_ok)
    };
    assert!((0..8).any(|_| period(&mut cell)));
}

/// One that nobody has heard, and that somebody has kept.
#[test]
fn a_request_is_soon_too_old() {
    let mut cell = Cell::new();
    cell.settle(3);
    let kept = cell.say(3).task;
    for period in 0..600 {
        let mut state = state(cell.step, 1);
        cell.robot.sign(&mut state);
        cell.controller.admit(&state).unwrap();
        if period < 400 {
            assert_eq!(cell.robot.clone().admit(&kept), Ok(()));
            assert_eq!(cell.controller.clone().admit(&kept), Ok(()));
        }
    }
    for gate in [&mut cell.robot, &mut cell.controller] {
        assert!(matches!(gate.admit(&kept), Err(Refusal::Late { .. })));
        let mut ahead = task(2, 4);
        keyring(secret()).sign(&mut ahead, gate.session(), i64::MAX);
        assert!(matches!(gate.admit(&ahead), Err(Refusal::Late { .. })));
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
