//! `NODE_STATUS`.

use super::{Port, stamp, to_bool};
use crate::error::Unusable;
use spatial::ports::{Fault, Hello, Latencies, LinkQuality, NodeState, NodeStatus, Role};

impl Port for NodeStatus {
    fn to_raw(&self) -> Self::Raw {
        Self::Raw {
            step: self.stamp.step,
            utime: self.stamp.utime,
            boot_id: self.stamp.boot_id,
            node_role: text(self.role),
            node_host: self.host,
            node_state: self.state.code(),
            node_fault: self.fault.code(),
            node_fault_step: self.fault_step,
            node_fault_peer: self.fault_peer.code(),
            node_fault_expected: self.fault_expected,
            node_fault_found: self.fault_found,
            node_run_id: self.hello.run_id,
            node_protocol: self.hello.protocol,
            node_ticks_per_cycle: self.hello.ticks_per_cycle,
            node_seed: self.hello.seed,
            node_configuration_hash: self.hello.configuration_hash,
            node_published: self.link.published,
            node_received: self.link.received,
            node_repeated: self.link.repeated,
            node_lost: self.link.lost,
            node_dropped: self.link.dropped,
            node_kernel_dropped: self.link.kernel_dropped,
            node_undecodable: self.link.undecodable,
            node_refused: self.link.refused,
            node_missed: self.link.missed,
            node_answer_s: percentiles(&self.answer),
            node_lateness_s: percentiles(&self.lateness),
            node_round_trip_s: percentiles(&self.round_trip),
            node_age_s: percentiles(&self.age),
            node_clock_offset_s: self.clock_offset_s,
            node_clock_bound_s: self.clock_bound_s,
            node_clock_rate: self.clock_rate,
            node_slip_s: self.slip_s,
            node_authenticated: self.authenticated.into(),
            node_realtime: self.realtime.into(),
        }
    }

    fn from_raw(raw: &Self::Raw) -> Result<Self, Unusable> {
        Ok(Self {
            stamp: stamp!(raw),
            role: role(raw.node_role)?,
            host: raw.node_host,
            state: NodeState::from_code(raw.node_state)?,
            fault: Fault::from_code(raw.node_fault)?,
            fault_step: raw.node_fault_step,
            fault_peer: Role::from_code(raw.node_fault_peer)?,
            fault_expected: raw.node_fault_expected,
            fault_found: raw.node_fault_found,
            hello: Hello {
                run_id: raw.node_run_id,
                protocol: raw.node_protocol,
                ticks_per_cycle: raw.node_ticks_per_cycle,
                seed: raw.node_seed,
                configuration_hash: raw.node_configuration_hash,
            },
            link: LinkQuality {
                published: raw.node_published,
                received: raw.node_received,
                repeated: raw.node_repeated,
                lost: raw.node_lost,
                dropped: raw.node_dropped,
                kernel_dropped: raw.node_kernel_dropped,
                undecodable: raw.node_undecodable,
                refused: raw.node_refused,
                missed: raw.node_missed,
            },
            answer: latencies(raw.node_answer_s),
            lateness: latencies(raw.node_lateness_s),
            round_trip: latencies(raw.node_round_trip_s),
            age: latencies(raw.node_age_s),
            clock_offset_s: raw.node_clock_offset_s,
            clock_bound_s: raw.node_clock_bound_s,
            clock_rate: raw.node_clock_rate,
            slip_s: raw.node_slip_s,
            authenticated: to_bool("node_authenticated", raw.node_authenticated)?,
            realtime: to_bool("node_realtime", raw.node_realtime)?,
        })
    }
}

/// A role in ASCII, padded with zeros.
fn text(role: Role) -> [u8; 32] {
    let name: &[u8] = match role {
        Role::Robot => b"robot",
        Role::Sensor => b"sensor",
        Role::Controller => b"controller",
    };
    let mut text = [0; 32];
    text[..name.len()].copy_from_slice(name);
    text
}

fn role(found: [u8; 32]) -> Result<Role, Unusable> {
    let known = Role::ALL.iter().find(|&&role| text(role) == found);
    known.copied().ok_or(Unusable::Role(found))
}

fn percentiles(latencies: &Latencies) -> [f64; 4] {
    [
        latencies.p50_s,
        latencies.p99_s,
        latencies.p999_s,
        latencies.max_s,
    ]
}

fn latencies([p50_s, p99_s, p999_s, max_s]: [f64; 4]) -> Latencies {
    Latencies {
        p50_s,
        p99_s,
        p999_s,
        max_s,
    }
}
