//! What is written says what the messages say.

use super::*;
use crate::scenarios::Source;
use crate::transcript;
use lcmtypes::Message;
use serde_json::Value as Json;
use spatial::ports::{ControllerStatus, RobotState};
use std::collections::BTreeMap;

fn log() -> Log {
    let scenario = Source::find("paper")
        .unwrap()
        .scenario(&["timing.duration_s=0.1".to_owned()])
        .unwrap();
    Log::of(Path::new(""), transcript::in_process(&scenario).unwrap())
}

#[test]
fn a_table_has_every_message_with_all_digits() {
    let (log, directory) = (log(), tempfile::tempdir().unwrap());
    let files = write_csv(&log, &directory.path().join("new")).unwrap();
    assert_eq!(files.len(), 7);
    let text = std::fs::read_to_string(directory.path().join("new/ROBOT_STATE.csv")).unwrap();
    let mut lines = text.lines().map(|line| line.split(',').collect::<Vec<_>>());
    let header = lines.next().unwrap();
    assert_eq!(header[..4], ["log_time_us", "step", "utime", "boot_id"]);
    let states: Vec<RobotState> = transcript::messages(&log.entries).collect();
    assert_eq!(states.len(), 26);
    let column = header
        .iter()
        .position(|name| *name == "robot_axis_position_rad[1][2]")
        .unwrap();
    for (state, line) in states.iter().zip(lines.by_ref()) {
        assert_eq!(line.len(), header.len());
        assert_eq!(line[1].parse(), Ok(state.stamp.step));
        assert_eq!(line[column].parse(), Ok(state.axis_position[1][2]));
    }
    assert_eq!(lines.next(), None);
    let nowhere = write_csv(&log, Path::new("/dev/null/x")).unwrap_err().to_string();
    assert!(nowhere.starts_with("can't write /dev/null/x: "), "{nowhere}");
}

#[test]
fn an_mcap_file_has_every_message_as_its_schema_says() {
    let (log, directory) = (log(), tempfile::tempdir().unwrap());
    let path = directory.path().join("log.mcap");
    write_mcap(&log, &path).unwrap();
    let bytes = std::fs::read(&path).unwrap();
    let mut left: BTreeMap<String, Vec<&Entry>> = BTreeMap::new();
    for entry in log.entries.iter().rev() {
        left.entry(entry.channel.clone()).or_default().push(entry);
    }
    for message in ::mcap::read::MessageStream::new(&bytes).unwrap() {
        let message = message.unwrap();
        let (channel, schema) = (&message.channel, message.channel.schema.as_ref().unwrap());
        assert_eq!(
            (channel.message_encoding.as_str(), schema.encoding.as_str()),
            ("json", "jsonschema")
        );
        let entry = left.get_mut(&channel.topic).unwrap().pop().unwrap();
        assert_eq!(message.log_time, entry.utime as u64 * 1000);
        let json: Json = serde_json::from_slice(&message.data).unwrap();
        let described: Json = serde_json::from_slice(&schema.data).unwrap();
        assert_same_shape(&json, &described, &schema.name);
        if channel.topic == ControllerStatus::CHANNEL {
            let status = ControllerStatus::decode(&entry.bytes).unwrap();
            let compliance = &json["controller_compliance_m_per_n"];
            assert_eq!(
                compliance[1][1].as_f64(),
                Some(status.compliance.translation[(1, 1)])
            );
            assert_eq!(
                json["controller_phase"].as_i64(),
                Some(i64::from(status.phase.code()))
            );
        }
    }
    assert!(left.values().all(Vec::is_empty));
    assert!(write_mcap(&log, Path::new("/nonexistent/a.mcap")).is_err());
}

/// A value is of the type that the schema says, at any depth.
fn assert_same_shape(value: &Json, schema: &Json, name: &str) {
    match schema["type"].as_str().unwrap() {
        "object" => {
            let (members, properties) = (
                value.as_object().unwrap(),
                schema["properties"].as_object().unwrap(),
            );
            assert_eq!(members.len(), properties.len());
            for (name, schema) in properties {
                assert_same_shape(&members[name], schema, name);
            }
        }
        "array" => {
            let items = value.as_array().unwrap();
            assert_eq!(schema["maxItems"].as_u64(), Some(items.len() as u64), "{name}");
            items
                .iter()
                .for_each(|item| assert_same_shape(item, &schema["items"], name));
        }
        "boolean" => assert!(value.is_boolean(), "{name}"),
        "integer" => assert!(value.is_i64() || value.is_u64(), "{name}"),
        "number" => assert!(value.is_f64(), "{name}"),
        other => panic!("{name} is {other}"),
    }
}
