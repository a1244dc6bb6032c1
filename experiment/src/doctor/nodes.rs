//! Who is on a URL, and how well.

use super::{Finding, Verdict};
use crate::program::words;
use crate::up::unpadded;
use lcmtypes::LcmBuilder;
use node::clock;
use node::greeting::role_name;
use node::rights::REMEDY;
use spatial::TICK_S;
use spatial::ports::{Fault, NodeStatus, Role, Stamp};
use std::collections::BTreeMap;
use std::time::Duration;

/// Nodes by role and process.
type Nodes = BTreeMap<(usize, i64), NodeStatus>;
/// So many are told apart.
const MOST: usize = 32;

/// The nodes on `url` that are heard within `patience`.
pub(super) fn heard(url: &str, patience: Duration) -> Vec<Finding> {
    let listen = || {
        let mut link = LcmBuilder::open(url)?;
        let statuses = link.subscribe::<NodeStatus>(64);
        let _link = link.start()?;
        let until = clock::now() + patience;
        let mut nodes = Nodes::new();
        while let Ok(received) = statuses.receiver().recv_deadline(until) {
            let status = received.message;
            if nodes.len() < MOST {
                nodes.insert((status.role as usize, status.stamp.boot_id), status);
            }
        }
        Ok::<_, lcmtypes::LcmError>(nodes)
    };
    match listen() {
        Ok(nodes) => judge(&nodes, url, patience),
        // It says how to mend it.
        Err(error) => vec![Finding::new("url", Verdict::Bad, error.to_string())],
    }
}

fn judge(nodes: &Nodes, url: &str, patience: Duration) -> Vec<Finding> {
    if nodes.is_empty() {
        return vec![
            Finding::new(
                "nodes",
                Verdict::Warning,
                format!("none heard on {url} within {} ms", patience.as_millis()),
            )
            .mended_by(
                "touchdown up CELL.toml; if they run on another host: touchdown doctor --peer, on both at the same time",
            ),
        ];
    }
    let mut findings: Vec<Finding> = nodes.values().map(|status| node(status, url)).collect();
    for role in [Role::Robot, Role::Sensor, Role::Controller] {
        let count = nodes.keys().filter(|(found, _)| *found == role as usize).count();
        if count > 1 {
            findings.push(
                Finding::new(
                    role_name(role),
                    Verdict::Bad,
                    format!("{count} processes on {url} play this role, 1 may"),
                )
                .mended_by("end all but one, or give each cell a port of its own"),
            );
        }
    }
    findings
}

/// What a node says of itself.
fn node(status: &NodeStatus, url: &str) -> Finding {
    let link = &status.link;
    // In lockstep nobody needs rights, and clocks don't matter.
    let lockstep = Stamp::lockstep(0, status.hello.seed, status.role).boot_id == status.stamp.boot_id;
    let mut text = format!(
        "on {}: {}, run {}",
        unpadded(&status.host),
        words(status.state.name()),
        status.hello.run_id
    );
    let mut remedy = None;
    let mut verdict = Verdict::Good;
    let mut worse = |found: Verdict, how: String| {
        if found > verdict {
            (verdict, remedy) = (found, Some(how));
        }
    };
    if status.fault != Fault::None {
        text += &format!(": {}", words(status.fault.name()));
        let how = match status.fault {
            Fault::HelloMismatch => {
                "start all nodes of the cell with the same file: touchdown up CELL.toml".to_owned()
            }
            Fault::SecondOwner => "end the second process in this role".to_owned(),
            _ => format!("touchdown task reset --url \"{url}\", once the cause is mended"),
        };
        worse(Verdict::Bad, how);
    }
    text += &format!(
        "; messages: {} received, {} lost, {} dropped, {} by the kernel, {} undecodable, {} refused; {} deadlines missed",
        link.received,
        link.lost,
        link.dropped,
        link.kernel_dropped.max(0),
        link.undecodable,
        link.refused,
        link.missed
    );
    if status.age.max_s > 0.0 {
        text += &format!(
            "; age of what it uses {:.2} ms (p50), {:.2} ms (p99.9)",
            1e3 * status.age.p50_s,
            1e3 * status.age.p999_s
        );
    }
    if status.role == Role::Controller && !lockstep {
        let quarter_s = f64::from(status.hello.ticks_per_cycle) * TICK_S / 4.0;
        for (i, whose) in ["robot", "sensor"].into_iter().enumerate() {
            let (offset_s, bound_s) = (status.clock_offset_s[i], status.clock_bound_s[i]);
            if bound_s <= 0.0 {
                text += &format!("; {whose}'s clock not known yet");
                continue;
            }
            text += &format!("; {whose}'s clock {offset_s:+.6} s (+- {:.0} us)", bound_s * 1e6);
            if bound_s > quarter_s {
                text += &format!(", above T/4 = {:.0} us", quarter_s * 1e6);
                let how = "touchdown doctor --peer on both hosts measures the round trip; use a wired network of its own";
                worse(Verdict::Warning, how.to_owned());
            }
        }
    }
    if !lockstep && !status.authenticated {
        text += "; without a key (`touchdown keygen`)";
    }
    if !lockstep && !status.realtime {
        text += "; without real-time rights";
        let program = format!("$(command -v {})", role_name(status.role));
        worse(Verdict::Warning, REMEDY.replace("PROGRAM", &program));
    }
    let finding = Finding::new(role_name(status.role), verdict, text);
    match remedy {
        Some(remedy) => finding.mended_by(remedy),
        None => finding,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use node::health::Health;
    use spatial::ports::{Hello, NodeState};

    const URL: &str = "udpm://239.255.76.67:7667?ttl=1";

    fn controller() -> NodeStatus {
        let hello = Hello {
            ticks_per_cycle: 4,
            run_id: 3,
            ..Hello::default()
        };
        let mut status = Health::new(Role::Controller, hello).status();
        status.stamp.boot_id = 42;
        status.state = NodeState::Running;
        (status.realtime, status.authenticated) = (true, true);
        (status.clock_offset_s, status.clock_bound_s) = ([0.25, 0.0], [50e-6, 0.0]);
        status
    }

    #[test]
    fn a_node_that_is_well_is_told_with_its_clocks() {
        let found = node(&controller(), URL);
        assert_eq!((found.verdict, found.remedy), (Verdict::Good, None));
        assert!(found.observed.contains(": running, run 3;"), "{}", found.observed);
        assert!(
            found
                .observed
                .ends_with("robot's clock +0.250000 s (+- 50 us); sensor's clock not known yet"),
            "{}",
            found.observed
        );
    }

    #[test]
    fn the_worst_of_a_node_gives_the_remedy() {
        let mut status = controller();
        (status.realtime, status.authenticated) = (false, false);
        let found = node(&status, URL);
        assert!(found.observed.contains("; without a key"), "{found:?}");
        assert_eq!(found.verdict, Verdict::Warning);
        assert!(found.remedy.unwrap().ends_with("+ep $(command -v controller)"));
        status.clock_bound_s[0] = 2e-3;
        let found = node(&status, URL);
        assert!(
            found.observed.contains("(+- 2000 us), above T/4 = 1000 us"),
            "{found:?}"
        );
        (status.fault, status.state) = (Fault::SensorStale, NodeState::Fault);
        let found = node(&status, URL);
        assert_eq!(found.verdict, Verdict::Bad);
        assert!(found.remedy.unwrap().starts_with("touchdown task reset --url"));
    }

    #[test]
    fn nobody_and_two_of_a_kind_are_told() {
        let patience = Duration::from_millis(1200);
        let none = judge(&Nodes::new(), URL, patience);
        assert_eq!(none[0].verdict, Verdict::Warning);
        let mut nodes = Nodes::new();
        for boot_id in [1, 2] {
            nodes.insert((Role::Controller as usize, boot_id), controller());
        }
        let found = judge(&nodes, URL, patience);
        assert_eq!(found.len(), 3);
        assert_eq!(found[2].verdict, Verdict::Bad);
        assert!(found[2].observed.starts_with("2 processes on"));
    }
}
