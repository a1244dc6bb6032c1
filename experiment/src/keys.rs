//! The reference of all keys of a scenario, from their one declaration.

use node::scenario::{Allowed, Key, Scenario, Section, Step};
use serde::Serialize;
use std::fmt::{Display, Formatter, Result};

/// One key, as the reference tells it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Entry {
    /// Section and name, such as `task.desired_force_n`.
    pub key: &'static str,
    /// Its unit; empty: none.
    pub unit: &'static str,
    /// What it accepts, in words.
    pub accepts: String,
    /// Least number that it accepts.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub minimum: Option<f64>,
    /// Greatest number that it accepts.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub maximum: Option<f64>,
    /// Default in TOML.
    pub default: String,
    /// What it means.
    pub meaning: &'static str,
}

impl From<&Key> for Entry {
    fn from(key: &Key) -> Self {
        let (accepts, range) = match &key.allowed {
            Allowed::Number(limits) => (span(limits.start(), limits.end()), Some(limits.clone())),
            Allowed::Array(limits, count) => {
                let each = span(limits.start(), limits.end());
                (format!("{count} numbers, {each} each"), Some(limits.clone()))
            }
            Allowed::List(limits) => {
                let each = span(limits.start(), limits.end());
                (format!("numbers, {each} each"), Some(limits.clone()))
            }
            Allowed::Integer(limits) => {
                let range = *limits.start() as f64..=*limits.end() as f64;
                let whole = match *limits.end() {
                    i64::MAX => format!("whole, {} or more", limits.start()),
                    end => format!("whole, {} to {end}", limits.start()),
                };
                (whole, Some(range))
            }
            Allowed::Flag => ("true or false".to_owned(), None),
            Allowed::Word(words) => (quoted(words), None),
        };
        Self {
            key: key.path,
            unit: key.unit,
            accepts,
            minimum: range.as_ref().map(|range| *range.start()),
            maximum: range.as_ref().map(|range| *range.end()),
            default: key.default.clone(),
            meaning: key.doc,
        }
    }
}

/// Words as TOML has them.
fn quoted(words: &[&str]) -> String {
    let quoted: Vec<_> = words.iter().map(|word| format!("{word:?}")).collect();
    quoted.join(", ")
}

fn span(start: &f64, end: &f64) -> String {
    format!("{start:?} to {end:?}")
}

/// The sections, and of each the keys whose path or meaning has `word` in it; an empty word: all of them.
fn sections(word: &str) -> Vec<(Section, Vec<Entry>)> {
    let all: Vec<Key> = Scenario::keys().into_iter().chain(Step::keys()).collect();
    let word = word.to_lowercase();
    let found = |key: &&Key| key.path.contains(&word) || key.doc.to_lowercase().contains(&word);
    let of = |section: &Section| {
        let own = all.iter().filter(|key| key.section() == section.path);
        own.filter(found).map(Entry::from).collect::<Vec<_>>()
    };
    let sections = Scenario::sections().into_iter();
    sections
        .map(|section| (section, of(&section)))
        .filter(|(_, keys)| !keys.is_empty())
        .collect()
}

/// The keys whose path or meaning has `word` in it.
pub fn entries(word: &str) -> Vec<Entry> {
    sections(word).into_iter().flat_map(|(_, keys)| keys).collect()
}

/// For a terminal: the keys whose path or meaning has the word in it, section by section.
#[derive(Clone, Copy, Debug)]
pub struct Text<'a>(pub &'a str);

impl Display for Text<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        for (i, (section, keys)) in sections(self.0).into_iter().enumerate() {
            if i > 0 {
                writeln!(f)?;
            }
            writeln!(f, "[{}]  {}", section.path, section.doc)?;
            for key in keys {
                writeln!(f, "  {} = {}", name(&key), key.default)?;
                let unit = if key.unit.is_empty() { "" } else { ", " };
                writeln!(f, "      {}{unit}{}. {}", key.unit, key.accepts, key.meaning)?;
            }
        }
        Ok(())
    }
}

/// docs/configuration.md.
#[derive(Clone, Copy, Debug)]
pub struct Markdown;

impl Display for Markdown {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        write!(
            f,
            "# Every key of a scenario\n\n\
             `touchdown keys --markdown` writes this page (`make keys`) from where the keys are declared; `touchdown keys \
             WORD` looks in it.\n\
             A scenario is one TOML file. Every key may be left out, and has its default then, which are the paper's \
             experiment on\nthe reference plant; any can be changed on the command line: `--set task.desired_force_n=12`. \
             What is refused is told with\nfile, line, limit and remedy. Names end with their unit; SI and radians.\n"
        )?;
        for (section, keys) in sections("") {
            let brackets = match section.path {
                "program.step" => format!("[[{}]]", section.path),
                path => format!("[{path}]"),
            };
            write!(f, "\n## `{brackets}`\n\n{}\n\n", section.doc)?;
            writeln!(
                f,
                "| Key | Unit | Accepts | Default | Meaning |\n|---|---|---|---|---|"
            )?;
            for key in keys {
                writeln!(
                    f,
                    "| `{}` | {} | {} | `{}` | {} |",
                    name(&key),
                    key.unit,
                    key.accepts,
                    key.default,
                    key.meaning.replace('|', "\\|"),
                )?;
            }
            if section.path == "program.step" {
                writeln!(f, "\n| Kind | Its keys |\n|---|---|")?;
                for (kind, known) in Step::kinds() {
                    let known: Vec<_> = known.iter().filter(|name| **name != "kind").collect();
                    let known: Vec<_> = known.into_iter().map(|name| format!("`{name}`")).collect();
                    writeln!(f, "| `{kind}` | {} |", known.join(", "))?;
                }
            }
        }
        Ok(())
    }
}

/// The name within the section.
fn name(entry: &Entry) -> &'static str {
    entry.key.rsplit_once('.').map_or(entry.key, |(_, name)| name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_key_is_told_once_with_its_limits() {
        let all = entries("");
        assert_eq!(all.len(), Scenario::keys().len() + Step::keys().len());
        let force = all.iter().find(|key| key.key == "task.desired_force_n").unwrap();
        assert_eq!((force.unit, force.default.as_str()), ("N", "10.0"));
        assert_eq!(Some(force.minimum..=force.maximum), {
            let limits = Scenario::limits(force.key).unwrap();
            Some(Some(*limits.start())..=Some(*limits.end()))
        });
    }

    #[test]
    fn a_word_finds_keys_by_path_and_by_meaning() {
        let found = entries("Spiral");
        assert!(
            found.iter().any(|key| key.key == "program.step.radius_m"),
            "{found:?}"
        );
        let text = Text("detection_threshold").to_string();
        assert!(text.starts_with("[controller]"), "{text}");
        assert_eq!(Text("no such word").to_string(), "");
    }

    #[test]
    fn the_stored_reference_is_the_present_one() {
        let stored = concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/configuration.md");
        let stored = std::fs::read_to_string(stored).unwrap();
        assert!(
            stored == Markdown.to_string(),
            "docs/configuration.md is not up to date: make keys"
        );
    }
}
