//! How long messages took, and what nodes say of themselves.

use crate::transcript::{self, Entry};
use node::greeting::role_name;
use serde::Serialize;
use spatial::ports::{Command, Latencies, NodeStatus, RobotState, Role};
use std::collections::BTreeMap;

/// Times of a log.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Timing {
    /// From the sampling of a state to the arrival of the command that answers it, both on the robot's own clock, s, in the order
    /// of the commands; empty in lockstep, whose time is simulated.
    pub answers_s: Vec<f64>,
    /// Cycles without a new command, as the robot has counted.
    pub missed_commands: Option<i64>,
    /// The last that each node has said of itself.
    pub nodes: Vec<Health>,
}

/// What a node said of itself last; times are median, 99th and 99.9th percentile and maximum, s.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Health {
    /// Which.
    pub node: &'static str,
    /// Deadlines missed.
    pub missed: i64,
    /// Gaps in the peers' sequence.
    pub lost: i64,
    /// Dropped by a full queue.
    pub dropped: i64,
    /// Not usable.
    pub undecodable: i64,
    /// Time to answer.
    pub answer_s: [f64; 4],
    /// Lateness of its wake-up.
    pub lateness_s: [f64; 4],
    /// Round trip to the peers.
    pub round_trip_s: [f64; 4],
    /// Plant time lost against the wall clock, s.
    pub slip_s: f64,
    /// Whether it had real-time rights.
    pub realtime: bool,
}

pub(super) fn of(said: &[Entry]) -> Timing {
    let mut last: BTreeMap<i32, NodeStatus> = BTreeMap::new();
    transcript::messages::<NodeStatus>(said).for_each(|status| {
        last.insert(status.role as i32, status);
    });
    Timing {
        answers_s: answers(said),
        missed_commands: transcript::messages::<RobotState>(said)
            .last()
            .map(|state| state.missed_commands),
        nodes: last.values().map(health).collect(),
    }
}

fn answers(said: &[Entry]) -> Vec<f64> {
    let sampled: BTreeMap<i64, i64> = transcript::messages::<RobotState>(said)
        .map(|state| (state.stamp.step, state.stamp.utime))
        .collect();
    // By the time at which it was sent, a command is told.
    let arrived: BTreeMap<i64, i64> = transcript::messages::<RobotState>(said)
        .map(|state| (state.echo.command_send_utime, state.echo.receive_utime))
        .filter(|(sent, _)| *sent != 0)
        .collect();
    let commands = transcript::messages::<Command>(said);
    commands
        .filter_map(|command| {
            let from = sampled.get(&command.stamp.step)?;
            let to = arrived.get(&command.send_utime)?;
            Some(1e-6 * (to - from) as f64)
        })
        .collect()
}

fn health(status: &NodeStatus) -> Health {
    let all = |it: &Latencies| [it.p50_s, it.p99_s, it.p999_s, it.max_s];
    let link = &status.link;
    Health {
        node: role_name(status.role),
        missed: link.missed,
        lost: link.lost,
        dropped: link.dropped,
        undecodable: link.undecodable,
        answer_s: all(&status.answer),
        lateness_s: all(&status.lateness),
        round_trip_s: all(&status.round_trip),
        slip_s: if status.role == Role::Robot {
            status.slip_s
        } else {
            0.0
        },
        realtime: status.realtime,
    }
}

impl Timing {
    /// Median, 99th and 99.9th percentile and maximum of the answers' times, s; `None`: there are none.
    pub fn percentiles_s(&self) -> Option<[f64; 4]> {
        let mut sorted = self.answers_s.clone();
        sorted.sort_by(f64::total_cmp);
        let last = sorted.len().checked_sub(1)?;
        let at = |share: f64| sorted[libm::ceil(share * last as f64) as usize];
        Some([at(0.5), at(0.99), at(0.999), at(1.0)])
    }
}
