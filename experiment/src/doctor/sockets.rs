//! Receive buffers, and what they have lost.

use super::{Finding, Verdict, read};
use crate::run_port::{FREE_PORTS, LCM_DEFAULT_PORT};

pub(super) fn limit(name: &'static str) -> (&'static str, Option<u64>) {
    (
        name,
        read(&format!("/proc/sys/net/core/{name}")).trim().parse().ok(),
    )
}

/// liblcm takes the default size for its sockets; programs may ask for more, up to the maximum.
pub(super) fn receive_buffers(wanted: u64, limits: [(&str, Option<u64>); 2]) -> Finding {
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
pub(super) fn sockets(table: &str, asked: u16) -> Finding {
    let (mut runs, mut others, mut dropped) = (0, 0, 0);
    for line in table.lines().skip(1) {
        let mut fields = line.split_ascii_whitespace();
        let port = fields
            .nth(1)
            .and_then(|address| u16::from_str_radix(address.rsplit(':').next()?, 16).ok());
        let count = match port {
            Some(port) if port == asked => &mut others,
            Some(port) if (*FREE_PORTS.start()..=FREE_PORTS.end() + 1).contains(&port) => &mut runs,
            _ => continue,
        };
        *count += 1;
        dropped += fields
            .next_back()
            .and_then(|drops| drops.parse::<u64>().ok())
            .unwrap_or(0);
    }
    let whose = match asked {
        LCM_DEFAULT_PORT => " (other LCM programs)",
        _ => "",
    };
    let observed = format!(
        "{runs} on ports {}..={} (runs), {others} on {asked}{whose}, \
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
