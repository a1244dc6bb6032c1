//! Names that the schema does not know, and the known ones that may have been meant.

use super::{Key, Scenario, error::Refusal, schema::split};
use std::fmt::{Display, Formatter, Result};
use std::sync::LazyLock;
use strsim::levenshtein;

/// The sections of a scenario, in the order of declaration.
pub(super) fn sections() -> &'static [&'static str] {
    static SECTIONS: LazyLock<Vec<&str>> = LazyLock::new(|| {
        let mut sections: Vec<_> = Scenario::keys().iter().map(Key::section).collect();
        sections.dedup();
        sections
    });
    &SECTIONS
}

/// The refusal of a key, or table, `path` that no section declares.
pub(super) fn unknown(path: &str, is_table: bool) -> Refusal {
    let path = path.to_owned();
    let sections = sections();
    let bracketed = sections.iter().map(|section| (*section, format!("[{section}]")));
    let all_sections = join(bracketed.clone().map(|(_, full)| full));
    let (section, name) = split(&path);
    if is_table {
        let near = Near::to(name, bracketed.map(|(section, full)| (split(section).1, full)));
        return Refusal::UnknownSection {
            path,
            known: all_sections,
            near,
        };
    }
    // Of equally close names the first counts: those in the same section.
    let (inside, outside): (Vec<_>, Vec<_>) = Scenario::keys()
        .into_iter()
        .partition(|key| key.section() == section);
    let near = Near::to(
        name,
        inside
            .iter()
            .chain(&outside)
            .map(|key| (key.name(), key.path.to_owned())),
    );
    if inside.is_empty() {
        return Refusal::UnknownPath {
            path,
            known: all_sections,
            near,
        };
    }
    let (section, known) = (
        section.to_owned(),
        join(inside.iter().map(|key| key.name().to_owned())),
    );
    Refusal::UnknownKey {
        path,
        section,
        known,
        near,
    }
}

fn join(names: impl Iterator<Item = String>) -> String {
    names.collect::<Vec<_>>().join(", ")
}

/// The known name closest to an unknown one, if it is close.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Near(Option<String>);

impl Near {
    /// The one of `known` whose name is closest to `name`, if no more than a third of its letters (or one) differ.
    /// Each comes with what to call it in full.
    pub(super) fn to<'a>(name: &str, known: impl IntoIterator<Item = (&'a str, String)>) -> Self {
        let rated = known.into_iter().filter_map(|(known, full)| {
            let limit = (known.len() / 3).max(1);
            let distance = (name.len().abs_diff(known.len()) <= limit).then(|| levenshtein(name, known))?;
            (distance <= limit).then_some((distance, full))
        });
        Self(rated.min_by_key(|(distance, _)| *distance).map(|(_, full)| full))
    }
}

impl Display for Near {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        self.0
            .iter()
            .try_for_each(|name| write!(f, "; did you mean {name}?"))
    }
}
