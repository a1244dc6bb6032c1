//! LCM over UDP multicast, the receiving side.
//!
//! Messages are sent through liblcm, but received here: a message of a single packet is a header of eight bytes,
//! the channel's name, a zero and the encoding. That costs two thread wake-ups less than liblcm does, and none
//! of its defects can be reached from the network (a forged fragment makes it copy outside its buffer, a packet
//! without the zero delivers a length of 2^32 - 1, a firewall blocks it for 10 s).

use crate::datagram;
use crate::error::LcmError;
use crate::kernel;
use crate::router::{Router, SELF_TEST, now};
use crate::url::Group;
use socket2::{Domain, Protocol, SockRef, Socket, Type};
use std::io::{self, ErrorKind};
use std::net::{Ipv4Addr, UdpSocket};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Largest UDP packet.
pub(crate) const LARGEST_PACKET: usize = 65_536;
/// So many packets are delivered before the thread that receives does something else.
pub(crate) const MOST_AT_ONCE: usize = 256;
/// Bound of a wait for a packet; `interrupt` ends it sooner.
const WAIT: Duration = Duration::from_millis(100);
const ATTEMPTS: u64 = 5;

/// A socket that hears a group.
#[derive(Debug)]
pub(crate) struct Receiver {
    socket: UdpSocket,
}

impl Receiver {
    pub(crate) fn join(group: &Group) -> Result<Self, LcmError> {
        let address = group.address;
        let failed = |action| {
            move |source| LcmError::Socket {
                action,
                group: address,
                source,
            }
        };
        let socket = open().map_err(failed("open a socket"))?;
        socket.set_reuse_address(true).map_err(failed("share the port"))?;
        // A smaller buffer than asked for is granted silently.
        socket
            .set_recv_buffer_size(group.receive_buffer)
            .map_err(failed("size the receive buffer"))?;
        // Bound to the group, not to any address: packets of other groups on the same port stay out.
        socket.bind(&address.into()).map_err(failed("bind"))?;
        socket
            .join_multicast_v4(address.ip(), &Ipv4Addr::UNSPECIFIED)
            .map_err(|source| LcmError::NoRoute {
                group: address,
                source,
            })?;
        socket
            .set_read_timeout(Some(WAIT))
            .map_err(failed("set a time limit"))?;
        let socket = socket.into();
        kernel::stamp_arrivals(&socket);
        Ok(Self { socket })
    }

    /// Delivers packets until `stop` is set.
    pub(crate) fn run(&self, router: &Router, stop: &AtomicBool) {
        let mut buffer = vec![0; LARGEST_PACKET];
        while !stop.load(Ordering::Acquire) {
            match self.socket.recv(&mut buffer) {
                // An interrupt looks like an empty packet.
                Ok(0) if stop.load(Ordering::Acquire) => {}
                Ok(length) => deliver(router, &buffer[..length], now()),
                Err(error) if is_timeout(&error) => {}
                // Nothing to be done about it here; don't burn the processor.
                Err(_) => std::thread::park_timeout(WAIT),
            }
        }
    }

    /// Delivers what has come since it was `empty`, and does not wait; of a flood the first [`MOST_AT_ONCE`] packets. Returns
    /// since when it is empty now.
    pub(crate) fn drain(&self, router: &Router, buffer: &mut [u8], empty: Instant) -> Instant {
        let mut looked = now();
        for _ in 0..MOST_AT_ONCE {
            let Ok((length, age)) = kernel::take(&self.socket, buffer) else {
                // Nothing more, or an error that the next call does not find any more.
                return looked;
            };
            looked = now();
            // An age that reaches back to before it was empty is that of a clock that was set.
            let arrived = age
                .and_then(|age| looked.checked_sub(age))
                .filter(|at| *at >= empty);
            deliver(router, &buffer[..length], arrived.unwrap_or(looked));
        }
        empty
    }

    pub(crate) fn socket(&self) -> &UdpSocket {
        &self.socket
    }

    /// How many packets the kernel has dropped because the socket's buffer was full; `None`: it does not tell.
    pub(crate) fn dropped(&self) -> Option<u64> {
        kernel::dropped(&self.socket)
    }

    /// Wakes a thread in [`Receiver::run`] at once. (Linux does so although it also reports "not connected";
    /// elsewhere the thread looks at its flag every 100 ms.)
    pub(crate) fn interrupt(&self) {
        let _ = SockRef::from(&self.socket).shutdown(std::net::Shutdown::Both);
    }
}

/// Sends liblcm's own self test to the group and waits for it.
pub(crate) fn probe(group: &Group) -> Result<(), LcmError> {
    let receiver = Receiver::join(group)?;
    let address = group.address;
    let no_route = |source: io::Error| match source.kind() {
        ErrorKind::PermissionDenied => LcmError::Forbidden {
            group: address,
            source,
        },
        _ => LcmError::NoRoute {
            group: address,
            source,
        },
    };
    let sender = open().map_err(no_route)?;
    sender.set_multicast_ttl_v4(group.ttl.into()).map_err(no_route)?;
    sender.set_multicast_loop_v4(true).map_err(no_route)?;
    let mut message = Vec::new();
    datagram::join(&mut message, 0, SELF_TEST, b"lcm self test");
    for _ in 0..ATTEMPTS {
        sender.send_to(&message, &address.into()).map_err(no_route)?;
        if receiver.hears_self_test() {
            return Ok(());
        }
    }
    let waited_ms = ATTEMPTS * u64::try_from(WAIT.as_millis()).unwrap_or(u64::MAX);
    Err(LcmError::Unheard {
        group: address,
        waited_ms,
    })
}

impl Receiver {
    /// Whether a self test arrives before 100 ms of silence or a thousand other packets.
    fn hears_self_test(&self) -> bool {
        let mut buffer = vec![0; LARGEST_PACKET];
        (0..1000)
            .map_while(|_| {
                self.socket.recv(&mut buffer).ok().map(|length| {
                    datagram::split(&buffer[..length])
                        .is_some_and(|(channel, _)| channel == SELF_TEST.as_bytes())
                })
            })
            .any(|heard| heard)
    }
}

fn deliver(router: &Router, packet: &[u8], received_at: Instant) {
    match datagram::split(packet) {
        Some((channel, bytes)) => router.dispatch(channel, bytes, received_at),
        None => router.malformed(packet.len()),
    }
}

fn open() -> io::Result<Socket> {
    Socket::new(Domain::IPV4, Type::DGRAM, Some(Protocol::UDP))
}

fn is_timeout(error: &io::Error) -> bool {
    matches!(
        error.kind(),
        ErrorKind::WouldBlock | ErrorKind::TimedOut | ErrorKind::Interrupted
    )
}
