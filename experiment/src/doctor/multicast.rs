//! Does a datagram to LCM's group come back, and which way does it go?

use super::{Finding, Verdict};
use crate::run_port::member;
use std::fmt;
use std::io;
use std::net::{Ipv4Addr, UdpSocket};
use std::time::Duration;

/// Why a datagram sent to the group did not come back.
#[derive(Debug)]
pub(super) enum NoEcho {
    Join(io::Error),
    Send(io::Error),
    Silence(Duration),
}

/// Sends one datagram to the group on a free port, ttl 0, and receives it.
pub(super) fn echo(group: Ipv4Addr, patience: Duration) -> Result<(), NoEcho> {
    let ear = member(group, 0).map_err(NoEcho::Join)?;
    let open = || -> io::Result<(u16, UdpSocket)> {
        let mouth = UdpSocket::bind((Ipv4Addr::UNSPECIFIED, 0))?;
        mouth.set_multicast_ttl_v4(0)?;
        ear.set_read_timeout(Some(patience))?;
        Ok((ear.local_addr()?.port(), mouth))
    };
    let (port, mouth) = open().map_err(NoEcho::Join)?;
    let word = format!("touchdown doctor {} {port}", std::process::id());
    mouth
        .send_to(word.as_bytes(), (group, port))
        .map_err(NoEcho::Send)?;
    let mut heard = [0; 64];
    // Somebody else's datagram may come first.
    for _ in 0..4 {
        match ear.recv_from(&mut heard) {
            Ok((size, _)) if heard[..size] == *word.as_bytes() => return Ok(()),
            Ok(_) => {}
            Err(_) => break,
        }
    }
    Err(NoEcho::Silence(patience))
}

/// What multicast is wanted for.
#[derive(Debug)]
pub(super) struct Asked<'a> {
    pub(super) group: Ipv4Addr,
    /// 0: this host alone.
    pub(super) ttl: u8,
    /// An interface that leads out of this host.
    pub(super) outward: Option<&'a str>,
}

impl Asked<'_> {
    /// The interface that multicast should take.
    pub(super) fn interface(&self) -> &str {
        match self.ttl {
            0 => "lo",
            _ => self.outward.unwrap_or("INTERFACE"),
        }
    }

    /// How far messages go.
    fn reach(&self) -> String {
        match self.ttl {
            0 => "with ttl=0 none leaves this host".to_owned(),
            1 => "with ttl=1 they reach this network".to_owned(),
            ttl => format!(
                "with ttl={ttl} they pass {} routers, if these forward multicast",
                ttl - 1
            ),
        }
    }
}

/// Whether the group is reached, and if not, why.
pub(super) fn multicast(echo: Result<(), NoEcho>, route: Option<&Route>, asked: &Asked<'_>) -> Finding {
    let through = route.map_or_else(String::new, |route| format!(" through {route}"));
    let group = asked.group;
    let interface = asked.interface();
    let (observed, remedy) = match (echo, route) {
        (Ok(()), _) => {
            let observed = format!("a datagram to {group} came back{through}; {}", asked.reach());
            return Finding::new("multicast", Verdict::Good, observed);
        }
        (Err(NoEcho::Join(error) | NoEcho::Send(error)), None) => (
            format!("no route to {group}, neither one for 224.0.0.0/4 nor a default route: {error}"),
            format!("sudo ip route add 224.0.0.0/4 dev {interface}"),
        ),
        (Err(NoEcho::Send(error)), _) if error.kind() == io::ErrorKind::PermissionDenied => (
            format!("a firewall on this host forbids to send to {group}{through}: {error}"),
            "sudo iptables -I OUTPUT -d 224.0.0.0/4 -p udp -j ACCEPT".to_owned(),
        ),
        (Err(NoEcho::Join(error) | NoEcho::Send(error)), Some(route)) if route.interface == REJECTED => {
            (format!("can't reach {group}{through}: {error}"), route.removal())
        }
        (Err(NoEcho::Join(error) | NoEcho::Send(error)), _) => (
            format!("can't reach {group}{through}: {error}"),
            format!("sudo ip route replace 224.0.0.0/4 dev {interface}"),
        ),
        (Err(NoEcho::Silence(patience)), route) => (
            format!(
                "a datagram to {group}{through} did not come back within {} ms: a firewall on this host drops it",
                patience.as_millis()
            ),
            match route {
                Some(route) if route.interface == "lo" => {
                    "sudo iptables -I INPUT -d 224.0.0.0/4 -p udp -j ACCEPT; or: sudo ip link set lo multicast on"
                }
                _ => "sudo iptables -I INPUT -d 224.0.0.0/4 -p udp -j ACCEPT",
            }
            .to_owned(),
        ),
    };
    Finding::new("multicast", Verdict::Bad, observed).mended_by(remedy)
}

/// What stands for the interface of a route that rejects.
pub(super) const REJECTED: &str = "*";

/// How multicast leaves.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Route {
    pub(super) interface: String,
    /// Address and length of the mask.
    pub(super) destination: String,
}

impl Route {
    /// The command that takes it away.
    pub(super) fn removal(&self) -> String {
        format!("sudo ip route del {}", self.destination)
    }
}

impl fmt::Display for Route {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            interface,
            destination,
        } = self;
        let kind = match destination.as_str() {
            "0.0.0.0/0" => "the default route".to_owned(),
            destination => format!("the route for {destination}"),
        };
        match interface.as_str() {
            REJECTED => write!(f, "{kind}, which rejects it"),
            interface => write!(f, "{interface} ({kind})"),
        }
    }
}

/// The route to the group in `/proc/net/route`: that of the longest mask, then of the least metric.
pub(super) fn route(table: &str, group: Ipv4Addr) -> Option<Route> {
    const UP: u32 = 0x1;
    let group = u32::from_ne_bytes(group.octets());
    let matching = |line: &str| {
        let fields: Vec<&str> = line.split_ascii_whitespace().collect();
        let hex = |index: usize| u32::from_str_radix(fields.get(index)?, 16).ok();
        let (destination, flags, mask) = (hex(1)?, hex(3)?, hex(7)?);
        let metric: u32 = fields[6].parse().ok()?;
        let length = mask.count_ones();
        (flags & UP != 0 && group & mask == destination).then(|| {
            let route = Route {
                interface: fields[0].to_owned(),
                destination: format!("{}/{length}", Ipv4Addr::from(destination.to_ne_bytes())),
            };
            (std::cmp::Reverse(length), metric, route)
        })
    };
    table
        .lines()
        .skip(1)
        .filter_map(matching)
        .min_by_key(|&(length, metric, _)| (length, metric))
        .map(|(.., route)| route)
}
