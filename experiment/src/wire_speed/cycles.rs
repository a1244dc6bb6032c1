//! How long a controller takes to answer: from a sensor's message to the command, both ways over the wire.
//!
//! This process is robot and sensor at once, computes the physics between two measurements, and receives from a raw socket,
//! whoever answers. The law works: first the scenario runs to its end, without being measured; what is measured then is the state
//! that it ends in, such as a contact with the desired force.

use super::peer::Peer;
use super::statistics::{Turns, order, quantile};
use super::{Programs, WireSpeedError, wait_until};
use crossbeam::channel::Receiver;
use node::clock;
use node::scenario::Scenario;
use serde::Serialize;
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// How many cycles of a turn are not counted: the process has been idle while others had theirs.
pub(super) const COLD: u32 = 10;

/// How a process receives, that answers the sensor's messages.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Receive {
    /// From a raw socket, and computes nothing.
    Raw,
    /// The controller, by this project's own receiving.
    Own,
    /// The controller, through liblcm.
    Liblcm,
    /// Through Python's LCM, by the interpreter at a path; it computes nothing.
    Python(PathBuf),
}

impl Receive {
    /// What an LCM URL says to receive through liblcm.
    pub(super) const LIBLCM: &str = "&receive=liblcm";

    /// In words.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Raw => "raw",
            Self::Own => "controller",
            Self::Liblcm => "controller, liblcm",
            Self::Python(_) => "python",
        }
    }
}

/// How often there is a cycle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Pace {
    /// In words.
    pub name: &'static str,
    period: Option<Duration>,
}

impl Pace {
    /// The paper's.
    pub const HZ_250: Self = Self::every("250 Hz", Duration::from_millis(4));
    /// The same messages, T = 4 ms included, more often.
    pub const HZ_500: Self = Self::every("500 Hz", Duration::from_millis(2));
    #[allow(missing_docs)]
    pub const HZ_1000: Self = Self::every("1000 Hz", Duration::from_millis(1));
    #[allow(missing_docs)]
    pub const HZ_2000: Self = Self::every("2000 Hz", Duration::from_micros(500));
    #[allow(missing_docs)]
    pub const HZ_4000: Self = Self::every("4000 Hz", Duration::from_micros(250));
    /// Each as soon as the one before is answered.
    pub const UNPACED: Self = Self {
        name: "back to back",
        period: None,
    };

    const fn every(name: &'static str, period: Duration) -> Self {
        Self {
            name,
            period: Some(period),
        }
    }
}

/// How long the answers took that came in one way at one pace. Ratios are to raw, all turns together and of each turn.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    /// How often there was a cycle.
    pub pace: &'static str,
    /// How the answering process received.
    pub receive: &'static str,
    /// Answers.
    pub cycles: usize,
    /// Answers that do not count since a message was lost.
    pub lost: u32,
    /// Quantiles, us.
    pub p50_us: f64,
    #[allow(missing_docs)]
    pub p99_us: f64,
    #[allow(missing_docs)]
    pub p999_us: f64,
    /// The longest, us.
    pub max_us: f64,
    /// Median against raw.
    pub p50_ratio: f64,
    /// The least of a turn.
    pub p50_ratio_min: f64,
    /// The largest of a turn.
    pub p50_ratio_max: f64,
    /// The 99.9th percentile against raw.
    pub p999_ratio: f64,
}

/// How much is measured.
#[derive(Clone, Copy, Debug)]
pub struct Amount {
    /// Turns of each way of receiving, at each pace.
    pub turns: u16,
    /// Cycles of a turn that count.
    pub cycles: u32,
}

/// Measure all ways of receiving, of which the first is that to which the others are compared, at all paces.
pub fn measure(
    ways: &[Receive],
    paces: &[Pace],
    amount: Amount,
    programs: &Programs,
    scenario: &Scenario,
    stop: &Receiver<()>,
) -> Result<Vec<Row>, WireSpeedError> {
    let starting = ways
        .iter()
        .map(|receive| Peer::start(receive, programs, scenario, stop));
    let mut peers = starting.collect::<Result<Vec<_>, _>>()?;
    for peer in &mut peers {
        settle(peer, scenario, stop)?;
    }
    let mut rows = Vec::new();
    for pace in paces {
        let mut measured = vec![(Turns::default(), 0); peers.len()];
        for turn in 0..amount.turns {
            for i in order(usize::from(turn), peers.len()) {
                let (turns, lost) = &mut measured[i];
                let answers = take_turn(&mut peers[i], pace, amount.cycles, stop)?;
                *lost += amount.cycles - answers.len() as u32;
                turns.push(answers);
            }
        }
        let raw = measured[0].0.clone();
        let row =
            |(receive, (turns, lost)): (&Receive, &(Turns, u32))| row(pace, receive, turns, *lost, &raw);
        rows.extend(ways.iter().zip(&measured).map(row));
    }
    Ok(rows)
}

/// Let `scenario` run to its end.
pub(super) fn settle(
    peer: &mut Peer,
    scenario: &Scenario,
    stop: &Receiver<()>,
) -> Result<(), WireSpeedError> {
    for _ in 0..scenario.timing.ticks() / scenario.timing.command_period_ticks {
        wait_until(clock::now(), stop)?;
        let said = peer.prepare()?;
        peer.exchange(&said)?;
    }
    Ok(())
}

/// How long the answers of one turn took, us; those that were lost are left out.
pub(super) fn take_turn(
    peer: &mut Peer,
    pace: &Pace,
    cycles: u32,
    stop: &Receiver<()>,
) -> Result<Vec<f64>, WireSpeedError> {
    let mut took_us = Vec::new();
    let mut due: Option<Instant> = None;
    for cycle in 0..COLD + cycles {
        let said = peer.prepare()?;
        match pace.period {
            None => wait_until(clock::now(), stop)?,
            Some(period) => {
                let now = clock::now();
                let next = due.map_or(now, |due| (due + period).max(now));
                wait_until(next, stop)?;
                due = Some(next);
            }
        }
        let took = peer.exchange(&said)?;
        if cycle >= COLD {
            took_us.extend(took.map(|took| 1e6 * took.as_secs_f64()));
        }
    }
    Ok(took_us)
}

fn row(pace: &Pace, receive: &Receive, turns: &Turns, lost: u32, raw: &Turns) -> Row {
    let sorted = turns.sorted();
    let median = turns.ratio(raw, 0.5);
    Row {
        pace: pace.name,
        receive: receive.name(),
        cycles: sorted.len(),
        lost,
        p50_us: quantile(&sorted, 0.5),
        p99_us: quantile(&sorted, 0.99),
        p999_us: quantile(&sorted, 0.999),
        max_us: quantile(&sorted, 1.0),
        p50_ratio: median.all,
        p50_ratio_min: median.least,
        p50_ratio_max: median.largest,
        p999_ratio: turns.ratio(raw, 0.999).all,
    }
}
