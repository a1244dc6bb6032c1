//! Rules that every node keeps, robot or sensor.

use super::Finding;
use super::echo::{echo, honest};
use super::record::{Head, Record, pairs, quantile};
use spatial::ports::{PROTOCOL, Role};
use std::collections::BTreeMap;

/// Statuses come every 100 ms; their median distance may be so far off, us.
const STATUS_US: [f64; 2] = [80e3, 120e3];
/// A node that is silent for so long is taken for gone, us.
const SILENT_US: f64 = 500e3;

/// All of them.
pub fn rules(record: &Record) -> Vec<Finding> {
    let heads = record.heads();
    vec![
        usable(record),
        status(record),
        hello(record),
        signed(record),
        boot_id(record, &heads),
        echo(record, &heads),
        honest(record, &heads),
    ]
}

/// Every message can be used: length, fingerprint, finite numbers, known codes.
pub fn usable(record: &Record) -> Finding {
    const RULE: &str = "messages can be used";
    if let Some(refused) = record.refused.iter().find(|refused| refused.count > 0) {
        let observed = format!(
            "{} messages on {} are refused: {}",
            refused.count, refused.channel, refused.why
        );
        let remedy = "generate the types from lcmtypes/types/*.lcm, fill every member, and send finite numbers and known codes";
        return Finding::broken(RULE, observed, remedy);
    }
    let [statuses, messages] = [record.statuses.len(), record.heads().len()];
    if statuses + messages == 0 {
        return Finding::not_seen(RULE, "nothing was heard");
    }
    let observed = format!(
        "all of {messages} {} and {statuses} NODE_STATUS",
        record.channel()
    );
    Finding::kept(RULE, observed)
}

/// Node and checker have the same key, or none.
pub fn signed(record: &Record) -> Finding {
    const RULE: &str = "signed with the key, or without a key";
    let Some(status) = record.statuses.last() else {
        return Finding::not_seen(RULE, "no NODE_STATUS");
    };
    let [told, own] = [status.message.authenticated, record.signed.is_some()].map(u8::from);
    if told != own {
        let observed = format!("node_authenticated is {told}, here it is {own}");
        return Finding::broken(
            RULE,
            observed,
            "give the node and this check the same --key FILE, or none of them",
        );
    }
    let Some(signed) = &record.signed else {
        return Finding::kept(RULE, "neither has a key");
    };
    let observed = format!(
        "{} of {} {} are signed and new (95 %){}",
        signed.taken,
        signed.taken + signed.refused,
        record.channel(),
        signed
            .why
            .as_ref()
            .map_or(String::new(), |why| format!("; the first other: {why}"))
    );
    Finding::judge(
        RULE,
        signed.taken > 0 && 19 * signed.refused <= signed.taken,
        observed,
        "sign with the key of the cell as lcmtypes/README.md says, tests/golden/tags being examples: session as it was heard last, \
         seq one more each time",
    )
}

/// `NODE_STATUS` every 100 ms.
pub fn status(record: &Record) -> Finding {
    const RULE: &str = "NODE_STATUS every 100 ms";
    if record.statuses.len() < 2 {
        let observed = format!(
            "{} heard in {:.1} s",
            record.statuses.len(),
            1e-6 * record.listened_us as f64
        );
        let remedy = "publish NODE_STATUS with the node's role every 100 ms, on the same LCM URL (--url), with a ttl that reaches here";
        return Finding::broken(RULE, observed, remedy);
    }
    let gaps: Vec<f64> = pairs(&record.statuses)
        .map(|(a, b)| (b.us - a.us) as f64)
        .collect();
    let [median, longest] = [0.5, 1.0].map(|ratio| quantile(&gaps, ratio).unwrap_or(0.0));
    let kept = (STATUS_US[0]..=STATUS_US[1]).contains(&median) && longest < SILENT_US;
    let observed = format!(
        "median {:.0} ms (80 to 120), longest {:.0} ms (below 500)",
        1e-3 * median,
        1e-3 * longest
    );
    Finding::judge(
        RULE,
        kept,
        observed,
        "publish it every 100 ms, whatever else happens: peers give up a node after 500 ms",
    )
}

/// The hello stays as it is, can be, and is that of the peers.
pub fn hello(record: &Record) -> Finding {
    const RULE: &str = "hello agrees with itself and the peers";
    let Some(first) = record.statuses.first() else {
        return Finding::not_seen(RULE, "no NODE_STATUS");
    };
    let hello = first.message.hello;
    if let Some(other) = record.statuses.iter().find(|it| it.message.hello != hello) {
        let observed = format!("{hello:?}, later {:?}", other.message.hello);
        return Finding::broken(
            RULE,
            observed,
            "take the five values once, and keep them until the process ends",
        );
    }
    if hello.protocol != PROTOCOL {
        let observed = format!("node_protocol is {}, here it is {PROTOCOL}", hello.protocol);
        return Finding::broken(
            RULE,
            observed,
            "generate the types from the same version of lcmtypes/types",
        );
    }
    if !(1..=12).contains(&hello.ticks_per_cycle) {
        let observed = format!(
            "node_ticks_per_cycle is {}, outside 1 to 12",
            hello.ticks_per_cycle
        );
        return Finding::broken(RULE, observed, "say T in ticks of 1 ms, usually 4");
    }
    let peer = record
        .peers
        .iter()
        .find(|it| it.message.role != Role::Controller && it.message.hello != hello);
    if let Some(peer) = peer {
        let observed = format!(
            "{hello:?}, but the {:?} says {:?}",
            peer.message.role, peer.message.hello
        );
        return Finding::broken(
            RULE,
            observed,
            "take run id, protocol, T, seed and configuration hash from the robot's NODE_STATUS",
        );
    }
    let observed = format!(
        "protocol {PROTOCOL}, T = {} ms, run id {}",
        hello.ticks_per_cycle, hello.run_id
    );
    Finding::kept(RULE, observed)
}

/// One positive boot id in all messages.
pub fn boot_id(record: &Record, heads: &[Head]) -> Finding {
    const RULE: &str = "one positive boot_id in all messages";
    let mut counts = BTreeMap::<i64, usize>::new();
    let statuses = record.statuses.iter().map(|it| it.message.stamp.boot_id);
    for id in statuses.chain(heads.iter().map(|head| head.stamp.boot_id)) {
        *counts.entry(id).or_default() += 1;
    }
    match counts.iter().next() {
        None => Finding::not_seen(RULE, "no message"),
        Some((id, _)) if counts.len() == 1 && *id > 0 => Finding::kept(RULE, format!("{id:x}")),
        Some((id, _)) if counts.len() == 1 => Finding::broken(
            RULE,
            format!("{id}, not above 0"),
            "draw a positive random number when the process starts",
        ),
        Some(_) => {
            let shown: Vec<_> = counts
                .iter()
                .take(4)
                .map(|(id, count)| format!("{id:x} in {count}"))
                .collect();
            let remedy = "draw it once per start, and put the same one into NODE_STATUS and all else; if there are two processes, stop one";
            Finding::broken(
                RULE,
                format!("{} different ones: {}", counts.len(), shown.join(", ")),
                remedy,
            )
        }
    }
}
