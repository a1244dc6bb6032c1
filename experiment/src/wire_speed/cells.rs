//! Several cells on one machine, each three processes in lockstep: on ports of its own, or all on the same ones with channel
//! suffixes.

use super::ring::{self, ROLES};
use super::{Programs, QUIET, WireSpeedError, wait_until};
use crate::cost::median;
use crate::launch::Cell;
use crate::run_port::RunPort;
use crate::usage::Usage;
use crossbeam::channel::Receiver;
use node::clock;
use serde::Serialize;
use std::time::Duration;

/// What so many cells do and take: the medians of all turns.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Row {
    /// How many.
    pub cells: usize,
    /// Whether all are on the same ports, where each process gets the messages of all cells; else each has its own.
    pub one_network: bool,
    /// Ticks of all together in a second.
    pub ticks_per_s: f64,
    /// Time on a core of the three processes of a cell for each of its ticks, us.
    pub core_us_per_tick: f64,
}

/// Time each of `counts` of cells for `window`, `turns` times one after the other. The programs go on for as long as they are looked at.
pub fn measure(
    programs: &Programs,
    counts: &[usize],
    turns: u16,
    window: Duration,
    stop: &Receiver<()>,
) -> Result<Vec<Row>, WireSpeedError> {
    let kinds = [false, true].map(|one_network| counts.iter().map(move |cells| (*cells, one_network)));
    let kinds: Vec<_> = kinds.into_iter().flatten().collect();
    let mut measured = vec![[const { Vec::new() }; 2]; kinds.len()];
    for _ in 0..turns {
        for ((cells, one_network), [rates, costs]) in kinds.iter().zip(&mut measured) {
            let [ticks, seconds, core_s] = together(programs, *cells, *one_network, window, stop)?;
            rates.push(ticks / seconds);
            costs.push(1e6 * core_s / ticks);
        }
    }
    let row = |((cells, one_network), [mut rates, mut costs]): ((usize, bool), [Vec<f64>; 2])| {
        rates.sort_by(f64::total_cmp);
        costs.sort_by(f64::total_cmp);
        Row {
            cells,
            one_network,
            ticks_per_s: median(&rates),
            core_us_per_tick: median(&costs),
        }
    };
    Ok(kinds.into_iter().zip(measured).map(row).collect())
}

/// The ticks of `count` cells, in how many s, and what time on a core they took, s.
fn together(
    programs: &Programs,
    count: usize,
    one_network: bool,
    window: Duration,
    stop: &Receiver<()>,
) -> Result<[f64; 3], WireSpeedError> {
    let ports = match one_network {
        true => 1,
        false => count,
    };
    let ports = (0..ports)
        .map(|_| RunPort::free(QUIET))
        .collect::<Result<Vec<_>, _>>()?;
    let mut cells = Vec::new();
    for (i, port) in ports.iter().cycle().take(count).enumerate() {
        let (suffix, options) = match one_network {
            true => (format!("_{i}"), format!("&suffix=_{i}")),
            false => Default::default(),
        };
        let nodes = ROLES.map(|role| programs.command(role, port, &options));
        let nodes = nodes.into_iter().collect::<Result<Vec<_>, _>>()?;
        cells.push((Cell::of("memq://", 0, &nodes)?, port, suffix));
    }
    let look = || -> Result<_, WireSpeedError> {
        let (mut ticks, mut core_s) = (0, 0.0);
        for (cell, port, suffix) in &cells {
            ticks += ring::look(port, suffix, stop)?.0;
            for role in ROLES {
                let id = cell.process_id(role).unwrap_or_default();
                core_s += Usage::of(id).map_err(WireSpeedError::Usage)?.core_s;
            }
        }
        Ok((ticks, core_s, clock::now()))
    };
    look()?;
    wait_until(clock::now() + ring::WARM_UP, stop)?;
    let (tick, before_s, from) = look()?;
    wait_until(from + window, stop)?;
    let (last, after_s, until) = look()?;
    Ok([
        (last - tick) as f64,
        (until - from).as_secs_f64(),
        after_s - before_s,
    ])
}
