//! Does a driver keep the wire contract (`lcmtypes/README.md`)? Each rule is a pure function of a [`Record`] of what was heard
//! and said; [`session`] makes one by playing the peers that are missing.
//!
//! | What is judged | Module |
//! |---|---|
//! | what every node says of itself | [`common`] |
//! | its clock, and the echo of the controller's | [`echo`] |
//! | what a robot says | [`mod@robot`] |
//! | a robot that nobody enables | [`still`] |
//! | a robot that is enabled, released, left alone, reset | [`moved`] |
//! | a sensor | [`mod@sensor`] |

pub mod common;
pub mod echo;
pub mod moved;
pub mod record;
pub mod robot;
pub mod sensor;
pub mod session;
mod session_robot;
mod signatures;
pub mod still;
mod voice;

#[cfg(test)]
mod tests;

pub use record::Record;

use serde::Serialize;
use std::fmt;

/// What became of a rule.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// It was kept.
    Kept,
    /// It was broken.
    Broken,
    /// What it is about has not come.
    NotSeen,
}

/// One rule and what became of it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Finding {
    /// The rule.
    pub rule: &'static str,
    /// What became of it.
    pub verdict: Verdict,
    /// What was observed, with units and limits.
    pub observed: String,
    /// What to change.
    pub remedy: Option<String>,
}

impl Finding {
    /// `rule` was kept.
    pub fn kept(rule: &'static str, observed: impl Into<String>) -> Self {
        let (observed, remedy) = (observed.into(), None);
        Self {
            rule,
            verdict: Verdict::Kept,
            observed,
            remedy,
        }
    }

    /// What `rule` is about has not come.
    pub fn not_seen(rule: &'static str, why: impl Into<String>) -> Self {
        let verdict = Verdict::NotSeen;
        Self {
            verdict,
            ..Self::kept(rule, why)
        }
    }

    /// `rule` was broken.
    pub fn broken(rule: &'static str, observed: impl Into<String>, remedy: impl Into<String>) -> Self {
        let (verdict, remedy) = (Verdict::Broken, Some(remedy.into()));
        Self {
            verdict,
            remedy,
            ..Self::kept(rule, observed)
        }
    }

    /// Kept or broken.
    pub fn judge(rule: &'static str, kept: bool, observed: impl Into<String>, remedy: &str) -> Self {
        match kept {
            true => Self::kept(rule, observed),
            false => Self::broken(rule, observed, remedy),
        }
    }
}

/// What is checked of a robot beyond what its messages say of themselves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Expectation {
    /// n_d: periods T from a command to its effect.
    pub delay_periods: i64,
    /// `robot.command_gap_s`, s.
    pub command_gap_s: f64,
    /// Whether the robot was enabled.
    pub moved: bool,
}

/// Every rule for a robot.
pub fn robot(record: &Record, expectation: &Expectation) -> Vec<Finding> {
    let mut findings = common::rules(record);
    findings.extend(robot::rules(record));
    findings.extend(still::rules(record));
    if expectation.moved {
        findings.extend(moved::rules(record, expectation));
    }
    findings
}

/// Every rule for a sensor.
pub fn sensor(record: &Record) -> Vec<Finding> {
    let mut findings = common::rules(record);
    findings.extend(sensor::rules(record));
    findings
}

/// Whether a rule is broken.
pub fn broken(findings: &[Finding]) -> bool {
    findings.iter().any(|finding| finding.verdict == Verdict::Broken)
}

/// Findings for people: a line each, the remedy below, and how many there are of each kind.
#[derive(Clone, Copy, Debug)]
pub struct Table<'a>(pub &'a [Finding]);

impl fmt::Display for Table<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let width = self.0.iter().map(|finding| finding.rule.len()).max().unwrap_or(0);
        for Finding {
            rule,
            verdict,
            observed,
            remedy,
        } in self.0
        {
            let verdict = match verdict {
                Verdict::Kept => "kept",
                Verdict::Broken => "BROKEN",
                Verdict::NotSeen => "not seen",
            };
            writeln!(f, "{verdict:8}  {rule:width$}  {observed}")?;
            if let Some(remedy) = remedy {
                writeln!(f, "{:8}  {:width$}  remedy: {remedy}", "", "")?;
            }
        }
        let count = |verdict| self.0.iter().filter(|it| it.verdict == verdict).count();
        let [kept, broken, unseen] = [Verdict::Kept, Verdict::Broken, Verdict::NotSeen].map(count);
        writeln!(f, "{kept} rules kept, {broken} broken, {unseen} not seen")
    }
}
