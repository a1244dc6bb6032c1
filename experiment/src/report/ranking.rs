//! All laws in one figure, on a logarithmic scale: mean with its confidence, and the worst run.

use crate::figure::style::{Area, Drawn, FAINT, INK, LARGE, SMALL, label, line, px, svg};
use crate::table::{Figure, Row};
use crate::tuning::Gains;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

/// Sizes, px.
const WIDTH: i32 = 480;
const LEFT: i32 = 92;
const RIGHT: i32 = 22;
const TOP: i32 = 38;
const LINE: i32 = 30;
const AXIS: i32 = 30;
/// Between the two marks of a law.
const APART: i32 = 6;
/// Of a mark.
const RADIUS: i32 = 5;

/// Colours of Okabe and Ito; filled and hollow, so that they are told apart without colour, too.
const TUNED: RGBColor = RGBColor(0, 114, 178);
const DEFAULT: RGBColor = RGBColor(213, 94, 0);

/// From a figure's values to pixels.
struct Scale {
    low: f64,
    high: f64,
}

impl Scale {
    /// Over all that `rows` show of `figure`, a little more; `None`: they show nothing.
    fn over(rows: &[Row], figure: &Figure) -> Option<Self> {
        let values = rows
            .iter()
            .flat_map(|row| [mean(row, figure), worst(row, figure)]);
        let values: Vec<f64> = values.filter(|value| value.is_finite() && *value > 0.0).collect();
        let low = values.iter().copied().reduce(f64::min)?;
        let high = values.iter().copied().reduce(f64::max)?;
        Some(Self {
            low: low / 1.25,
            high: high * 1.25,
        })
    }

    fn x(&self, value: f64) -> i32 {
        let share = libm::log(value / self.low) / libm::log(self.high / self.low);
        let wide = f64::from(px(WIDTH - LEFT - RIGHT));
        px(LEFT) + libm::rint(share.clamp(0.0, 1.0) * wide) as i32
    }

    /// Round numbers within it: at most about eight.
    fn ticks(&self) -> Vec<f64> {
        let decades = libm::log10(self.high / self.low);
        let steps: &[f64] = if decades > 2.5 {
            &[1.0]
        } else if decades > 1.2 {
            &[1.0, 3.0]
        } else {
            &[1.0, 1.5, 2.0, 3.0, 5.0, 7.0]
        };
        (-6..7)
            .flat_map(|power| {
                steps
                    .iter()
                    .map(move |step| step * libm::pow(10.0, f64::from(power)))
            })
            .filter(|tick| (self.low..=self.high).contains(tick))
            .collect()
    }
}

fn mean(row: &Row, figure: &Figure) -> f64 {
    figure.3(&row.mean) * figure.1
}

fn worst(row: &Row, figure: &Figure) -> f64 {
    figure.3(&row.worst) * figure.1
}

/// `rows` by `figure`, which `title` names with its unit, the best tuned law on top; `None`: there is nothing to show.
pub(super) fn draw(rows: &[Row], figure: &Figure, title: &str) -> Drawn<Option<String>> {
    let Some(scale) = Scale::over(rows, figure) else {
        return Ok(None);
    };
    let laws = order(rows, figure);
    let height = TOP + laws.len() as i32 * LINE + AXIS;
    let drawn = svg(WIDTH, height, |root| {
        let left = Pos::new(HPos::Left, VPos::Center);
        root.draw(&label(title, (4, 14), LARGE, left, INK))?;
        draw_axis(root, &scale, height)?;
        for (i, law) in (0..).zip(&laws) {
            let y = TOP + i * LINE + LINE / 2;
            let right = Pos::new(HPos::Right, VPos::Center);
            root.draw(&label(law, (LEFT - 12, y), SMALL, right, INK))?;
            for row in rows.iter().filter(|row| row.law == **law) {
                draw_mark(root, &scale, row, figure, y)?;
            }
        }
        Ok(())
    })?;
    Ok(Some(drawn))
}

/// The laws, the best first by what they reach at best.
fn order<'a>(rows: &'a [Row], figure: &Figure) -> Vec<&'a str> {
    let mut laws: Vec<&str> = Vec::new();
    for row in rows {
        if !laws.contains(&row.law.as_str()) {
            laws.push(&row.law);
        }
    }
    let best = |law: &str| {
        let own = rows.iter().filter(|row| row.law == law);
        own.map(|row| mean(row, figure)).fold(f64::INFINITY, f64::min)
    };
    laws.sort_by(|a, b| best(a).total_cmp(&best(b)));
    laws
}

fn draw_axis(root: &Area<'_>, scale: &Scale, height: i32) -> Drawn {
    let (top, bottom) = (px(TOP - 6), px(height - AXIS));
    let below = Pos::new(HPos::Center, VPos::Top);
    for tick in scale.ticks() {
        let x = scale.x(tick);
        root.draw(&line([(x, top), (x, bottom)], FAINT, 1))?;
        // Twelve digits hide what a binary number adds to a decimal one.
        let text = format!("{tick:.12}");
        let text = text.trim_end_matches('0').trim_end_matches('.');
        root.draw(&label(text, (x / px(1), height - AXIS + 6), SMALL, below, INK))?;
    }
    root.draw(&line([(px(LEFT), bottom), (px(WIDTH - RIGHT), bottom)], INK, 1))?;
    Ok(())
}

fn draw_mark(root: &Area<'_>, scale: &Scale, row: &Row, figure: &Figure, y: i32) -> Drawn {
    let (colour, y) = match row.gains {
        Gains::Tuned => (TUNED, px(y + APART)),
        Gains::Default => (DEFAULT, px(y - APART)),
    };
    let (mean, worst) = (mean(row, figure), worst(row, figure));
    if !(mean > 0.0 && mean.is_finite()) {
        return Ok(());
    }
    let at = scale.x(mean);
    if worst.is_finite() {
        let end = scale.x(worst);
        root.draw(&line([(at, y), (end, y)], colour, 1))?;
        root.draw(&line([(end, y - px(4)), (end, y + px(4))], colour, 2))?;
    }
    let half = figure.3(&row.confidence) * figure.1;
    if half.is_finite() && half < mean {
        root.draw(&line(
            [(scale.x(mean - half), y), (scale.x(mean + half), y)],
            colour,
            4,
        ))?;
    }
    root.draw(&Circle::new((at, y), px(RADIUS), colour.filled()))?;
    if row.gains == Gains::Default {
        root.draw(&Circle::new((at, y), px(RADIUS - 2), WHITE.filled()))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::metrics::Metrics;
    use crate::table::FIGURES;

    fn row(law: &str, gains: Gains, iae_n_s: f64) -> Row {
        let metrics = Metrics {
            iae_n_s,
            ..Metrics::default()
        };
        Row {
            gains,
            ..Row::single("rigid", "gantry", law, metrics)
        }
    }

    #[test]
    fn the_best_law_is_on_top_and_what_is_no_number_is_not_drawn() {
        let rows = [
            row("pd", Gains::Default, 0.6),
            row("proposed", Gains::Default, 0.14),
            row("ros2", Gains::Default, f64::NAN),
            row("ros2", Gains::Tuned, 1.1),
        ];
        let figure = FIGURES.iter().find(|figure| figure.0 == "IAE N s").unwrap();
        assert_eq!(order(&rows, figure), ["proposed", "pd", "ros2"]);
        let svg = draw(&rows, figure, "IAE").unwrap().unwrap();
        let place = |text: &str| svg.find(&format!("\n{text}\n")).unwrap();
        assert!(place("proposed") < place("pd"), "{svg}");
        assert!(!svg.contains("NaN"));
        assert_eq!(draw(&rows[2..3], figure, "IAE").unwrap(), None);
    }

    #[test]
    fn ticks_are_round() {
        let ticks = |low, high| Scale { low, high }.ticks();
        assert_eq!(ticks(0.1, 5.0).len(), 4);
        assert_eq!(ticks(9.0, 31.0).len(), 4);
        assert_eq!(ticks(0.02, 40.0).len(), 3);
    }
}
