//! The panels of the figure, drawn with plotters.

use super::style::{Area, Chart, Drawn, FAINT, INK, LARGE, SMALL, font, label, line, px, svg};
use super::{BAND, LabelledCurve, TIME_S, points};
use crate::metrics::Metrics;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use std::ops::Range;

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

const MEASURED: RGBColor = RGBColor(150, 150, 150);
const SHADE: RGBColor = RGBColor(232, 232, 232);

/// One panel for each of `curves`, one above the other, all of them with the forces of `force_n`: the SVG.
pub(super) fn draw(curves: &[LabelledCurve], force_n: &Range<f64>) -> Drawn<String> {
    let height = LEGEND_HEIGHT + PANEL_HEIGHT * curves.len() as i32 + AXIS_HEIGHT;
    svg(WIDTH, height, |root| draw_all(root, curves, force_n))
}

/// The panel of `curve`, the `index`th of several, alone, without a legend.
pub(super) fn single(curve: &LabelledCurve, index: usize, force_n: &Range<f64>, width: i32) -> Drawn<String> {
    svg(width, PANEL_HEIGHT + AXIS_HEIGHT, |root| {
        draw_panel(root, curve, colour(&curve.law, index), force_n, (width, true))
    })
}

fn draw_all(root: &Area<'_>, curves: &[LabelledCurve], force_n: &Range<f64>) -> Drawn {
    let (legend, mut rest) = root.split_vertically(px(LEGEND_HEIGHT));
    draw_legend(&legend)?;
    for (i, curve) in curves.iter().enumerate() {
        let last = i + 1 == curves.len();
        let height = PANEL_HEIGHT + if last { AXIS_HEIGHT } else { 0 };
        let (panel, below) = rest.split_vertically(px(height));
        draw_panel(&panel, curve, colour(&curve.law, i), force_n, (WIDTH, last))?;
        rest = below;
    }
    Ok(())
}

fn draw_panel(
    panel: &Area<'_>,
    curve: &LabelledCurve,
    colour: RGBColor,
    force_n: &Range<f64>,
    (width, last): (i32, bool),
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
    let dashes = DashedLineSeries::new(reference, px(6), px(4), INK.stroke_width(px(1) as u32));
    chart.draw_series(dashes)?;
    chart.draw_series([line(points(&curve.measured), MEASURED, 1)])?;
    chart.draw_series(points(&curve.measured).map(|point| Circle::new(point, px(2), MEASURED.filled())))?;
    chart.draw_series([line(points(&curve.curve), colour, 2)])?;
    draw_axes(&mut chart, last)?;
    // Where the force ends, there is no room for words.
    let above = desired - force_n.start < 0.6 * (force_n.end - force_n.start);
    draw_figures(panel, &curve.metrics, width, above)
}

fn draw_axes(chart: &mut Chart<'_, '_>, last: bool) -> Drawn {
    let text = font(SMALL).color(&INK);
    let mut mesh = chart.configure_mesh();
    mesh.disable_mesh()
        .axis_style(INK.stroke_width(px(1) as u32))
        .label_style(text.clone())
        .axis_desc_style(text)
        .set_all_tick_mark_size(px(4))
        .x_labels(10)
        .y_labels(8)
        .x_label_formatter(&|time| whole(time * 1e3))
        .y_label_formatter(&|force| whole(*force))
        .y_desc("contact force, N");
    if last {
        mesh.x_desc("time after first contact, ms");
    }
    Ok(mesh.draw()?)
}

/// The figures of the run on the panel's right, `above` the force where it ends or below.
fn draw_figures(panel: &Area<'_>, metrics: &Metrics, width: i32, above: bool) -> Drawn {
    let lines = [
        format!("peak {:.1} N", metrics.peak_n),
        settled(10, metrics.settling_10_s),
        settled(2, metrics.settling_2_s),
        format!("IAE {:.3} N s", metrics.iae_n_s),
    ];
    let right = Pos::new(HPos::Right, VPos::Top);
    let top = if above {
        TITLE_HEIGHT + 8
    } else {
        PANEL_HEIGHT - BOTTOM - 8 - 4 * 19
    };
    for (i, text) in lines.iter().enumerate() {
        let at = (width - RIGHT - 10, top + 19 * i as i32);
        panel.draw(&label(text, at, SMALL, right, INK))?;
    }
    Ok(())
}

fn settled(percent: u32, after_s: f64) -> String {
    if after_s.is_nan() {
        return format!("never settled within \u{b1}{percent} %");
    }
    format!("within \u{b1}{percent} % after {:.0} ms", after_s * 1e3)
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
        let at = |dx, dy| (px(x + dx), px(middle + dy));
        match i {
            0 => area.draw(&line([at(0, 0), at(28, 0)], INK, 2))?,
            1 => {
                area.draw(&line([at(0, 0), at(28, 0)], MEASURED, 1))?;
                area.draw(&Circle::new(at(14, 0), px(2), MEASURED.filled()))?;
            }
            2 => {
                for dash in [0, 10, 20] {
                    area.draw(&line([at(dash, 0), at(dash + 6, 0)], INK, 1))?;
                }
            }
            _ => area.draw(&Rectangle::new([at(0, -6), at(28, 6)], SHADE.filled()))?,
        }
        area.draw(&label(text, (x + 35, middle), SMALL, left, INK))?;
    }
    Ok(())
}

/// Colours of Okabe and Ito, which people with colour-blindness tell apart.
pub(super) fn colour(law: &str, index: usize) -> RGBColor {
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

/// With the sign that printers use.
fn whole(value: f64) -> String {
    format!("{value:.0}").replace('-', "\u{2212}")
}
