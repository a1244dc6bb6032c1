//! A link to other programs: subscribe first, then start, then publish and receive.

use crate::datagram::LONGEST_NAME;
use crate::error::{LcmError, Refusal};
use crate::inboxes::Inbox;
use crate::liblcm::{self, Handle};
use crate::message::{Encoded, Message};
use crate::multicast;
use crate::router::{RawMessage, Router, Subscription, now};
use crate::suffix::Suffix;
use crate::tally::{Counters, Tally};
use crate::url::Url;
use std::ffi::{CStr, CString};
use std::os::fd::AsRawFd;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{self, JoinHandle};
use std::time::Duration;

/// A link that is not started: the time to subscribe.
pub struct LcmBuilder {
    url: Url,
    handle: Arc<Handle>,
    router: Router,
}

impl LcmBuilder {
    /// Opens an LCM URL: `udpm://239.255.76.67:7667?ttl=0` (a multicast group; ttl=0 stays on this machine) or
    /// `memq://` (this link alone, for tests). With `suffix=_B` all names of channels end in `_B` on the wire, and other
    /// messages are nobody's here. Says within half a second if the group can't be used.
    pub fn open(url: &str) -> Result<Self, LcmError> {
        let parsed = Url::parse(url)?;
        // liblcm's own test would block for 10 s and then leave a handle that aborts.
        if let Url::Multicast(group, _) = &parsed {
            multicast::probe(group)?;
        }
        let create = || LcmError::Create { url: url.to_owned() };
        let spelled_out = CString::new(parsed.for_liblcm()).map_err(|_| create())?;
        let handle = Handle::open(&spelled_out).ok_or_else(create)?;
        Ok(Self {
            router: Router::new(parsed.suffix()),
            url: parsed,
            handle: Arc::new(handle),
        })
    }

    /// Subscribes to the channel of `M`, keeping the newest `capacity` (at least 1) messages not yet taken.
    pub fn subscribe<M: Message>(&mut self, capacity: usize) -> Subscription<M> {
        self.router.subscribe(capacity)
    }

    /// Subscribes to every channel without decoding, for recorders and for finding foreign traffic.
    pub fn subscribe_all(&mut self, capacity: usize) -> Subscription<RawMessage> {
        self.router.subscribe_all(capacity)
    }

    /// Starts the link without a thread: what comes is delivered when [`Inbox::deliver`] is called. What was sent before is
    /// not heard.
    pub(crate) fn start_quiet(self) -> Result<(Lcm, Inbox), LcmError> {
        let tallies = self.router.tallies();
        let (inbox, socket) = match self.url.socket() {
            Some(group) => {
                let socket = Arc::new(multicast::Receiver::join(group)?);
                let inbox = Inbox::Socket(socket.clone(), self.router, now());
                (inbox, Some(socket))
            }
            None => (Inbox::Liblcm(inbox(&self.url, &self.handle, self.router)?), None),
        };
        let lcm = Lcm {
            handle: self.handle,
            suffix: self.url.suffix(),
            tallies,
            socket,
            _receiving: None,
        };
        Ok((lcm, inbox))
    }

    /// Starts the link; with subscriptions also the one thread that receives. What was sent before is not heard.
    pub fn start(self) -> Result<Lcm, LcmError> {
        let tallies = self.router.tallies();
        let receiving = if self.router.is_empty() {
            None
        } else {
            Some(Receiving::start(&self.url, &self.handle, self.router)?)
        };
        Ok(Lcm {
            handle: self.handle,
            suffix: self.url.suffix(),
            tallies,
            socket: receiving.as_ref().and_then(|it| it.socket.clone()),
            _receiving: receiving,
        })
    }
}

/// A started link. Publishing takes `&self` from any thread; dropping it ends all subscriptions.
pub struct Lcm {
    handle: Arc<Handle>,
    suffix: Suffix,
    tallies: Vec<Arc<Tally>>,
    socket: Option<Arc<multicast::Receiver>>,
    _receiving: Option<Receiving>,
}

impl Lcm {
    /// Checks, encodes and publishes a message on its channel.
    pub fn publish<M: Message>(&self, message: &M) -> Result<(), LcmError> {
        let invalid = |invalid| LcmError::Invalid {
            channel: M::CHANNEL,
            invalid,
        };
        self.publish_encoded(&message.encode().map_err(invalid)?)
    }

    /// Publishes an encoded message, perhaps again: bit for bit the same.
    pub fn publish_encoded(&self, encoded: &Encoded) -> Result<(), LcmError> {
        self.send(encoded.channel_name(), encoded.as_bytes())
    }

    /// Publishes any bytes on any channel, unchecked: for the replay of logs and for tests of robustness.
    pub fn publish_raw(&self, channel: &str, bytes: &[u8]) -> Result<(), LcmError> {
        let name = CString::new(channel).map_err(|_| LcmError::ChannelName(channel.to_owned()))?;
        self.send(&name, bytes)
    }

    fn send(&self, channel: &CStr, bytes: &[u8]) -> Result<(), LcmError> {
        let told = || channel.to_string_lossy().into_owned();
        let mut buffer = [0; LONGEST_NAME + 1];
        let name = self
            .suffix
            .append(channel, &mut buffer)
            .ok_or_else(|| LcmError::ChannelName(told()))?;
        self.handle
            .publish(name, bytes)
            .map_err(|source| LcmError::Publish {
                channel: told(),
                source,
            })
    }

    /// What the link and all its subscriptions have received and dropped.
    pub fn counters(&self) -> Counters {
        let kernel = Counters {
            kernel_dropped: self.socket.as_ref().and_then(|socket| socket.dropped()),
            ..Counters::default()
        };
        self.tallies
            .iter()
            .map(|tally| tally.counters())
            .fold(kernel, |sum, one| sum + one)
    }

    /// A message or packet refused, and why: the last one of the first subscription that refused any.
    pub fn last_refusal(&self) -> Option<Refusal> {
        self.tallies.iter().find_map(|tally| tally.last_refusal())
    }
}

/// The thread that receives; it ends when this is dropped.
struct Receiving {
    stop: Arc<AtomicBool>,
    socket: Option<Arc<multicast::Receiver>>,
    thread: Option<JoinHandle<()>>,
}

impl Receiving {
    fn start(url: &Url, handle: &Arc<Handle>, router: Router) -> Result<Self, LcmError> {
        let stop = Arc::new(AtomicBool::new(false));
        let stopped = stop.clone();
        let builder = thread::Builder::new().name("lcm-receive".to_owned());
        let (socket, thread) = match url.socket() {
            Some(group) => {
                let socket = Arc::new(multicast::Receiver::join(group)?);
                let own = socket.clone();
                (Some(socket), builder.spawn(move || own.run(&router, &stopped)))
            }
            None => {
                let inbox = inbox(url, handle, router)?;
                (None, builder.spawn(move || handle_until(inbox, &stopped)))
            }
        };
        let thread = Some(thread.map_err(LcmError::Thread)?);
        Ok(Self { stop, socket, thread })
    }
}

impl Drop for Receiving {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Release);
        if let Some(socket) = &self.socket {
            socket.interrupt();
        }
        if let Some(thread) = self.thread.take() {
            thread.thread().unpark();
            // The router catches panics; there is nothing to learn from the thread's result.
            let _ = thread.join();
        }
    }
}

/// How long liblcm waits before the thread looks at its flag.
const WAIT_MS: i32 = 20;

fn inbox(url: &Url, handle: &Arc<Handle>, router: Router) -> Result<liblcm::Inbox, LcmError> {
    let url = url.for_liblcm();
    let Some(inbox) = liblcm::Inbox::new(handle.clone(), router) else {
        return Err(LcmError::Create { url });
    };
    match inbox.descriptor().as_raw_fd() {
        0..1024 => Ok(inbox),
        descriptor => Err(LcmError::Descriptor { url, descriptor }),
    }
}

fn handle_until(mut inbox: liblcm::Inbox, stop: &AtomicBool) {
    while !stop.load(Ordering::Acquire) {
        if inbox.handle(WAIT_MS).is_err() {
            // A signal, or nothing to be done about it here; don't burn the processor.
            thread::park_timeout(Duration::from_millis(1));
        }
    }
}
