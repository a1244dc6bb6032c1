//! What a process has published, in an LCM event log: written by a thread of its own, so that the disk never
//! holds up the control.

use crossbeam::channel::{Receiver, Sender, TrySendError, bounded};
use lcmtypes::{Encoded, EventLogWriter, LogError};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;

/// Messages that wait for the disk.
const QUEUE: usize = 1024;

/// A log that is being written.
pub struct Recorder {
    path: PathBuf,
    queue: Option<Sender<(i64, Encoded)>>,
    failed: Arc<AtomicBool>,
    thread: Option<JoinHandle<Result<(), LogError>>>,
}

impl Recorder {
    /// A new log at `path`.
    pub fn create(path: &Path) -> Result<Self, LogError> {
        let writer = EventLogWriter::create(path)?;
        let (queue, waiting) = bounded(QUEUE);
        let failed = Arc::new(AtomicBool::new(false));
        let flag = failed.clone();
        let write = move || {
            let result = write_all(writer, &waiting);
            flag.store(result.is_err(), Ordering::Release);
            result
        };
        Ok(Self {
            path: path.to_owned(),
            queue: Some(queue),
            failed,
            thread: Some(std::thread::spawn(write)),
        })
    }

    /// Where the log is.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Have `message` of simulated or real time `utime` (us) written. Waits where the disk is slower than the
    /// experiment: in lockstep nothing may be lost. `false`: the log could not be written.
    #[must_use]
    pub fn record(&self, utime: i64, message: &Encoded) -> bool {
        let Some(queue) = &self.queue else { return false };
        match queue.try_send((utime, message.clone())) {
            Ok(()) => {}
            Err(TrySendError::Full(entry)) => {
                if queue.send(entry).is_err() {
                    return false;
                }
            }
            Err(TrySendError::Disconnected(_)) => return false,
        }
        !self.failed.load(Ordering::Acquire)
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
