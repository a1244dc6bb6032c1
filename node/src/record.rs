//! What a process has published and heard, in an LCM event log: written by a thread of its own, so that the disk never
//! holds up the control.

use crate::problem::Problem;
use crossbeam::channel::{Receiver, RecvTimeoutError, Sender, TrySendError, bounded};
use lcmtypes::{Encoded, EventLogWriter, LogError};
use std::borrow::Cow;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, OnceLock};
use std::thread::JoinHandle;
use std::time::Duration;

/// What stands before the channel of a message that a node has heard and used, as it used it: such an event is in its
/// record alone, never on the network.
pub const HEARD: &str = "HEARD_";
/// Messages that wait for the disk: of the busiest node those of 2 s.
const QUEUE: usize = 8192;
/// In real time: between two looks at what waits. The thread is not woken by a message, which would be a system call of
/// who sends it.
const LOOK: Duration = Duration::from_millis(10);

/// Whether a message was said or heard.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Direction {
    /// Published by this node.
    Said,
    /// Heard and used by it; see [`HEARD`].
    Heard,
}

impl Direction {
    /// The name of an event's channel.
    pub fn channel(self, channel: &str) -> Cow<'_, str> {
        match self {
            Self::Said => channel.into(),
            Self::Heard => format!("{HEARD}{channel}").into(),
        }
    }
}

/// What becomes of a message for which the disk is too slow.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WhenFull {
    /// The node waits: in lockstep nothing may be lost.
    Wait,
    /// It is left out, counted and told: in real time nothing may be held up.
    Drop,
}

/// A message on its way to the log.
struct Waiting {
    utime: i64,
    direction: Direction,
    message: Encoded,
}

/// A log that is being written.
pub struct Recorder {
    path: PathBuf,
    when_full: WhenFull,
    queue: Option<Sender<Waiting>>,
    /// Dropped to have the rest written.
    goes_on: Option<Sender<()>>,
    dropped: Arc<AtomicU64>,
    /// Why the log can't be written any more.
    failure: Arc<OnceLock<String>>,
    thread: Option<JoinHandle<Result<(), LogError>>>,
}

impl Recorder {
    /// A new log at `path`.
    pub fn create(path: &Path, when_full: WhenFull) -> Result<Self, LogError> {
        Self::with_queue(path, when_full, QUEUE)
    }

    fn with_queue(path: &Path, when_full: WhenFull, length: usize) -> Result<Self, LogError> {
        let writer = EventLogWriter::create(path)?;
        let (queue, waiting) = bounded(length);
        let (goes_on, ends) = bounded(0);
        let (failure, dropped) = (Arc::new(OnceLock::new()), Arc::new(AtomicU64::new(0)));
        let (told, lost) = (failure.clone(), dropped.clone());
        let write = move || {
            let result = match when_full {
                WhenFull::Wait => write_all(writer, &waiting),
                WhenFull::Drop => write_now_and_then(writer, &waiting, &ends, &lost),
            };
            if let Err(error) = &result {
                told.get_or_init(|| error.to_string());
            }
            result
        };
        Ok(Self {
            path: path.to_owned(),
            when_full,
            queue: Some(queue),
            goes_on: Some(goes_on),
            dropped,
            failure,
            thread: Some(std::thread::spawn(write)),
        })
    }

    /// Have `message` of simulated or real time `utime` (us) written. Tells when the log can't be written any more.
    pub fn record(&self, utime: i64, direction: Direction, message: &Encoded) -> Result<(), Problem> {
        if let Some(queue) = &self.queue {
            let waiting = Waiting {
                utime,
                direction,
                message: message.clone(),
            };
            match (queue.try_send(waiting), self.when_full) {
                // The queue is disconnected only when writing has failed, which is told below.
                (Ok(()) | Err(TrySendError::Disconnected(_)), _) => {}
                (Err(TrySendError::Full(waiting)), WhenFull::Wait) => drop(queue.send(waiting)),
                (Err(TrySendError::Full(_)), WhenFull::Drop) => {
                    self.dropped.fetch_add(1, Ordering::Relaxed);
                }
            }
        }
        match self.failure.get() {
            None => Ok(()),
            Some(cause) => Err(Problem::Record {
                path: self.path.clone(),
                cause: cause.clone(),
            }),
        }
    }

    /// Messages that were left out so far.
    pub fn dropped(&self) -> u64 {
        self.dropped.load(Ordering::Relaxed)
    }

    /// Write what is waiting and close the log.
    pub fn close(mut self) -> Result<(), LogError> {
        self.end().unwrap_or(Ok(()))
    }

    fn end(&mut self) -> Option<Result<(), LogError>> {
        (self.queue, self.goes_on) = (None, None);
        let result = self.thread.take()?.join().ok();
        let dropped = self.dropped();
        if dropped > 0 {
            tracing::warn!(
                "the record {} lacks {dropped} messages, for which the disk was too slow",
                self.path.display()
            );
        }
        result
    }
}

impl Drop for Recorder {
    fn drop(&mut self) {
        self.end();
    }
}

fn write(writer: &mut EventLogWriter, waiting: &Waiting) -> Result<(), LogError> {
    let Waiting {
        utime,
        direction,
        message,
    } = waiting;
    writer.write(*utime, &direction.channel(message.channel()), message.as_bytes())
}

fn write_all(mut writer: EventLogWriter, waiting: &Receiver<Waiting>) -> Result<(), LogError> {
    for waiting in waiting {
        write(&mut writer, &waiting)?;
    }
    writer.close()
}

fn write_now_and_then(
    mut writer: EventLogWriter,
    waiting: &Receiver<Waiting>,
    ends: &Receiver<()>,
    dropped: &AtomicU64,
) -> Result<(), LogError> {
    let mut told = false;
    loop {
        let goes_on = ends.recv_timeout(LOOK) == Err(RecvTimeoutError::Timeout);
        for waiting in waiting.try_iter() {
            write(&mut writer, &waiting)?;
        }
        if !told && dropped.load(Ordering::Relaxed) > 0 {
            told = true;
            tracing::warn!("the disk is too slow for the record: messages are left out, and counted");
        }
        if !goes_on {
            return writer.close();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lcmtypes::{EventLogReader, Message};
    use spatial::ports::Task;

    fn message() -> Encoded {
        Task::default().encode().unwrap()
    }

    /// A pipe that nobody reads is the slowest disk there is.
    #[test]
    fn a_slow_disk_costs_messages_in_real_time_and_says_how_many() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("pipe");
        rustix::fs::mknodat(
            rustix::fs::CWD,
            &path,
            rustix::fs::FileType::Fifo,
            rustix::fs::Mode::RWXU,
            0,
        )
        .unwrap();
        let reader = std::fs::File::options()
            .read(true)
            .write(true)
            .open(&path)
            .unwrap();
        let recorder = Recorder::with_queue(&path, WhenFull::Drop, 16).unwrap();
        for utime in 0..4096 {
            recorder.record(utime, Direction::Said, &message()).unwrap();
        }
        // A pipe holds 64 KiB, a message has 256 bytes.
        assert!(recorder.dropped() > 3000, "{}", recorder.dropped());
        let drain = std::thread::spawn(move || std::io::copy(&mut { reader }, &mut std::io::sink()));
        drop(recorder);
        drop(drain);
    }

    #[test]
    fn what_is_said_and_what_is_heard_are_told_apart() {
        let directory = tempfile::tempdir().unwrap();
        for when_full in [WhenFull::Wait, WhenFull::Drop] {
            let path = directory.path().join("log");
            let recorder = Recorder::create(&path, when_full).unwrap();
            recorder.record(1, Direction::Heard, &message()).unwrap();
            recorder.record(2, Direction::Said, &message()).unwrap();
            recorder.close().unwrap();
            let events: Vec<_> = EventLogReader::open(&path)
                .unwrap()
                .map(|event| event.map(|event| (event.utime, event.channel)).unwrap())
                .collect();
            assert_eq!(events, [(1, "HEARD_TASK".to_owned()), (2, "TASK".to_owned())]);
        }
    }
}
