//! Event logs, whole and damaged.

use lcmtypes::{Event, EventLogReader, EventLogWriter, LogError};
use std::fs;
use std::path::{Path, PathBuf};
use tempfile::TempDir;

fn events() -> Vec<Event> {
    let event = |utime, channel: &str, bytes: Vec<u8>| Event {
        utime,
        channel: channel.to_owned(),
        bytes,
    };
    vec![
        event(1_700_000_000_000_000, "ROBOT_STATE", (0..=255).collect()),
        event(-1, "X", vec![]),
        event(i64::MAX, &"N".repeat(63), vec![0xed, 0xa1, 0xda, 0x01]),
    ]
}

/// A log of `events` in a directory of its own.
fn log() -> (TempDir, PathBuf) {
    let directory = TempDir::new().unwrap();
    let path = directory.path().join("some.lcmlog");
    let mut writer = EventLogWriter::create(&path).unwrap();
    for event in events() {
        writer.write(event.utime, &event.channel, &event.bytes).unwrap();
    }
    writer.close().unwrap();
    (directory, path)
}

/// The events that can be read and the error after them.
fn read(path: &Path) -> (Vec<Event>, Option<String>) {
    let (mut events, mut error) = (vec![], None);
    for event in EventLogReader::open(path).unwrap() {
        assert!(error.is_none(), "nothing follows an error");
        match event {
            Ok(event) => events.push(event),
            Err(damage) => error = Some(damage.to_string()),
        }
    }
    (events, error)
}

#[test]
fn what_is_written_is_read() {
    let (_directory, path) = log();
    assert_eq!(read(&path), (events(), None));
    fs::write(&path, []).unwrap();
    assert_eq!(read(&path), (vec![], None));
}

#[test]
fn a_truncated_log_gives_its_whole_events_and_then_an_error() {
    let (_directory, path) = log();
    let bytes = fs::read(&path).unwrap();
    let ends = [0, 28 + 11 + 256, 28 + 11 + 256 + 28 + 1, bytes.len()];
    for length in 0..bytes.len() {
        fs::write(&path, &bytes[..length]).unwrap();
        let whole = ends.iter().filter(|&&end| end <= length).count() - 1;
        let (found, error) = read(&path);
        assert_eq!(found, events()[..whole], "{length} bytes");
        let expected = format!(
            "is damaged at byte {}, after {whole} whole events: it ends inside an event",
            ends[whole]
        );
        match error {
            None => assert_eq!(length, ends[whole]),
            Some(error) => assert!(error.contains(&expected), "{length} bytes: {error}"),
        }
    }
}

#[test]
fn a_damaged_length_is_not_believed() {
    let (_directory, path) = log();
    let whole = fs::read(&path).unwrap();
    for (place, value) in [
        (20, [0x7f, 0xff, 0xff, 0xff]),
        (24, [0x7f, 0xff, 0xff, 0xff]),
        (24, [0xff; 4]),
        (20, [0; 4]),
    ] {
        let mut bytes = whole.clone();
        bytes[place..place + 4].copy_from_slice(&value);
        fs::write(&path, &bytes).unwrap();
        let (events, error) = read(&path);
        assert_eq!(events, []);
        assert!(error.is_some_and(|error| error.contains("is damaged at byte 0")));
    }
}

#[test]
fn what_is_no_log_says_so() {
    let (_directory, path) = log();
    fs::write(&path, "not a log, but a text of more than 28 bytes").unwrap();
    let (events, error) = read(&path);
    assert_eq!(events, []);
    assert!(error.is_some_and(|error| error.ends_with("after 0 whole events: no event starts there")));
    assert!(matches!(
        EventLogReader::open("/nonexistent.lcmlog"),
        Err(LogError::Open { .. })
    ));
    assert!(matches!(EventLogReader::open("/"), Err(LogError::Open { .. })));
}

#[test]
fn a_full_disk_is_an_error() {
    let mut writer = EventLogWriter::create("/dev/full").unwrap();
    writer.write(0, "X", b"small enough for a buffer").unwrap();
    let error = writer.close().unwrap_err().to_string();
    assert!(
        error.starts_with("can't write event log /dev/full: No space left on device"),
        "{error}"
    );
    assert!(matches!(
        EventLogWriter::create("/nonexistent/log"),
        Err(LogError::Open { .. })
    ));
}

#[test]
fn an_event_without_a_channel_is_refused() {
    let (_directory, path) = log();
    let mut writer = EventLogWriter::create(&path).unwrap();
    for channel in [String::new(), "N".repeat(1000)] {
        assert!(matches!(
            writer.write(0, &channel, b""),
            Err(LogError::Event { .. })
        ));
    }
}
