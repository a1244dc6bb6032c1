//! The host check: is multicast usable here, and if not, which command mends it?
//!
//! Nothing is changed; [`examine`] opens sockets, sends one datagram with ttl 0 and reads `/proc`. It takes less
//! than a second where all is well, and never more than a few.

mod multicast;
mod realtime;

use std::fmt;
use std::fs;
use std::io;
use std::net::{Ipv4Addr, TcpListener, TcpStream};
use std::time::Duration;

use serde::Serialize;

use crate::run_port::{FREE_PORTS, Heard, LCM_DEFAULT_PORT, receiver};
use multicast::{echo, multicast, route};

/// What [`examine`] asks of the host.
#[derive(Debug, Clone)]
pub struct Options {
    /// How long a datagram may take to come back.
    pub echo_within: Duration,
    /// How long to listen for other LCM programs.
    pub listen: Duration,
    /// The receive buffer that holds a burst of messages, bytes.
    pub receive_buffer_bytes: u64,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            echo_within: Duration::from_millis(500),
            listen: Duration::from_millis(200),
            receive_buffer_bytes: 2 << 20,
        }
    }
}

/// How good a [`Finding`] is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
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

    fn mended_by(self, remedy: impl Into<String>) -> Self {
        Self {
            remedy: Some(remedy.into()),
            ..self
        }
    }
}

/// Examines this host.
pub fn examine(options: &Options) -> Vec<Finding> {
    vec![
        library(lcmtypes::LCM_VERSION, &read("/proc/self/maps")),
        loopback(options.echo_within),
        multicast(
            echo(options.echo_within),
            route(&read("/proc/net/route")).as_ref(),
        ),
        receive_buffers(
            options.receive_buffer_bytes,
            ["rmem_default", "rmem_max"].map(limit),
        ),
        sockets(&read("/proc/net/udp")),
        default_port(options.listen),
        realtime::rights(),
        realtime::wake_ups(),
    ]
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

fn limit(name: &'static str) -> (&'static str, Option<u64>) {
    (
        name,
        read(&format!("/proc/sys/net/core/{name}")).trim().parse().ok(),
    )
}

/// liblcm takes the default size for its sockets; programs may ask for more, up to the maximum.
fn receive_buffers(wanted: u64, limits: [(&str, Option<u64>); 2]) -> Finding {
    let shown = limits.map(|(name, bytes)| match bytes {
        Some(bytes) => format!("net.core.{name} {bytes} bytes"),
        None => format!("net.core.{name} can't be read here"),
    });
    let low = limits
        .into_iter()
        .filter(|(_, bytes)| bytes.is_some_and(|bytes| bytes < wanted));
    let settings: String = low
        .map(|(name, _)| format!(" net.core.{name}={wanted}"))
        .collect();
    let observed = shown.join(", ");
    if settings.is_empty() {
        Finding::new("receive buffer", Verdict::Good, observed)
    } else {
        let observed = format!("{observed}; below {wanted} bytes a burst of messages may be lost");
        Finding::new("receive buffer", Verdict::Warning, observed)
            .mended_by(format!("sudo sysctl -w{settings}"))
    }
}

/// Counts the sockets of runs and of other LCM programs, and what the kernel dropped because they read too late.
fn sockets(table: &str) -> Finding {
    let (mut runs, mut others, mut dropped) = (0, 0, 0);
    for line in table.lines().skip(1) {
        let mut fields = line.split_ascii_whitespace();
        let port = fields
            .nth(1)
            .and_then(|address| u16::from_str_radix(address.rsplit(':').next()?, 16).ok());
        let count = match port {
            Some(LCM_DEFAULT_PORT) => &mut others,
            Some(port) if (*FREE_PORTS.start()..=FREE_PORTS.end() + 1).contains(&port) => &mut runs,
            _ => continue,
        };
        *count += 1;
        dropped += fields
            .next_back()
            .and_then(|drops| drops.parse::<u64>().ok())
            .unwrap_or(0);
    }
    let observed = format!(
        "{runs} on ports {}..={} (runs), {others} on {LCM_DEFAULT_PORT} (other LCM programs), \
         {dropped} datagrams dropped by full buffers",
        FREE_PORTS.start(),
        FREE_PORTS.end() + 1
    );
    let verdict = if dropped == 0 {
        Verdict::Good
    } else {
        Verdict::Warning
    };
    Finding::new("udp sockets", verdict, observed)
}

fn default_port(listen: Duration) -> Finding {
    let heard = receiver(LCM_DEFAULT_PORT).and_then(|ear| Heard::within(&ear, listen));
    let (verdict, observed) = match heard {
        Ok(None) => (
            Verdict::Good,
            format!("port {LCM_DEFAULT_PORT} is silent for {} ms", listen.as_millis()),
        ),
        Ok(Some(heard)) => (
            Verdict::Good,
            format!(
                "port {LCM_DEFAULT_PORT} carries {heard}; it does not disturb runs, which have ports of their own"
            ),
        ),
        Err(error) => (
            Verdict::Warning,
            format!("can't listen on port {LCM_DEFAULT_PORT}: {error}"),
        ),
    };
    Finding::new("other lcm", verdict, observed)
}

#[cfg(test)]
mod tests;
