//! The check of two hosts: `touchdown doctor --peer` runs on both at once, each asks the other and answers it.
//!
//! The datagrams are LCM messages of a channel of their own, on the group, port and ttl that the nodes are to use: what hinders
//! these hinders those. Nodes that run there do not listen to that channel.

mod tally;
mod word;

pub use tally::Peer;

use super::{Finding, Verdict};
use lcmtypes::{Group, LcmBuilder, LcmError};
use node::clock::{self, Clock, HostClock};
use rustix::rand::{GetRandomFlags, getrandom};
use std::time::Duration;
use tally::Tally;
use word::Word;

/// The channel of questions and answers.
pub const CHANNEL: &str = "DOCTOR";
/// The URL where none is named: this network.
pub const DEFAULT_URL: &str = "udpm://239.255.76.67:7667?ttl=1";
/// Between two questions.
const PERIOD: Duration = Duration::from_millis(10);
/// Questions are still answered for so long after the last own one.
const LINGER: Duration = Duration::from_secs(1);
/// More than that lost, in either direction, is warned of.
const LOSS: f64 = 0.01;
/// Half of a longer round trip (p99) leaves nothing of T/4 at T = 4 ms.
const ROUND_TRIP_S: f64 = 2e-3;

/// What to measure.
#[derive(Clone, Debug)]
pub struct PeerOptions {
    /// LCM URL.
    pub url: String,
    /// How long to wait for another host.
    pub wait: Duration,
    /// How long to ask once another host is heard.
    pub measure: Duration,
}

/// Ask and answer whoever does the same on the URL.
pub fn measure(options: &PeerOptions) -> Result<Vec<Peer>, LcmError> {
    let mut builder = LcmBuilder::open(&options.url)?;
    let words = builder.subscribe_all(1024);
    let link = builder.start()?;
    let clock = HostClock::start();
    let mut tally = Tally::new(node::health::host(), identity());
    let started = clock::now();
    let (mut next, mut since) = (started, None);
    loop {
        let now = clock::now();
        let (asking, end) = match since {
            Some(since) => (since + options.measure, since + options.measure + LINGER),
            None => (started + options.wait, started + options.wait),
        };
        if now >= end {
            return Ok(tally.peers());
        }
        if now >= next && now < asking {
            next = (next + PERIOD).max(now);
            let question = tally.ask(clock.utime(clock::now()));
            // A full buffer is one more loss.
            let _ = link.publish_raw(CHANNEL, &question.encode());
        }
        let wake = if now < asking { next.min(end) } else { end };
        let Ok(received) = words.receiver().recv_deadline(wake) else {
            continue;
        };
        if received.message.channel != CHANNEL {
            continue;
        }
        let Some(word) = Word::decode(&received.message.bytes) else {
            continue;
        };
        let answer = tally.hear(&word, clock.utime(received.received_at));
        if since.is_none() && tally.any() {
            since = Some(clock::now());
        }
        if let Some(mut answer) = answer {
            answer.sent_us = clock.utime(clock::now());
            let _ = link.publish_raw(CHANNEL, &answer.encode());
        }
    }
}

/// Tells this process from all others.
fn identity() -> u64 {
    let mut bytes = [0; 8];
    match getrandom(&mut bytes, GetRandomFlags::empty()) {
        Ok(_) => u64::from_ne_bytes(bytes).max(1),
        Err(_) => u64::from(std::process::id()),
    }
}

/// What `peers` tell; without any, the probable causes.
pub fn judge(peers: &[Peer], options: &PeerOptions) -> Result<Vec<Finding>, LcmError> {
    let group = Group::of(&options.url)?;
    if peers.is_empty() {
        return Ok(nobody(options, group));
    }
    Ok(peers.iter().map(|peer| one(peer, group)).collect())
}

fn one(peer: &Peer, group: Option<Group>) -> Finding {
    let Peer { host, .. } = peer;
    let address = group.map_or(String::new(), |group| {
        format!(" -d {} --dport {}", group.address.ip(), group.address.port())
    });
    if peer.answered == 0 {
        return Finding::new(
            "peer",
            Verdict::Bad,
            format!(
                "{host}: {} of its {} datagrams heard, but no answer: it does not hear this host",
                peer.heard, peer.sent
            ),
        )
        .mended_by(format!(
            "on {host}: sudo iptables -I INPUT -p udp{address} -j ACCEPT; here, if `ip route get 239.255.76.67` names the \
             wrong interface: sudo ip route replace 224.0.0.0/4 dev INTERFACE; and a url with ttl=1 on both"
        ));
    }
    let lost = |had: usize, of: usize| 1.0 - had as f64 / of.max(1) as f64;
    let loss = lost(peer.answered, peer.asked).max(lost(peer.heard, peer.sent));
    let observed = format!(
        "{host}: {} of {} answered, {} of its {} heard; round trip {:.2} ms (p50), {:.2} ms (p99); its wall clock {:+.6} s \
         (+- {:.0} us)",
        peer.answered,
        peer.asked,
        peer.heard,
        peer.sent,
        peer.round_trip_p50_s * 1e3,
        peer.round_trip_p99_s * 1e3,
        peer.clock_offset_s,
        peer.clock_bound_s * 1e6
    );
    if loss > LOSS {
        return Finding::new(
            "peer",
            Verdict::Warning,
            format!(
                "{observed}; {:.1} % lost, above the limit of {:.0} %",
                loss * 100.0,
                LOSS * 100.0
            ),
        )
        .mended_by(
            "use a wired network of its own; sudo sysctl -w net.core.rmem_default=2097152 on both hosts",
        );
    }
    if peer.round_trip_p99_s > ROUND_TRIP_S {
        return Finding::new(
            "peer",
            Verdict::Warning,
            format!("{observed}; p99 above the limit of {} ms", ROUND_TRIP_S * 1e3),
        )
        .mended_by("use a wired network of its own, and give the hosts less other work");
    }
    Finding::new("peer", Verdict::Good, observed)
}

/// Nobody was heard: what is wrong most often, each with its remedy.
fn nobody(options: &PeerOptions, group: Option<Group>) -> Vec<Finding> {
    let url = &options.url;
    let Some(Group { address, ttl, .. }) = group else {
        return vec![
            Finding::new(
                "peer",
                Verdict::Bad,
                format!("{url} stays in one process, so that no host is heard"),
            )
            .mended_by(format!("touchdown doctor --peer --url \"{DEFAULT_URL}\"")),
        ];
    };
    let cause = |observed: String, remedy: String| {
        Finding::new("peer, cause", Verdict::Warning, observed).mended_by(remedy)
    };
    let (ip, port) = (address.ip(), address.port());
    let mut findings = vec![
        Finding::new(
            "peer",
            Verdict::Bad,
            format!(
                "no other host heard on {address} for {} s",
                options.wait.as_secs()
            ),
        )
        .mended_by(format!(
            "on the other host, at the same time: touchdown doctor --peer --url \"{url}\""
        )),
    ];
    if ttl == 0 {
        findings.push(cause(
            "ttl=0 keeps datagrams on one host".to_owned(),
            format!("touchdown doctor --peer --url \"udpm://{address}?ttl=1\", and so in the cell's url"),
        ));
    }
    findings.extend([
        cause(
            format!("multicast leaves through another interface, on either host (`ip route get {ip}` names it)"),
            "sudo ip route replace 224.0.0.0/4 dev INTERFACE".to_owned(),
        ),
        cause(
            "a firewall, on either host".to_owned(),
            format!("sudo iptables -I INPUT -p udp -d {ip} --dport {port} -j ACCEPT"),
        ),
        cause(
            "the other host's address is not routed through the interface it is heard on (reverse path filter)".to_owned(),
            "sudo sysctl -w net.ipv4.conf.all.rp_filter=2".to_owned(),
        ),
        cause(
            "a switch with IGMP snooping but without a querier, a wireless or a virtual network that drops multicast"
                .to_owned(),
            "enable the switch's querier or disable its snooping; for a Linux bridge: sudo ip link set BRIDGE type bridge \
             mcast_snooping 0"
                .to_owned(),
        ),
    ]);
    findings
}

#[cfg(test)]
mod tests;
