//! MCAP: JSON messages, and a JSON schema for each type.

use super::{ExportError, messages};
use crate::log::Log;
use ::mcap::records::MessageHeader;
use ::mcap::{McapError, McapResult, WriteOptions, Writer};
use lcmtypes::schema::{Kind, Member, Type, Value};
use serde_json::{Map, Value as Json, json};
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, BufWriter};
use std::path::Path;

/// Write all messages of `log` as the MCAP file `path`.
pub fn write_mcap(log: &Log, path: &Path) -> Result<(), ExportError> {
    write(log, path).map_err(|error| {
        let source = match error {
            McapError::Io(source) => source,
            other => io::Error::other(other),
        };
        ExportError::new(path, source)
    })
}

/// A channel of the file.
struct Topic {
    id: u16,
    messages: u32,
}

fn write(log: &Log, path: &Path) -> McapResult<()> {
    let options = WriteOptions::new()
        .compression(None)
        .library(concat!("touchdown ", env!("CARGO_PKG_VERSION")));
    let mut file = options.create(BufWriter::new(File::create(path)?))?;
    let mut topics: BTreeMap<&str, Topic> = BTreeMap::new();
    for (entry, this, values) in messages(log) {
        let topic = match topics.entry(&entry.channel) {
            std::collections::btree_map::Entry::Occupied(known) => known.into_mut(),
            std::collections::btree_map::Entry::Vacant(new) => {
                new.insert(topic(&mut file, &entry.channel, this)?)
            }
        };
        // ns
        let time = entry.utime.max(0).unsigned_abs().saturating_mul(1000);
        let head = MessageHeader {
            channel_id: topic.id,
            sequence: topic.messages,
            log_time: time,
            publish_time: time,
        };
        topic.messages += 1;
        file.write_to_known_channel(&head, object(this, &values).to_string().as_bytes())?;
    }
    file.finish()?;
    Ok(())
}

fn topic(file: &mut Writer<BufWriter<File>>, channel: &str, this: &Type) -> McapResult<Topic> {
    let name = format!("touchdown.{}", this.name);
    let schema = file.add_schema(&name, "jsonschema", schema(this).to_string().as_bytes())?;
    let id = file.add_channel(schema, channel, "json", &BTreeMap::new())?;
    Ok(Topic { id, messages: 0 })
}

/// The JSON schema of a type.
pub(super) fn schema(this: &Type) -> Json {
    let property = |member: &Member| {
        let kind = match member.kind {
            Kind::Boolean => "boolean",
            Kind::Byte | Kind::Int32 | Kind::Int64 => "integer",
            Kind::Double => "number",
        };
        let mut described = json!({ "type": kind });
        for size in member.dimensions.iter().rev() {
            described = json!({ "type": "array", "items": described, "minItems": size, "maxItems": size });
        }
        described["description"] = member.about.into();
        (member.name.to_owned(), described)
    };
    let names: Vec<_> = this.members.iter().map(|member| member.name).collect();
    json!({
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": format!("touchdown.{}", this.name),
        "description": this.about,
        "type": "object",
        "properties": this.members.iter().map(property).collect::<Map<_, _>>(),
        "required": names,
    })
}

/// A message as JSON.
pub(super) fn object(this: &Type, values: &[Value]) -> Json {
    let mut rest = values;
    let mut object = Map::new();
    for member in this.members {
        let (own, after) = rest.split_at(member.count().min(rest.len()));
        rest = after;
        object.insert(member.name.to_owned(), nested(member.dimensions, own));
    }
    Json::Object(object)
}

fn nested(dimensions: &[usize], values: &[Value]) -> Json {
    match dimensions.split_first() {
        None => values.first().map_or(Json::Null, number),
        Some((size, inner)) => {
            let each = (values.len() / size.max(&1)).max(1);
            values.chunks(each).map(|chunk| nested(inner, chunk)).collect()
        }
    }
}

fn number(value: &Value) -> Json {
    match value {
        Value::Boolean(flag) => (*flag).into(),
        Value::Integer(number) => (*number).into(),
        // What JSON has no number for is null.
        Value::Double(number) => (*number).into(),
    }
}
