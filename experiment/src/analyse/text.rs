//! An analysis as people and programs read it.

use super::{Analysis, Channel, Impact};
use crate::scenarios::word;
use crate::table::{Align, Column, MoreFigures, Row, Table, print_columns};
use node::scenario::Scenario;
use serde_json::{Value, json};
use spatial::ports::ImpactAssessment;
use std::fmt::{self, Display, Formatter, Write};

/// As people read it.
pub(super) struct Text<'a>(pub(super) &'a Analysis, pub(super) &'a Scenario);

impl Analysis {
    /// Tables for people; the analysis is of a log of `scenario`.
    pub fn text<'a>(&'a self, scenario: &'a Scenario) -> impl Display + 'a {
        Text(self, scenario)
    }

    /// The row of a table with the figures, if there are any.
    pub fn row(&self, scenario: &Scenario) -> Option<Row> {
        let metrics = self.metrics()?.ok()?;
        let (gears, kinematics) = (word(scenario.robot.gears), word(scenario.robot.kinematics));
        let law = crate::tuning::law_word(scenario.controller.law);
        Some(Row::single(&gears, &kinematics, law, metrics))
    }

    /// One object for programs.
    pub fn json(&self) -> Value {
        let (metrics, reason) = match self.metrics() {
            Some(Ok(metrics)) => (Some(metrics), None),
            Some(Err(reason)) => (None, Some(reason.to_string())),
            None => (None, Some(NO_FORCE.to_owned())),
        };
        json!({
            "force_from": self.recording.as_ref().map(|(_, _, from)| from),
            "metrics": metrics,
            "no_metrics": reason,
            "impact": impact_json(&self.impact),
            "channels": self.channels,
            "clocks": self.clocks,
            "answer_s": self.timing.percentiles_s(),
            "missed_commands": self.timing.missed_commands,
            "nodes": self.timing.nodes,
        })
    }
}

/// Why there are no figures.
pub(super) const NO_FORCE: &str =
    "the log tells of no force: it has neither SIM_TRUTH nor CONTROLLER_STATUS nor SENSOR_DEFLECTION";

fn impact_json(impact: &Impact) -> Value {
    let assessed = |it: Option<ImpactAssessment>| {
        it.map(|it| {
            json!({
                "speed_m_per_s": it.speed_m_per_s,
                "effective_mass_kg": it.effective_mass_kg,
                "peak_force_n": it.peak_force_n,
                "maximum_depth_m": it.maximum_depth_m,
            })
        })
    };
    let truth = impact.truth.map(|[speed, peak, depth]| {
        json!({ "speed_m_per_s": speed, "peak_force_n": peak, "maximum_depth_m": depth })
    });
    json!({ "foreseen": assessed(impact.foreseen), "measured": assessed(impact.measured), "truth": truth })
}

impl Display for Text<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let Self(analysis, scenario) = self;
        match (analysis.metrics(), analysis.row(scenario)) {
            (Some(Ok(_)), Some(row)) => {
                write!(f, "{}", Table(std::slice::from_ref(&row)))?;
                write!(f, "{}", MoreFigures(&[row]))?;
            }
            (Some(Err(reason)), _) => writeln!(f, "no figures: {reason}")?,
            _ => writeln!(f, "no figures: {NO_FORCE}")?,
        }
        if let Some((_, _, from)) = &analysis.recording {
            writeln!(f, "force: {}\n", super::source(*from))?;
        }
        channels(f, &analysis.channels)?;
        for channel in analysis.channels.iter().filter(|channel| channel.missing > 0) {
            writeln!(f, "{}", gaps(channel))?;
        }
        for clock in &analysis.clocks {
            let bound = clock.bound_s.map_or_else(
                || "unknown bound".to_owned(),
                |bound| format!("within {:.3} ms", 1e3 * bound),
            );
            writeln!(
                f,
                "clock of {}: {:.3} ms ahead of the controller's ({bound}), told by the {}",
                clock.device,
                1e3 * clock.ahead_s,
                clock.told_by
            )?;
        }
        if let Some([p50, p99, p999, max]) = analysis.timing.percentiles_s() {
            writeln!(
                f,
                "from a state's sampling to the arrival of its command: median {:.3} ms, 99 % {:.3}, 99.9 % {:.3}, at most \
                 {:.3}",
                1e3 * p50,
                1e3 * p99,
                1e3 * p999,
                1e3 * max
            )?;
        }
        match analysis.timing.missed_commands {
            Some(missed) => writeln!(f, "cycles without a new command: {missed}"),
            None => Ok(()),
        }
    }
}

/// Where messages are missing.
pub(super) fn gaps(channel: &Channel) -> String {
    const SHOWN: usize = 5;
    let mut text = format!(
        "{}: {} messages missing in {} gaps, after step",
        channel.channel,
        channel.missing,
        channel.gaps.len()
    );
    for gap in channel.gaps.iter().take(SHOWN) {
        // Writing to a text does not fail.
        let _ = write!(text, " {} ({})", gap.after_step, gap.missing);
    }
    if channel.gaps.len() > SHOWN {
        text += " ...";
    }
    text
}

fn channels(f: &mut Formatter<'_>, channels: &[Channel]) -> fmt::Result {
    let text = |header, cell: fn(&Channel) -> String, align| {
        Column::new(header, channels.iter().map(cell).collect(), align)
    };
    let columns = [
        text("channel", |it| it.channel.clone(), Align::Left),
        text("messages", |it| it.messages.to_string(), Align::Right),
        text("repeated", |it| it.repeated.to_string(), Align::Right),
        text("senders", |it| it.senders.to_string(), Align::Right),
        text(
            "steps",
            |it| {
                it.steps
                    .map_or("-".to_owned(), |[first, last]| format!("{first} to {last}"))
            },
            Align::Right,
        ),
        text("every", |it| it.period_steps.to_string(), Align::Right),
        text("missing", |it| it.missing.to_string(), Align::Right),
    ];
    print_columns(f, &columns, channels.len())
}
