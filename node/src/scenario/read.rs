//! From text to a scenario: every key into its place, every problem into the list.

use super::{
    Scenario,
    check::Conflict,
    error::{Place, Problem, Refusal, ScenarioError},
    names::{sections, unknown},
    program::{Step, Steps},
    schema::Field,
    value::describe,
};
use std::{borrow::Cow, collections::BTreeMap, ops::Range, path::Path};
use toml::{
    Spanned,
    de::{DeTable, DeValue},
};

impl Scenario {
    /// Reads the file at `path`, then applies `overrides`: texts `section.key=value` with the value in TOML, in
    /// which a single word needs no quotes. Keys that neither names keep their defaults.
    pub fn load(path: &Path, overrides: &[String]) -> Result<Self, ScenarioError> {
        let name = path.display().to_string();
        match std::fs::read_to_string(path) {
            Ok(text) => Self::parse(&name, &text, overrides),
            Err(error) => {
                let refusal = Refusal::Unreadable(error.to_string());
                Err(ScenarioError::new(vec![Problem {
                    place: Place::Whole(name),
                    refusal,
                }]))
            }
        }
    }

    /// As [`Scenario::load`], from `text`; `name` stands for the file in errors.
    pub fn parse(name: &str, text: &str, overrides: &[String]) -> Result<Self, ScenarioError> {
        let mut reader = Reader::new(name, Self::default());
        reader.document(text);
        reader.overrides(overrides);
        reader.finish()
    }

    /// This scenario with `overrides` applied, checked as a whole.
    pub fn with(&self, overrides: &[String]) -> Result<Self, ScenarioError> {
        let mut reader = Reader::new("scenario", self.clone());
        reader.overrides(overrides);
        reader.finish()
    }
}

struct Reader<'a> {
    name: &'a str,
    scenario: Scenario,
    /// Where each key that was given was given last.
    places: BTreeMap<String, Place>,
    problems: Vec<Problem>,
}

impl<'a> Reader<'a> {
    fn new(name: &'a str, scenario: Scenario) -> Self {
        Self {
            name,
            scenario,
            places: BTreeMap::new(),
            problems: Vec::new(),
        }
    }

    fn refuse(&mut self, place: Place, refusal: Refusal) {
        self.problems.push(Problem { place, refusal });
    }

    fn document(&mut self, text: &str) {
        let lines = Lines::of(text);
        let place = |span: Range<usize>| lines.locate(self.name, span.start);
        let (document, errors) = DeTable::parse_recoverable(text);
        if errors.is_empty() {
            self.table("", document.get_ref(), &place);
        }
        for error in errors {
            self.refuse(place(error.span().unwrap_or_default()), syntax(text, &error));
        }
    }

    fn overrides(&mut self, overrides: &[String]) {
        for text in overrides {
            let place = |_| Place::Override(text.clone());
            let assignment = text
                .split_once('=')
                .map(|(key, value)| (key.trim(), value.trim()));
            match assignment.filter(|(key, value)| !key.is_empty() && !value.is_empty()) {
                Some((key, value)) => match assigned(value) {
                    Ok(value) => self.entry(key, 0..0, &value, &place),
                    Err(refusal) => self.refuse(place(0..0), refusal),
                },
                None => self.refuse(place(0..0), Refusal::NotAnAssignment),
            }
        }
    }

    fn table(&mut self, section: &str, table: &DeTable<'_>, place: &impl Fn(Range<usize>) -> Place) {
        for (key, value) in table.iter() {
            let name = bare(key.get_ref());
            let path = if section.is_empty() {
                name.into_owned()
            } else {
                format!("{section}.{name}")
            };
            self.entry(&path, key.span(), value, place);
        }
    }

    /// One key (or section) and its value.
    fn entry(
        &mut self,
        path: &str,
        key: Range<usize>,
        value: &Spanned<DeValue<'_>>,
        place: &impl Fn(Range<usize>) -> Place,
    ) {
        let field = self.scenario.fields().find(|field| field.path == path);
        if let Some(Field { slot, .. }) = field {
            match slot.put(path, value) {
                Ok(()) => drop(self.places.insert(path.to_owned(), place(key))),
                Err(misfits) => misfits
                    .into_iter()
                    .for_each(|(span, refusal)| self.refuse(place(span), refusal)),
            }
            return;
        }
        if path == "program.step" {
            return self.steps(key, value, place);
        }
        let is_section = sections().contains(&path);
        match value.get_ref() {
            DeValue::Table(table) if is_section => self.table(path, table, place),
            value if is_section => {
                let refusal = Refusal::NotASection {
                    path: path.to_owned(),
                    found: describe(value),
                };
                self.refuse(place(key), refusal);
            }
            value => self.refuse(place(key), unknown(path, value.is_table())),
        }
    }

    /// The steps of a program.
    fn steps(
        &mut self,
        key: Range<usize>,
        value: &Spanned<DeValue<'_>>,
        place: &impl Fn(Range<usize>) -> Place,
    ) {
        let tables = value.get_ref().as_array();
        let tables: Option<Vec<_>> = tables.and_then(|items| items.iter().map(as_table).collect());
        let Some(tables) = tables else {
            let (path, found) = ("program.step".to_owned(), describe(value.get_ref()));
            self.refuse(place(key), Refusal::NotSteps { path, found });
            return;
        };
        let mut steps = Vec::new();
        for (i, (span, table)) in tables.into_iter().enumerate() {
            match Step::read(i, table, &place(span), place) {
                Ok(step) => steps.push(step),
                Err(refused) => refused
                    .into_iter()
                    .for_each(|(place, refusal)| self.refuse(place, refusal)),
            }
        }
        self.scenario.program.steps = Steps(steps);
        self.places.insert("program.step".to_owned(), place(key));
    }

    fn finish(mut self) -> Result<Scenario, ScenarioError> {
        if self.problems.is_empty() {
            for Conflict { keys, text } in self.scenario.conflicts() {
                let given = keys.iter().find_map(|key| self.places.get(*key)).cloned();
                let place = given.unwrap_or_else(|| Place::Whole(self.name.to_owned()));
                self.refuse(place, Refusal::Conflict(text));
            }
        }
        if self.problems.is_empty() {
            Ok(self.scenario)
        } else {
            Err(ScenarioError::new(self.problems))
        }
    }
}

/// Where a table is, and what is in it.
fn as_table<'a, 'b>(item: &'a Spanned<DeValue<'b>>) -> Option<(Range<usize>, &'a DeTable<'b>)> {
    Some((item.span(), item.get_ref().as_table()?))
}

/// The value of an assignment: TOML, or a single word.
fn assigned(text: &str) -> Result<Spanned<DeValue<'_>>, Refusal> {
    match DeValue::parse(text) {
        Ok(value) => Ok(value),
        Err(_) if is_bare(text) => Ok(Spanned::new(0..text.len(), DeValue::String(text.into()))),
        Err(error) => Err(syntax(text, &error)),
    }
}

fn is_bare(name: &str) -> bool {
    !name.is_empty()
        && name
            .chars()
            .all(|c| c.is_ascii_alphanumeric() || "-_".contains(c))
}

/// A key as TOML writes it: with quotes where it needs them.
fn bare(name: &str) -> Cow<'_, str> {
    if is_bare(name) {
        name.into()
    } else {
        format!("{name:?}").into()
    }
}

fn syntax(text: &str, error: &toml::de::Error) -> Refusal {
    let found = error
        .span()
        .and_then(|span| text.get(span))
        .and_then(|found| found.lines().next());
    let found = found
        .filter(|found| !found.is_empty())
        .map_or("the end of the line".to_owned(), |f| format!("{f:?}"));
    Refusal::Syntax {
        found,
        message: error.message().to_owned(),
    }
}

/// A text and where each of its lines begins: every key asks for its place.
struct Lines<'a> {
    text: &'a str,
    starts: Vec<usize>,
}

impl<'a> Lines<'a> {
    fn of(text: &'a str) -> Self {
        let after = text.match_indices('\n').map(|(i, _)| i + 1);
        Self {
            text,
            starts: std::iter::once(0).chain(after).collect(),
        }
    }

    /// Line and column of the byte at `offset`.
    fn locate(&self, name: &str, offset: usize) -> Place {
        let line = self.starts.partition_point(|&start| start <= offset);
        let start = self
            .starts
            .get(line.saturating_sub(1))
            .copied()
            .unwrap_or_default();
        let before = self.text.get(start..offset).unwrap_or_default();
        Place::At(name.to_owned(), line, before.chars().count() + 1)
    }
}
