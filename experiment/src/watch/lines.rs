//! Where there is no terminal: a line for each change of a node or a phase, and one a second while the controller works.

use super::rows::{ControllerRow, NodeRow, Snapshot};
use std::time::{Duration, Instant};

/// From one line to the next where nothing changes but numbers.
const PERIOD: Duration = Duration::from_secs(1);

/// What has been told so far.
#[derive(Clone, Debug, Default)]
pub struct Lines {
    started: Option<Instant>,
    nodes: Vec<String>,
    phase: String,
    told: Option<(f64, Instant)>,
}

impl Lines {
    /// What there is to tell `now`.
    pub fn tell(&mut self, snapshot: &Snapshot, now: Instant) -> Vec<String> {
        // Who has not had the time to be heard is not missing.
        let started = *self.started.get_or_insert(now);
        let early = now.saturating_duration_since(started) < PERIOD;
        let known = snapshot.nodes.iter().filter(|row| row.age_s.is_some() || !early);
        let nodes: Vec<String> = known.map(node).collect();
        let known = std::mem::replace(&mut self.nodes, nodes);
        let mut news: Vec<String> = self
            .nodes
            .iter()
            .filter(|line| !known.contains(line))
            .cloned()
            .collect();
        if let Some(row) = &snapshot.controller {
            let phase = phase(row);
            let due = self.told.is_none_or(|(time_s, told)| {
                time_s != row.time_s && now.saturating_duration_since(told) >= PERIOD
            });
            if due || phase != self.phase {
                self.phase = phase;
                self.told = Some((row.time_s, now));
                news.push(controller(row));
            }
        }
        news
    }
}

fn node(row: &NodeRow) -> String {
    let state = match (&row.fault, row.silent) {
        (_, true) if row.age_s.is_some() => "silent".to_owned(),
        (Some(fault), _) => format!("{}: {fault}", row.state),
        (None, _) => row.state.clone(),
    };
    format!("{:10}  {:12}  {state}", row.node, row.host)
}

/// Phase, step of the program, and fault.
pub(super) fn phase(row: &ControllerRow) -> String {
    let step = row
        .program_step
        .map_or(String::new(), |step| format!(" ({step})"));
    let fault = row
        .fault
        .as_ref()
        .map_or(String::new(), |fault| format!(": {fault}"));
    format!("{}{step}{fault}", row.phase)
}

fn controller(row: &ControllerRow) -> String {
    let object = match row.object_position_m {
        Some(position) => format!("{:.3} mm", position[2] * 1e3),
        None => "unknown".to_owned(),
    };
    let limits = match row.limits.is_empty() {
        true => String::new(),
        false => format!("  limits: {}", row.limits.join(", ")),
    };
    format!(
        "{:10.3} s  {:14}  force {:.2} N of {:.2} N  tcp {:.3} mm  object {object}  detection {:.2} of {:.2} N  \
         impact {:.1} N at {:.1} mm/s{limits}",
        row.time_s,
        phase(row),
        row.normal_force_n,
        row.desired_force_n[2],
        row.tcp_position_m[2] * 1e3,
        row.detection.statistic_n,
        row.detection.threshold_n,
        row.impact.peak_force_n,
        row.impact.speed_m_per_s * 1e3,
    )
}
