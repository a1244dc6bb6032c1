//! A run's two UDP multicast ports: locked, and free of foreign traffic.
//!
//! A run talks on group 239.255.76.67, ttl 0: the device channels on one port, the simulated world on the next.
//! Two runs on the same port would mix their messages, so a run holds a lock while it lives: a TCP listener on
//! 127.0.0.1 with the number of each of the two ports. The kernel grants it to one process of one user, and
//! takes it back however that process ends; there is no lock file to clean up.

mod error;

pub use error::RunPortError;

use lcmtypes::datagram;
use std::fmt;
use std::io::{self, ErrorKind};
use std::net::{Ipv4Addr, SocketAddr, TcpListener, UdpSocket};
use std::ops::RangeInclusive;
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::Duration;

use socket2::{Domain, Protocol, Socket, Type};

/// LCM's multicast group.
pub const GROUP: Ipv4Addr = Ipv4Addr::new(239, 255, 76, 67);

/// LCM's own default port, which runs leave to others.
pub const LCM_DEFAULT_PORT: u16 = 7667;

/// The first ports that [`RunPort::free`] chooses among: even, and below those that Linux hands out by itself.
pub const FREE_PORTS: RangeInclusive<u16> = 20_000..=31_998;

/// The ports that [`RunPort::fixed`] takes: no rights are needed for them, and each has a next one.
pub const FIXED_PORTS: RangeInclusive<u16> = 1024..=65_534;

/// The two ports of a run, locked until this is dropped.
#[derive(Debug)]
pub struct RunPort {
    port: u16,
    _locks: [TcpListener; 2],
}

impl RunPort {
    /// Two ports that no other run holds and on which nothing is heard for `quiet`.
    pub fn free(quiet: Duration) -> Result<Self, RunPortError> {
        // Runs that start together begin their search apart, be they processes (with neighbouring ids) or threads.
        static CALLS: AtomicU32 = AtomicU32::new(0);
        let start = std::process::id()
            .wrapping_mul(101)
            .wrapping_add(CALLS.fetch_add(1, Ordering::Relaxed));
        let pairs = FREE_PORTS.step_by(2).len();
        for port in FREE_PORTS
            .step_by(2)
            .cycle()
            .skip(start as usize % pairs)
            .take(pairs)
        {
            match Self::claim(port, quiet) {
                Err(
                    RunPortError::Locked { .. } | RunPortError::Taken { .. } | RunPortError::Foreign { .. },
                ) => {}
                claimed => return claimed,
            }
        }
        Err(RunPortError::NoneFree)
    }

    /// `port` and the next one, if no other run holds them and nothing is heard on them for `quiet`.
    pub fn fixed(port: u16, quiet: Duration) -> Result<Self, RunPortError> {
        if !FIXED_PORTS.contains(&port) {
            return Err(RunPortError::OutOfRange { port });
        }
        Self::claim(port, quiet)
    }

    fn claim(port: u16, quiet: Duration) -> Result<Self, RunPortError> {
        let locks = [lock(port)?, lock(port + 1)?];
        let ears = [open(port)?, open(port + 1)?];
        // What reaches the second port while the first is listened to waits in its socket.
        for (ear, (port, patience)) in ears.iter().zip([(port, quiet), (port + 1, Duration::ZERO)]) {
            match Heard::within(ear, patience) {
                Ok(None) => {}
                Ok(Some(heard)) => return Err(RunPortError::Foreign { port, heard, quiet }),
                Err(error) => return Err(RunPortError::Deaf { port, error }),
            }
        }
        Ok(Self { port, _locks: locks })
    }

    /// The port of the device channels; the simulated world has the next one.
    pub fn port(&self) -> u16 {
        self.port
    }

    /// The LCM URL of the device channels.
    pub fn device_url(&self) -> String {
        url(self.port)
    }

    /// The LCM URL of the simulated world's channels.
    pub fn simulation_url(&self) -> String {
        url(self.port + 1)
    }
}

/// The LCM URL of `port` on this host: ttl 0, so that nothing leaves it.
fn url(port: u16) -> String {
    format!("udpm://{GROUP}:{port}?ttl=0")
}

fn lock(port: u16) -> Result<TcpListener, RunPortError> {
    TcpListener::bind((Ipv4Addr::LOCALHOST, port)).map_err(|error| match error.kind() {
        ErrorKind::AddrInUse => RunPortError::Locked { port },
        _ => RunPortError::NoLock { port, error },
    })
}

fn open(port: u16) -> Result<UdpSocket, RunPortError> {
    receiver(port).map_err(|error| match error.kind() {
        ErrorKind::AddrInUse => RunPortError::Taken { port },
        _ => RunPortError::Deaf { port, error },
    })
}

/// A socket that receives what an LCM node on `port` (0: any free one) receives: the port is shared with other
/// receivers, and since it is bound to all addresses, other multicast groups on the same port count too.
pub(crate) fn receiver(port: u16) -> io::Result<UdpSocket> {
    member(GROUP, port)
}

/// The same for another group.
pub(crate) fn member(group: Ipv4Addr, port: u16) -> io::Result<UdpSocket> {
    let socket = Socket::new(Domain::IPV4, Type::DGRAM, Some(Protocol::UDP))?;
    socket.set_reuse_address(true)?;
    socket.set_reuse_port(true)?;
    socket.bind(&SocketAddr::from((Ipv4Addr::UNSPECIFIED, port)).into())?;
    socket.join_multicast_v4(&group, &Ipv4Addr::UNSPECIFIED)?;
    Ok(socket.into())
}

/// A datagram heard on a port that was to be silent.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Heard {
    /// Who sent it.
    pub sender: SocketAddr,
    /// Its channel, if it is a short LCM message.
    pub channel: Option<String>,
    /// Its size, bytes.
    pub size: usize,
}

impl Heard {
    /// The first datagram that `socket` receives within `patience`, if any.
    pub(crate) fn within(socket: &UdpSocket, patience: Duration) -> io::Result<Option<Self>> {
        socket.set_nonblocking(patience.is_zero())?;
        socket.set_read_timeout(Some(patience).filter(|patience| !patience.is_zero()))?;
        let mut datagram = [0; 2048];
        loop {
            match socket.recv_from(&mut datagram) {
                Ok((size, sender)) => {
                    let channel = channel(&datagram[..size]);
                    return Ok(Some(Self {
                        sender,
                        channel,
                        size,
                    }));
                }
                Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => {
                    return Ok(None);
                }
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(error) => return Err(error),
            }
        }
    }
}

impl fmt::Display for Heard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.channel {
            Some(channel) => write!(f, "an LCM message on channel \"{channel}\" from {}", self.sender),
            None => write!(
                f,
                "a datagram of {} bytes, not a short LCM message, from {}",
                self.size, self.sender
            ),
        }
    }
}

/// The channel of a short LCM message.
fn channel(datagram: &[u8]) -> Option<String> {
    let (channel, _) = datagram::split(datagram)?;
    Some(channel.escape_ascii().to_string())
}

#[cfg(test)]
mod tests;
