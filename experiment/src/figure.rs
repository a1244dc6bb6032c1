//! The force of several laws over time as one SVG: the counterpart of the paper's Figs. 7 and 8.

use crate::metrics::{ForceCurve, Metrics};
use plotters::coord::Shift;
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use std::io;
use std::ops::Range;
use std::path::{Path, PathBuf};

/// The force of one run and what to say about it.
#[derive(Clone, Debug, PartialEq)]
pub struct LabelledCurve {
    /// Law, such as `proposed`; it decides the colour.
    pub law: String,
    /// Title of its panel; see [`title`].
    pub title: String,
    /// Desired force, N.
    pub desired_force_n: f64,
    /// The true force, quasi-static: see [`Recording::force_curve`](crate::metrics::Recording::force_curve).
    pub curve: ForceCurve,
    /// The force as the controller sees it, in every cycle: with the sensor's noise, low pass and delay.
    pub measured: ForceCurve,
    /// The figures of the run.
    pub metrics: Metrics,
}

/// Why there is no figure.
#[derive(Debug, thiserror::Error)]
pub enum FigureError {
    /// Nothing to draw.
    #[error("no force between {} and {} s after the first contact; record at least one run with contact",
        TIME_S.start, TIME_S.end)]
    Empty,
    /// The drawing failed.
    #[error("the figure can't be drawn: {0}")]
    Draw(String),
    /// The file can't be written.
    #[error("the figure {} can't be written: {source}; choose a directory that can be written to", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
}

/// What a panel of `law` is called: its equations in the paper.
pub fn title(law: &str) -> String {
    match law {
        "pd" => "pd law, eq. (1)".to_owned(),
        "proposed" => "proposed law, eqs. (2) and (9)\u{2013}(12)".to_owned(),
        other => format!("{other} law"),
    }
}

/// The time shown, after the first contact, s.
const TIME_S: Range<f64> = -0.05..0.4;
/// The band that is shaded, as a fraction of the desired force.
const BAND: f64 = 0.10;
/// Plotters rounds to whole pixels: draw larger by this and let the viewer scale.
const SCALE: i32 = 8;
/// Size of the figure and of its parts, px.
const WIDTH: i32 = 800;
const LEGEND_HEIGHT: i32 = 36;
const PANEL_HEIGHT: i32 = 236;
const AXIS_HEIGHT: i32 = 44;
const TITLE_HEIGHT: i32 = 30;
const LEFT: i32 = 66;
const RIGHT: i32 = 16;
const BOTTOM: i32 = 10;
const EDGE: i32 = 8;
/// Sizes of the letters, px.
const LARGE: i32 = 16;
const SMALL: i32 = 14;

const INK: RGBColor = RGBColor(40, 40, 40);
const MEASURED: RGBColor = RGBColor(150, 150, 150);
const SHADE: RGBColor = RGBColor(232, 232, 232);
const FAINT: RGBColor = RGBColor(205, 205, 205);

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
type Chart<'a, 'b> = ChartContext<'a, SVGBackend<'b>, Cartesian2d<RangedCoordf64, RangedCoordf64>>;
type Drawn<T = ()> = Result<T, Box<dyn std::error::Error>>;

/// Draw one panel for each of `curves`, one above the other, into the SVG file `path`.
pub fn force_figure(curves: &[LabelledCurve], path: &Path) -> Result<(), FigureError> {
    let svg = draw(curves)?;
    std::fs::write(path, svg).map_err(|source| FigureError::Write {
        path: path.to_owned(),
        source,
    })
}

fn draw(curves: &[LabelledCurve]) -> Result<String, FigureError> {
    let force_n = force_range(curves).ok_or(FigureError::Empty)?;
    let size = (
        WIDTH,
        LEGEND_HEIGHT + PANEL_HEIGHT * curves.len() as i32 + AXIS_HEIGHT,
    );
    let drawn = ((SCALE * size.0) as u32, (SCALE * size.1) as u32);
    let mut svg = String::new();
    let root = SVGBackend::with_string(&mut svg, drawn).into_drawing_area();
    let result = draw_all(&root, curves, &force_n);
    drop(root);
    result.map_err(|error| FigureError::Draw(error.to_string()))?;
    let dimensions = |(width, height)| format!(r#"width="{width}" height="{height}" viewBox"#);
    let (large, small) = (dimensions((drawn.0 as i32, drawn.1 as i32)), dimensions(size));
    Ok(svg.replacen(&large, &small, 1))
}

fn draw_all(root: &Area<'_>, curves: &[LabelledCurve], force_n: &Range<f64>) -> Drawn {
    root.fill(&WHITE)?;
    let (legend, mut rest) = root.split_vertically(px(LEGEND_HEIGHT));
    draw_legend(&legend)?;
    for (i, curve) in curves.iter().enumerate() {
        let last = i + 1 == curves.len();
        let height = PANEL_HEIGHT + if last { AXIS_HEIGHT } else { 0 };
        let (panel, below) = rest.split_vertically(px(height));
        draw_panel(&panel, curve, colour(&curve.law, i), force_n, last)?;
        rest = below;
    }
    root.present()?;
    Ok(())
}

fn draw_panel(
    panel: &Area<'_>,
    curve: &LabelledCurve,
    colour: RGBColor,
    force_n: &Range<f64>,
    last: bool,
) -> Drawn {
    let left = Pos::new(HPos::Left, VPos::Top);
    panel.draw(&label(&curve.title, (LEFT, 6), LARGE, left, colour))?;
    let mut chart = ChartBuilder::on(panel)
        .margin_top(px(TITLE_HEIGHT))
        .margin_right(px(RIGHT))
        .margin_bottom(px(BOTTOM))
        .margin_left(px(EDGE))
        .y_label_area_size(px(LEFT - EDGE))
        .x_label_area_size(px(if last { AXIS_HEIGHT } else { 0 }))
        .build_cartesian_2d(TIME_S, force_n.clone())?;
    let desired = curve.desired_force_n;
    let band = [
        (TIME_S.start, desired * (1.0 - BAND)),
        (TIME_S.end, desired * (1.0 + BAND)),
    ];
    chart.draw_series([Rectangle::new(band, SHADE.filled())])?;
    chart.draw_series([
        line([(0.0, force_n.start), (0.0, force_n.end)], FAINT, 1),
        line([(TIME_S.start, 0.0), (TIME_S.end, 0.0)], FAINT, 1),
    ])?;
    let reference = [(TIME_S.start, desired), (TIME_S.end, desired)];
    let dashes = DashedLineSeries::new(reference, 6 * SCALE, 4 * SCALE, INK.stroke_width(SCALE as u32));
    chart.draw_series(dashes)?;
    chart.draw_series([line(points(&curve.measured), MEASURED, 1)])?;
    chart.draw_series(points(&curve.measured).map(|point| Circle::new(point, px(2), MEASURED.filled())))?;
    chart.draw_series([line(points(&curve.curve), colour, 2)])?;
    draw_axes(&mut chart, last)?;
    draw_figures(panel, &curve.metrics)
}

fn draw_axes(chart: &mut Chart<'_, '_>, last: bool) -> Drawn {
    let text = font(SMALL).color(&INK);
    let mut mesh = chart.configure_mesh();
    mesh.disable_mesh()
        .axis_style(INK.stroke_width(SCALE as u32))
        .label_style(text.clone())
        .axis_desc_style(text)
        .set_all_tick_mark_size(px(4))
        .x_labels(10)
        .y_labels(8)
        .x_label_formatter(&|time| format!("{time:.1}").replace('-', "\u{2212}"))
        .y_label_formatter(&|force| format!("{force:.0}").replace('-', "\u{2212}"))
        .y_desc("contact force, N");
    if last {
        mesh.x_desc("time after first contact, s");
    }
    Ok(mesh.draw()?)
}

/// The figures of the run in the panel's upper right corner.
fn draw_figures(panel: &Area<'_>, metrics: &Metrics) -> Drawn {
    let lines = [
        format!("peak {:.1} N", metrics.peak_n),
        format!("within \u{b1}10 % after {:.0} ms", metrics.settling_10_s * 1e3),
        format!("within \u{b1}2 % after {:.0} ms", metrics.settling_2_s * 1e3),
        format!("IAE {:.3} N s", metrics.iae_n_s),
    ];
    let right = Pos::new(HPos::Right, VPos::Top);
    for (i, text) in lines.iter().enumerate() {
        let at = (WIDTH - RIGHT - 10, TITLE_HEIGHT + 8 + 19 * i as i32);
        panel.draw(&label(text, at, SMALL, right, INK))?;
    }
    Ok(())
}

/// What the lines mean, in a row above the panels.
fn draw_legend(area: &Area<'_>) -> Drawn {
    let middle = LEGEND_HEIGHT / 2;
    let left = Pos::new(HPos::Left, VPos::Center);
    let entries = [
        (LEFT, "true force"),
        (LEFT + 130, "as the controller sees it"),
        (LEFT + 355, "desired force"),
        (LEFT + 500, "\u{b1}10 %"),
    ];
    for (i, (x, text)) in entries.into_iter().enumerate() {
        let ends = [(px(x), px(middle)), (px(x + 28), px(middle))];
        let corners = [(px(x), px(middle - 6)), (px(x + 28), px(middle + 6))];
        match i {
            0 => area.draw(&PathElement::new(ends, INK.stroke_width(2 * SCALE as u32)))?,
            1 => area.draw(&PathElement::new(ends, MEASURED.stroke_width(SCALE as u32)))?,
            2 => {
                for start in [x, x + 10, x + 20] {
                    let dash = [(px(start), px(middle)), (px(start + 6), px(middle))];
                    area.draw(&PathElement::new(dash, INK.stroke_width(SCALE as u32)))?;
                }
            }
            _ => area.draw(&Rectangle::new(corners, SHADE.filled()))?,
        }
        area.draw(&label(text, (x + 35, middle), SMALL, left, INK))?;
    }
    Ok(())
}

/// The forces shown in all panels, with a margin; `None`: a panel would be empty.
fn force_range(curves: &[LabelledCurve]) -> Option<Range<f64>> {
    const MARGIN: f64 = 0.05;
    if curves.is_empty() || curves.iter().any(|curve| points(&curve.curve).next().is_none()) {
        return None;
    }
    let (mut low, mut high) = (0.0, 0.0);
    for curve in curves {
        high = f64::max(high, curve.desired_force_n * (1.0 + BAND));
        for (_, force) in points(&curve.curve).chain(points(&curve.measured)) {
            (low, high) = (f64::min(low, force), f64::max(high, force));
        }
    }
    let margin = MARGIN * (high - low);
    Some(low - margin..high + margin)
}

/// The part of a curve that is shown.
fn points(curve: &ForceCurve) -> impl Iterator<Item = (f64, f64)> {
    let both = curve.time_s.iter().copied().zip(curve.force_n.iter().copied());
    both.filter(|(time, force)| TIME_S.contains(time) && force.is_finite())
}

/// Colours of Okabe and Ito, which people with colour-blindness tell apart.
fn colour(law: &str, index: usize) -> RGBColor {
    const OTHERS: [RGBColor; 4] = [
        RGBColor(0, 158, 115),
        RGBColor(204, 121, 167),
        RGBColor(230, 159, 0),
        RGBColor(86, 180, 233),
    ];
    match law {
        "proposed" => RGBColor(0, 114, 178),
        "pd" => RGBColor(213, 94, 0),
        _ => OTHERS[index % OTHERS.len()],
    }
}

fn line(
    points: impl IntoIterator<Item = (f64, f64)>,
    colour: RGBColor,
    width: i32,
) -> PathElement<(f64, f64)> {
    let points: Vec<_> = points.into_iter().collect();
    PathElement::new(points, colour.stroke_width(px(width) as u32))
}

fn font(size: i32) -> TextStyle<'static> {
    // Plotters writes 1 / 1.24 of the size.
    ("sans-serif", 1.24 * f64::from(px(size))).into()
}

fn label(
    text: &str,
    at: (i32, i32),
    size: i32,
    pos: Pos,
    colour: RGBColor,
) -> Text<'static, (i32, i32), String> {
    let color = colour.to_backend_color();
    let style = TextStyle {
        color,
        pos,
        ..font(size)
    };
    Text::new(text.to_owned(), (px(at.0), px(at.1)), style)
}

/// Pixels of the figure in those that are drawn.
fn px(pixels: i32) -> i32 {
    SCALE * pixels
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::in_process;
    use crate::metrics::Recording;
    use crate::scenarios::Source;
    use spatial::TICK_S;

    fn run(law: &str) -> LabelledCurve {
        let overrides = [format!("controller.law={law}")];
        let scenario = Source::find("paper").unwrap().scenario(&overrides).unwrap();
        let mut recording = Recording::new(&scenario);
        let mut measured = ForceCurve::default();
        in_process::run(&scenario, |tick| {
            recording.push(&tick.sensor.truth);
            if let Some(outputs) = &tick.controller {
                measured.time_s.push(outputs.status.stamp.step as f64 * TICK_S);
                measured.force_n.push(outputs.status.detection.statistic_n);
            }
        });
        let contact_s = recording.first_contact_s().unwrap();
        measured.time_s.iter_mut().for_each(|time| *time -= contact_s);
        LabelledCurve {
            law: law.to_owned(),
            title: title(law),
            desired_force_n: scenario.task.desired_force_n,
            curve: recording.force_curve().unwrap(),
            measured,
            metrics: recording.metrics().unwrap(),
        }
    }

    #[test]
    fn both_laws_are_drawn() {
        let directory = std::env::temp_dir().join("figure-test");
        std::fs::create_dir_all(&directory).unwrap();
        force_figure(&[run("pd"), run("proposed")], &directory.join("force.svg")).unwrap();
    }
}
