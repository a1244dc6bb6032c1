//! The figures of an analysis.

use super::Analysis;
use crate::figure::chart::{BLUE, Chart, GREEN, GREY, Line, RED};
use crate::transcript;
use lcmtypes::Message;
use nalgebra::{UnitQuaternion, Vector3};
use node::scenario::Scenario;
use plotters::style::RGBColor;
use spatial::ports::{ControllerStatus, Deflections, Truth};
use spatial::{TICK_S, rotation};
use std::ops::Range;

/// A figure, what it is called in a page and as a file.
pub struct Figure {
    /// File name without ending.
    pub name: &'static str,
    /// What it shows.
    pub title: &'static str,
    /// As SVG.
    pub svg: String,
}

/// What is shown around the first contact, ms.
const AROUND_MS: Range<f64> = -100.0..1500.0;
const IMPACT_MS: Range<f64> = -2.0..20.0;
const TIME: &str = "time after first contact, ms";
const BINS: usize = 60;

impl Analysis {
    /// All figures that the log has data for.
    pub fn figures(&self, scenario: &Scenario) -> Vec<Figure> {
        let charts = [
            ("force", "Contact force", self.force(scenario)),
            ("position", "Height of tool and object", self.position()),
            ("deflection", "Deflection of the sensor", self.deflection()),
            ("twist", "Rotation of the sensor", self.twist()),
            ("orientation", "Orientation of the tool", self.orientation()),
            ("impact", "Impact", self.peak()),
            (
                "timing",
                "From a state's sampling to the arrival of its command",
                self.latency(),
            ),
        ];
        let drawn = charts.into_iter().filter_map(|(name, title, chart)| {
            let svg = chart.draw()?.ok()?;
            Some(Figure { name, title, svg })
        });
        drawn.collect()
    }

    /// Time of the first contact, s; 0: there is none.
    fn contact_s(&self) -> f64 {
        let recording = self.recording.as_ref().map(|(recording, ..)| recording);
        recording
            .and_then(|recording| recording.first_contact_s())
            .unwrap_or(0.0)
    }

    /// What is shown: around the contact, or all where there is none.
    fn range_ms(&self) -> Range<f64> {
        let contact = self
            .recording
            .as_ref()
            .and_then(|(recording, ..)| recording.first_contact_s());
        match contact {
            Some(_) => AROUND_MS,
            None => {
                let last = transcript::messages::<ControllerStatus>(&self.said)
                    .map(|it| it.stamp.step)
                    .max();
                0.0..last.unwrap_or(1).max(1) as f64
            }
        }
    }

    /// A number of each message on a channel over the time after the contact, ms.
    fn over_time<M: Message>(&self, value: impl Fn(&M) -> f64) -> Vec<(f64, f64)> {
        let contact_s = self.contact_s();
        let messages = transcript::messages::<M>(&self.said);
        messages
            .map(|message| {
                (
                    1e3 * (message.stamp().step as f64 * TICK_S - contact_s),
                    value(&message),
                )
            })
            .collect()
    }

    fn chart(&self, unit: &'static str, lines: Vec<Line>) -> Chart {
        Chart {
            axes: [TIME, unit],
            range: self.range_ms(),
            lines,
            bars: Vec::new(),
        }
    }

    fn force(&self, scenario: &Scenario) -> Chart {
        let points = |curve: &crate::metrics::ForceCurve| -> Vec<_> {
            let times = curve.time_s.iter().map(|time_s| 1e3 * time_s);
            times.zip(curve.force_n.iter().copied()).collect()
        };
        let (mut truth, mut measured) = (Vec::new(), Vec::new());
        if let Some((recording, seen, _)) = &self.recording {
            measured = points(seen);
            truth = recording.force_curve().as_ref().map(points).unwrap_or_default();
        }
        let desired = self.over_time(|status: &ControllerStatus| status.desired_wrench.force.z);
        let name = match self.recording {
            Some((.., super::ForceFrom::Truth)) => "true force",
            _ => "measured force",
        };
        let mut lines = vec![solid("as the controller sees it", measured, GREY)];
        lines.push(solid(name, truth, BLUE));
        if scenario.task.pressing_force_n() > 0.0 {
            lines.push(dashed("desired", desired, RED));
        }
        self.chart("force, N", lines)
    }

    fn position(&self) -> Chart {
        let mm = |metres: f64| 1e3 * metres;
        let seen = self.over_time(|it: &ControllerStatus| mm(it.tcp_pose.translation.z));
        let object = self.over_time(|it: &ControllerStatus| match it.object_known {
            true => mm(it.object_pose.translation.z),
            false => f64::NAN,
        });
        self.chart(
            "height in r, mm",
            vec![
                solid(
                    "tool, true",
                    self.over_time(|it: &Truth| mm(it.tcp_pose.translation.z)),
                    BLUE,
                ),
                dashed("tool, as seen", seen, GREEN),
                solid(
                    "object, true",
                    self.over_time(|it: &Truth| mm(it.object_height_m)),
                    RED,
                ),
                dashed("object, as seen", object, GREY),
            ],
        )
    }

    fn axes(&self, names: [&'static str; 3], of: impl Fn(usize) -> Vec<(f64, f64)>) -> Vec<Line> {
        let [x, y, z] = names;
        vec![
            dashed(x, of(0), GREEN),
            dashed(y, of(1), RED),
            solid(z, of(2), BLUE),
        ]
    }

    fn deflection(&self) -> Chart {
        let of = |axis: usize| {
            self.over_time(|it: &Deflections| match it.samples[0].flags.valid {
                true => 1e6 * it.samples[0].deflection.translation[axis],
                false => f64::NAN,
            })
        };
        self.chart(
            "deflection in s, um",
            self.axes(["along x", "along y", "along z"], of),
        )
    }

    fn twist(&self) -> Chart {
        let of = |axis: usize| {
            self.over_time(|it: &Deflections| match it.samples[0].flags.valid {
                true => 1e3 * it.samples[0].deflection.rotation[axis],
                false => f64::NAN,
            })
        };
        self.chart(
            "rotation in s, mrad",
            self.axes(["about x", "about y", "about z"], of),
        )
    }

    fn orientation(&self) -> Chart {
        let contact_s = self.contact_s();
        let before = |step: i64| (step as f64 * TICK_S) < contact_s - 0.05;
        let truths: Vec<_> = transcript::messages::<Truth>(&self.said)
            .map(|it| (it.stamp.step, it.tcp_pose.rotation))
            .collect();
        let statuses = || transcript::messages::<ControllerStatus>(&self.said);
        let poses = match truths.is_empty() {
            false => truths,
            true => statuses()
                .map(|it| (it.stamp.step, it.tcp_pose.rotation))
                .collect(),
        };
        let rest = poses
            .iter()
            .rev()
            .find(|(step, _)| before(*step))
            .or(poses.first());
        let rest = rest.map_or_else(UnitQuaternion::identity, |(_, rotation)| *rotation);
        let turned: Vec<(f64, Vector3<f64>)> = poses
            .iter()
            .map(|(step, turned)| {
                let time_ms = 1e3 * (*step as f64 * TICK_S - contact_s);
                (time_ms, rotation::log(&(*turned * rest.inverse())))
            })
            .collect();
        let of = |axis: usize| {
            turned
                .iter()
                .map(|(time, turn)| (*time, 1e3 * turn[axis]))
                .collect()
        };
        self.chart(
            "turned since before, mrad",
            self.axes(["about x", "about y", "about z"], of),
        )
    }

    fn peak(&self) -> Chart {
        let seen = self.over_time(|it: &ControllerStatus| it.detection.statistic_n);
        Chart {
            range: IMPACT_MS,
            ..self.chart(
                "force, N",
                vec![
                    solid(
                        "largest true force of each ms",
                        self.over_time(|it: &Truth| it.contact_force_peak_n),
                        BLUE,
                    ),
                    dashed("as the sensor shows it", seen, RED),
                ],
            )
        }
    }

    /// How often answers took how long.
    fn latency(&self) -> Chart {
        let most_ms = self.timing.percentiles_s().map_or(0.0, |[.., max]| 1e3 * max);
        let width = most_ms / BINS as f64;
        let mut bars: Vec<_> = (0..BINS)
            .map(|i| [width * i as f64, width * (i + 1) as f64, 0.0])
            .collect();
        for answer_s in &self.timing.answers_s {
            let bin = (1e3 * answer_s / width).max(0.0) as usize;
            bars[bin.min(BINS - 1)][2] += 1.0;
        }
        if width <= 0.0 {
            bars.clear();
        }
        Chart {
            axes: ["time, ms", "commands"],
            range: 0.0..most_ms,
            lines: Vec::new(),
            bars,
        }
    }
}

fn solid(name: &'static str, points: Vec<(f64, f64)>, colour: RGBColor) -> Line {
    Line {
        name,
        points,
        colour,
        dashed: false,
    }
}

fn dashed(name: &'static str, points: Vec<(f64, f64)>, colour: RGBColor) -> Line {
    Line {
        dashed: true,
        ..solid(name, points, colour)
    }
}
