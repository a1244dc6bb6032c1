//! What is wrong with a scenario, and where.

use super::names::Near;
use std::fmt::{Display, Formatter, Result};

/// How many problems are listed; more are counted.
const LISTED: usize = 20;

/// Everything that is wrong with a scenario, one problem per line: where, what, the limit and the remedy.
#[derive(Debug, Clone, PartialEq)]
pub struct ScenarioError(Vec<Problem>);

/// One thing that is wrong, and where.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Problem {
    pub(super) place: Place,
    pub(super) refusal: Refusal,
}

/// Where a value comes from.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Place {
    /// Nowhere in particular in the named file.
    Whole(String),
    /// Name of the file, line and column, both from 1.
    At(String, usize, usize),
    /// The text of an assignment on the command line.
    Override(String),
}

/// Why something in a scenario is refused.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub(super) enum Refusal {
    #[error(
        "the scenario can't be read: {0}; name an existing file, such as experiment/scenarios/paper.toml"
    )]
    Unreadable(String),
    #[error("not valid TOML at {found}: {message}")]
    Syntax { found: String, message: String },
    #[error("not an assignment; write --set section.key=value")]
    NotAnAssignment,
    #[error("unknown key {path}; [{section}] knows {known}{near}")]
    UnknownKey {
        path: String,
        section: String,
        known: String,
        near: Near,
    },
    #[error("unknown key {path}; a scenario has the sections {known}{near}")]
    UnknownPath { path: String, known: String, near: Near },
    #[error("unknown section [{path}]; a scenario has {known}{near}")]
    UnknownSection { path: String, known: String, near: Near },
    #[error("{path} is {found}, not a section; write [{path}] and its keys on the lines below")]
    NotASection { path: String, found: String },
    #[error("{path} is {found}, not a list of steps; write [[{path}]] before the keys of each step")]
    NotSteps { path: String, found: String },
    #[error("{path} is {found}, not {expected}; choose {allowed}")]
    WrongType {
        path: String,
        found: String,
        expected: &'static str,
        allowed: String,
    },
    #[error("{path} has {found} values instead of {expected}; list {expected} numbers in {allowed}")]
    WrongCount {
        path: String,
        found: usize,
        expected: usize,
        allowed: String,
    },
    #[error("{path} is {value}, {side} the limit of {limit}; choose a value in {allowed}")]
    OutOfRange {
        path: String,
        value: String,
        side: &'static str,
        limit: String,
        allowed: String,
    },
    #[error("{path} is the unknown word {word:?}; choose {allowed}{near}")]
    UnknownWord {
        path: String,
        word: String,
        allowed: String,
        near: Near,
    },
    #[error("{0}")]
    Conflict(String),
}

impl ScenarioError {
    /// `problems` in the order of the file, then of the overrides.
    pub(super) fn new(mut problems: Vec<Problem>) -> Self {
        problems.sort_by_key(|problem| match problem.place {
            Place::Whole(_) => (0, 0),
            Place::At(_, line, column) => (line, column),
            Place::Override(_) => (usize::MAX, 0),
        });
        Self(problems)
    }
}

impl std::error::Error for ScenarioError {}

impl Display for ScenarioError {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        for (i, problem) in self.0.iter().take(LISTED).enumerate() {
            let Problem { place, refusal } = problem;
            write!(f, "{}{place}: {refusal}", if i > 0 { "\n" } else { "" })?;
        }
        match self.0.len().saturating_sub(LISTED) {
            0 => Ok(()),
            1 => write!(f, "\nand 1 more problem"),
            more => write!(f, "\nand {more} more problems"),
        }
    }
}

impl Display for Place {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        match self {
            Self::Whole(name) => write!(f, "{name}"),
            Self::At(name, line, column) => write!(f, "{name}:{line}:{column}"),
            Self::Override(text) => write!(f, "--set {text}"),
        }
    }
}
