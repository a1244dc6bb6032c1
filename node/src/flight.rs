//! The flight recorder of a node in real time: the last seconds of what it has said and heard, in memory that is there from
//! the start. When something goes wrong a thread of its own writes them to an LCM event log.
//!
//! The node's own thread neither allocates nor waits nor calls the system for it: it copies each message into a ring, and
//! hands the whole ring over when the time has come, while it goes on with a second one.

use crate::clock::{self, Clock, HostClock};
use crate::record::Direction;
use crate::rights;
use crossbeam::channel::{Receiver, RecvTimeoutError, Sender, bounded};
use lcmtypes::{Encoded, EventLogWriter, LogError};
use std::collections::VecDeque;
use std::path::{Path, PathBuf};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Bytes of messages in a ring: 5 s of sensor-sim, more than 10 s of the others.
const BYTES: usize = 8 << 20;
/// Messages in a ring: shorter ones than this many bytes on average are none.
const SHORTEST: usize = 160;
/// How long what follows a fault belongs to it.
const AFTER: Duration = Duration::from_millis(500);
/// Between two looks of the writing thread, which nobody wakes.
const LOOK: Duration = Duration::from_millis(50);
/// So many files of a role are left in the directory: the newest.
const FILES: usize = 10;

/// A message in a ring.
#[derive(Clone, Copy)]
struct Kept {
    utime: i64,
    channel: &'static str,
    direction: Direction,
    length: usize,
}

/// Messages one after the other, the oldest overwritten by the newest.
struct Ring {
    bytes: Vec<u8>,
    /// Where the oldest message begins, and how many bytes are in use from there on.
    start: usize,
    used: usize,
    kept: VecDeque<Kept>,
}

impl Ring {
    fn new(bytes: usize) -> Self {
        let none = Kept {
            utime: 0,
            channel: "",
            direction: Direction::Said,
            length: 0,
        };
        // Written, so that the memory is there: a page that is touched for the first time is a system call in disguise.
        let mut kept = VecDeque::from(vec![none; bytes / SHORTEST]);
        kept.clear();
        Self {
            bytes: vec![0xff; bytes],
            start: 0,
            used: 0,
            kept,
        }
    }

    fn forget_oldest(&mut self) {
        if let Some(oldest) = self.kept.pop_front() {
            self.start = (self.start + oldest.length) % self.bytes.len();
            self.used -= oldest.length;
        }
    }

    fn push(&mut self, utime: i64, direction: Direction, message: &Encoded) {
        let new = message.as_bytes();
        if new.len() > self.bytes.len() {
            return;
        }
        while self.used + new.len() > self.bytes.len() || self.kept.len() == self.bytes.len() / SHORTEST {
            self.forget_oldest();
        }
        let at = (self.start + self.used) % self.bytes.len();
        let before_end = new.len().min(self.bytes.len() - at);
        let (first, second) = new.split_at(before_end);
        self.bytes[at..at + first.len()].copy_from_slice(first);
        self.bytes[..second.len()].copy_from_slice(second);
        self.used += new.len();
        self.kept.push_back(Kept {
            utime,
            channel: message.channel(),
            direction,
            length: new.len(),
        });
    }

    fn clear(&mut self) {
        (self.start, self.used) = (0, 0);
        self.kept.clear();
    }

    /// Write all of it, oldest first.
    fn write(&self, path: &Path) -> Result<(), LogError> {
        let mut writer = EventLogWriter::create(path)?;
        let (mut at, mut message) = (self.start, Vec::new());
        for kept in &self.kept {
            let before_end = kept.length.min(self.bytes.len() - at);
            message.clear();
            message.extend_from_slice(&self.bytes[at..at + before_end]);
            message.extend_from_slice(&self.bytes[..kept.length - before_end]);
            writer.write(kept.utime, &kept.direction.channel(kept.channel), &message)?;
            at = (at + kept.length) % self.bytes.len();
        }
        writer.close()
    }
}

/// A ring to be written, and when it is, us since 1970.
struct Full {
    ring: Ring,
    utime: i64,
}

/// What keeps the last seconds.
pub struct FlightRecorder {
    ring: Option<Ring>,
    /// When the ring is to be handed over.
    due: Option<Instant>,
    clock: HostClock,
    full: Option<Sender<Full>>,
    empty: Receiver<Ring>,
    /// Dropped to end the thread.
    goes_on: Option<Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

impl FlightRecorder {
    /// Of the node `name`, into `directory`, which is made when it is needed.
    pub fn start(name: &'static str, directory: PathBuf) -> Self {
        Self::with_rings(name, directory, BYTES)
    }

    fn with_rings(name: &'static str, directory: PathBuf, bytes: usize) -> Self {
        let (full, to_write) = bounded::<Full>(1);
        let (give_back, empty) = bounded(1);
        let (goes_on, ends) = bounded(0);
        // There is room for it.
        let _ = give_back.try_send(Ring::new(bytes));
        let work = move || {
            rights::give_up();
            loop {
                let ended = ends.recv_timeout(LOOK) != Err(RecvTimeoutError::Timeout);
                for Full { mut ring, utime } in to_write.try_iter() {
                    tell(&ring, write(&ring, utime, name, &directory));
                    ring.clear();
                    let _ = give_back.try_send(ring);
                }
                if ended {
                    break;
                }
            }
        };
        Self {
            ring: Some(Ring::new(bytes)),
            due: None,
            clock: HostClock::start(),
            full: Some(full),
            empty,
            goes_on: Some(goes_on),
            thread: Some(std::thread::spawn(work)),
        }
    }

    /// Keep a message of tick time `utime`, us.
    pub fn keep(&mut self, utime: i64, direction: Direction, message: &Encoded) {
        if self.ring.is_none() {
            // Both were full: the first one is being written.
            self.ring = self.empty.try_recv().ok();
        }
        if let Some(ring) = &mut self.ring {
            ring.push(utime, direction, message);
        }
        if self.due.is_some_and(|due| clock::now() >= due) {
            self.hand_over();
        }
    }

    /// Something has gone wrong: have the last seconds written, with what follows within half a second.
    pub fn write_soon(&mut self) {
        self.due.get_or_insert(clock::now() + AFTER);
    }

    fn hand_over(&mut self) {
        let (Some(_), Some(full)) = (self.due.take(), &self.full) else {
            return;
        };
        if let Some(ring) = self.ring.take() {
            let utime = self.clock.utime(clock::now());
            // There is room for one of the two rings, and the other one is here or being written.
            if let Err(refused) = full.try_send(Full { ring, utime }) {
                self.ring = Some(refused.into_inner().ring);
            }
        }
    }
}

impl Drop for FlightRecorder {
    fn drop(&mut self) {
        self.hand_over();
        (self.full, self.goes_on) = (None, None);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

/// Write `ring`; where to.
fn write(ring: &Ring, utime: i64, name: &str, directory: &Path) -> Result<PathBuf, String> {
    let prefix = format!("flight-{name}-");
    let path = directory.join(format!("{prefix}{}.lcmlog", utime / 1000));
    let failed = |error: &dyn std::fmt::Display| {
        format!("the last seconds can't be kept in {}: {error}", path.display())
    };
    std::fs::create_dir_all(directory).map_err(|error| failed(&error))?;
    // Under its name it is whole.
    let part = path.with_extension("part");
    ring.write(&part).map_err(|error| failed(&error))?;
    std::fs::rename(&part, &path).map_err(|error| failed(&error))?;
    let mut files: Vec<_> = std::fs::read_dir(directory)
        .map_err(|error| failed(&error))?
        .flatten()
        .map(|entry| entry.path())
        .filter(|path| {
            let name = path.file_name().map(|name| name.to_string_lossy());
            name.is_some_and(|name| name.starts_with(&prefix) && name.ends_with(".lcmlog"))
        })
        .collect();
    files.sort();
    for old in files.iter().rev().skip(FILES) {
        // Somebody else may have removed it.
        let _ = std::fs::remove_file(old);
    }
    Ok(path)
}

fn tell(ring: &Ring, outcome: Result<PathBuf, String>) {
    // By the node's own messages: what is heard may bear any time.
    let own = || ring.kept.iter().filter(|it| it.direction == Direction::Said);
    let ends = own().next().zip(own().next_back());
    let seconds = ends.map_or(0.0, |(first, last)| 1e-6 * (last.utime - first.utime) as f64);
    match outcome {
        Ok(path) => tracing::warn!(
            "the last {seconds:.1} s are kept in {} (the newest {FILES} are left there); `touchdown analyse` reads them",
            path.display()
        ),
        Err(error) => tracing::warn!("{error}"),
    }
}

/// Where flight records go unless told otherwise: what systemd gives as a state directory, the user's own, or that for temporary
/// files.
pub fn default_directory() -> PathBuf {
    let variable = |name| {
        std::env::var_os(name)
            .filter(|value| !value.is_empty())
            .map(PathBuf::from)
    };
    // A service's state directory is its own already.
    if let Some(own) = variable("STATE_DIRECTORY") {
        return own;
    }
    variable("XDG_STATE_HOME")
        .or_else(|| variable("HOME").map(|home| home.join(".local/state")))
        .unwrap_or_else(std::env::temp_dir)
        .join("touchdown")
}

#[cfg(test)]
mod tests {
    use super::*;
    use lcmtypes::{EventLogReader, Message};
    use spatial::ports::{Stamp, Task};

    fn message(step: i64) -> Encoded {
        let stamp = Stamp {
            step,
            ..Stamp::default()
        };
        Task {
            stamp,
            ..Task::default()
        }
        .encode()
        .unwrap()
    }

    fn steps(path: &Path) -> Vec<(i64, i64, String)> {
        let events = EventLogReader::open(path).unwrap().map(Result::unwrap);
        events
            .map(|event| {
                (
                    event.utime,
                    Task::decode(&event.bytes).unwrap().stamp.step,
                    event.channel,
                )
            })
            .collect()
    }

    fn files(directory: &Path) -> Vec<PathBuf> {
        let mut files: Vec<_> = std::fs::read_dir(directory)
            .unwrap()
            .map(|entry| entry.unwrap().path())
            .collect();
        files.sort();
        files
    }

    /// Page faults of this thread that took no reading from a disk.
    fn page_faults() -> u64 {
        let stat = std::fs::read_to_string("/proc/thread-self/stat").unwrap();
        let fields = stat.rsplit_once(')').unwrap().1;
        fields.split_ascii_whitespace().nth(7).unwrap().parse().unwrap()
    }

    #[test]
    fn a_rings_memory_is_there_from_the_start() {
        let mut ring = Ring::new(BYTES);
        let message = message(1);
        ring.push(1, Direction::Said, &message);
        let before = page_faults();
        while ring.kept.len() < BYTES / message.as_bytes().len() {
            ring.push(1, Direction::Said, &message);
        }
        // It has 2048 pages for the messages' bytes and some hundred for what else is kept of them.
        let faults = page_faults() - before;
        assert!(faults < 16, "{faults} page faults");
    }

    #[test]
    fn a_ring_keeps_the_newest_messages_whole() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("log");
        let length = message(0).as_bytes().len();
        // Not a multiple of a message: they are wrapped.
        let mut ring = Ring::new(10 * length + length / 3);
        for step in 0..1000 {
            ring.push(step, Direction::Said, &message(step));
            if step % 97 == 0 {
                ring.write(&path).unwrap();
                let first = (step - 9).max(0);
                let expected: Vec<_> = (first..=step).map(|it| (it, it, "TASK".to_owned())).collect();
                assert_eq!(steps(&path), expected);
            }
        }
        assert_eq!(ring.bytes.len(), 10 * length + length / 3);
    }

    #[test]
    fn the_last_seconds_are_written_once_something_goes_wrong() {
        let directory = tempfile::tempdir().unwrap();
        let place = directory.path().join("state");
        let mut recorder = FlightRecorder::with_rings("controller", place.clone(), 4096);
        recorder.keep(1, Direction::Said, &message(1));
        recorder.write_soon();
        recorder.keep(2, Direction::Heard, &message(2));
        drop(recorder);
        let files = files(&place);
        assert_eq!(files.len(), 1, "{files:?}");
        let expected = [(1, 1, "TASK".to_owned()), (2, 2, "HEARD_TASK".to_owned())];
        assert_eq!(steps(&files[0]), expected);
        // Without trouble nothing is written.
        let quiet = FlightRecorder::with_rings("robot-sim", directory.path().join("none"), 4096);
        drop(quiet);
        assert!(!directory.path().join("none").exists());
    }

    #[test]
    fn the_newest_files_are_left_and_those_of_others() {
        let directory = tempfile::tempdir().unwrap();
        let mut ring = Ring::new(4096);
        ring.push(0, Direction::Said, &message(0));
        std::fs::write(directory.path().join("flight-sensor-sim-1.lcmlog"), "").unwrap();
        for second in 1000..1000 + FILES as i64 + 5 {
            write(&ring, second * 1_000_000, "controller", directory.path()).unwrap();
        }
        let names = files(directory.path());
        assert_eq!(names.len(), FILES + 1);
        assert!(
            names[0].ends_with("flight-controller-1005000.lcmlog"),
            "{names:?}"
        );
    }
}
