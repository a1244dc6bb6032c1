//! LCM's event logs, which lcm-logger writes and lcm-logplayer reads.
#![allow(unsafe_code, reason = "calls liblcm")]

mod read;

pub use read::{Event, EventLogReader};

use crate::error::LogError;
use crate::raw;
use std::ffi::{CStr, CString};
use std::io;
use std::os::unix::ffi::OsStrExt;
use std::path::{Path, PathBuf};
use std::ptr::NonNull;

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
        let (Ok(channellen @ 1..=read::LONGEST_NAME), Ok(datalen)) = sizes else {
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
