//! Detection delay over the speed of the approach, as one SVG.

use super::Delay;
use crate::figure::FigureError;
use crate::figure::style::{Drawn, FAINT, INK, LARGE, SMALL, font, label, line, px, svg};
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use std::path::Path;

const WIDTH: i32 = 720;
const HEIGHT: i32 = 420;
const TITLE_HEIGHT: i32 = 36;
const LEFT: i32 = 66;
const AXIS_HEIGHT: i32 = 44;

/// Colours of Okabe and Ito.
const ALONE: RGBColor = RGBColor(213, 94, 0);
const BOTH: RGBColor = RGBColor(0, 114, 178);

/// Draw `delays` with the `title` into the SVG file `path`: means as lines, the longest as circles.
pub fn draw(delays: &[Delay], title: &str, path: &Path) -> Result<(), FigureError> {
    let drawn = drawn(delays, title).map_err(|error| FigureError::Draw(error.to_string()))?;
    std::fs::write(path, drawn).map_err(|source| FigureError::Write {
        path: path.to_owned(),
        source,
    })
}

fn drawn(delays: &[Delay], title: &str) -> Drawn<String> {
    type Of = fn(&Delay) -> Option<[f64; 2]>;
    let points = |of: Of, which: usize| {
        delays
            .iter()
            .filter_map(move |delay| Some((1e3 * delay.speed_m_per_s, 1e3 * of(delay)?[which])))
            .collect::<Vec<_>>()
    };
    let curves: [(Of, RGBColor, &str); 2] = [
        (|delay| delay.threshold_s, ALONE, "threshold alone"),
        (|delay| delay.both_s, BOTH, "threshold and cumulative sum"),
    ];
    let speeds = || delays.iter().map(|delay| 1e3 * delay.speed_m_per_s);
    let (slowest, fastest) = (
        speeds().fold(f64::INFINITY, f64::min),
        speeds().fold(0.0, f64::max),
    );
    let longest = curves
        .iter()
        .flat_map(|(of, _, _)| points(*of, 1))
        .fold(10.0, |most, point| f64::max(most, point.1));
    svg(WIDTH, HEIGHT, |root| {
        let left = Pos::new(HPos::Left, VPos::Top);
        root.draw(&label(title, (14, 8), LARGE, left, INK))?;
        let mut chart = ChartBuilder::on(root)
            .margin_top(px(TITLE_HEIGHT))
            .margin_right(px(18))
            .margin_left(px(8))
            .y_label_area_size(px(LEFT))
            .x_label_area_size(px(AXIS_HEIGHT))
            .build_cartesian_2d(
                (0.9 * slowest..1.1 * fastest).log_scale(),
                (0.8..1.3 * longest).log_scale(),
            )?;
        let text = font(SMALL).color(&INK);
        chart
            .configure_mesh()
            .light_line_style(TRANSPARENT)
            .bold_line_style(FAINT.stroke_width(px(1) as u32))
            .axis_style(INK.stroke_width(px(1) as u32))
            .label_style(text.clone())
            .axis_desc_style(text)
            .set_all_tick_mark_size(px(4))
            .x_label_formatter(&|speed| speed.to_string())
            .y_label_formatter(&|delay| delay.to_string())
            .x_desc("approach, mm/s")
            .y_desc("from touch to detecting sample, ms")
            .draw()?;
        for (i, (of, colour, name)) in (0..).zip(curves) {
            chart.draw_series([line(points(of, 0), colour, 2)])?;
            chart.draw_series(
                points(of, 1)
                    .into_iter()
                    .map(|point| Circle::new(point, px(3), colour.stroke_width(px(1) as u32))),
            )?;
            let right = Pos::new(HPos::Right, VPos::Top);
            root.draw(&label(
                name,
                (WIDTH - 30, TITLE_HEIGHT + 8 + 20 * i),
                SMALL,
                right,
                colour,
            ))?;
        }
        let right = Pos::new(HPos::Right, VPos::Top);
        let note = "lines: mean, circles: longest";
        root.draw(&label(note, (WIDTH - 30, TITLE_HEIGHT + 48), SMALL, right, INK))?;
        Ok(())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_curves_are_drawn() {
        let delays = [(0.001, 20e-3, 12e-3), (0.02, 2.3e-3, 2.2e-3)].map(|(speed, alone, both)| Delay {
            speed_m_per_s: speed,
            threshold_s: Some([alone, 1.2 * alone]),
            both_s: Some([both, 1.2 * both]),
        });
        let svg = drawn(&delays, "paper").unwrap();
        assert!(svg.contains("cumulative sum") && svg.contains("#D55E00") && svg.contains("#0072B2"));
        assert!(!svg.contains("NaN") && svg.trim_end().ends_with("</svg>"));
        let error = draw(&delays, "paper", Path::new("no such directory/a.svg")).unwrap_err();
        assert!(error.to_string().contains("can't be written"));
    }
}
