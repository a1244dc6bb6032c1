//! From a packet to the subscriptions that want it.

use crate::error::Refusal;
use crate::message::{CHANNELS, Message};
use crate::suffix::Suffix;
use crate::tally::{Counters, Tally};
use crossbeam::channel::{Receiver, Sender, TrySendError, bounded};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::time::Instant;

/// Every liblcm sends on this channel when it starts to receive; it is nobody's message.
pub(crate) const SELF_TEST: &str = "LCM_SELF_TEST";

/// A message and when it arrived.
#[derive(Clone, Debug, PartialEq)]
pub struct Received<M> {
    /// The message, checked.
    pub message: M,
    /// When it arrived, on this machine's monotonic clock: where the thread that controls receives by itself, as the kernel
    /// tells, however late the thread looked; else when the receiving thread got it.
    pub received_at: Instant,
}

/// A message of any channel, not decoded.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RawMessage {
    /// Channel; bytes that are not UTF-8 are replaced.
    pub channel: String,
    /// Encoding.
    pub bytes: Vec<u8>,
}

/// The newest messages of one channel. It ends (the receiver disconnects) when the link does.
#[derive(Debug)]
pub struct Subscription<M> {
    receiver: Receiver<Received<M>>,
    tally: Arc<Tally>,
}

impl<M> Subscription<M> {
    /// The oldest message that has come and not been taken.
    pub fn take(&self) -> Option<Received<M>> {
        self.receiver.try_recv().ok()
    }

    /// Where messages arrive, oldest first; to be used with `crossbeam::select!`.
    pub fn receiver(&self) -> &Receiver<Received<M>> {
        &self.receiver
    }

    /// What this subscription has received and dropped.
    pub fn counters(&self) -> Counters {
        self.tally.counters()
    }

    /// Why a message was refused last.
    pub fn last_refusal(&self) -> Option<Refusal> {
        self.tally.last_refusal()
    }
}

/// Takes the messages of one subscription.
trait Route: Send {
    fn wants(&self, channel: &[u8]) -> bool;
    fn deliver(&self, channel: &[u8], bytes: &[u8], received_at: Instant);
}

/// A bounded queue that keeps the newest, and its counts.
struct Newest<M> {
    sender: Sender<Received<M>>,
    receiver: Receiver<Received<M>>,
    tally: Arc<Tally>,
}

impl<M> Newest<M> {
    fn push(&self, message: M, received_at: Instant) {
        self.tally.receive();
        let mut item = Received { message, received_at };
        while let Err(TrySendError::Full(back)) = self.sender.try_send(item) {
            item = back;
            if self.receiver.try_recv().is_ok() {
                self.tally.drop_oldest();
            }
        }
    }
}

struct Typed<M>(Newest<M>);

impl<M: Message> Route for Typed<M> {
    fn wants(&self, channel: &[u8]) -> bool {
        channel == M::CHANNEL.as_bytes()
    }

    fn deliver(&self, _channel: &[u8], bytes: &[u8], received_at: Instant) {
        match M::decode(bytes) {
            Ok(message) => self.0.push(message, received_at),
            Err(error) => self.0.tally.refuse(error.into()),
        }
    }
}

struct Everything(Newest<RawMessage>);

impl Route for Everything {
    fn wants(&self, channel: &[u8]) -> bool {
        channel != SELF_TEST.as_bytes()
    }

    fn deliver(&self, channel: &[u8], bytes: &[u8], received_at: Instant) {
        let message = RawMessage {
            channel: String::from_utf8_lossy(channel).into_owned(),
            bytes: bytes.to_vec(),
        };
        self.0.push(message, received_at);
    }
}

/// Whether a channel is of this contract, this cell's or that of another one with a suffix, or LCM's own.
fn is_known(name: &[u8]) -> bool {
    let of = |channel: &&str| {
        name.strip_prefix(channel.as_bytes())
            .is_some_and(|suffix| suffix.is_empty() || suffix.starts_with(b"_"))
    };
    name == SELF_TEST.as_bytes() || CHANNELS.iter().any(of)
}

/// All subscriptions of a link. One thread delivers.
pub(crate) struct Router {
    suffix: Suffix,
    routes: Vec<(Box<dyn Route>, Arc<Tally>)>,
    tally: Arc<Tally>,
}

impl Router {
    /// For the messages whose channels end in `suffix`.
    pub(crate) fn new(suffix: Suffix) -> Self {
        Self {
            suffix,
            routes: Vec::new(),
            tally: Arc::default(),
        }
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.routes.is_empty()
    }

    pub(crate) fn subscribe<M: Message>(&mut self, capacity: usize) -> Subscription<M> {
        self.add(capacity, |queue| Box::new(Typed(queue)))
    }

    pub(crate) fn subscribe_all(&mut self, capacity: usize) -> Subscription<RawMessage> {
        self.add(capacity, |queue| Box::new(Everything(queue)))
    }

    fn add<M>(
        &mut self,
        capacity: usize,
        route: impl FnOnce(Newest<M>) -> Box<dyn Route>,
    ) -> Subscription<M> {
        let (sender, receiver) = bounded(capacity.max(1));
        let tally = Arc::<Tally>::default();
        let subscription = Subscription {
            receiver: receiver.clone(),
            tally: tally.clone(),
        };
        self.routes.push((
            route(Newest {
                sender,
                receiver,
                tally: tally.clone(),
            }),
            tally,
        ));
        subscription
    }

    /// The counts of the link itself, then those of its subscriptions.
    pub(crate) fn tallies(&self) -> Vec<Arc<Tally>> {
        let own = std::iter::once(&self.tally);
        own.chain(self.routes.iter().map(|(_, tally)| tally))
            .cloned()
            .collect()
    }

    /// Delivers a message that has just arrived to whom it concerns. Never panics: C code may be the caller.
    pub(crate) fn dispatch(&self, name: &[u8], bytes: &[u8], received_at: Instant) {
        let wanted = self
            .suffix
            .strip_bytes(name)
            .is_some_and(|channel| self.deliver(channel, bytes, received_at));
        if !wanted && !is_known(name) {
            self.tally.pass_over();
        }
    }

    /// Whether anybody wanted it.
    fn deliver(&self, channel: &[u8], bytes: &[u8], received_at: Instant) -> bool {
        let mut wanted = false;
        for (route, tally) in &self.routes {
            let mut deliver = || {
                if route.wants(channel) {
                    wanted = true;
                    route.deliver(channel, bytes, received_at);
                }
            };
            if catch_unwind(AssertUnwindSafe(&mut deliver)).is_err() {
                tally.refuse(Refusal::Panicked);
            }
        }
        wanted
    }

    /// Counts a packet that is no message.
    pub(crate) fn malformed(&self, length: usize) {
        self.tally.refuse(Refusal::Malformed { length });
    }
}

/// The receive stamp of what has just come.
#[expect(
    clippy::disallowed_methods,
    reason = "the receive stamp: liblcm's own is not reliable, and only here is it early enough"
)]
pub(crate) fn now() -> Instant {
    Instant::now()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::liblcm::{Handle, Inbox};
    use spatial::ports::Task;
    use std::time::Duration;

    struct Panics;

    impl Route for Panics {
        fn wants(&self, _channel: &[u8]) -> bool {
            true
        }
        fn deliver(&self, _channel: &[u8], _bytes: &[u8], _received_at: Instant) {
            panic!("a panic that must not reach C");
        }
    }

    #[test]
    fn a_panic_does_not_cross_liblcm_and_is_counted() {
        let mut router = Router::new(Suffix::default());
        let tally = Arc::<Tally>::default();
        router.routes.push((Box::new(Panics), tally.clone()));
        let tasks = router.subscribe::<Task>(1);
        let handle = Arc::new(Handle::open(c"memq://").unwrap());
        let mut inbox = Inbox::new(handle.clone(), router).unwrap();
        handle
            .publish(c"TASK", Task::default().encode().unwrap().as_bytes())
            .unwrap();
        inbox.handle(10_000).unwrap();
        assert_eq!(tally.counters().panics, 1);
        assert_eq!(tally.last_refusal(), Some(Refusal::Panicked));
        // The other subscriptions get theirs.
        assert!(tasks.receiver().recv_timeout(Duration::from_secs(1)).is_ok());
    }

    /// A queue that is too short for its reader gives him the messages in order, the newest at last, and loses none uncounted.
    #[test]
    fn while_it_is_read_a_full_queue_keeps_the_newest_and_counts_the_others() {
        const LAST: i64 = 200_000;
        let mut router = Router::new(Suffix::default());
        let tasks = router.subscribe::<Task>(2);
        let writer = std::thread::spawn(move || {
            let mut task = Task::default();
            for step in 1..=LAST {
                task.stamp.step = step;
                router.dispatch(b"TASK", task.encode().unwrap().as_bytes(), now());
            }
        });
        let (mut newest, mut taken) = (0, 0);
        // It disconnects when the router is gone.
        for it in tasks.receiver() {
            let step = it.message.stamp.step;
            assert!(step > newest, "{step} after {newest}");
            (newest, taken) = (step, taken + 1);
        }
        writer.join().unwrap();
        let counters = tasks.tally.counters();
        assert_eq!((newest, counters.received), (LAST, LAST as u64));
        assert_eq!(taken + counters.dropped, LAST as u64);
    }
}
