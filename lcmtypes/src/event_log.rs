//! LCM's event logs, which lcm-logger writes and lcm-logplayer reads.
#![allow(unsafe_code, reason = "calls liblcm")]

mod scan;

use crate::error::LogError;
use crate::raw;
use std::ffi::{CStr, CString};
use std::io;
use std::os::unix::ffi::OsStrExt;
use std::path::{Path, PathBuf};
use std::ptr::NonNull;
use std::slice;

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

/// An open `lcm_eventlog_t`.
#[derive(Debug)]
struct Log {
    log: NonNull<raw::lcm_eventlog_t>,
    path: PathBuf,
}

// SAFETY: a log has no ties to a thread; it is used by one at a time through `&mut`.
unsafe impl Send for Log {}

impl Log {
    fn open(path: &Path, mode: &CStr) -> Result<Self, LogError> {
        let failed = |source| LogError::Open {
            path: path.to_owned(),
            source,
        };
        let name = CString::new(path.as_os_str().as_bytes()).map_err(|error| failed(error.into()))?;
        // SAFETY: both strings outlive the call; the mode is one of "r", "w".
        let log = unsafe { raw::lcm_eventlog_create(name.as_ptr(), mode.as_ptr()) };
        let log = NonNull::new(log).ok_or_else(|| failed(io::Error::last_os_error()))?;
        Ok(Self {
            log,
            path: path.to_owned(),
        })
    }
}

impl Drop for Log {
    fn drop(&mut self) {
        // SAFETY: the log is open.
        unsafe { raw::lcm_eventlog_destroy(self.log.as_ptr()) }
    }
}

/// Writes a log. Dropping it closes the file; [`close`](Self::close) also says whether that went well.
#[derive(Debug)]
pub struct EventLogWriter {
    log: Log,
}

impl EventLogWriter {
    /// Creates the file, or empties it.
    pub fn create(path: impl AsRef<Path>) -> Result<Self, LogError> {
        Ok(Self {
            log: Log::open(path.as_ref(), c"w")?,
        })
    }

    /// Appends a message that was received at `utime`, us since 1970.
    pub fn write(&mut self, utime: i64, channel: &str, bytes: &[u8]) -> Result<(), LogError> {
        let sizes = (i32::try_from(channel.len()), i32::try_from(bytes.len()));
        let (Ok(channellen @ 1..=scan::LONGEST_NAME), Ok(datalen)) = sizes else {
            let (path, length) = (self.log.path.clone(), bytes.len());
            return Err(LogError::Event {
                path,
                channel: channel.to_owned(),
                length,
            });
        };
        let mut event = raw::lcm_eventlog_event_t {
            eventnum: 0,
            timestamp: utime,
            channellen,
            datalen,
            channel: channel.as_ptr().cast_mut().cast(),
            data: bytes.as_ptr().cast_mut().cast(),
        };
        // SAFETY: the log is open; channel and data are as long as said, and only read.
        match unsafe { raw::lcm_eventlog_write_event(self.log.log.as_ptr(), &mut event) } {
            0 => Ok(()),
            _ => Err(self.failed()),
        }
    }

    /// Hands everything written to the system.
    pub fn flush(&mut self) -> Result<(), LogError> {
        // SAFETY: the log is open, and its file with it.
        match unsafe { raw::fflush(self.log.log.as_ref().f) } {
            0 => Ok(()),
            _ => Err(self.failed()),
        }
    }

    /// Writes what is left and closes the file.
    pub fn close(mut self) -> Result<(), LogError> {
        self.flush()
    }

    fn failed(&self) -> LogError {
        LogError::Write {
            path: self.log.path.clone(),
            source: io::Error::last_os_error(),
        }
    }
}

/// Reads a log: all whole events, then, if the file is damaged, one error.
#[derive(Debug)]
pub struct EventLogReader {
    log: Log,
    remaining: u64,
    damage: Option<LogError>,
}

impl EventLogReader {
    /// Opens a log and looks through the lengths in it: liblcm believes them.
    pub fn open(path: impl AsRef<Path>) -> Result<Self, LogError> {
        let path = path.as_ref();
        let failed = |source| LogError::Open {
            path: path.to_owned(),
            source,
        };
        let scan::Extent { events, end, problem } = scan::extent(path).map_err(failed)?;
        let damaged = |problem| LogError::Damaged {
            path: path.to_owned(),
            offset: end,
            events,
            problem,
        };
        Ok(Self {
            log: Log::open(path, c"r")?,
            remaining: events,
            damage: problem.map(damaged),
        })
    }

    fn read(&mut self) -> Option<Event> {
        // SAFETY: the log is open.
        let event = NonNull::new(unsafe { raw::lcm_eventlog_read_next_event(self.log.log.as_ptr()) })?;
        // SAFETY: liblcm returns a whole event, or none.
        let head = unsafe { event.as_ref() };
        let read = Event {
            utime: head.timestamp,
            channel: String::from_utf8_lossy(bytes(head.channel.cast(), head.channellen)).into_owned(),
            bytes: bytes(head.data.cast(), head.datalen).to_vec(),
        };
        // SAFETY: the event is liblcm's, and everything in it has been copied.
        unsafe { raw::lcm_eventlog_free_event(event.as_ptr()) };
        Some(read)
    }
}

/// The memory that liblcm allocated for a channel or for data.
fn bytes<'a>(start: *const u8, length: i32) -> &'a [u8] {
    match usize::try_from(length) {
        // SAFETY: liblcm allocates one byte more than this length, and fills it.
        Ok(length) if !start.is_null() => unsafe { slice::from_raw_parts(start, length) },
        _ => &[],
    }
}

impl Iterator for EventLogReader {
    type Item = Result<Event, LogError>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.remaining > 0 {
            self.remaining -= 1;
            if let Some(event) = self.read() {
                return Some(Ok(event));
            }
            // liblcm also gives up on the event before the damage.
            self.remaining = 0;
        }
        self.damage.take().map(Err)
    }
}
