//! One scenario of a report: laws side by side, and their force over time.

use super::origin::quoted;
use super::{Options, Origin, ReportError};
use crate::compare::{Comparison, Matrix};
use crate::figure::{LabelledCurve, force_panels};
use crate::metrics::Recording;
use crate::scenarios::{Source, word};
use crate::transcript;
use crate::tuning::{Gains, Tuned, law_word, parameters};
use node::scenario::Scenario;
use rayon::prelude::*;
use std::fmt::Write;

/// Scenarios in which all laws take part, with default and with tuned gains: one plant each.
const SHOOT_OUTS: [&str; 2] = ["paper", "elastic_arm"];
const ALL_LAWS: [&str; 7] = [
    "proposed",
    "impedance",
    "literal",
    "pd-reset",
    "pd",
    "ros2",
    "fzi",
];
/// Width of a panel, px: readable on a phone, and two of them side by side on a desk.
const PANEL_WIDTH: i32 = 480;

/// One scenario.
#[derive(Clone, Debug)]
pub struct Section {
    /// Name or path.
    pub scenario: String,
    /// What the scenario says of itself.
    pub about: String,
    /// The law that the scenario is made for.
    pub law: String,
    /// Whether all laws take part, with all gains.
    pub shoot_out: bool,
    /// The laws side by side.
    pub comparison: Comparison,
    /// Where these figures come from.
    pub origin: Origin,
    /// The force of each law over time.
    pub panels: Vec<Panel>,
}

/// The force of one law over time.
#[derive(Clone, Debug)]
pub struct Panel {
    /// The law.
    pub law: String,
    /// With which gains.
    pub gains: Gains,
    /// The figure, or why there is none.
    pub svg: Result<String, String>,
    /// Where it comes from.
    pub origin: Origin,
}

/// What a section will run.
pub(super) struct Planned {
    name: String,
    source: Source,
    scenario: Scenario,
    law: &'static str,
    matrix: Matrix,
}

impl Planned {
    /// What `options` ask of the scenario `name`.
    pub(super) fn new(name: &str, options: &Options) -> Result<Self, ReportError> {
        let source = Source::find(name)?;
        let scenario = source.scenario(&[])?;
        let law = law_word(scenario.controller.law);
        let shoot_out = SHOOT_OUTS.contains(&name);
        let others: &[&str] = if shoot_out { &ALL_LAWS } else { &["proposed", "pd"] };
        let mut laws = vec![law.to_owned()];
        laws.extend(
            others
                .iter()
                .filter(|&&other| other != law)
                .map(|&other| other.to_owned()),
        );
        let gains = if shoot_out {
            vec![Gains::Default, Gains::Tuned]
        } else {
            vec![Gains::Default]
        };
        Ok(Self {
            matrix: Matrix {
                robots: vec![word(scenario.robot.gears)],
                kinematics: vec![word(scenario.robot.kinematics)],
                laws,
                gains,
                phases: options.phases,
                seeds: options.seeds,
            },
            name: name.to_owned(),
            source,
            scenario,
            law,
        })
    }

    /// Runs in all.
    pub(super) fn runs(&self) -> usize {
        self.matrix.runs() + self.drawn().len()
    }

    /// The laws whose curves are drawn: none of what is lost in process only, where `touchdown run` would draw others.
    fn drawn(&self) -> &[String] {
        match self.scenario.network.loss_ratio > 0.0 {
            true => &[],
            false => &self.matrix.laws,
        }
    }

    fn shoot_out(&self) -> bool {
        self.matrix.gains.len() > 1
    }

    /// Run it; `done` is told of runs.
    pub(super) fn run(&self, tuned: &Tuned, done: impl Fn(usize) + Sync) -> Result<Section, ReportError> {
        let comparison = self.matrix.run(&self.scenario, tuned, || done(1))?;
        let planned = self.drawn().iter().map(|law| self.curve(law, tuned));
        let planned: Vec<_> = planned.collect::<Result<_, _>>()?;
        let curves: Vec<Result<LabelledCurve, String>> = planned
            .par_iter()
            .map(|(scenario, ..)| {
                let curve = curve(scenario);
                done(1);
                curve
            })
            .collect();
        let shown: Vec<LabelledCurve> = curves.iter().flatten().cloned().collect();
        let mut figures = match shown.is_empty() {
            true => Vec::new(),
            false => force_panels(&shown, PANEL_WIDTH)?,
        }
        .into_iter();
        let panels = planned.into_iter().zip(curves).zip(self.drawn());
        let panels = panels.map(|(((_, gains, origin), curve), law)| Panel {
            law: law.clone(),
            gains,
            // There are as many figures as curves.
            svg: curve.and_then(|_| figures.next().ok_or_else(String::new)),
            origin,
        });
        Ok(Section {
            about: about(&self.source.text),
            law: self.law.to_owned(),
            shoot_out: self.shoot_out(),
            panels: panels.collect(),
            origin: Origin::new(self.command(), &self.scenario, self.matrix.seeds),
            scenario: self.name.clone(),
            comparison,
        })
    }

    fn command(&self) -> String {
        let Matrix {
            laws,
            gains,
            phases,
            seeds,
            ..
        } = &self.matrix;
        let gains: Vec<_> = gains.iter().map(Gains::word).collect();
        format!(
            "touchdown compare {} --laws {} --gains {} --phases {phases} --seeds {seeds}",
            quoted(&self.name),
            laws.join(","),
            gains.join(",")
        )
    }

    /// One run of `law`: in a shoot-out tuned, where there is anything to tune.
    fn curve(&self, law: &str, tuned: &Tuned) -> Result<(Scenario, Gains, Origin), ReportError> {
        let own = self.scenario.with(&[format!("controller.law={law}")])?;
        let tunable = self.shoot_out() && !parameters(own.controller.law).is_empty();
        let gains = if tunable { Gains::Tuned } else { Gains::Default };
        let mut command = format!("touchdown run {} --laws {law}", quoted(&self.name));
        let mut overrides = Vec::new();
        if gains == Gains::Tuned {
            overrides = tuned.overrides(&own)?;
            for text in &overrides {
                // Writing to a text does not fail.
                let _ = write!(command, " --set {}", quoted(text));
            }
        }
        // The command's hash is that of the scenario before the law is chosen.
        let origin = Origin::new(command, &self.scenario.with(&overrides)?, 1);
        Ok((own.with(&overrides)?, gains, origin))
    }
}

/// One run as `touchdown run` records it.
fn curve(scenario: &Scenario) -> Result<LabelledCurve, String> {
    let entries = transcript::in_process(scenario).map_err(|error| error.to_string())?;
    let (recording, measured) = Recording::from_transcript(scenario, &entries);
    let law = law_word(scenario.controller.law);
    LabelledCurve::new(law, scenario, &recording, measured).map_err(|error| error.to_string())
}

/// The first paragraph of the comment that a scenario begins with.
fn about(text: &str) -> String {
    let lines = text.lines().take_while(|line| line.starts_with('#'));
    let words = lines.map(|line| line.trim_start_matches('#').trim());
    words
        .take_while(|line| !line.is_empty())
        .collect::<Vec<_>>()
        .join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_shipped_scenario_says_what_it_is() {
        for name in crate::scenarios::names() {
            let text = about(&Source::find(name).unwrap().text);
            assert!(text.len() > 40 && text.ends_with('.'), "{name}: {text:?}");
            assert!(!text.contains("paper.toml"), "{name}: {text:?}");
        }
    }
}
