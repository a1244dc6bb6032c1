//! Rules for a node's clock: its stamps, and those of the controller that it sends back.

use super::Finding;
use super::record::{Head, Record, pairs, quantile};
use std::collections::BTreeMap;

/// An echo is of a command that is at most so many periods old, on the way here and there included.
const ECHO_PERIODS: i64 = 5;
/// Of so many messages the echo may be older: a machine that is busy.
const LATE_RATIO: f64 = 0.1;
/// So far a stamp may be off, us, ...
const CLOCK_US: f64 = 200.0;
/// ... and so much more by what two clocks drift apart while they are compared, 1.
const DRIFT: f64 = 2e-4;

/// The stamps of the newest command come back.
pub fn echo(record: &Record, heads: &[Head]) -> Finding {
    const RULE: &str = "echo of the newest command";
    let sent = record.sent();
    let Some((_, &first_us)) = sent.first_key_value() else {
        return Finding::not_seen(RULE, "no command was sent");
    };
    if heads.is_empty() {
        return Finding::not_seen(RULE, format!("no {}", record.channel()));
    }
    let broken = |observed: String, remedy: &str| Finding::broken(RULE, observed, remedy);
    // Until it hears of this controller it may echo the one before.
    let known = |head: &Head| sent.contains_key(&head.echo.command_send_utime);
    let begin = heads.iter().position(known).unwrap_or(heads.len());
    let heard = heads.get(begin..).unwrap_or_default();
    let good: BTreeMap<i64, i64> = record
        .commands
        .iter()
        .map(|it| (it.us, it.message.send_utime))
        .collect();
    let limit = ECHO_PERIODS * record.period_ticks().max(4) * 1000;
    let late = |head: &&Head| {
        let newest = good.range(..=head.us).next_back().map_or(0, |(_, send)| *send);
        !known(head) || newest - head.echo.command_send_utime > limit
    };
    if let Some(finding) = heads.iter().find_map(stamps) {
        return finding;
    }
    for head in heard {
        let (step, echo) = (head.stamp.step, head.echo.command_send_utime);
        match sent.get(&echo) {
            None => {
                return broken(
                    format!("step {step} echoes {echo} us, which the controller has not sent"),
                    "copy command_send_us as it is, of the controller that you work with alone",
                );
            }
            Some(sent_us) if head.us < *sent_us => {
                return broken(
                    format!("step {step} echoes a command before it was sent"),
                    "echo only what was received",
                );
            }
            Some(_) => {}
        }
    }
    let back = pairs(heard).find(|(a, b)| {
        b.echo.command_send_utime < a.echo.command_send_utime || b.echo.send_utime < a.echo.send_utime
    });
    if let Some((_, b)) = back {
        let observed = format!("the echo of step {} is older than the one before", b.stamp.step);
        return broken(observed, "keep the stamps of the newest command");
    }
    let after: Vec<&Head> = heads
        .iter()
        .filter(|head| head.us > first_us + 1_000_000)
        .collect();
    if after.is_empty() {
        return Finding::not_seen(RULE, "no message came a second after the first command");
    }
    let old = after.iter().copied().filter(late).count();
    if old as f64 > LATE_RATIO * after.len() as f64 {
        let observed = format!(
            "{old} of {} messages echo a command older than {ECHO_PERIODS} T, one that was not sent, or none",
            after.len()
        );
        let remedy = "subscribe to ROBOT_COMMAND, work with the controller whose hello agrees, and echo its newest command_send_us \
                      unchanged, enabled or not";
        return broken(observed, remedy);
    }
    let bound = clock(record, heads).map_or(0.0, |(_, bound)| bound);
    Finding::kept(
        RULE,
        format!(
            "{} of {} messages, shortest round trip {:.0} us",
            heard.len(),
            heads.len(),
            2.0 * bound
        ),
    )
}

/// What is wrong with the stamps of one echo by themselves.
fn stamps(head: &Head) -> Option<Finding> {
    const RULE: &str = "echo of the newest command";
    let (echo, step) = (head.echo, head.stamp.step);
    if echo.command_send_utime == 0 && (echo.receive_utime != 0 || echo.send_utime != 0) {
        let observed = format!("step {step} has receive or send stamps without a command");
        return Some(Finding::broken(
            RULE,
            observed,
            "leave all three 0 until there is a command",
        ));
    }
    (echo.receive_utime > echo.send_utime).then(|| {
        let late = echo.receive_utime - echo.send_utime;
        Finding::broken(
            RULE,
            format!("step {step} was sent {late} us before its command was received"),
            "read both stamps from one monotonic clock: receive on arrival, send right before publishing",
        )
    })
}

/// How far the node's clock is ahead of the checker's, and by how much that may be wrong, us: from the fastest echo.
pub fn clock(record: &Record, heads: &[Head]) -> Option<(f64, f64)> {
    let sent = record.sent();
    let exchanges = heads.iter().filter_map(|head| {
        let (out, back) = (*sent.get(&head.echo.command_send_utime)?, head.us);
        let there = head.echo.receive_utime - out;
        let here = head.echo.send_utime - back;
        Some((0.5 * (there + here) as f64, 0.5 * (there - here) as f64))
    });
    exchanges
        .filter(|(_, bound)| *bound >= 0.0)
        .min_by(|a, b| a.1.total_cmp(&b.1))
}

/// `utime` is when the content was sampled: not after it was sent, not after it came.
pub fn honest(record: &Record, heads: &[Head]) -> Finding {
    const RULE: &str = "utime is not later than sending";
    const REMEDY: &str = "utime is the sampling instant of the newest reading on the clock that the echo's stamps are read from";
    let echoing = || heads.iter().filter(|head| head.echo.command_send_utime != 0);
    let Some((ahead, bound)) = clock(record, heads) else {
        return Finding::not_seen(RULE, "no echo tells of the node's clock");
    };
    if let Some(head) = echoing().find(|head| head.stamp.utime > head.echo.send_utime) {
        let late = head.stamp.utime - head.echo.send_utime;
        return Finding::broken(
            RULE,
            format!("step {} was sampled {late} us after it was sent", head.stamp.step),
            REMEDY,
        );
    }
    let ages: Vec<f64> = heads
        .iter()
        .map(|head| head.us as f64 - (head.stamp.utime as f64 - ahead))
        .collect();
    let [youngest, median, oldest] = [0.0, 0.5, 1.0].map(|ratio| quantile(&ages, ratio).unwrap_or(0.0));
    let most = 50e3;
    let observed = format!(
        "on arrival {:.2} ms old, at least {:.2}, at most {:.2} (median from 0 to 50); the clock is known within {:.0} us",
        1e-3 * median,
        1e-3 * youngest,
        1e-3 * oldest,
        bound
    );
    let allowed = bound + CLOCK_US + DRIFT * record.listened_us as f64;
    let kept = youngest >= -allowed && median <= most;
    Finding::judge(RULE, kept, observed, REMEDY)
}
