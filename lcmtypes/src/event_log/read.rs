//! Reading, without liblcm: that allocates what a damaged length says, and gives up on the event before the damage.

use crate::error::LogError;
use std::fs::File;
use std::io::{self, BufReader, Read};
use std::path::{Path, PathBuf};

/// First four bytes of every event.
const SYNC: [u8; 4] = [0xed, 0xa1, 0xda, 0x01];
/// Sync word, event number, time stamp, length of the channel, length of the data; big-endian.
const HEAD: usize = 4 + 8 + 8 + 4 + 4;
/// Longest channel name that liblcm reads back.
pub(super) const LONGEST_NAME: i32 = 999;

/// A message in a log.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Event {
    /// When it was received, us since 1970.
    pub utime: i64,
    /// Channel; bytes that are not UTF-8 are replaced.
    pub channel: String,
    /// Encoding.
    pub bytes: Vec<u8>,
}

/// Reads a log: all whole events, then, if the file is damaged, one error.
#[derive(Debug)]
pub struct EventLogReader<R = BufReader<File>> {
    file: R,
    path: PathBuf,
    /// Bytes of the file that have not been read.
    left: u64,
    /// Byte after the last whole event.
    end: u64,
    /// Whole events so far.
    events: u64,
}

/// Why an event can't be read.
enum Damage {
    Form(&'static str),
    Read(io::Error),
}

impl EventLogReader {
    /// Opens a log.
    pub fn open(path: impl AsRef<Path>) -> Result<Self, LogError> {
        let path = path.as_ref().to_owned();
        let open = || -> io::Result<(File, u64)> {
            let file = File::open(&path)?;
            let about = file.metadata()?;
            match about.is_dir() {
                true => Err(io::ErrorKind::IsADirectory.into()),
                false => Ok((file, about.len())),
            }
        };
        match open() {
            Ok((file, left)) => Ok(Self::of(BufReader::new(file), left, path)),
            Err(source) => Err(LogError::Open { path, source }),
        }
    }
}

impl<R: Read> EventLogReader<R> {
    /// Reads the `length` bytes of `file`, which errors call `path`.
    pub fn of(file: R, length: u64, path: impl AsRef<Path>) -> Self {
        Self {
            file,
            path: path.as_ref().to_owned(),
            left: length,
            end: 0,
            events: 0,
        }
    }

    fn take(&mut self, length: usize) -> Result<Vec<u8>, Damage> {
        let mut bytes = vec![0; length];
        self.file.read_exact(&mut bytes).map_err(Damage::Read)?;
        self.left -= length as u64;
        Ok(bytes)
    }

    fn event(&mut self) -> Result<Event, Damage> {
        if self.left < HEAD as u64 {
            return Err(Damage::Form("it ends inside an event's head"));
        }
        let head = self.take(HEAD)?;
        let number = |start: usize, end: usize| {
            head[start..end]
                .iter()
                .fold(0_u64, |value, byte| value << 8 | u64::from(*byte))
        };
        let length = |start: usize| number(start, start + 4) as u32 as i32;
        if !head.starts_with(&SYNC) {
            return Err(Damage::Form("no event starts there"));
        }
        let (Ok(name), Ok(data)) = (usize::try_from(length(20)), usize::try_from(length(24))) else {
            return Err(Damage::Form("an event of impossible length"));
        };
        if !(1..=LONGEST_NAME as usize).contains(&name) {
            return Err(Damage::Form("an event of impossible length"));
        }
        // Believed only as far as the file goes.
        if self.left < (name + data) as u64 {
            return Err(Damage::Form("it ends inside an event"));
        }
        Ok(Event {
            utime: number(12, 20) as i64,
            channel: String::from_utf8_lossy(&self.take(name)?).into_owned(),
            bytes: self.take(data)?,
        })
    }
}

impl<R: Read> Iterator for EventLogReader<R> {
    type Item = Result<Event, LogError>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.left == 0 {
            return None;
        }
        let before = self.left;
        let (path, offset, events) = (self.path.clone(), self.end, self.events);
        match self.event() {
            Ok(event) => {
                self.events += 1;
                self.end += before - self.left;
                Some(Ok(event))
            }
            Err(damage) => {
                self.left = 0;
                Some(Err(match damage {
                    Damage::Read(source) => LogError::Open { path, source },
                    Damage::Form(problem) => LogError::Damaged {
                        path,
                        offset,
                        events,
                        problem,
                    },
                }))
            }
        }
    }
}
