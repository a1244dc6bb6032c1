//! Why a run cannot have a port.

use super::{FIXED_PORTS, FREE_PORTS, GROUP, Heard};
use std::io;
use std::time::Duration;

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
