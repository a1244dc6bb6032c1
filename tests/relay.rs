//! A relay that joins ports of one multicast group, on one host or between several, and impairs what passes, seeded.

use crossbeam::channel::{Receiver, RecvTimeoutError, Sender, unbounded};
use node::clock;
use node::rights::Wanted;
use rand_core::{Rng, SeedableRng};
use rand_pcg::Pcg64;
use socket2::{Domain, Protocol, Socket, Type};
use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::io;
use std::net::{Ipv4Addr, SocketAddr, SocketAddrV4, UdpSocket};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

const GROUP: Ipv4Addr = Ipv4Addr::new(239, 255, 76, 67);
/// How often a thread looks whether it should end.
const LOOK: Duration = Duration::from_millis(50);

/// What happens to a datagram on its way to each other port.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Impairment {
    /// Probability of being lost.
    pub loss: f64,
    /// Probability of arriving twice.
    pub duplication: f64,
    /// Probability that one bit of it is another one.
    pub corruption: f64,
    /// Probability of being overtaken: it takes `OVERTAKEN` longer.
    pub reordering: f64,
    /// How long each takes at least.
    pub delay: Duration,
    /// How much longer it takes at most, uniformly distributed.
    pub jitter: Duration,
    /// Seed of the random streams.
    pub seed: u64,
}

/// How much longer a datagram takes that is overtaken.
pub(crate) const OVERTAKEN: Duration = Duration::from_millis(6);

/// Forwards each datagram heard on one of its ports to all others; dropping it ends it.
pub struct Relay {
    stop: Arc<AtomicBool>,
    lost: Arc<AtomicU64>,
    /// Ports that nothing passes, to or from.
    cut: Vec<(u16, Arc<AtomicBool>)>,
    threads: Vec<JoinHandle<()>>,
}

impl Relay {
    /// A relay between each set of `ports`; what it sends goes `ttl` networks far, 0: stays on this host.
    pub fn start(sets: &[Vec<u16>], ttl: u32, impairment: Impairment) -> io::Result<Self> {
        let mut relay = Self {
            stop: Arc::default(),
            lost: Arc::default(),
            cut: Vec::new(),
            threads: Vec::new(),
        };
        for ports in sets {
            // Sent from one socket, whose port tells what the relay itself has sent.
            let sender = Arc::new(UdpSocket::bind((Ipv4Addr::UNSPECIFIED, 0))?);
            sender.set_multicast_ttl_v4(ttl)?;
            let own = sender.local_addr()?.port();
            let (late, waiting) = unbounded();
            let postman = Postman {
                waiting,
                sender: sender.clone(),
                heap: BinaryHeap::new(),
            };
            relay.threads.push(punctual(move || postman.run()));
            let cut: Vec<_> = ports
                .iter()
                .map(|port| (*port, Arc::<AtomicBool>::default()))
                .collect();
            for (port, shut) in &cut {
                let forward = Forward {
                    receiver: receiver(*port)?,
                    sender: sender.clone(),
                    late: late.clone(),
                    own,
                    shut: shut.clone(),
                    others: cut.iter().filter(|(other, _)| other != port).cloned().collect(),
                    impairment,
                    random: Pcg64::seed_from_u64(impairment.seed.wrapping_mul(65_537) + u64::from(*port)),
                    lost: relay.lost.clone(),
                };
                let stop = relay.stop.clone();
                relay.threads.push(punctual(move || forward.run(&stop)));
            }
            relay.cut.extend(cut);
        }
        Ok(relay)
    }

    /// Datagrams lost so far.
    pub fn lost(&self) -> u64 {
        self.lost.load(Ordering::Relaxed)
    }

    /// Cut `port` off from all others, or join it again.
    pub fn cut(&self, port: u16, off: bool) {
        for (_, shut) in self.cut.iter().filter(|(known, _)| *known == port) {
            shut.store(off, Ordering::Relaxed);
        }
    }
}

impl Drop for Relay {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        for thread in self.threads.drain(..) {
            let _ = thread.join();
        }
    }
}

/// A thread that a busy machine does not hold up, as far as it lets: a network is not late because its hosts are busy.
fn punctual(work: impl FnOnce() + Send + 'static) -> JoinHandle<()> {
    std::thread::spawn(move || {
        let _missing = Wanted::default().missing();
        work();
    })
}

/// A datagram that takes longer: when it is delivered, its place among others of that time, to which port, and what it
/// says.
type Letter = (Instant, u64, u16, Vec<u8>);

/// Delivers what takes longer.
struct Postman {
    waiting: Receiver<Letter>,
    sender: Arc<UdpSocket>,
    heap: BinaryHeap<Reverse<Letter>>,
}

impl Postman {
    /// Until nobody brings anything any more.
    fn run(mut self) {
        loop {
            let next = self.heap.peek().map(|Reverse((due, ..))| *due);
            let received = match next {
                Some(due) => self.waiting.recv_deadline(due),
                None => self.waiting.recv().map_err(|_| RecvTimeoutError::Disconnected),
            };
            match received {
                Ok(letter) => self.heap.push(Reverse(letter)),
                Err(RecvTimeoutError::Disconnected) => return,
                Err(RecvTimeoutError::Timeout) => {}
            }
            let now = clock::now();
            while self.heap.peek().is_some_and(|Reverse((due, ..))| *due <= now) {
                if let Some(Reverse((_, _, port, bytes))) = self.heap.pop() {
                    let _ = self.sender.send_to(&bytes, (GROUP, port));
                }
            }
        }
    }
}

struct Forward {
    receiver: UdpSocket,
    sender: Arc<UdpSocket>,
    late: Sender<Letter>,
    own: u16,
    shut: Arc<AtomicBool>,
    others: Vec<(u16, Arc<AtomicBool>)>,
    impairment: Impairment,
    random: Pcg64,
    lost: Arc<AtomicU64>,
}

impl Forward {
    fn run(mut self, stop: &AtomicBool) {
        let mut buffer = [0; 65_536];
        let mut count = 0;
        while !stop.load(Ordering::Relaxed) {
            let Ok((length, SocketAddr::V4(source))) = self.receiver.recv_from(&mut buffer) else {
                continue;
            };
            if source.port() == self.own || self.shut.load(Ordering::Relaxed) {
                continue;
            }
            for i in 0..self.others.len() {
                let (port, shut) = self.others[i].clone();
                if shut.load(Ordering::Relaxed) {
                    continue;
                }
                for _ in 0..self.copies() {
                    count += 1;
                    self.deliver(&buffer[..length], port, count);
                }
            }
        }
    }

    fn deliver(&mut self, bytes: &[u8], port: u16, count: u64) {
        let mut bytes = bytes.to_vec();
        if self.chance(self.impairment.corruption) && !bytes.is_empty() {
            let bit = self.random.next_u64() as usize % (8 * bytes.len());
            bytes[bit / 8] ^= 1 << (bit % 8);
        }
        let Impairment { delay, jitter, .. } = self.impairment;
        let overtaken = self.chance(self.impairment.reordering);
        let mut takes = delay + jitter.mul_f64(self.share());
        if overtaken {
            takes += OVERTAKEN;
        }
        if takes.is_zero() {
            // A full buffer is one more loss.
            let _ = self.sender.send_to(&bytes, (GROUP, port));
        } else {
            let _ = self.late.send((clock::now() + takes, count, port, bytes));
        }
    }

    fn copies(&mut self) -> usize {
        if self.chance(self.impairment.loss) {
            self.lost.fetch_add(1, Ordering::Relaxed);
            return 0;
        }
        1 + usize::from(self.chance(self.impairment.duplication))
    }

    fn chance(&mut self, probability: f64) -> bool {
        self.share() >= 1.0 - probability
    }

    /// Uniformly distributed from 0 to 1.
    fn share(&mut self) -> f64 {
        (self.random.next_u64() >> 11) as f64 / (1u64 << 53) as f64
    }
}

fn receiver(port: u16) -> io::Result<UdpSocket> {
    let socket = Socket::new(Domain::IPV4, Type::DGRAM, Some(Protocol::UDP))?;
    socket.set_reuse_address(true)?;
    socket.set_reuse_port(true)?;
    // Bound to the group: traffic of other groups on the same port is not ours.
    socket.bind(&SocketAddrV4::new(GROUP, port).into())?;
    socket.join_multicast_v4(&GROUP, &Ipv4Addr::UNSPECIFIED)?;
    socket.set_read_timeout(Some(LOOK))?;
    Ok(socket.into())
}
