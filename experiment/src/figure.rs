//! The force of several laws over time as one SVG: the counterpart of the paper's Figs. 7 and 8.

pub(crate) mod chart;
mod panel;
pub(crate) mod style;

use crate::metrics::{ForceCurve, Metrics, NoFigures, Recording};
use node::scenario::Scenario;
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

impl LabelledCurve {
    /// The curve of a recorded run with `law`, and what the controller `measured`, if the run has figures.
    pub fn new(
        law: &str,
        scenario: &Scenario,
        recording: &Recording,
        measured: ForceCurve,
    ) -> Result<Self, NoFigures> {
        let metrics = recording.metrics()?;
        Ok(Self {
            law: law.to_owned(),
            title: title(law),
            desired_force_n: scenario.task.pressing_force_n(),
            curve: recording.force_curve().unwrap_or_default(),
            measured,
            metrics,
        })
    }
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

/// Draw one panel for each of `curves`, one above the other, into the SVG file `path`.
pub fn force_figure(curves: &[LabelledCurve], path: &Path) -> Result<(), FigureError> {
    let svg = draw(curves)?;
    std::fs::write(path, svg).map_err(|source| FigureError::Write {
        path: path.to_owned(),
        source,
    })
}

/// A figure of its own for each of `curves`, `width` px wide, all of them with the same forces, as SVG. What the lines mean
/// is left to whoever shows them.
pub(crate) fn force_panels(curves: &[LabelledCurve], width: i32) -> Result<Vec<String>, FigureError> {
    let force_n = force_range(curves).ok_or(FigureError::Empty)?;
    let single = |(i, curve)| panel::single(curve, i, &force_n, width);
    let panels: Result<_, _> = curves.iter().enumerate().map(single).collect();
    panels.map_err(|error| FigureError::Draw(error.to_string()))
}

fn draw(curves: &[LabelledCurve]) -> Result<String, FigureError> {
    let force_n = force_range(curves).ok_or(FigureError::Empty)?;
    panel::draw(curves, &force_n).map_err(|error| FigureError::Draw(error.to_string()))
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::in_process;
    use crate::scenarios::Source;
    use plotters::style::Color;
    use spatial::TICK_S;

    fn run(law: &str) -> LabelledCurve {
        let overrides = [format!("controller.law={law}")];
        let scenario = Source::find("paper").unwrap().scenario(&overrides).unwrap();
        let mut recording = Recording::new(&scenario);
        let mut measured = ForceCurve::default();
        in_process::run(&scenario, |tick| {
            recording.observe(tick);
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
            desired_force_n: scenario.task.pressing_force_n(),
            curve: recording.force_curve().unwrap(),
            measured,
            metrics: recording.metrics().unwrap(),
        }
    }

    #[test]
    fn both_laws_are_drawn_with_their_figures() {
        let curves = [run("pd"), run("proposed")];
        let svg = draw(&curves).unwrap();
        for (i, curve) in curves.iter().enumerate() {
            let (r, g, b) = panel::colour(&curve.law, i).rgb();
            let stroke = format!("stroke=\"#{r:02X}{g:02X}{b:02X}\"");
            let longest = svg
                .lines()
                .filter(|line| line.contains(&stroke))
                .map(str::len)
                .max();
            assert!(
                longest.is_some_and(|length| length > 1000),
                "{}: {longest:?}",
                curve.law
            );
            assert!(svg.contains(&format!("\npeak {:.1} N\n", curve.metrics.peak_n)));
            assert!(svg.contains(&curve.title));
        }
        // Every coordinate is finite and inside the figure.
        let size = 8 * 800;
        for line in svg.lines().filter(|line| line.starts_with("<polyline")) {
            let points = line.split("points=\"").nth(1).unwrap().split('"').next().unwrap();
            for coordinate in points.split([' ', ',']).filter(|text| !text.is_empty()) {
                assert!((0..=size).contains(&coordinate.parse().unwrap()), "{line}");
            }
        }
        assert!(svg.starts_with("<svg width=\"800\" height=\"552\" viewBox=\"0 0 6400 4416\""));
        assert!(
            svg.trim_end().ends_with("</svg>") && !svg.contains("NaN"),
            "{svg}"
        );
    }

    #[test]
    fn nothing_to_draw_and_nowhere_to_write_are_errors() {
        let path = Path::new("no such directory/force.svg");
        assert!(matches!(force_figure(&[], path), Err(FigureError::Empty)));
        let mut curve = LabelledCurve {
            law: "pd".to_owned(),
            title: title("pd"),
            desired_force_n: 10.0,
            curve: ForceCurve::default(),
            measured: ForceCurve::default(),
            metrics: Metrics::default(),
        };
        assert!(matches!(
            force_figure(&[curve.clone()], path),
            Err(FigureError::Empty)
        ));
        curve.curve = ForceCurve {
            time_s: vec![0.0, 0.1, 0.2],
            force_n: vec![0.0, f64::NAN, 10.0],
        };
        let error = force_figure(&[curve], path).unwrap_err().to_string();
        assert!(
            error.starts_with("the figure no such directory/force.svg can't be written"),
            "{error}"
        );
    }
}
