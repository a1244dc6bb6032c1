//! Who else speaks on a port.

use super::{Finding, Verdict};
use crate::log;
use crate::run_port::{Heard, member};
use node::clock;
use std::collections::BTreeMap;
use std::io;
use std::net::{IpAddr, Ipv4Addr, UdpSocket};
use std::time::Duration;

/// So many senders and channels are told apart.
const MOST: usize = 64;
/// So many are named.
const NAMED: usize = 4;

/// What is no Touchdown message, by sender and channel.
type Strangers = BTreeMap<(IpAddr, String), u32>;

/// Other LCM programs on `port`. `ours`: a cell is to use that port, so that they would disturb it.
pub(super) fn others(group: Ipv4Addr, port: u16, ours: bool, patience: Duration) -> Finding {
    let heard = member(group, port).and_then(|ear| listen(&ear, patience));
    match heard {
        Ok(strangers) => judge(&strangers, port, ours, patience),
        Err(error) => Finding::new(
            "other lcm",
            Verdict::Warning,
            format!("can't listen on port {port}: {error}"),
        ),
    }
}

fn listen(ear: &UdpSocket, patience: Duration) -> io::Result<Strangers> {
    let until = clock::now() + patience;
    let mut strangers = Strangers::new();
    loop {
        let left = until.saturating_duration_since(clock::now());
        if left.is_zero() {
            return Ok(strangers);
        }
        let Some(heard) = Heard::within(ear, left)? else {
            return Ok(strangers);
        };
        let channel = heard.channel.unwrap_or_else(|| "no short LCM message".to_owned());
        let own = channel == "LCM_SELF_TEST" || channel.starts_with(super::peer::CHANNEL);
        if own || log::suffix(&channel).is_some() {
            continue;
        }
        let key = (heard.sender.ip(), channel);
        if strangers.len() < MOST || strangers.contains_key(&key) {
            *strangers.entry(key).or_default() += 1;
        }
    }
}

fn judge(strangers: &Strangers, port: u16, ours: bool, patience: Duration) -> Finding {
    let finding = |verdict, observed: String| Finding::new("other lcm", verdict, observed);
    let ms = patience.as_millis();
    if strangers.is_empty() {
        return finding(Verdict::Good, format!("none on port {port} for {ms} ms"));
    }
    let mut named: Vec<String> = strangers
        .iter()
        .take(NAMED)
        .map(|((sender, channel), count)| format!("{channel:?} from {sender} ({count})"))
        .collect();
    if strangers.len() > NAMED {
        named.push(format!("and {} more", strangers.len() - NAMED));
    }
    let named = named.join(", ");
    if ours {
        return finding(
            Verdict::Warning,
            format!("port {port} carries {named} within {ms} ms; every node has to look at each of these"),
        )
        .mended_by(format!(
            "give the cell a port of its own: url = \"udpm://239.255.76.67:{}?ttl=1\"",
            port.saturating_add(10)
        ));
    }
    finding(
        Verdict::Good,
        format!("port {port} carries {named}; it does not disturb runs, which have ports of their own"),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strangers_are_named_and_disturb_a_cell_alone() {
        let patience = Duration::from_millis(200);
        let mut strangers = Strangers::new();
        assert_eq!(judge(&strangers, 7667, true, patience).verdict, Verdict::Good);
        for i in 0..6 {
            strangers.insert((IpAddr::from([10, 0, 0, i]), "POSE".to_owned()), 3);
        }
        let found = judge(&strangers, 7667, true, patience);
        assert_eq!(found.verdict, Verdict::Warning);
        assert!(
            found
                .observed
                .contains("\"POSE\" from 10.0.0.3 (3), and 2 more within 200 ms"),
            "{found:?}"
        );
        assert!(found.remedy.unwrap().contains(":7677?ttl=1"));
        assert_eq!(judge(&strangers, 7667, false, patience).verdict, Verdict::Good);
    }

    #[test]
    fn touchdown_s_own_messages_are_no_strangers() {
        let ear = member(crate::run_port::GROUP, 0).unwrap();
        let port = ear.local_addr().unwrap().port();
        let mouth = UdpSocket::bind((Ipv4Addr::UNSPECIFIED, 0)).unwrap();
        mouth.set_multicast_ttl_v4(0).unwrap();
        for datagram in [
            &b"LC02\0\0\0\0TASK\0x"[..],
            b"LC02\0\0\0\0TASK_B\0x",
            b"LC02\0\0\0\0TASKS\0x",
            b"noise",
        ] {
            mouth.send_to(datagram, (crate::run_port::GROUP, port)).unwrap();
        }
        let strangers = listen(&ear, Duration::from_millis(300)).unwrap();
        let channels: Vec<_> = strangers.keys().map(|(_, channel)| channel.as_str()).collect();
        assert_eq!(channels, ["TASKS", "no short LCM message"]);
    }
}
