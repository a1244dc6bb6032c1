//! Links whose messages the calling thread receives by itself: for a thread that controls, since no other one has to wake it.

use crate::error::LcmError;
use crate::liblcm;
use crate::link::{Lcm, LcmBuilder};
use crate::multicast::{self, LARGEST_PACKET, MOST_AT_ONCE};
use crate::router::Router;
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::io::Errno;
use std::io::{self, Read};
use std::os::fd::{AsFd, BorrowedFd};
use std::os::unix::net::UnixStream;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// A node has two: device channels and simulated world.
const MOST_LINKS: usize = 2;

/// What a link receives from, and to whom that goes.
pub(crate) enum Inbox {
    /// The own multicast socket, and since when it has been empty.
    Socket(Arc<multicast::Receiver>, Router, Instant),
    /// liblcm.
    Liblcm(liblcm::Inbox),
}

impl Inbox {
    /// Readable when something has come.
    fn descriptor(&self) -> BorrowedFd<'_> {
        match self {
            Self::Socket(socket, ..) => socket.socket().as_fd(),
            Self::Liblcm(inbox) => inbox.descriptor(),
        }
    }

    /// Delivers what has come.
    fn deliver(&mut self, buffer: &mut [u8]) {
        match self {
            Self::Socket(socket, router, empty) => *empty = socket.drain(router, buffer, *empty),
            Self::Liblcm(inbox) => {
                // liblcm does not tell a timeout from a message: its descriptor does.
                for _ in 0..MOST_AT_ONCE {
                    if !readable(inbox.descriptor()) || inbox.handle(0).is_err() {
                        break;
                    }
                }
            }
        }
    }
}

fn readable(descriptor: BorrowedFd<'_>) -> bool {
    let mut waiting = [PollFd::new(&descriptor, PollFlags::IN)];
    poll(&mut waiting, Some(&Timespec::default())) == Ok(1)
}

/// Why [`Inboxes::wait`] has returned.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Woken {
    /// Messages may have come, to be taken from the subscriptions; or a signal handler ran.
    Messages,
    /// Nothing within the time.
    Nothing,
    /// There was something to read from the stream that says stop: told once for each byte, for ever once it is closed.
    Stopped,
}

/// Links that one thread receives from, and a stream that says when to stop.
pub struct Inboxes {
    stop: UnixStream,
    inboxes: Vec<Inbox>,
    buffer: Vec<u8>,
}

impl Inboxes {
    /// None yet; anything to read from `stop` ends one's waiting.
    pub fn new(stop: UnixStream) -> Self {
        Self {
            stop,
            inboxes: Vec::new(),
            buffer: vec![0; LARGEST_PACKET],
        }
    }

    /// Starts a link without a thread of its own: its subscriptions get what has come while [`Inboxes::wait`] runs.
    pub fn start(&mut self, builder: LcmBuilder) -> Result<Lcm, LcmError> {
        if self.inboxes.len() == MOST_LINKS {
            return Err(LcmError::Links { most: MOST_LINKS });
        }
        let (lcm, inbox) = builder.start_quiet()?;
        self.inboxes.push(inbox);
        Ok(lcm)
    }

    /// Waits until a message has come, for at most `limit` (`None`: for ever), and gives the subscriptions all that has. Of a
    /// flood it takes a part, so that the caller can look at its deadlines.
    pub fn wait(&mut self, limit: Option<Duration>) -> io::Result<Woken> {
        let limit = limit.map(|limit| Timespec {
            tv_sec: i64::try_from(limit.as_secs()).unwrap_or(i64::MAX),
            tv_nsec: limit.subsec_nanos().into(),
        });
        // The stream last, and again for each link that there is not: an array, since nothing is allocated here.
        let mut all: [_; MOST_LINKS + 1] = std::array::from_fn(|i| {
            let descriptor = self.inboxes.get(i).map_or(self.stop.as_fd(), Inbox::descriptor);
            PollFd::from_borrowed_fd(descriptor, PollFlags::IN)
        });
        match poll(&mut all, limit.as_ref()) {
            Ok(0) => return Ok(Woken::Nothing),
            Ok(_) => {}
            Err(Errno::INTR) => return Ok(Woken::Messages),
            Err(error) => return Err(error.into()),
        }
        let ready = all.map(|it| !it.revents().is_empty());
        if ready[MOST_LINKS] {
            // That it is readable says all.
            let _ = self.stop.read(&mut [0]);
            return Ok(Woken::Stopped);
        }
        for (inbox, ready) in self.inboxes.iter_mut().zip(ready) {
            if ready {
                inbox.deliver(&mut self.buffer);
            }
        }
        Ok(Woken::Messages)
    }
}
