//! The terminal: one picture of what is shown at an instant.

use super::lines::phase;
use super::points::{Point, Points, WINDOW_S};
use super::rows::{ControllerRow, NodeRow, Percentiles, Snapshot};
use ratatui::Frame;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::{Color, Style, Stylize};
use ratatui::symbols::Marker;
use ratatui::text::{Line, Span};
use ratatui::widgets::{Axis, Chart, Dataset, GraphType, Paragraph, Row, Table};

/// Rows that the plot needs.
const PLOT: u16 = 8;

/// Draws what is heard on `url`.
pub fn draw(frame: &mut Frame<'_>, url: &str, snapshot: &Snapshot, points: &Points) {
    let area = frame.area();
    let lines = match &snapshot.controller {
        Some(row) => experiment(row, snapshot),
        None => vec![Line::from("no controller is heard").dim()],
    };
    let nodes = snapshot.nodes.len() as u16 + 1;
    let text = lines.len() as u16;
    // What the terminal is too low for: the times first, since they change least.
    let timings = if area.height >= 1 + 2 * nodes + text + PLOT {
        nodes
    } else {
        0
    };
    let parts = Layout::vertical([1, nodes, timings, text].map(Constraint::Length)).split(area);
    let used = 1 + nodes + timings + text;
    let plot = Rect {
        y: area.y + used.min(area.height),
        height: area.height.saturating_sub(used),
        ..area
    };
    let title = Line::from(vec![
        "touchdown watch".bold(),
        Span::raw(format!("  {url}  ")),
        "q: quit".dim(),
    ]);
    frame.render_widget(Paragraph::new(title), parts[0]);
    frame.render_widget(table_of_nodes(&snapshot.nodes), parts[1]);
    frame.render_widget(table_of_times(&snapshot.nodes), parts[2]);
    frame.render_widget(Paragraph::new(lines), parts[3]);
    if plot.height >= 4 {
        draw_plot(frame, plot, points);
    }
}

fn header(names: &[&'static str]) -> Row<'static> {
    Row::new(names.to_vec()).style(Style::new().bold().underlined())
}

fn table_of_nodes(nodes: &[NodeRow]) -> Table<'static> {
    let rows = nodes.iter().map(|row| {
        let (state, style) = match (&row.fault, row.silent) {
            (Some(fault), _) => (
                format!("{}: {fault}", row.state),
                Style::new().fg(Color::Red).bold(),
            ),
            (None, true) if row.age_s.is_some() => {
                ("silent".to_owned(), Style::new().fg(Color::Yellow).bold())
            }
            (None, true) => (row.state.clone(), Style::new().dim()),
            (None, false) => (row.state.clone() + &lacks(row), Style::new()),
        };
        let age = match row.age_s {
            Some(age_s) if age_s >= 1.0 => format!("{age_s:.1} s"),
            Some(age_s) => format!("{:.0} ms", age_s * 1e3),
            None => "-".to_owned(),
        };
        Row::new(vec![
            row.node.to_owned(),
            row.host.clone(),
            state,
            age,
            format!("{:.0}", row.rate_hz),
            format!("{:.1}", row.loss_ratio * 1e2),
            lost(row).to_string(),
            row.refused.to_string(),
            row.missed.to_string(),
        ])
        .style(style)
    });
    let mut widths = [10, 8, 0, 6, 5, 6, 5, 5, 6].map(Constraint::Length);
    widths[2] = Constraint::Fill(1);
    Table::new(rows, widths).header(header(&[
        "node", "host", "state", "age", "Hz", "loss %", "lost", "bad", "missed",
    ]))
}

/// What a node in real time should have.
fn lacks(row: &NodeRow) -> String {
    let lacking = [(row.authenticated, "key"), (row.realtime_rights, "rt rights")];
    let lacking = lacking.iter().filter(|(there, _)| !there && !row.lockstep);
    lacking.map(|(_, what)| format!(", no {what}")).collect()
}

/// Messages that were meant for a node and have not reached it.
fn lost(row: &NodeRow) -> i64 {
    let dropped = row.dropped.saturating_add(row.kernel_dropped.unwrap_or(0));
    row.lost.saturating_add(dropped)
}

/// Median, 99th percentile and maximum, us.
fn microseconds(times: &Percentiles) -> String {
    if times.max == 0.0 {
        return "-".to_owned();
    }
    let us = |seconds: f64| seconds * 1e6;
    format!("{:.0} {:.0} {:.0}", us(times.p50), us(times.p99), us(times.max))
}

fn table_of_times(nodes: &[NodeRow]) -> Table<'static> {
    let rows = nodes.iter().map(|row| {
        let times = [
            &row.answer_s,
            &row.lateness_s,
            &row.round_trip_s,
            &row.age_at_use_s,
        ];
        Row::new(std::iter::once(row.node.to_owned()).chain(times.map(microseconds)))
    });
    let widths = [10, 17, 17, 17, 17].map(Constraint::Length);
    Table::new(rows, widths).header(header(&[
        "us",
        "answer 50 99 max",
        "lateness",
        "round trip",
        "age at use",
    ]))
}

fn millimetres(position_m: &[f64; 3]) -> String {
    let [x, y, z] = position_m.map(|metres| metres * 1e3);
    format!("{x:.3} {y:.3} {z:.3} mm")
}

/// A name and what it stands for.
fn line(name: &'static str, text: String) -> Line<'static> {
    Line::from(vec![format!("{name:10}").dim(), Span::raw(text)])
}

fn experiment(row: &ControllerRow, snapshot: &Snapshot) -> Vec<Line<'static>> {
    let mut state = format!("{:.3} s  {}, law {}", row.time_s, phase(row), row.law);
    if row.silent {
        state += &format!("; silent for {:.1} s", row.age_s);
    }
    if !row.limits.is_empty() {
        state += &format!("; limits: {}", row.limits.join(", "));
    }
    if let Some(answer) = &row.answer {
        state += &format!("; last answer: {answer}");
    }
    let style = match (&row.fault, row.silent) {
        (Some(_), _) => Style::new().fg(Color::Red).bold(),
        (None, true) => Style::new().fg(Color::Yellow).bold(),
        (None, false) => Style::new().bold(),
    };
    let [x, y, _] = row.force_n;
    let [mx, my, mz] = row.moment_nm;
    let object = match &row.object_position_m {
        Some(position) => format!(
            "{}, {:.2} mm/s up",
            millimetres(position),
            row.object_velocity_m_per_s[2] * 1e3
        ),
        None => "unknown".to_owned(),
    };
    let (detection, impact) = (&row.detection, &row.impact);
    let contact = match detection.contact_time_s {
        Some(time_s) => format!(", contact at {time_s:.3} s"),
        None => String::new(),
    };
    let allowed = match impact.speed_limit_m_per_s {
        Some(limit) => format!(" of {:.1} mm/s allowed", limit * 1e3),
        None => " mm/s, any force allowed".to_owned(),
    };
    let mut lines = vec![
        Line::from(vec![format!("{:10}", "phase").dim(), Span::styled(state, style)]),
        line(
            "force",
            format!(
                "{:.2} N of {:.2} N (error {:+.2} N), sideways {x:.2} {y:.2} N, moment {mx:.3} {my:.3} {mz:.3} Nm",
                row.normal_force_n, row.desired_force_n[2], row.force_error_n
            ),
        ),
        line("tcp", millimetres(&row.tcp_position_m)),
        line("object", object),
        line(
            "detection",
            format!(
                "{:.2} N, threshold {:.2} N{contact}",
                detection.statistic_n, detection.threshold_n
            ),
        ),
        line(
            "impact",
            format!(
                "{:.1} N peak at {:.1}{allowed}, {:.2} kg, {:.1} um deep, {:.2} ms",
                impact.peak_force_n,
                impact.speed_m_per_s * 1e3,
                impact.effective_mass_kg,
                impact.maximum_depth_m * 1e6,
                impact.characteristic_time_s * 1e3
            ),
        ),
    ];
    if let (Some(gain), Some(phase_rad)) = (row.gain_margin, row.phase_margin_rad) {
        lines.push(line(
            "margins",
            format!(
                "gain {gain:.1}, phase {:.0} deg, oscillation {:.2} N",
                phase_rad.to_degrees(),
                row.oscillation_n
            ),
        ));
    }
    lines.push(line("devices", devices(snapshot)));
    if let Some(clocks) = clocks(snapshot) {
        lines.push(line("clocks", clocks));
    }
    lines
}

fn devices(snapshot: &Snapshot) -> String {
    let mut told = Vec::new();
    if let Some(robot) = &snapshot.robot {
        let fault = robot
            .fault
            .as_ref()
            .map_or(String::new(), |fault| format!(": {fault}"));
        told.push(format!(
            "robot {}{fault}, {} commands missed",
            robot.mode, robot.missed_commands
        ));
    }
    if let Some(sensor) = &snapshot.sensor {
        let saturated = if sensor.saturated { ", saturated" } else { "" };
        told.push(format!(
            "deflection {}, {} of 8 readings{saturated}",
            millimetres(&sensor.translation_m),
            sensor.valid
        ));
    }
    if let Some(object) = &snapshot.object {
        told.push(match object.visible {
            true => format!("seen at {}", millimetres(&object.position_m)),
            false => "object not seen".to_owned(),
        });
    }
    told.join("; ")
}

/// Clocks against the controller's, and plant time that was lost.
fn clocks(snapshot: &Snapshot) -> Option<String> {
    let clocks = snapshot.nodes.iter().flat_map(|row| &row.clocks);
    let mut told: Vec<String> = clocks
        .map(|clock| {
            format!(
                "{} {:+.6} s (+- {:.0} us)",
                clock.whose,
                clock.offset_s,
                clock.bound_s * 1e6
            )
        })
        .collect();
    let slips = snapshot.nodes.iter().filter(|row| row.slip_s > 0.0);
    told.extend(slips.map(|row| format!("{} has slipped {:.3} s", row.node, row.slip_s)));
    (!told.is_empty()).then(|| told.join(", "))
}

/// Least and greatest, with some room.
fn bounds(values: impl Iterator<Item = f64>) -> [f64; 2] {
    let start = [f64::INFINITY, f64::NEG_INFINITY];
    let [low, high] = values.fold(start, |[low, high], value| [low.min(value), high.max(value)]);
    if low > high {
        return [0.0, 1.0];
    }
    let room = 0.05 * (high - low) + 0.05;
    [low - room, high + room]
}

fn draw_plot(frame: &mut Frame<'_>, area: Rect, points: &Points) {
    let end = points.iter().last().map_or(WINDOW_S, |point| point.time_s);
    let start = end - WINDOW_S;
    let series = |value: fn(&Point) -> f64| {
        points
            .iter()
            .map(|point| (point.time_s, value(point)))
            .collect::<Vec<_>>()
    };
    let (force, desired) = (
        series(|point| point.force_n),
        series(|point| point.desired_force_n),
    );
    let [low, high] = bounds(force.iter().chain(&desired).map(|(_, value)| *value));
    let dataset = |name: &'static str, data, colour| {
        Dataset::default()
            .name(name)
            .marker(Marker::Braille)
            .graph_type(GraphType::Line)
            .style(Style::new().fg(colour))
            .data(data)
    };
    let label = |value: f64, unit: &str| format!("{value:.1}{unit}");
    let chart = Chart::new(vec![
        dataset("desired", &desired, Color::Yellow),
        dataset("force", &force, Color::Cyan),
    ])
    .x_axis(Axis::default().bounds([start, end]).labels([
        label(start, ""),
        label(0.5 * (start + end), ""),
        label(end, " s"),
    ]))
    .y_axis(Axis::default().bounds([low, high]).labels([
        label(low, ""),
        label(0.5 * (low + high), ""),
        label(high, " N"),
    ]));
    frame.render_widget(chart, area);
}
