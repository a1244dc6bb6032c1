//! Several cells on one machine, each three processes in lockstep on ports of its own.

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
    let mut measured = vec![[const { Vec::new() }; 2]; counts.len()];
    for _ in 0..turns {
        for (count, [rates, costs]) in counts.iter().zip(&mut measured) {
            let [ticks, seconds, core_s] = together(programs, *count, window, stop)?;
            rates.push(ticks / seconds);
            costs.push(1e6 * core_s / ticks);
        }
    }
    let row = |(cells, [mut rates, mut costs]): (&usize, [Vec<f64>; 2])| {
        rates.sort_by(f64::total_cmp);
        costs.sort_by(f64::total_cmp);
        Row {
            cells: *cells,
            ticks_per_s: median(&rates),
            core_us_per_tick: median(&costs),
        }
    };
    Ok(counts.iter().zip(measured).map(row).collect())
}

/// The ticks of `count` cells, in how many s, and what time on a core they took, s.
fn together(
    programs: &Programs,
    count: usize,
    window: Duration,
    stop: &Receiver<()>,
) -> Result<[f64; 3], WireSpeedError> {
    let mut cells = Vec::new();
    for _ in 0..count {
        let port = RunPort::free(QUIET)?;
        let nodes = ROLES.map(|role| programs.command(role, &port, ""));
        let nodes = nodes.into_iter().collect::<Result<Vec<_>, _>>()?;
        cells.push((Cell::of("memq://", 0, &nodes)?, port));
    }
    let look = || -> Result<_, WireSpeedError> {
        let (mut ticks, mut core_s) = (0, 0.0);
        for (cell, port) in &cells {
            ticks += ring::look(port, stop)?.0;
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
