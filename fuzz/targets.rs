//! What reads bytes from outside, each as a function of any bytes: for libFuzzer, and for the replay of its corpora in the
//! tests (`experiment/tests/corpora.rs`). What they find is a panic, an overflow, or an assertion here.

#[path = "../experiment/src/watch/web/request.rs"]
mod request;
#[path = "../experiment/src/doctor/peer/word.rs"]
mod word;

use experiment::impact::library::Library;
use experiment::log::Log;
use experiment::sweep::Definition;
use experiment::tuning::Tuned;
use lcmtypes::{CHANNELS, EventLogReader, Message, Suffix, datagram, schema::Type};
use node::commanded::Commanded;
use node::scenario::Scenario;
use spatial::ports::{
    Check, Command, ControllerStatus, Deflections, LinkMotion, NodeStatus, ObjectPose, RobotState, Task,
    ToolMotion, Truth,
};
use std::path::Path;
use std::str;
use std::sync::LazyLock;

/// Reads any bytes.
pub(crate) type Target = fn(&[u8]);

/// Name and function of each.
pub(crate) const TARGETS: [(&str, Target); 9] = [
    ("datagram", packet),
    ("message", message),
    ("event_log", event_log),
    ("commands", commands),
    ("scenario", scenario),
    ("sweep", sweep),
    ("gains", gains),
    ("materials", materials),
    ("request", client),
];

/// A packet, as it comes from the network.
fn packet(bytes: &[u8]) {
    let Some((channel, encoding)) = datagram::split(bytes) else {
        return;
    };
    assert!((1..64).contains(&channel.len()) && bytes.len() == 9 + channel.len() + encoding.len());
    datagram::step(encoding);
    if let Some(word) = word::Word::decode(encoding) {
        assert!(word.encode() == encoding);
    }
    let _ = lcmtypes::check(&String::from_utf8_lossy(channel), encoding);
}

/// A message: the first byte says of which channel, and whether its head is put right.
fn message(bytes: &[u8]) {
    let Some((&first, rest)) = bytes.split_first() else {
        return;
    };
    let channel = CHANNELS[usize::from(first & 0x7f) % CHANNELS.len()];
    let mut encoding = rest.to_vec();
    if first & 0x80 == 0 {
        put_right(channel, &mut encoding);
    }
    let _ = lcmtypes::check(channel, &encoding).map_err(|error| error.to_string());
    let _ = Type::values(channel, &encoding);
    round::<RobotState>(channel, &encoding);
    round::<Deflections>(channel, &encoding);
    round::<Command>(channel, &encoding);
    round::<ControllerStatus>(channel, &encoding);
    round::<NodeStatus>(channel, &encoding);
    round::<Task>(channel, &encoding);
    round::<ObjectPose>(channel, &encoding);
    round::<LinkMotion>(channel, &encoding);
    round::<ToolMotion>(channel, &encoding);
    round::<Truth>(channel, &encoding);
}

/// The fingerprint and the length of what `channel` carries.
fn put_right(channel: &str, encoding: &mut Vec<u8>) {
    let fingerprint = lcmtypes::fingerprints().find(|(known, _)| *known == channel);
    encoding.resize(Type::of(channel).map_or(8, Type::size), 0);
    if let Some((_, fingerprint)) = fingerprint {
        encoding[..8].copy_from_slice(&fingerprint.to_be_bytes());
    }
}

/// What is accepted is encoded to the same bytes.
fn round<M: Message>(channel: &str, encoding: &[u8]) {
    if channel == M::CHANNEL
        && let Ok(message) = M::decode(encoding)
    {
        let again = message.encode().map(|again| again.as_bytes() == encoding);
        assert!(again == Ok(true), "{channel}");
    }
}

/// A file that somebody calls an event log.
fn event_log(bytes: &[u8]) {
    let path = Path::new("some.lcmlog");
    let events = EventLogReader::of(bytes, bytes.len() as u64, path);
    if let Ok(log) = Log::from_events(path, &Suffix::default(), events) {
        log.complaints();
        log.said();
    }
}

/// Commands to a robot, each of the bytes that a command has, at ticks that its first byte says. Whatever they ask for, each
/// axis is asked for no more than twice its speed within its range.
fn commands(bytes: &[u8]) {
    static SCENARIO: LazyLock<Scenario> = LazyLock::new(Scenario::default);
    let Ok(axes) = SCENARIO.start_axes() else { return };
    let size = Type::of(Command::CHANNEL).map_or(0, Type::size);
    let drives = SCENARIO.robot.drives();
    let (mut robot, mut tick, mut before) = (Commanded::new(&SCENARIO, axes), 0, axes);
    for chunk in bytes.chunks(size) {
        let mut encoding = chunk.to_vec();
        put_right(Command::CHANNEL, &mut encoding);
        if let Ok(command) = Command::decode(&encoding) {
            assert!(command.check().is_ok());
            // Once as it is, once as the next one that is due.
            robot.hear(tick, &command);
            let mut due = command;
            (due.stamp.step, due.enable) = (tick - tick % 4, true);
            robot.hear(tick, &due);
        }
        for _ in 0..1 + chunk[0] % 16 {
            let asked = robot.begin(tick);
            for axis in 0..6 {
                let speed = (asked[axis] - before[axis]).abs() / spatial::TICK_S;
                assert!(
                    speed <= 2.0 * drives.velocity_limit_rad_per_s[axis] + 1e-9,
                    "{speed} rad/s"
                );
                let range = drives.axis_minimum_rad[axis]..=drives.axis_maximum_rad[axis];
                assert!(range.contains(&asked[axis]));
            }
            (before, tick) = (asked, tick + 1);
            robot.pass(tick % 3 == 0);
        }
    }
}

/// A scenario's file; where its first line is an assignment, that overrides it, too.
fn scenario(bytes: &[u8]) {
    let Ok(text) = str::from_utf8(bytes) else { return };
    let first = text.lines().take(1).filter(|line| line.contains('='));
    let overrides: Vec<_> = first.map(str::to_owned).collect();
    match Scenario::parse("a.toml", text, &overrides) {
        Ok(scenario) => {
            let again = Scenario::parse("b.toml", &scenario.to_toml(), &[]);
            assert!(again.is_ok_and(|again| again.hash() == scenario.hash()));
        }
        Err(error) => assert!(!error.to_string().is_empty()),
    }
}

/// A definition of a sweep.
fn sweep(bytes: &[u8]) {
    if let Ok(text) = str::from_utf8(bytes) {
        let _ = Definition::parse("a", text).map_err(|error| error.to_string());
    }
}

/// Tuned gains.
fn gains(bytes: &[u8]) {
    if let Ok(text) = str::from_utf8(bytes)
        && let Ok(tuned) = Tuned::parse("a", text)
    {
        // By their text: they are written with fewer digits than they may be read with.
        let again = Tuned::parse("b", &tuned.to_toml());
        assert!(again.is_ok_and(|again| again.to_toml() == tuned.to_toml()));
    }
}

/// A library of materials and shapes.
fn materials(bytes: &[u8]) {
    if let Ok(text) = str::from_utf8(bytes) {
        let _ = Library::parse("a.toml", text).map_err(|error| error.to_string());
    }
}

/// What a client of `touchdown watch --web` sends.
fn client(bytes: &[u8]) {
    request::answer(bytes, 8765);
}
