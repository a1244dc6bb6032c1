//! A relay that joins ports of one multicast group and loses and doubles datagrams on the way, seeded.

use rand_core::{Rng, SeedableRng};
use rand_pcg::Pcg64;
use socket2::{Domain, Protocol, Socket, Type};
use std::io;
use std::net::{Ipv4Addr, SocketAddr, SocketAddrV4, UdpSocket};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread::JoinHandle;
use std::time::Duration;

const GROUP: Ipv4Addr = Ipv4Addr::new(239, 255, 76, 67);
/// How often a thread looks whether it should end.
const LOOK: Duration = Duration::from_millis(50);

/// What happens to a datagram on its way to each other port.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Impairment {
    /// Probability of being lost.
    pub loss: f64,
    /// Probability of arriving twice.
    pub duplication: f64,
    /// Seed of the random streams.
    pub seed: u64,
}

/// Forwards each datagram heard on one of its ports to all others; dropping it ends it.
pub struct Relay {
    stop: Arc<AtomicBool>,
    lost: Arc<AtomicU64>,
    threads: Vec<JoinHandle<()>>,
}

impl Relay {
    /// A relay between each set of `ports`.
    pub fn start(sets: &[Vec<u16>], impairment: Impairment) -> io::Result<Self> {
        let mut relay = Self {
            stop: Arc::default(),
            lost: Arc::default(),
            threads: Vec::new(),
        };
        for ports in sets {
            // Sent from one socket, whose port tells what the relay itself has sent.
            let sender = Arc::new(UdpSocket::bind((Ipv4Addr::UNSPECIFIED, 0))?);
            sender.set_multicast_ttl_v4(0)?;
            let own = sender.local_addr()?.port();
            for &port in ports {
                let others: Vec<u16> = ports.iter().copied().filter(|other| *other != port).collect();
                let receiver = receiver(port)?;
                let (sender, stop, lost) = (sender.clone(), relay.stop.clone(), relay.lost.clone());
                let random = Pcg64::seed_from_u64(impairment.seed.wrapping_mul(65_537) + u64::from(port));
                let forward = Forward {
                    receiver,
                    sender,
                    own,
                    others,
                    impairment,
                    random,
                    lost,
                };
                relay.threads.push(std::thread::spawn(move || forward.run(&stop)));
            }
        }
        Ok(relay)
    }

    /// Datagrams lost so far.
    pub fn lost(&self) -> u64 {
        self.lost.load(Ordering::Relaxed)
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

struct Forward {
    receiver: UdpSocket,
    sender: Arc<UdpSocket>,
    own: u16,
    others: Vec<u16>,
    impairment: Impairment,
    random: Pcg64,
    lost: Arc<AtomicU64>,
}

impl Forward {
    fn run(mut self, stop: &AtomicBool) {
        let mut buffer = [0; 65_536];
        while !stop.load(Ordering::Relaxed) {
            let Ok((length, SocketAddr::V4(source))) = self.receiver.recv_from(&mut buffer) else {
                continue;
            };
            if source.port() == self.own {
                continue;
            }
            for i in 0..self.others.len() {
                let copies = self.copies();
                for _ in 0..copies {
                    // A full buffer is one more loss.
                    let _ = self.sender.send_to(&buffer[..length], (GROUP, self.others[i]));
                }
            }
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
        (self.random.next_u64() >> 11) as f64 / (1u64 << 53) as f64 >= 1.0 - probability
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
