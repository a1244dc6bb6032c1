//! The host check: is multicast usable here, and if not, which command mends it?
//!
//! Nothing is changed; [`examine`] opens sockets, sends a few datagrams and reads `/proc` and `/sys`. It takes less than two
//! seconds where all is well, and never more than a few. What two hosts hear of each other, [`peer`] measures.

mod interface;
mod multicast;
mod nodes;
pub mod peer;
mod realtime;
mod sockets;
mod traffic;

use std::fmt;
use std::fs;
use std::io;
use std::net::{Ipv4Addr, TcpListener, TcpStream};
use std::time::Duration;

use serde::Serialize;

use crate::run_port::{GROUP, LCM_DEFAULT_PORT, member};
use interface::{interface, interfaces, membership, outward};
use lcmtypes::{Group, LcmError};
use multicast::{Asked, echo, multicast, route};
use sockets::{limit, receive_buffers, sockets};

/// What [`examine`] asks of the host.
#[derive(Debug, Clone)]
pub struct Options {
    /// LCM URL of device channels that are to be used, or are; `None`: no particular one.
    pub url: Option<String>,
    /// How long a datagram may take to come back.
    pub echo_within: Duration,
    /// How long to listen for other LCM programs.
    pub listen: Duration,
    /// How long to listen for nodes: longer than they are silent; zero: not at all.
    pub listen_for_nodes: Duration,
    /// The receive buffer that holds a burst of messages, bytes.
    pub receive_buffer_bytes: u64,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            url: None,
            echo_within: Duration::from_millis(500),
            listen: Duration::from_millis(200),
            listen_for_nodes: Duration::from_millis(1200),
            receive_buffer_bytes: 2 << 20,
        }
    }
}

/// How good a [`Finding`] is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// As it should be.
    Good,
    /// Runs work, not at their best.
    Warning,
    /// No run can work.
    Bad,
}

/// One thing examined.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Finding {
    /// What was examined.
    pub name: &'static str,
    /// How good it is.
    pub verdict: Verdict,
    /// What was found, with units.
    pub observed: String,
    /// The command that mends it.
    pub remedy: Option<String>,
}

impl Finding {
    fn new(name: &'static str, verdict: Verdict, observed: impl Into<String>) -> Self {
        Self {
            name,
            verdict,
            observed: observed.into(),
            remedy: None,
        }
    }

    /// One that no run works with, which says itself how to mend it.
    pub fn bad(name: &'static str, observed: impl Into<String>) -> Self {
        Self::new(name, Verdict::Bad, observed)
    }

    fn mended_by(self, remedy: impl Into<String>) -> Self {
        Self {
            remedy: Some(remedy.into()),
            ..self
        }
    }
}

/// Examines this host, and who is heard on the URL; an error: the URL is none.
pub fn examine(options: &Options) -> Result<Vec<Finding>, LcmError> {
    let group = options.url.as_deref().map(Group::of).transpose()?.flatten();
    let (address, port, ttl) = group.map_or((GROUP, LCM_DEFAULT_PORT, 0), |group| {
        (*group.address.ip(), group.address.port(), group.ttl)
    });
    let route = route(&read("/proc/net/route"), address);
    // While the group is joined, so that its membership shows.
    let ear = member(address, 0);
    let memberships = read("/proc/net/igmp");
    drop(ear);
    let interfaces = interfaces(&read("/proc/net/dev"), &memberships);
    let asked = Asked {
        group: address,
        ttl,
        outward: outward(&interfaces),
    };
    let mut findings = vec![
        library(lcmtypes::LCM_VERSION, &read("/proc/self/maps")),
        loopback(options.echo_within),
        multicast(echo(address, options.echo_within), route.as_ref(), &asked),
        interface(route.as_ref(), &interfaces, &asked),
        membership(&memberships, route.as_ref(), address),
        receive_buffers(
            options.receive_buffer_bytes,
            ["rmem_default", "rmem_max"].map(limit),
        ),
        sockets(&read("/proc/net/udp"), port),
        traffic::others(address, port, options.url.is_some(), options.listen),
        realtime::rights(),
        realtime::wake_ups(),
    ];
    if let Some(url) = options
        .url
        .as_deref()
        .filter(|_| !options.listen_for_nodes.is_zero())
    {
        findings.extend(nodes::heard(url, options.listen_for_nodes));
    }
    Ok(findings)
}

/// The exit code of a host check: 1 if a finding is bad, else 0.
pub fn exit_code(findings: &[Finding]) -> u8 {
    findings
        .iter()
        .any(|finding| finding.verdict == Verdict::Bad)
        .into()
}

/// Findings for people: a line each, the remedy below.
#[derive(Debug, Clone, Copy)]
pub struct Table<'a>(pub &'a [Finding]);

impl fmt::Display for Table<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let width = self.0.iter().map(|finding| finding.name.len()).max().unwrap_or(0);
        for Finding {
            name,
            verdict,
            observed,
            remedy,
        } in self.0
        {
            let verdict = match verdict {
                Verdict::Good => "good",
                Verdict::Warning => "warning",
                Verdict::Bad => "BAD",
            };
            writeln!(f, "{verdict:7}  {name:width$}  {observed}")?;
            if let Some(remedy) = remedy {
                writeln!(f, "{:7}  {:width$}  remedy: {remedy}", "", "")?;
            }
        }
        Ok(())
    }
}

/// Empty where the system has no such file.
fn read(path: &str) -> String {
    fs::read_to_string(path).unwrap_or_default()
}

/// Debian's library of LCM 1.3.1 is called liblcm.so.1.3.4: the version is that of the headers.
fn library((major, minor, micro): (i32, i32, i32), maps: &str) -> Finding {
    let file = |line: &str| line.split_ascii_whitespace().nth(5).map(str::to_owned);
    let loaded = maps
        .lines()
        .filter_map(file)
        .find(|path| path.contains("/liblcm.so"));
    let place = loaded.unwrap_or_else(|| "linked into this program".to_owned());
    Finding::new(
        "liblcm",
        Verdict::Good,
        format!("LCM {major}.{minor}.{micro}, {place}"),
    )
}

/// Runs lock their ports on 127.0.0.1. (Where no interface is up, binding alone succeeds.)
fn loopback(patience: Duration) -> Finding {
    let connected = TcpListener::bind((Ipv4Addr::LOCALHOST, 0))
        .and_then(|listener| TcpStream::connect_timeout(&listener.local_addr()?, patience));
    let finding = |verdict, observed| Finding::new("loopback", verdict, observed);
    match connected {
        Ok(_) => finding(Verdict::Good, "127.0.0.1 is up".to_owned()),
        Err(error) if error.kind() == io::ErrorKind::TimedOut => finding(
            Verdict::Warning,
            "a firewall on this host drops tcp to 127.0.0.1".to_owned(),
        )
        .mended_by("sudo iptables -I INPUT -i lo -j ACCEPT"),
        Err(error) => {
            finding(Verdict::Bad, format!("127.0.0.1 is down: {error}")).mended_by("sudo ip link set lo up")
        }
    }
}

#[cfg(test)]
mod tests;
