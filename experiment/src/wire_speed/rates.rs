//! What the controller takes of a core, by how often it is asked.

use super::cycles::{COLD, Pace, Receive, settle, take_turn};
use super::peer::Peer;
use super::{Programs, WireSpeedError};
use crate::cost::median;
use crossbeam::channel::Receiver;
use node::clock;
use node::scenario::Scenario;
use serde::Serialize;

/// From the paper's rate up.
const PACES: [Pace; 5] = [
    Pace::HZ_250,
    Pace::HZ_500,
    Pace::HZ_1000,
    Pace::HZ_2000,
    Pace::HZ_4000,
];

/// What it takes at one rate: the medians of all turns.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Row {
    /// Cycles a second that there were.
    pub cycles_per_s: f64,
    /// Share of one core.
    pub core_share: f64,
    /// Time on a core for each cycle, us.
    pub core_us_per_cycle: f64,
}

/// Ask the controller of `scenario` for `cycles` cycles at each rate, `turns` times one rate after the other.
pub fn measure(
    programs: &Programs,
    scenario: &Scenario,
    turns: u16,
    cycles: u32,
    stop: &Receiver<()>,
) -> Result<Vec<Row>, WireSpeedError> {
    let mut peer = Peer::start(&Receive::Own, programs, scenario, stop)?;
    settle(&mut peer, scenario, stop)?;
    let mut measured = vec![Vec::new(); PACES.len()];
    for _ in 0..turns {
        for (pace, measured) in PACES.iter().zip(&mut measured) {
            let (started, before) = (clock::now(), peer.usage()?);
            take_turn(&mut peer, pace, cycles, stop)?;
            let core_s = (peer.usage()? - before).core_s;
            measured.push([
                f64::from(COLD + cycles),
                core_s,
                (clock::now() - started).as_secs_f64(),
            ]);
        }
    }
    let row = |measured: Vec<[f64; 3]>| {
        let of = |figure: fn(&[f64; 3]) -> f64| {
            let mut values: Vec<f64> = measured.iter().map(figure).collect();
            values.sort_by(f64::total_cmp);
            median(&values)
        };
        Row {
            cycles_per_s: of(|[cycles, _, s]| cycles / s),
            core_share: of(|[_, core_s, s]| core_s / s),
            core_us_per_cycle: of(|[cycles, core_s, _]| 1e6 * core_s / cycles),
        }
    };
    Ok(measured.into_iter().map(row).collect())
}
