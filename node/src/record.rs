//! What a process has published, in an LCM event log: written by a thread of its own, so that the disk never
//! holds up the control.

use crate::problem::Problem;
use crossbeam::channel::{Receiver, Sender, TrySendError, bounded};
use lcmtypes::{Encoded, EventLogWriter, LogError};
use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};
use std::thread::JoinHandle;

/// Messages that wait for the disk.
const QUEUE: usize = 1024;

/// A log that is being written.
pub struct Recorder {
    path: PathBuf,
    queue: Option<Sender<(i64, Encoded)>>,
    /// Why the log can't be written any more.
    failure: Arc<OnceLock<String>>,
    thread: Option<JoinHandle<Result<(), LogError>>>,
}

impl Recorder {
    /// A new log at `path`.
    pub fn create(path: &Path) -> Result<Self, LogError> {
        let writer = EventLogWriter::create(path)?;
        let (queue, waiting) = bounded(QUEUE);
        let failure = Arc::new(OnceLock::new());
        let told = failure.clone();
        let write = move || {
            let result = write_all(writer, &waiting);
            if let Err(error) = &result {
                told.get_or_init(|| error.to_string());
            }
            result
        };
        Ok(Self {
            path: path.to_owned(),
            queue: Some(queue),
            failure,
            thread: Some(std::thread::spawn(write)),
        })
    }

    /// Have `message` of simulated or real time `utime` (us) written. Waits where the disk is slower than the
    /// experiment: in lockstep nothing may be lost. Tells when the log can't be written any more.
    pub fn record(&self, utime: i64, message: &Encoded) -> Result<(), Problem> {
        if let Some(queue) = &self.queue {
            // The queue is disconnected only when writing has failed, which is told below.
            let _ = match queue.try_send((utime, message.clone())) {
                Err(TrySendError::Full(entry)) => queue.send(entry).is_ok(),
                sent => sent.is_ok(),
            };
        }
        match self.failure.get() {
            None => Ok(()),
            Some(cause) => Err(Problem::Record {
                path: self.path.clone(),
                cause: cause.clone(),
            }),
        }
    }

    /// Write what is waiting and close the log.
    pub fn close(mut self) -> Result<(), LogError> {
        self.queue = None;
        match self.thread.take().map(JoinHandle::join) {
            Some(Ok(result)) => result,
            _ => Ok(()),
        }
    }
}

impl Drop for Recorder {
    fn drop(&mut self) {
        self.queue = None;
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

fn write_all(mut writer: EventLogWriter, waiting: &Receiver<(i64, Encoded)>) -> Result<(), LogError> {
    for (utime, message) in waiting {
        writer.write(utime, message.channel(), message.as_bytes())?;
    }
    writer.close()
}
