//! The host check: is multicast usable here, and if not, which command mends it?
//!
//! Nothing is changed; [`examine`] opens sockets, sends one datagram with ttl 0 and reads `/proc`. It takes less
//! than a second where all is well, and never more than a few.

use std::fmt;
use std::fs;
use std::io;
use std::net::{Ipv4Addr, TcpListener, TcpStream, UdpSocket};
use std::time::Duration;

use serde::Serialize;

use crate::run_port::{FREE_PORTS, GROUP, Heard, LCM_DEFAULT_PORT, receiver};

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

/// Why a datagram sent to the group did not come back.
#[derive(Debug)]
enum NoEcho {
    Join(io::Error),
    Send(io::Error),
    Silence(Duration),
}

/// Sends one datagram to the group on a free port, ttl 0, and receives it.
fn echo(patience: Duration) -> Result<(), NoEcho> {
    let ear = receiver(0).map_err(NoEcho::Join)?;
    let open = || -> io::Result<(u16, UdpSocket)> {
        let mouth = UdpSocket::bind((Ipv4Addr::UNSPECIFIED, 0))?;
        mouth.set_multicast_ttl_v4(0)?;
        ear.set_read_timeout(Some(patience))?;
        Ok((ear.local_addr()?.port(), mouth))
    };
    let (port, mouth) = open().map_err(NoEcho::Join)?;
    let word = format!("touchdown doctor {} {port}", std::process::id());
    mouth
        .send_to(word.as_bytes(), (GROUP, port))
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

fn multicast(echo: Result<(), NoEcho>, route: Option<&Route>) -> Finding {
    let through = route.map_or_else(String::new, |route| format!(" through {route}"));
    let (observed, remedy) = match (echo, route) {
        (Ok(()), _) => {
            let observed =
                format!("a datagram to {GROUP} came back{through}; with ttl=0 none leaves this host");
            return Finding::new("multicast", Verdict::Good, observed);
        }
        (Err(NoEcho::Join(error) | NoEcho::Send(error)), None) => (
            format!("no route to {GROUP}, neither one for 224.0.0.0/4 nor a default route: {error}"),
            "sudo ip route add 224.0.0.0/4 dev lo",
        ),
        (Err(NoEcho::Send(error)), _) if error.kind() == io::ErrorKind::PermissionDenied => (
            format!("a firewall on this host forbids to send to {GROUP}{through}: {error}"),
            "sudo iptables -I OUTPUT -d 224.0.0.0/4 -p udp -j ACCEPT",
        ),
        (Err(NoEcho::Join(error) | NoEcho::Send(error)), _) => (
            format!("can't reach {GROUP}{through}: {error}"),
            "sudo ip route replace 224.0.0.0/4 dev lo",
        ),
        (Err(NoEcho::Silence(patience)), route) => (
            format!(
                "a datagram to {GROUP}{through} did not come back within {} ms: a firewall on this host drops it",
                patience.as_millis()
            ),
            match route {
                Some(route) if route.interface == "lo" => {
                    "sudo iptables -I INPUT -d 224.0.0.0/4 -p udp -j ACCEPT; or: sudo ip link set lo multicast on"
                }
                _ => "sudo iptables -I INPUT -d 224.0.0.0/4 -p udp -j ACCEPT",
            },
        ),
    };
    Finding::new("multicast", Verdict::Bad, observed).mended_by(remedy)
}

/// How multicast leaves.
#[derive(Debug, PartialEq, Eq)]
struct Route {
    interface: String,
    default: bool,
}

impl fmt::Display for Route {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let kind = if self.default {
            "the default route"
        } else {
            "a multicast route"
        };
        match self.interface.as_str() {
            "*" => write!(f, "{kind} that rejects it"),
            interface => write!(f, "{interface} ({kind})"),
        }
    }
}

/// The route to the group in `/proc/net/route`: that of the longest mask, then of the least metric.
fn route(table: &str) -> Option<Route> {
    const UP: u32 = 0x1;
    let group = u32::from_ne_bytes(GROUP.octets());
    let matching = |line: &str| {
        let fields: Vec<&str> = line.split_ascii_whitespace().collect();
        let hex = |index: usize| u32::from_str_radix(fields.get(index)?, 16).ok();
        let (destination, flags, mask) = (hex(1)?, hex(3)?, hex(7)?);
        let metric: u32 = fields[6].parse().ok()?;
        (flags & UP != 0 && group & mask == destination).then(|| {
            let route = Route {
                interface: fields[0].to_owned(),
                default: mask == 0,
            };
            (std::cmp::Reverse(mask.count_ones()), metric, route)
        })
    };
    table
        .lines()
        .skip(1)
        .filter_map(matching)
        .min_by_key(|&(mask, metric, _)| (mask, metric))
        .map(|(.., route)| route)
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
mod tests {
    use super::*;

    const HEADER: &str = "Iface\tDestination\tGateway\tFlags\tRefCnt\tUse\tMetric\tMask\tMTU\tWindow\tIRTT\n";

    #[test]
    fn this_host_is_examined() {
        let options = Options {
            listen: Duration::from_millis(20),
            ..Options::default()
        };
        let findings = examine(&options);
        let names: Vec<_> = findings.iter().map(|finding| finding.name).collect();
        assert_eq!(
            names,
            [
                "liblcm",
                "loopback",
                "multicast",
                "receive buffer",
                "udp sockets",
                "other lcm"
            ]
        );
        // The tests need multicast themselves.
        assert_eq!(exit_code(&findings), 0, "{}", Table(&findings));
    }

    #[test]
    fn the_most_specific_route_counts() {
        let default = "eth0\t00000000\t010200C0\t0003\t0\t0\t100\t00000000\t0\t0\t0\n";
        let better_default = "wlan0\t00000000\t010200C0\t0003\t0\t0\t50\t00000000\t0\t0\t0\n";
        let elsewhere = "eth1\t000200C0\t00000000\t0001\t0\t0\t0\t00FFFFFF\t0\t0\t0\n";
        let multicast = "lo\t000000E0\t00000000\t0001\t0\t0\t0\t000000F0\t0\t0\t0\n";
        let rejecting = "*\t000000E0\t00000000\t0201\t0\t0\t0\t000000F0\t0\t0\t0\n";
        let through =
            |lines: &[&str]| route(&format!("{HEADER}{}", lines.concat())).map(|route| route.interface);
        assert_eq!(through(&[]), None);
        assert_eq!(through(&[elsewhere]), None);
        assert_eq!(
            through(&[elsewhere, default, better_default]).as_deref(),
            Some("wlan0")
        );
        assert_eq!(through(&[default, multicast]).as_deref(), Some("lo"));
        assert_eq!(through(&[default, rejecting]).as_deref(), Some("*"));
        assert_eq!(route("garbage\nlo x y z\n"), None);
    }

    #[test]
    fn each_cause_has_its_remedy() {
        let lo = Route {
            interface: "lo".to_owned(),
            default: false,
        };
        let eth0 = Route {
            interface: "eth0".to_owned(),
            default: true,
        };
        let denied = || io::Error::from(io::ErrorKind::PermissionDenied);
        let unreachable = || io::Error::from(io::ErrorKind::NetworkUnreachable);
        let silence = || NoEcho::Silence(Duration::from_millis(500));
        let cases = [
            (
                NoEcho::Join(unreachable()),
                None,
                "no route",
                "ip route add 224.0.0.0/4 dev lo",
            ),
            (
                NoEcho::Send(unreachable()),
                None,
                "no route",
                "ip route add 224.0.0.0/4 dev lo",
            ),
            (
                NoEcho::Send(denied()),
                Some(&eth0),
                "firewall",
                "iptables -I OUTPUT",
            ),
            (
                silence(),
                Some(&eth0),
                "through eth0 (the default route) did not come back within 500 ms",
                "-I INPUT",
            ),
            (silence(), Some(&lo), "firewall", "ip link set lo multicast on"),
        ];
        for (failure, route, observed, remedy) in cases {
            let finding = multicast(Err(failure), route);
            assert_eq!(finding.verdict, Verdict::Bad);
            assert!(finding.observed.contains(observed), "{finding:?}");
            assert!(
                finding
                    .remedy
                    .as_deref()
                    .is_some_and(|text| text.contains(remedy)),
                "{finding:?}"
            );
        }
    }

    #[test]
    fn small_receive_buffers_are_warned_of() {
        let finding = receive_buffers(
            2 << 20,
            [("rmem_default", Some(212_992)), ("rmem_max", Some(4 << 20))],
        );
        assert_eq!(finding.verdict, Verdict::Warning);
        assert_eq!(
            finding.remedy.as_deref(),
            Some("sudo sysctl -w net.core.rmem_default=2097152")
        );
        let finding = receive_buffers(2 << 20, [("rmem_default", Some(2 << 20)), ("rmem_max", None)]);
        assert_eq!((finding.verdict, finding.remedy), (Verdict::Good, None));
    }

    #[test]
    fn sockets_and_their_losses_are_counted() {
        let line = |port: u16, drops: u32| {
            format!(" 1: 00000000:{port:04X} 00000000:0000 07 0:0 0:0 0 0 0 9 2 0 {drops}\n")
        };
        let table = [
            "header\n".to_owned(),
            line(7667, 0),
            line(20_000, 3),
            line(31_999, 4),
            line(32_000, 9),
        ]
        .concat();
        let finding = sockets(&table);
        assert_eq!(finding.verdict, Verdict::Warning);
        assert!(
            finding
                .observed
                .starts_with("2 on ports 20000..=31999 (runs), 1 on 7667"),
            "{}",
            finding.observed
        );
        assert!(
            finding.observed.contains("7 datagrams dropped"),
            "{}",
            finding.observed
        );
    }

    #[test]
    fn the_loaded_library_is_named() {
        let maps =
            "7f00-7f01 r-xp 00000000 08:01 42    /usr/lib/liblcm.so.1.3.4\n7f02-7f03 rw-p 0 00:00 0 \n";
        assert!(
            library((1, 3, 1), maps)
                .observed
                .contains("/usr/lib/liblcm.so.1.3.4")
        );
        assert!(
            library((1, 5, 0), "")
                .observed
                .contains("linked into this program")
        );
    }

    #[test]
    fn the_table_is_aligned_and_json_has_the_same() {
        let findings = [
            Finding::new("loopback", Verdict::Good, "127.0.0.1 is up"),
            Finding::new("multicast", Verdict::Bad, "no route").mended_by("sudo x"),
        ];
        let expected = "good     loopback   127.0.0.1 is up\n\
                        BAD      multicast  no route\n                    remedy: sudo x\n";
        assert_eq!(Table(&findings).to_string(), expected);
        assert_eq!(exit_code(&findings), 1);
        let json = serde_json::to_string(&findings[1]).unwrap();
        assert_eq!(
            json,
            r#"{"name":"multicast","verdict":"bad","observed":"no route","remedy":"sudo x"}"#
        );
    }
}
