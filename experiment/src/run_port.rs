//! A run's two UDP multicast ports: locked, and free of foreign traffic.
//!
//! A run talks on group 239.255.76.67, ttl 0: the device channels on one port, the simulated world on the next.
//! Two runs on the same port would mix their messages, so a run holds a lock while it lives: a TCP listener on
//! 127.0.0.1 with the number of each of the two ports. The kernel grants it to one process of one user, and
//! takes it back however that process ends; there is no lock file to clean up.

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
    let socket = Socket::new(Domain::IPV4, Type::DGRAM, Some(Protocol::UDP))?;
    socket.set_reuse_address(true)?;
    socket.set_reuse_port(true)?;
    socket.bind(&SocketAddr::from((Ipv4Addr::UNSPECIFIED, port)).into())?;
    socket.join_multicast_v4(&GROUP, &Ipv4Addr::UNSPECIFIED)?;
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

/// The channel of a short LCM message: magic "LC02", a sequence number, the channel, a zero byte, the data.
fn channel(datagram: &[u8]) -> Option<String> {
    let rest = datagram.strip_prefix(b"LC02")?.get(4..)?;
    let end = rest.iter().take(64).position(|&byte| byte == 0)?;
    Some(rest[..end].escape_ascii().to_string())
}

/// Why a run cannot have a port.
#[derive(Debug, thiserror::Error)]
pub enum RunPortError {
    /// Another run holds it.
    #[error(
        "port {port} is locked by another run (it holds tcp 127.0.0.1:{port}); wait for that run to end, \
         or leave out --port to get a free one"
    )]
    Locked {
        /// The port.
        port: u16,
    },
    /// A program has it that does not share it.
    #[error(
        "udp port {port} belongs to a program that does not share it (`ss -ulpn sport = :{port}` names it); \
         end that program, or leave out --port to get a free one"
    )]
    Taken {
        /// The port.
        port: u16,
    },
    /// Somebody else sends there.
    #[error(
        "port {port} carries foreign traffic: {heard} within {} ms, where silence is needed; end that sender \
         (on this host, `ss -uapn sport = :{}` names it), or leave out --port to get a free one",
        quiet.as_millis(), heard.sender.port()
    )]
    Foreign {
        /// The port.
        port: u16,
        /// What was heard.
        heard: Heard,
        /// How long the port had to be silent.
        quiet: Duration,
    },
    /// The number itself is impossible.
    #[error(
        "port {port} is outside {}..={}: a run uses the port and the next one, without the rights of root; \
         choose one inside, or leave out --port to get a free one",
        FIXED_PORTS.start(), FIXED_PORTS.end()
    )]
    OutOfRange {
        /// The port.
        port: u16,
    },
    /// All of [`FREE_PORTS`] are in use.
    #[error(
        "no two consecutive ports of {}..={} are free: all are locked by other runs or carry traffic; \
         `ss -ulpn` and `ss -tlpn` name the programs, end some of them",
        FREE_PORTS.start(), FREE_PORTS.end() + 1
    )]
    NoneFree,
    /// The lock could not be taken for another reason.
    #[error(
        "can't lock port {port} (tcp 127.0.0.1:{port}): {error}; is loopback up (`sudo ip link set lo up`)? \
         `touchdown doctor` examines this host"
    )]
    NoLock {
        /// The port.
        port: u16,
        /// What the system said.
        error: io::Error,
    },
    /// Multicast cannot be received.
    #[error(
        "can't receive multicast group {GROUP} on udp port {port}: {error}{}; `touchdown doctor` examines this host",
        route_remedy(error)
    )]
    Deaf {
        /// The port.
        port: u16,
        /// What the system said.
        error: io::Error,
    },
}

/// Linux says "no such device" (ENODEV) when no route tells it through which one the group is reached.
fn route_remedy(error: &io::Error) -> &'static str {
    const ENODEV: i32 = 19;
    match error.raw_os_error() {
        Some(ENODEV) => " (no route to it: `sudo ip route add 224.0.0.0/4 dev lo`)",
        _ => "",
    }
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc;
    use std::thread;

    use super::*;

    const QUIET: Duration = Duration::from_millis(50);

    fn sender() -> UdpSocket {
        let socket = UdpSocket::bind((Ipv4Addr::UNSPECIFIED, 0)).unwrap();
        socket.set_multicast_ttl_v4(0).unwrap();
        socket
    }

    #[test]
    fn a_locked_port_is_refused_until_it_is_released() {
        let run = RunPort::free(QUIET).unwrap();
        let port = run.port();
        assert!(FREE_PORTS.contains(&port) && port.is_multiple_of(2));
        assert_eq!(run.device_url(), format!("udpm://239.255.76.67:{port}?ttl=0"));
        assert_eq!(
            run.simulation_url(),
            format!("udpm://239.255.76.67:{}?ttl=0", port + 1)
        );

        // A run that overlaps by one port is refused as well.
        for asked in [port - 1, port, port + 1] {
            let error = RunPort::fixed(asked, QUIET).unwrap_err();
            assert!(matches!(error, RunPortError::Locked { .. }), "{asked}: {error}");
        }
        let other = RunPort::free(QUIET).unwrap();
        assert_ne!(other.port(), port);

        drop(run);
        assert_eq!(RunPort::fixed(port, QUIET).unwrap().port(), port);
    }

    #[test]
    fn foreign_traffic_is_named() {
        for offset in [0, 1] {
            let port = RunPort::free(QUIET).unwrap().port();
            let (socket, (stop, stopped)) = (sender(), mpsc::channel::<()>());
            let local = socket.local_addr().unwrap().port();
            let chatter = thread::spawn(move || {
                while stopped.recv_timeout(Duration::from_millis(5)) == Err(mpsc::RecvTimeoutError::Timeout) {
                    socket
                        .send_to(b"LC02\0\0\0\x07ARM_STATE\0...", (GROUP, port + offset))
                        .unwrap();
                }
            });
            let error = RunPort::fixed(port, 20 * QUIET).unwrap_err();
            drop(stop);
            chatter.join().unwrap();
            match &error {
                RunPortError::Foreign { port: on, heard, .. } => {
                    assert_eq!((*on, heard.sender.port()), (port + offset, local));
                    assert_eq!(heard.channel.as_deref(), Some("ARM_STATE"));
                }
                _ => panic!("{error}"),
            }
            assert!(
                error.to_string().contains("channel \"ARM_STATE\" from"),
                "{error}"
            );
        }
    }

    #[test]
    fn a_listener_is_no_foreign_traffic() {
        let run = RunPort::free(QUIET).unwrap();
        let port = run.port();
        drop(run);
        let _spy = receiver(port).unwrap();
        assert!(RunPort::fixed(port, QUIET).is_ok());
    }

    #[test]
    fn a_port_that_is_not_shared_is_refused() {
        let port = RunPort::free(QUIET).unwrap().port();
        let _owner = UdpSocket::bind((Ipv4Addr::UNSPECIFIED, port)).unwrap();
        let error = RunPort::fixed(port, QUIET).unwrap_err();
        assert!(matches!(error, RunPortError::Taken { .. }), "{error}");
    }

    #[test]
    fn ports_out_of_range_are_refused() {
        for port in [0, 1023, 65_535] {
            let error = RunPort::fixed(port, QUIET).unwrap_err();
            assert!(matches!(error, RunPortError::OutOfRange { .. }), "{error}");
        }
    }

    #[test]
    fn channels_of_short_messages_are_read_and_nothing_else() {
        assert_eq!(
            channel(b"LC02\0\0\0\x01ROBOT_STATE\0data").as_deref(),
            Some("ROBOT_STATE")
        );
        assert_eq!(channel(b"LC02\0\0\0\x01\x1b[31m\0").as_deref(), Some("\\x1b[31m"));
        let endless = [b"LC02\0\0\0\x01".as_slice(), &[b'A'; 100]].concat();
        for other in [
            b"".as_slice(),
            b"LC02",
            b"LC02\0\0\0",
            b"LC02\0\0\0\x01NO_END",
            b"LC03\0\0\0\x01A\0",
            &endless,
        ] {
            assert_eq!(channel(other), None, "{other:?}");
        }
    }
}
