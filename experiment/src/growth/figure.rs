//! How costs grow, as SVG.

use super::Growth;
use crate::figure::FigureError;
use crate::figure::chart::{BLUE, Chart, GREY, Line, RED};
use plotters::style::RGBColor;
use std::path::Path;

/// A curve: its name, its colour and its points.
type Curve = (&'static str, RGBColor, Vec<(f64, f64)>);

/// Draw `growth` into files `growth-*.svg` in `directory`.
pub(super) fn draw(growth: &Growth, directory: &Path) -> Result<(), FigureError> {
    let rates = growth
        .rates
        .iter()
        .map(|row| (row.cycles_per_s, 1e2 * row.core_share));
    let cells = |one_network: bool| {
        let rows = growth.cells.iter().filter(|row| row.one_network == one_network);
        rows.map(|row| (row.cells as f64, row.cells as f64 * row.core_us_per_tick))
            .collect()
    };
    let logs =
        |of: fn(&super::LogRow) -> f64| growth.logs.iter().map(move |row| (row.log_s, of(row))).collect();
    let figures: [(&str, [&'static str; 2], Vec<Curve>); 4] = [
        (
            "rate",
            ["cycles/s", "controller, % of a core"],
            vec![("controller", BLUE, rates.collect())],
        ),
        (
            "cells",
            ["cells on this machine", "all, core us per tick"],
            vec![
                ("in lockstep, each on ports of its own", BLUE, cells(false)),
                ("all on one, with suffixes", RED, cells(true)),
            ],
        ),
        (
            "log-time",
            ["log, s", "time on a core, s"],
            vec![
                ("analyse", BLUE, logs(|row| row.analyse_core_s)),
                ("replay", RED, logs(|row| row.replay_core_s)),
            ],
        ),
        (
            "log-memory",
            ["log, s", "memory at most, MiB"],
            vec![
                ("analyse", BLUE, logs(|row| row.analyse_mib)),
                ("replay", RED, logs(|row| row.replay_mib)),
            ],
        ),
    ];
    for (name, axes, curves) in figures {
        let drawn = chart(axes, curves).draw().ok_or(FigureError::Empty)?;
        let svg = drawn.map_err(|error| FigureError::Draw(error.to_string()))?;
        let path = directory.join(format!("growth-{name}.svg"));
        std::fs::write(&path, svg).map_err(|source| FigureError::Write { path, source })?;
    }
    Ok(())
}

/// Each curve, and straight lines from the origin through their first points.
fn chart(axes: [&'static str; 2], curves: Vec<Curve>) -> Chart {
    let furthest = curves.iter().flat_map(|(_, _, points)| points);
    let furthest = furthest.map(|(x, _)| *x).fold(0.0, f64::max);
    // One line for all of them: to the origin and out again, no part of it twice, or dashes would fill each other's gaps.
    let proportional = curves.iter().enumerate().flat_map(|(i, (_, _, points))| {
        let (x, y) = points.first().copied().unwrap_or((1.0, 0.0));
        let (origin, end) = ((0.0, 0.0), (furthest, furthest * y / x));
        if i % 2 == 0 { [end, origin] } else { [origin, end] }
    });
    let mut lines = vec![Line {
        name: "in proportion",
        points: proportional.collect(),
        colour: GREY,
        dashed: true,
    }];
    lines.extend(curves.into_iter().map(|(name, colour, points)| Line {
        name,
        points,
        colour,
        dashed: false,
    }));
    Chart {
        axes,
        range: 0.0..1.02 * furthest,
        lines,
        bars: Vec::new(),
    }
}
