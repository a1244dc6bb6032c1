//! Lines over time, or over anything else, with a legend above and units at the axes.

use super::style::{Area, Drawn, FAINT, INK, SMALL, font, label, line, px, svg};
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use std::ops::Range;

/// Size of a chart and of its parts, px.
const WIDTH: i32 = 800;
const HEIGHT: i32 = 250;
const LEGEND_HEIGHT: i32 = 28;
const LEFT: i32 = 76;
const AXIS_HEIGHT: i32 = 44;
const EDGE: i32 = 8;
const RIGHT: i32 = 16;

/// Colours of Okabe and Ito, which people with colour-blindness tell apart.
pub(crate) const BLUE: RGBColor = RGBColor(0, 114, 178);
pub(crate) const RED: RGBColor = RGBColor(213, 94, 0);
pub(crate) const GREEN: RGBColor = RGBColor(0, 158, 115);
pub(crate) const GREY: RGBColor = RGBColor(150, 150, 150);

/// One line.
pub(crate) struct Line {
    /// What it is.
    pub(crate) name: &'static str,
    /// Its points.
    pub(crate) points: Vec<(f64, f64)>,
    /// Its colour.
    pub(crate) colour: RGBColor,
    /// Told apart without colour.
    pub(crate) dashed: bool,
}

/// Lines in the same axes.
pub(crate) struct Chart {
    /// The axes' names with units.
    pub(crate) axes: [&'static str; 2],
    /// What is shown of the first axis.
    pub(crate) range: Range<f64>,
    /// The lines, in the order of the legend.
    pub(crate) lines: Vec<Line>,
    /// Rectangles from zero up: first axis from, to, and height.
    pub(crate) bars: Vec<[f64; 3]>,
}

impl Chart {
    /// As SVG; `None`: there is nothing to show.
    pub(crate) fn draw(&self) -> Option<Drawn<String>> {
        let values = self.heights()?;
        Some(svg(WIDTH, HEIGHT + LEGEND_HEIGHT + AXIS_HEIGHT, |root| {
            let (legend, below) = root.split_vertically(px(LEGEND_HEIGHT));
            self.draw_legend(&legend)?;
            self.draw_lines(&below, &values)
        }))
    }

    fn shown(&self) -> impl Iterator<Item = (&Line, Vec<(f64, f64)>)> {
        self.lines.iter().map(|line| {
            let within = |(x, y): &&(f64, f64)| self.range.contains(x) && y.is_finite();
            (line, line.points.iter().filter(within).copied().collect())
        })
    }

    /// What is shown of the second axis.
    fn heights(&self) -> Option<Range<f64>> {
        const MARGIN: f64 = 0.06;
        let points: Vec<_> = self
            .shown()
            .flat_map(|(_, points)| points)
            .map(|(_, y)| y)
            .collect();
        let all = points
            .into_iter()
            .chain(self.bars.iter().flat_map(|[_, _, height]| [0.0, *height]));
        let (low, high) = all.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), y| {
            (low.min(y), high.max(y))
        });
        if !low.is_finite() || self.range.is_empty() {
            return None;
        }
        let margin = (MARGIN * (high - low)).max(1e-9 + 1e-6 * high.abs());
        let bottom = if self.bars.is_empty() { low - margin } else { 0.0 };
        Some(bottom..high + margin)
    }

    fn draw_legend(&self, area: &Area<'_>) -> Drawn {
        let mut x = LEFT;
        for (drawn, points) in self.shown() {
            if points.is_empty() {
                continue;
            }
            let at = |dx: i32| (px(x + dx), px(LEGEND_HEIGHT / 2));
            let parts: &[[i32; 2]] = if drawn.dashed {
                &[[0, 7], [10, 17], [20, 27]]
            } else {
                &[[0, 27]]
            };
            for [from, to] in parts {
                area.draw(&line([at(*from), at(*to)], drawn.colour, 2))?;
            }
            let middle = Pos::new(HPos::Left, VPos::Center);
            area.draw(&label(
                drawn.name,
                (x + 33, LEGEND_HEIGHT / 2),
                SMALL,
                middle,
                INK,
            ))?;
            x += 33 + 8 * drawn.name.chars().count() as i32 + 14;
        }
        Ok(())
    }

    fn draw_lines(&self, area: &Area<'_>, heights: &Range<f64>) -> Drawn {
        let mut chart = ChartBuilder::on(area)
            .margin_top(px(EDGE))
            .margin_right(px(RIGHT))
            .margin_left(px(EDGE))
            .y_label_area_size(px(LEFT - EDGE))
            .x_label_area_size(px(AXIS_HEIGHT))
            .build_cartesian_2d(self.range.clone(), heights.clone())?;
        for still in [
            [(0.0, heights.start), (0.0, heights.end)],
            [(self.range.start, 0.0), (self.range.end, 0.0)],
        ] {
            let within = still
                .iter()
                .all(|(x, y)| *x >= self.range.start && *y >= heights.start && *y <= heights.end);
            if within {
                chart.draw_series([line(still, FAINT, 1)])?;
            }
        }
        let bars = self
            .bars
            .iter()
            .map(|[from, to, height]| Rectangle::new([(*from, 0.0), (*to, *height)], BLUE.filled()));
        chart.draw_series(bars)?;
        for (drawn, points) in self.shown() {
            if drawn.dashed {
                let style = drawn.colour.stroke_width(px(2) as u32);
                chart.draw_series(DashedLineSeries::new(points, px(7), px(4), style))?;
            } else {
                chart.draw_series([line(points, drawn.colour, 2)])?;
            }
        }
        let text = font(SMALL).color(&INK);
        let high = decimals(heights.end - heights.start);
        let wide = decimals(self.range.end - self.range.start);
        chart
            .configure_mesh()
            .disable_mesh()
            .axis_style(INK.stroke_width(px(1) as u32))
            .label_style(text.clone())
            .axis_desc_style(text)
            .set_all_tick_mark_size(px(4))
            .x_labels(10)
            .y_labels(7)
            .x_label_formatter(&|x| number(*x, wide))
            .y_label_formatter(&|y| number(*y, high))
            .x_desc(self.axes[0])
            .y_desc(self.axes[1])
            .draw()?;
        Ok(())
    }
}

/// How many decimals the labels of an axis need that shows so much.
fn decimals(span: f64) -> usize {
    match span {
        ..0.05 => 3,
        ..0.5 => 2,
        ..5.0 => 1,
        _ => 0,
    }
}

/// With the sign that printers use.
fn number(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    let zero = text.trim_start_matches('-').chars().all(|c| c == '0' || c == '.');
    match zero {
        true => text.trim_start_matches('-').to_owned(),
        false => text.replace('-', "\u{2212}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chart(points: Vec<(f64, f64)>) -> Chart {
        Chart {
            axes: ["time, ms", "force, N"],
            range: 0.0..10.0,
            lines: vec![Line {
                name: "true",
                points,
                colour: BLUE,
                dashed: false,
            }],
            bars: Vec::new(),
        }
    }

    #[test]
    fn a_line_is_drawn_with_its_axes_and_what_lies_beyond_is_not() {
        let svg = chart(vec![(-5.0, 1e9), (0.0, 1.0), (5.0, f64::NAN), (9.0, -2.0)])
            .draw()
            .unwrap()
            .unwrap();
        for text in ["time, ms", "force, N", "true"] {
            assert!(svg.contains(text), "{text}");
        }
        assert!(!svg.contains("NaN") && !svg.contains("000000000"));
        assert!(svg.contains("\u{2212}2"));
    }

    #[test]
    fn nothing_is_no_figure() {
        assert!(chart(vec![(20.0, 1.0)]).draw().is_none());
        // A constant has a height, too.
        assert!(chart(vec![(1.0, 3.0), (2.0, 3.0)]).draw().unwrap().is_ok());
    }

    #[test]
    fn zero_has_no_sign() {
        assert_eq!(number(-0.01, 1), "0.0");
        assert_eq!(number(-1.5, 1), "\u{2212}1.5");
    }
}
