//! Logs by others, damaged ones, and such of another time.

use super::*;
use lcmtypes::{EventLogWriter, Message};
use spatial::ports::{Task, Truth};
use std::fs;

fn task(step: i64) -> Vec<u8> {
    let mut task = Task::default();
    task.stamp.step = step;
    task.encode().unwrap().as_bytes().to_vec()
}

/// A log of `events`.
fn log(directory: &Path, events: &[(&str, Vec<u8>)]) -> PathBuf {
    let path = directory.join("some.lcmlog");
    let mut writer = EventLogWriter::create(&path).unwrap();
    for (i, (channel, bytes)) in events.iter().enumerate() {
        writer.write(i as i64, channel, bytes).unwrap();
    }
    writer.close().unwrap();
    path
}

#[test]
fn what_is_not_of_this_contract_is_counted_and_the_rest_is_read() {
    let directory = tempfile::tempdir().unwrap();
    let events = [
        ("POSE", vec![1, 2, 3]),
        ("TASK", task(7)),
        ("HEARD_TASK", task(7)),
        ("POSE", vec![]),
    ];
    let log = Log::open(&log(directory.path(), &events)).unwrap();
    assert_eq!(log.foreign, [("POSE".to_owned(), 2)].into());
    let read: Vec<_> = log
        .entries
        .iter()
        .map(|it| (it.utime, said_on(&it.channel)))
        .collect();
    assert_eq!(read, [(1, "TASK"), (2, "TASK")]);
    assert_eq!(stamp(&log.entries[0].bytes).unwrap().step, 7);
    assert_eq!(log.complaints(), Vec::<String>::new());
}

#[test]
fn a_changed_type_is_named_with_both_fingerprints() {
    let directory = tempfile::tempdir().unwrap();
    let mut old = task(1);
    old[..8].copy_from_slice(&0x0123_4567_89ab_cdef_u64.to_be_bytes());
    let path = log(
        directory.path(),
        &[("TASK", old.clone()), ("TASK", old), ("TASK", task(3))],
    );
    let log = Log::open(&path).unwrap();
    let expected = format!(
        "2 messages of TASK are left out: the type task_t has changed, its fingerprint is 0x0123456789abcdef in the log \
         and {:#018x} in this program; use the version that recorded it",
        Task::fingerprint()
    );
    assert_eq!(log.complaints(), [expected]);
    assert_eq!((log.unusable[0].messages, log.unusable[0].usable), (2, 1));
    assert!(!log.unusable.iter().any(|it| it.type_name.is_empty()));
}

#[test]
fn what_comes_before_the_damage_is_read() {
    let directory = tempfile::tempdir().unwrap();
    let path = log(
        directory.path(),
        &[("TASK", task(1)), ("TASK", task(2)), ("TASK", task(3))],
    );
    let bytes = fs::read(&path).unwrap();
    let one = bytes.len() / 3;
    fs::write(&path, &bytes[..2 * one + 30]).unwrap();
    let truncated = Log::open(&path).unwrap();
    assert_eq!(truncated.entries.len(), 2);
    assert!(
        truncated.complaints()[0].ends_with(&format!(
            "is damaged at byte {}, after 2 whole events: it ends inside an event",
            2 * one
        )),
        "{:?}",
        truncated.complaints()
    );
    let mut corrupted = bytes;
    corrupted[one] = 0;
    fs::write(&path, corrupted).unwrap();
    assert_eq!(Log::open(&path).unwrap().entries.len(), 1);
}

#[test]
fn what_is_no_log_of_touchdown_says_what_it_is() {
    let directory = tempfile::tempdir().unwrap();
    let refusal = |path: &Path| Log::open(path).unwrap_err().to_string();
    let path = log(
        directory.path(),
        &[("POSE", vec![0; 9]), ("SIM_TRUTH", vec![0; 8])],
    );
    let told = refusal(&path);
    let expected = format!(
        "the type sim_truth_t has changed, its fingerprint is 0x0000000000000000 in the log and {:#018x}",
        Truth::fingerprint()
    );
    assert!(
        told.contains(&expected) && told.ends_with("it has channels of others: POSE"),
        "{told}"
    );
    fs::write(&path, "a text, longer than the head of an event").unwrap();
    assert!(refusal(&path).contains("is damaged at byte 0"));
    fs::write(&path, "").unwrap();
    assert!(refusal(&path).ends_with("is empty: nothing was recorded"));
}
