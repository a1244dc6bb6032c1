//! Force and depth over time, and the peak over the speed, as one SVG.

use super::report::Report;
use super::text::digits;
use crate::figure::FigureError;
use crate::figure::style::{Area, Drawn, FAINT, INK, LARGE, SMALL, font, label, line, px, svg};
use controller::impact::{Striker, numerical};
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use std::path::Path;

/// Sizes of a row of panels, px.
const WIDTH: i32 = 960;
const HEIGHT: i32 = 300;
const TITLE_HEIGHT: i32 = 34;
const LEFT: i32 = 74;
const RIGHT: i32 = 18;
const AXIS_HEIGHT: i32 = 44;

/// Colours of Okabe and Ito: what is predicted, what is simulated, what is allowed.
const PREDICTED: RGBColor = RGBColor(0, 114, 178);
const SIMULATED: RGBColor = RGBColor(213, 94, 0);
const ALLOWED: RGBColor = RGBColor(0, 158, 115);

/// A panel: what is on its axes, in units for people.
struct Panel<'a> {
    x: &'a str,
    y: &'a str,
    points: Vec<(f64, f64)>,
    /// What is allowed, as a horizontal line.
    allowed: Option<f64>,
    /// What control lets pass, as a horizontal line.
    controlled: Option<f64>,
    /// The speed asked for, and what comes of it.
    asked: Option<(f64, f64)>,
    /// What was simulated.
    simulated: Option<(f64, f64)>,
    /// A sampling time, as a vertical line.
    sample: Option<f64>,
}

/// Draw a row of three panels for each of `reports` into the SVG file `path`.
pub fn draw(reports: &[Report], path: &Path) -> Result<(), FigureError> {
    let drawn = svg(WIDTH, HEIGHT * reports.len().max(1) as i32, |root| {
        let rows = root.split_evenly((reports.len().max(1), 1));
        reports
            .iter()
            .zip(&rows)
            .try_for_each(|(report, row)| draw_row(row, report))
    });
    let svg = drawn.map_err(|error| FigureError::Draw(error.to_string()))?;
    std::fs::write(path, svg).map_err(|source| FigureError::Write {
        path: path.to_owned(),
        source,
    })
}

fn draw_row(row: &Area<'_>, report: &Report) -> Drawn {
    let left = Pos::new(HPos::Left, VPos::Top);
    row.draw(&label(&title(report), (14, 8), LARGE, left, INK))?;
    let (_, below) = row.split_vertically(px(TITLE_HEIGHT));
    let areas = below.split_evenly((1, 3));
    panels(report)
        .iter()
        .zip(&areas)
        .try_for_each(|(panel, area)| draw_panel(area, panel))
}

fn title(report: &Report) -> String {
    format!(
        "{}: {} kg at {} mm/s, peak {} N after {} ms",
        report.name,
        digits(report.effective_mass_kg),
        digits(1e3 * report.speed_m_per_s),
        digits(report.peak_force_n),
        digits(1e3 * report.indentation_time_s)
    )
}

fn panels(report: &Report) -> Vec<Panel<'static>> {
    let Ok(striker) = Striker::new(report.effective_mass_kg, report.speed_m_per_s) else {
        return Vec::new();
    };
    let surface = &report.surface;
    let way = numerical::impact(surface, &striker);
    // Far more points than pixels, most of them at the very beginning and end.
    let apart = report.characteristic_time_s / 400.0;
    let mut shown: Vec<numerical::Point> = Vec::new();
    for point in &way {
        if shown
            .last()
            .is_none_or(|last| point.time_s - last.time_s >= apart)
        {
            shown.push(*point);
        }
    }
    shown.extend(way.last());
    let over_time = |of: &dyn Fn(&numerical::Point) -> f64| {
        shown
            .iter()
            .map(|point| (1e3 * point.time_s, of(point)))
            .collect::<Vec<_>>()
    };
    let force = |point: &numerical::Point| {
        if point.time_s <= report.indentation_time_s {
            surface.law.force_n(point.depth_m)
        } else {
            report.rebound_ratio * surface.law.force_n(point.depth_m - report.remaining_depth_m)
        }
    };
    let allowed = [
        report.speed_for_allowed_force_m_per_s,
        report.speed_for_allowed_remaining_depth_m_per_s,
    ];
    let fastest = allowed.into_iter().flatten().fold(report.speed_m_per_s, f64::max) * 1.4;
    let peaks = (1..=100).filter_map(|i| {
        let speed = fastest * f64::from(i) / 100.0;
        let striker = Striker::new(report.effective_mass_kg, speed).ok()?;
        Some((1e3 * speed, surface.struck_by(&striker).peak_force_n))
    });
    let sample_ms = 1e3 * report.sampling_time_s;
    let end_ms = 1e3 * report.characteristic_time_s;
    let blank = Panel {
        x: "time, ms",
        y: "",
        points: Vec::new(),
        allowed: None,
        controlled: None,
        asked: None,
        simulated: None,
        // Far off, it would press the impact against the axis.
        sample: (sample_ms < 4.0 * end_ms).then_some(sample_ms),
    };
    vec![
        Panel {
            y: "force, N",
            points: over_time(&force),
            allowed: report.allowed_force_n,
            controlled: report.controlled_peak_n,
            ..blank
        },
        Panel {
            y: "indentation, \u{b5}m",
            points: over_time(&|point| 1e6 * point.depth_m),
            allowed: report.allowed_remaining_depth_m.map(|depth| 1e6 * depth),
            ..blank
        },
        Panel {
            x: "speed, mm/s",
            y: "peak force, N",
            points: std::iter::once((0.0, 0.0)).chain(peaks).collect(),
            allowed: report.allowed_force_n,
            controlled: report.controlled_peak_n,
            asked: Some((1e3 * report.speed_m_per_s, report.peak_force_n)),
            simulated: report
                .simulated
                .map(|simulated| (1e3 * simulated.contact_speed_m_per_s, simulated.peak_force_n)),
            sample: None,
        },
    ]
}

fn draw_panel(area: &Area<'_>, panel: &Panel<'_>) -> Drawn {
    let most = |of: fn(&(f64, f64)) -> f64, more: [Option<f64>; 3]| {
        let points = panel.points.iter().map(of);
        points.chain(more.into_iter().flatten()).fold(0.0, f64::max)
    };
    let right = most(|point| point.0, [panel.sample, None, None]);
    let top = most(
        |point| point.1,
        [
            panel.allowed,
            panel.controlled,
            panel.simulated.map(|point| point.1),
        ],
    );
    // Room for the names of horizontal lines.
    let (right, top) = (1.3 * right, 1.12 * top);
    let mut chart = ChartBuilder::on(area)
        .margin_top(px(6))
        .margin_right(px(RIGHT))
        .margin_left(px(8))
        .y_label_area_size(px(LEFT))
        .x_label_area_size(px(AXIS_HEIGHT))
        .build_cartesian_2d(0.0..right, 0.0..top)?;
    let text = font(SMALL).color(&INK);
    chart
        .configure_mesh()
        .disable_mesh()
        .axis_style(INK.stroke_width(px(1) as u32))
        .label_style(text.clone())
        .axis_desc_style(text)
        .set_all_tick_mark_size(px(4))
        .x_labels(5)
        .y_labels(6)
        .x_label_formatter(&|value| short(*value))
        .y_label_formatter(&|value| short(*value))
        .x_desc(panel.x)
        .y_desc(panel.y)
        .draw()?;
    let over = Pos::new(HPos::Right, VPos::Bottom);
    let note =
        |chart: &mut crate::figure::style::Chart<'_, '_>, y: f64, colour: RGBColor, text: &str| -> Drawn {
            chart.draw_series(DashedLineSeries::new(
                [(0.0, y), (right, y)],
                px(6),
                px(4),
                colour.stroke_width(px(1) as u32),
            ))?;
            let style = font(SMALL).color(&colour).pos(over);
            chart.draw_series([Text::new(text.to_owned(), (right, y), style)])?;
            Ok(())
        };
    if let Some(allowed) = panel.allowed {
        note(&mut chart, allowed, ALLOWED, "allowed")?;
    }
    if let Some(controlled) = panel.controlled {
        note(&mut chart, controlled, INK, "controlled peak")?;
    }
    if let Some(sample) = panel.sample {
        chart.draw_series([line([(sample, 0.0), (sample, top)], FAINT, 1)])?;
        let style = font(SMALL).color(&INK).pos(Pos::new(HPos::Right, VPos::Top));
        chart.draw_series([Text::new(
            "one sampling time".to_owned(),
            (sample - 0.01 * right, 0.97 * top),
            style,
        )])?;
    }
    chart.draw_series([line(panel.points.iter().copied(), PREDICTED, 2)])?;
    if let Some(asked) = panel.asked {
        chart.draw_series([Circle::new(asked, px(4), PREDICTED.filled())])?;
    }
    if let Some(simulated) = panel.simulated {
        chart.draw_series([Circle::new(
            simulated,
            px(6),
            SIMULATED.stroke_width(px(2) as u32),
        )])?;
        let style = font(SMALL).color(&SIMULATED).pos(Pos::new(HPos::Left, VPos::Top));
        chart.draw_series([Text::new(
            "simulated".to_owned(),
            (simulated.0 + 0.04 * right, simulated.1),
            style,
        )])?;
    }
    Ok(())
}

/// As few digits as an axis needs.
fn short(value: f64) -> String {
    let rounded: f64 = format!("{value:.3e}").parse().unwrap_or(value);
    rounded.to_string()
}

#[cfg(test)]
mod tests;
