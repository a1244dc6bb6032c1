//! Whether this host can keep time.

use super::{Finding, Verdict};
use crate::launch::programs;
use crossbeam::channel::{RecvTimeoutError, never};
use node::clock;
use node::rights::{REMEDY, Wanted};
use std::thread;
use std::time::Duration;

/// Ticks that are waited for.
const TICKS: u32 = 300;
const TICK: Duration = Duration::from_millis(1);
/// A later wake-up costs a cycle of T = 4 ms its quarter.
const LATE: Duration = Duration::from_millis(1);

/// Whether a node would get real-time rights.
pub(super) fn rights() -> Finding {
    // In a thread of its own, which ends with them.
    let missing = thread::spawn(|| Wanted::default().missing())
        .join()
        .unwrap_or_default();
    if missing.is_empty() {
        return Finding::new("real-time rights", Verdict::Good, "had");
    }
    Finding::new(
        "real-time rights",
        Verdict::Warning,
        format!("not had: {}", missing.join(", ")),
    )
    .mended_by(remedy())
}

/// What gives the rights to all programs.
fn remedy() -> String {
    let Ok(programs) = programs() else {
        return format!("{REMEDY} (for each of robot-sim, sensor-sim, controller)");
    };
    let program = |name: &str| format!(" cap_sys_nice,cap_ipc_lock+ep {}", programs.join(name).display());
    let all: String = ["robot-sim", "sensor-sim", "controller"].map(program).concat();
    format!("sudo setcap{all}")
}

/// How late a thread with these rights, as far as they are had, wakes up for ticks of 1 ms.
pub(super) fn wake_ups() -> Finding {
    let mut late = thread::spawn(lateness).join().unwrap_or_default();
    late.sort();
    let at = |share: f64| {
        late.get((share * late.len() as f64) as usize)
            .copied()
            .unwrap_or_default()
    };
    let (median, most) = (at(0.5), late.last().copied().unwrap_or_default());
    let observed = format!(
        "late by {} us (p50), {} us (p99), {} us (most) in {TICKS} ticks",
        median.as_micros(),
        at(0.99).as_micros(),
        most.as_micros()
    );
    if at(0.99) < LATE {
        return Finding::new("wake-ups", Verdict::Good, observed);
    }
    Finding::new("wake-ups", Verdict::Warning, observed).mended_by(
        "give the host less other work; in a scenario, robot.command_gap_s = 0.25 rides over the worst",
    )
}

fn lateness() -> Vec<Duration> {
    // What is not had shows in the figures, and is told by `rights`.
    let _ = Wanted::default().missing();
    let nothing = never::<()>();
    let start = clock::now();
    let one = |tick: u32| {
        let due = start + TICK * tick;
        match nothing.recv_deadline(due) {
            Err(RecvTimeoutError::Timeout) | Ok(()) => {}
            Err(RecvTimeoutError::Disconnected) => thread::park_timeout(TICK),
        }
        clock::now().saturating_duration_since(due)
    };
    (1..=TICKS).map(one).collect()
}
