//! Rules for what a robot says.

use super::Finding;
use super::record::{At, Record, pairs, quantile};
use spatial::TICK_US;
use spatial::ports::{ENCODER_SAMPLES, Fault, RobotMode, RobotState};

/// Of so many states one may be lost on the way.
const LOSS: f64 = 0.05;
/// Between two states the median may be off by so much of T.
const PACE: f64 = 0.1;
/// A clock may go wrong by so much, 1.
const RATE: f64 = 1e-3;
/// `utime` may be off from its tick by so much, us.
const JITTER_US: f64 = 5e3;

/// All of them.
pub fn rules(record: &Record) -> Vec<Finding> {
    vec![
        period(record),
        step(record),
        utime(record),
        readings(record),
        modes(record),
    ]
}

/// `ROBOT_STATE` every T.
pub fn period(record: &Record) -> Finding {
    const RULE: &str = "ROBOT_STATE every T";
    let period = record.period_ticks();
    if record.states.len() < 2 {
        let observed = format!(
            "{} heard in {:.1} s",
            record.states.len(),
            1e-6 * record.listened_us as f64
        );
        let remedy = "publish ROBOT_STATE at every tick that is a multiple of T, on the same LCM URL; a simulated robot needs \
                      its sensor to go on (start sensor-sim)";
        return Finding::broken(RULE, observed, remedy);
    }
    if period == 0 {
        return Finding::not_seen(RULE, "no NODE_STATUS says T");
    }
    let gaps: Vec<f64> = pairs(&record.states)
        .filter(|(a, b)| b.message.stamp.step - a.message.stamp.step == period)
        .map(|(a, b)| 1e-3 * (b.us - a.us) as f64)
        .collect();
    let all = pairs(&record.states)
        .map(|(a, b)| 1e-3 * (b.us - a.us) as f64)
        .collect();
    let gaps = if gaps.is_empty() { all } else { gaps };
    let [median, p99, longest] = [0.5, 0.99, 1.0].map(|ratio| quantile(&gaps, ratio).unwrap_or(0.0));
    let off = (median - period as f64).abs();
    let observed = format!(
        "median {median:.2} ms, 99th percentile {p99:.2}, longest {longest:.2} (T = {period} ms, median within {:.0} %)",
        100.0 * PACE
    );
    Finding::judge(
        RULE,
        off <= PACE * period as f64,
        observed,
        "pace by absolute deadlines of a monotonic clock; say the same T in node_ticks_per_cycle",
    )
}

/// `step` counts ticks of 1 ms, in multiples of T.
pub fn step(record: &Record) -> Finding {
    const RULE: &str = "step grows by T";
    let period = record.period_ticks();
    if record.states.len() < 2 || period == 0 {
        return Finding::not_seen(RULE, "fewer than two states, or no T");
    }
    let remedy =
        "count ticks of 1 ms from the start, whatever becomes of messages, and send at the multiples of T";
    let bad = |state: &At<RobotState>| state.message.stamp.step % period != 0 || state.message.stamp.step < 0;
    if let Some(state) = record.states.iter().find(|state| bad(state)) {
        return Finding::broken(
            RULE,
            format!(
                "{} is no multiple of T = {period} ticks",
                state.message.stamp.step
            ),
            remedy,
        );
    }
    let steps = || pairs(&record.states).map(|(a, b)| [a.message.stamp.step, b.message.stamp.step]);
    if let Some([a, b]) = steps().find(|[a, b]| b <= a) {
        return Finding::broken(RULE, format!("{b} follows {a}"), remedy);
    }
    let lost: i64 = steps().map(|[a, b]| (b - a) / period - 1).sum();
    let sent = record.states.len() as i64 + lost;
    let observed = format!("{lost} of {sent} states missing (at most {:.0} %)", 100.0 * LOSS);
    Finding::judge(RULE, lost as f64 <= LOSS * sent as f64, observed, remedy)
}

/// `utime` grows by 1 ms per tick, but for plant time that a simulator says has slipped.
pub fn utime(record: &Record) -> Finding {
    const RULE: &str = "utime grows by 1 ms per tick";
    let told = record.statuses.first().zip(record.statuses.last());
    let Some((first, last)) = told else {
        return Finding::not_seen(RULE, "no NODE_STATUS");
    };
    let within = |it: &&At<RobotState>| it.us >= first.us && it.us <= last.us;
    let states: Vec<_> = record.states.iter().filter(within).collect();
    let Some((a, b)) = states.first().zip(states.last()).filter(|(a, b)| a.us < b.us) else {
        return Finding::not_seen(RULE, "fewer than two states");
    };
    let remedy = "stamp each state with the sampling instant of its newest reading, by a monotonic clock in us; count what is \
                  late in node_slip_s or don't be late";
    if let Some((_, b)) = pairs(&states).find(|(a, b)| b.message.stamp.utime <= a.message.stamp.utime) {
        return Finding::broken(
            RULE,
            format!("step {} is not later than the one before", b.message.stamp.step),
            remedy,
        );
    }
    let origin = |it: &At<RobotState>| (it.message.stamp.utime - it.message.stamp.step * TICK_US) as f64;
    let slip = 1e6 * (last.message.slip_s - first.message.slip_s);
    let span = (b.message.stamp.utime - a.message.stamp.utime) as f64;
    let shifts: Vec<f64> = states.iter().map(|it| origin(it) - origin(a)).collect();
    let allowed = JITTER_US + RATE * span;
    let [least, most] = [0.0, 1.0].map(|ratio| quantile(&shifts, ratio).unwrap_or(0.0));
    let kept = least >= -allowed && most <= slip.max(0.0) + allowed;
    let observed = format!(
        "against the ticks it shifts by {:.2} to {:.2} ms in {:.1} s (within {:.1}, and {:.1} told in node_slip_s)",
        1e-3 * least,
        1e-3 * most,
        1e-6 * span,
        1e-3 * allowed,
        1e-3 * slip
    );
    Finding::judge(RULE, kept, observed, remedy)
}

/// Readings one tick apart: what two states both have is the same, and there are eight.
pub fn readings(record: &Record) -> Finding {
    const RULE: &str = "eight readings, one tick apart";
    let [Some(first), Some(last)] = [record.states.first(), record.states.last()] else {
        return Finding::not_seen(RULE, "no state");
    };
    let count = |state: &At<RobotState>| usize::try_from(state.message.sample_count).unwrap_or(0);
    let eight = ENCODER_SAMPLES as i64;
    if last.message.stamp.step - first.message.stamp.step >= eight && count(last) < ENCODER_SAMPLES {
        let observed = format!(
            "{} after {} ticks",
            count(last),
            last.message.stamp.step - first.message.stamp.step
        );
        return Finding::broken(
            RULE,
            observed,
            "read the encoders every ms, and send the last eight readings, newest first",
        );
    }
    let mut compared = 0_usize;
    for (a, b) in pairs(&record.states) {
        let ticks = b.message.stamp.step - a.message.stamp.step;
        let Some(shift) = usize::try_from(ticks).ok().filter(|shift| *shift > 0) else {
            continue;
        };
        for i in 0..count(a).min(count(b).saturating_sub(shift)) {
            let pair = (
                b.message.axis_position.get(i + shift),
                a.message.axis_position.get(i),
            );
            if let (Some(newer), Some(older)) = pair {
                compared += 1;
                if newer != older {
                    let observed = format!(
                        "reading {} of step {} is not reading {i} of step {}",
                        i + shift,
                        b.message.stamp.step,
                        a.message.stamp.step
                    );
                    return Finding::broken(
                        RULE,
                        observed,
                        "newest first, one tick apart: what was reading i is reading i + T a period later, bit for bit",
                    );
                }
            }
        }
    }
    match compared {
        0 => Finding::not_seen(RULE, "no two states overlap"),
        _ => Finding::kept(
            RULE,
            format!("{compared} readings that two states share are the same"),
        ),
    }
}

/// A fault is named when the mode says so, and not otherwise.
pub fn modes(record: &Record) -> Finding {
    const RULE: &str = "mode and fault agree";
    if record.states.is_empty() {
        return Finding::not_seen(RULE, "no state");
    }
    let bad = record.states.iter().map(|it| &it.message).find(|state| {
        let faulty = state.fault != Fault::None;
        let agree = match state.mode {
            RobotMode::Fault => faulty,
            RobotMode::Braking => true,
            _ => !faulty,
        };
        !agree || (!faulty && state.fault_axis != -1)
    });
    match bad {
        None => Finding::kept(RULE, format!("{} states", record.states.len())),
        Some(state) => Finding::broken(
            RULE,
            format!(
                "step {}: {:?} with fault {:?} of axis {}",
                state.stamp.step, state.mode, state.fault, state.fault_axis
            ),
            "a fault belongs to MODE_BRAKING and MODE_FAULT alone, and its axis is -1 where none is concerned",
        ),
    }
}
