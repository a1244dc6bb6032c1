//! A map as a figure: a panel for each law, a square for each cell.

use super::{Cell, Cells, MapDefinition, Plan, SweepError, Values};
use crate::figure::style::{Area, Drawn, FAINT, INK, LARGE, SMALL, font, label, line, px, svg};
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

/// Sizes, px.
/// Of the mark in the legend.
const MARK: i32 = 19;
/// Of a panel's longer side, and of its squares at least and at most.
const PANEL: i32 = 210;
const SQUARE: [i32; 2] = [16, 62];
const LEFT: i32 = 56;
const TOP: i32 = 112;
const TITLE: i32 = 26;
const TICKS: i32 = 58;
const GAP: i32 = 18;
const EDGE: i32 = 26;
/// Panels side by side.
const COLUMNS: usize = 4;
const LEAST_WIDTH: i32 = 900;

/// What the colours stand for, N s, on a logarithmic scale.
const IAE_N_S: [f64; 2] = [0.1, 10.0];
/// The border that theory predicts.
const BORDER: RGBColor = RGBColor(213, 94, 0);
/// A perceptually uniform scale that people with colour-blindness read: viridis, from light (little) to dark (much).
const SCALE: [RGBColor; 6] = [
    RGBColor(253, 231, 37),
    RGBColor(122, 209, 81),
    RGBColor(34, 168, 132),
    RGBColor(42, 120, 142),
    RGBColor(65, 68, 135),
    RGBColor(68, 1, 84),
];

/// The figure of map number `map`, as SVG.
pub fn map_figure(plan: &Plan, cells: &Cells, map: usize) -> Result<String, SweepError> {
    let described = &plan.definition.maps[map];
    draw(plan, described, &cells.maps[map]).map_err(|error| SweepError::Draw {
        map: described.name.clone(),
        message: error.to_string(),
    })
}

fn draw(plan: &Plan, map: &MapDefinition, laws: &[Vec<Vec<Cell>>]) -> Drawn<String> {
    let columns = laws.len().min(COLUMNS);
    let square = square(map);
    let (across, up) = (map.x.values.len() as i32, map.y.values.len() as i32);
    let (panel_width, panel_height) = (LEFT + across * square + GAP, TITLE + up * square + TICKS);
    let width = LEAST_WIDTH.max(EDGE + columns as i32 * panel_width);
    let height = TOP + laws.len().div_ceil(COLUMNS) as i32 * panel_height;
    svg(width, height, |root| {
        draw_legend(root, plan, map)?;
        for (i, (law, rows)) in plan.definition.laws(map).iter().zip(laws).enumerate() {
            let at = (
                EDGE + (i % COLUMNS) as i32 * panel_width + LEFT,
                TOP + (i / COLUMNS) as i32 * panel_height + TITLE,
            );
            draw_panel(root, map, law, rows, at)?;
        }
        Ok(())
    })
}

/// A panel whose squares' upper left corner is `at`.
fn draw_panel(root: &Area<'_>, map: &MapDefinition, law: &str, rows: &[Vec<Cell>], at: (i32, i32)) -> Drawn {
    let (up, square) = (rows.len() as i32, square(map));
    let corner = |x: i32, y: i32| (px(at.0 + x * square), px(at.1 + (up - y) * square));
    root.draw(&label(
        law,
        (at.0, at.1 - 8),
        LARGE,
        Pos::new(HPos::Left, VPos::Bottom),
        INK,
    ))?;
    for (y, row) in (0..).zip(rows) {
        for (x, cell) in (0..).zip(row) {
            draw_cell(root, cell, corner(x, y), corner(x + 1, y + 1))?;
        }
    }
    let across = map.x.values.len() as i32;
    for x in 0..=across {
        root.draw(&line([corner(x, 0), corner(x, up)], FAINT, 1))?;
    }
    for y in 0..=up {
        root.draw(&line([corner(0, y), corner(across, y)], FAINT, 1))?;
    }
    draw_border(root, rows, corner)?;
    draw_axes(root, map, at, up)
}

/// Its colour, or its cross on white; a point where it rings but dies out.
fn draw_cell(root: &Area<'_>, cell: &Cell, low: (i32, i32), high: (i32, i32)) -> Drawn {
    let shown = cell.mean.filter(|_| cell.stable());
    if let Some(mean) = shown {
        let fill = colour(mean.iae_n_s);
        root.draw(&Rectangle::new([low, high], fill.filled()))?;
    }
    let inset = px(5);
    let (left, right) = (low.0 + inset, high.0 - inset);
    let (bottom, top) = (low.1 - inset, high.1 + inset);
    if !cell.stable() {
        root.draw(&line([(left, bottom), (right, top)], INK, 1))?;
        if cell.unstable_runs == cell.runs {
            root.draw(&line([(left, top), (right, bottom)], INK, 1))?;
        }
    } else if !cell.settled() {
        let middle = ((low.0 + high.0) / 2, (low.1 + high.1) / 2);
        root.draw(&Circle::new(middle, px(3), WHITE.filled()))?;
    }
    Ok(())
}

/// Along the edges between cells that are predicted stable and cells that are not.
fn draw_border(root: &Area<'_>, rows: &[Vec<Cell>], corner: impl Fn(i32, i32) -> (i32, i32)) -> Drawn {
    let stable = |x: usize, y: usize| -> Option<bool> { Some(rows.get(y)?.get(x)?.predicted?.stable) };
    for (y, row) in rows.iter().enumerate() {
        for x in 0..row.len() {
            let (u, v) = (x as i32, y as i32);
            let differs = |other: Option<bool>| other.is_some_and(|other| Some(other) != stable(x, y));
            if stable(x, y).is_some() && differs(stable(x + 1, y)) {
                root.draw(&line([corner(u + 1, v), corner(u + 1, v + 1)], BORDER, 3))?;
            }
            if stable(x, y).is_some() && differs(stable(x, y + 1)) {
                root.draw(&line([corner(u, v + 1), corner(u + 1, v + 1)], BORDER, 3))?;
            }
        }
    }
    Ok(())
}

fn draw_axes(root: &Area<'_>, map: &MapDefinition, at: (i32, i32), up: i32) -> Drawn {
    let square = square(map);
    let below = Pos::new(HPos::Center, VPos::Top);
    let beside = Pos::new(HPos::Right, VPos::Center);
    let centre = |i: usize| i as i32 * square + square / 2;
    for i in shown(&map.x, square) {
        let text = number(map.x.values[i]);
        root.draw(&label(
            &text,
            (at.0 + centre(i), at.1 + up * square + 5),
            SMALL - 2,
            below,
            INK,
        ))?;
    }
    for i in 0..map.y.values.len() {
        let text = number(map.y.values[i]);
        root.draw(&label(
            &text,
            (at.0 - 5, at.1 + up * square - centre(i)),
            SMALL - 2,
            beside,
            INK,
        ))?;
    }
    let middle = map.x.values.len() as i32 * square / 2;
    let text = map.x.axis.label();
    root.draw(&label(
        text,
        (at.0 + middle, at.1 + up * square + 24),
        SMALL,
        below,
        INK,
    ))?;
    let turned = font(SMALL)
        .transform(FontTransform::Rotate270)
        .pos(Pos::new(HPos::Center, VPos::Bottom))
        .color(&INK);
    let where_to = (px(at.0 - 36), px(at.1 + up * square / 2));
    root.draw(&Text::new(map.y.axis.label().to_owned(), where_to, turned))?;
    Ok(())
}

/// The side of a square of `map`, px.
fn square(map: &MapDefinition) -> i32 {
    let most = map.x.values.len().max(map.y.values.len()) as i32;
    (PANEL / most).clamp(SQUARE[0], SQUARE[1])
}

/// The values that have room for a number along x, in squares of `square` px.
fn shown(values: &Values, square: i32) -> impl Iterator<Item = usize> + use<> {
    let longest = values
        .values
        .iter()
        .map(|value| number(*value).len())
        .max()
        .unwrap_or(0) as i32;
    // A digit takes 8 px, and some air.
    let step = (8 * longest + 4 + square - 1) / square;
    (0..values.values.len()).step_by(step.max(1) as usize)
}

fn number(value: f64) -> String {
    if value >= 1e4 {
        // Exact powers and the digits before them: 1.6e7 is 16M.
        return if value >= 1e6 {
            format!("{:.3}M", value / 1e6)
        } else {
            format!("{:.0}k", value / 1e3)
        }
        .replace(".000M", "M")
        .replace("00M", "M");
    }
    value.to_string()
}

/// Title, scale of the colours, and what the marks mean.
fn draw_legend(root: &Area<'_>, plan: &Plan, map: &MapDefinition) -> Drawn {
    let left = Pos::new(HPos::Left, VPos::Center);
    let (first, second) = (54, 90);
    let word =
        |text: &str, x: i32, y: i32| -> Drawn { Ok(root.draw(&label(text, (x, y), SMALL, left, INK))?) };
    root.draw(&label(&map.title, (EDGE, 22), LARGE, left, INK))?;
    word("integral of |force error| over 1.5 s, N s:", EDGE, first)?;
    let (start, wide) = (EDGE + 300, 240);
    for i in 0..wide {
        let share = f64::from(i) / f64::from(wide);
        let value = IAE_N_S[0] * libm::pow(IAE_N_S[1] / IAE_N_S[0], share);
        // Each overlaps the next, so that no viewer draws a seam.
        let end = (start + i + 2).min(start + wide);
        let corners = [(px(start + i), px(first - 8)), (px(end), px(first + 8))];
        root.draw(&Rectangle::new(corners, colour(value).filled()))?;
    }
    let under = Pos::new(HPos::Center, VPos::Top);
    for (value, text) in [(0.1, "0.1"), (0.3, "0.3"), (1.0, "1"), (3.0, "3"), (10.0, "10")] {
        let share = libm::log(value / IAE_N_S[0]) / libm::log(IAE_N_S[1] / IAE_N_S[0]);
        let at = start + libm::rint(share * f64::from(wide)) as i32;
        root.draw(&label(text, (at, first + 9), SMALL - 2, under, INK))?;
    }
    let (runs, gains) = (plan.definition.phases, plan.definition.gains.word());
    let phases = if runs == 1 {
        "one contact phase".to_owned()
    } else {
        format!("mean of {runs} contact phases")
    };
    word(&format!("{phases}; {gains} gains"), start + wide + 24, first)?;
    let mark = |x: i32, settled_runs: usize, unstable_runs: usize| -> Drawn {
        let cell = Cell {
            runs: 2,
            settled_runs,
            unstable_runs,
            mean: None,
            worst: None,
            predicted: None,
        };
        let half = MARK / 2;
        let (low, high) = ((px(x), px(second + half)), (px(x + MARK), px(second - half)));
        if unstable_runs == 0 {
            root.draw(&Rectangle::new([low, high], colour(1.0).filled()))?;
        }
        draw_cell(root, &cell, low, high)
    };
    mark(EDGE, 0, 2)?;
    word("unstable", EDGE + 24, second)?;
    mark(EDGE + 106, 1, 1)?;
    word("in some phases", EDGE + 130, second)?;
    mark(EDGE + 258, 0, 0)?;
    word("rings for more than 1.2 s, but dies out", EDGE + 284, second)?;
    let at = EDGE + 580;
    root.draw(&line(
        [(px(at), px(second)), (px(at + 24), px(second))],
        BORDER,
        3,
    ))?;
    word("border of stability by linear theory", at + 32, second)
}

/// Of an IAE in N s.
fn colour(iae_n_s: f64) -> RGBColor {
    let share = libm::log(iae_n_s / IAE_N_S[0]) / libm::log(IAE_N_S[1] / IAE_N_S[0]);
    let place = share.clamp(0.0, 1.0) * (SCALE.len() - 1) as f64;
    let below = (place as usize).min(SCALE.len() - 2);
    let part = place - below as f64;
    let mix = |a: u8, b: u8| libm::rint(f64::from(a) + (f64::from(b) - f64::from(a)) * part) as u8;
    let (a, b) = (SCALE[below], SCALE[below + 1]);
    RGBColor(mix(a.0, b.0), mix(a.1, b.1), mix(a.2, b.2))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short() {
        let written = [1e4, 1.6e5, 1.3e6, 1.6e7, 0.85, 2.0].map(number);
        assert_eq!(written, ["10k", "160k", "1.3M", "16M", "0.85", "2"]);
    }

    #[test]
    fn colours_end_where_the_scale_does() {
        let ends = [0.001, 0.1, 10.0, 1e6].map(|iae| colour(iae).rgb());
        assert_eq!(
            ends,
            [SCALE[0], SCALE[0], SCALE[5], SCALE[5]].map(|colour| colour.rgb())
        );
    }
}
