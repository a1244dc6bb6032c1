//! How much of an event log is whole. liblcm allocates what a length in the file says, and would follow a damaged
//! one.

use std::fs::File;
use std::io::{self, BufReader, Read};
use std::path::Path;

/// First four bytes of every event.
const SYNC: [u8; 4] = [0xed, 0xa1, 0xda, 0x01];
/// Sync word, event number, time stamp, length of the channel, length of the data; big-endian.
const HEAD: usize = 4 + 8 + 8 + 4 + 4;
/// Longest channel name that liblcm reads back.
pub(super) const LONGEST_NAME: i32 = 999;

/// The whole events at the start of a log.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Extent {
    pub(super) events: u64,
    /// Byte after the last whole event.
    pub(super) end: u64,
    /// What follows, if not the end of the file.
    pub(super) problem: Option<&'static str>,
}

pub(super) fn extent(path: &Path) -> io::Result<Extent> {
    let file = File::open(path)?;
    let size = file.metadata()?.len();
    let mut file = BufReader::new(file);
    let mut extent = Extent {
        events: 0,
        end: 0,
        problem: None,
    };
    while extent.end < size {
        let mut head = [0; HEAD];
        if size - extent.end < HEAD as u64 {
            extent.problem = Some("it ends inside an event's head");
            break;
        }
        file.read_exact(&mut head)?;
        let length = |start: usize| -> i64 {
            let bytes = [head[start], head[start + 1], head[start + 2], head[start + 3]];
            i32::from_be_bytes(bytes).into()
        };
        let (name, data) = (length(20), length(24));
        if !head.starts_with(&SYNC) {
            extent.problem = Some("no event starts there");
        } else if !(1..=LONGEST_NAME.into()).contains(&name) || data < 0 {
            extent.problem = Some("an event of impossible length");
        } else if size - extent.end < HEAD as u64 + (name + data).unsigned_abs() {
            extent.problem = Some("it ends inside an event");
        }
        if extent.problem.is_some() {
            break;
        }
        file.seek_relative(name + data)?;
        extent.events += 1;
        extent.end += HEAD as u64 + (name + data).unsigned_abs();
    }
    Ok(extent)
}
