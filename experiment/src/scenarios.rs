//! Where a scenario comes from: the built-in ones by name, all others as files.

use node::scenario::{Scenario, ScenarioError};
use std::io;
use std::path::PathBuf;

/// Name and text of every built-in scenario.
const BUILT_IN: [(&str, &str); 20] = [
    ("paper", include_str!("../scenarios/paper.toml")),
    ("arm", include_str!("../scenarios/arm.toml")),
    ("elastic", include_str!("../scenarios/elastic.toml")),
    ("elastic_arm", include_str!("../scenarios/elastic_arm.toml")),
    ("expected", include_str!("../scenarios/expected.toml")),
    ("face", include_str!("../scenarios/face.toml")),
    ("conveyor", include_str!("../scenarios/conveyor.toml")),
    ("insert", include_str!("../scenarios/insert.toml")),
    ("screws", include_str!("../scenarios/screws.toml")),
    ("peg", include_str!("../scenarios/peg.toml")),
    ("car_body", include_str!("../scenarios/car_body.toml")),
    ("lever_0", include_str!("../scenarios/lever_0.toml")),
    ("lever_200", include_str!("../scenarios/lever_200.toml")),
    ("stiff", include_str!("../scenarios/stiff.toml")),
    ("soft", include_str!("../scenarios/soft.toml")),
    ("slow_sensor", include_str!("../scenarios/slow_sensor.toml")),
    ("delayed_sensor", include_str!("../scenarios/delayed_sensor.toml")),
    ("lossy", include_str!("../scenarios/lossy.toml")),
    ("wrong_c", include_str!("../scenarios/wrong_c.toml")),
    ("fast", include_str!("../scenarios/fast.toml")),
];

/// The text of a scenario and where it comes from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Source {
    /// Name of the built-in scenario, or the path as it was given.
    pub name: String,
    /// The scenario as TOML.
    pub text: String,
    /// The file; `None`: built in.
    pub path: Option<PathBuf>,
}

/// Why there is no such scenario.
#[derive(Debug, thiserror::Error)]
pub enum SourceError {
    /// Neither a built-in scenario nor a path.
    #[error(
        "unknown scenario {name:?}; the built-in ones are: {}; a path works too: it contains a / or ends with .toml",
        names().collect::<Vec<_>>().join(", ")
    )]
    Unknown {
        /// The name.
        name: String,
    },
    /// A path that can't be read.
    #[error("the scenario {} can't be read: {source}; name an existing file, or one of: {}", path.display(),
        names().collect::<Vec<_>>().join(", "))]
    Unreadable {
        /// The path.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
}

/// A choice as the scenario spells it: `Rigid` is `rigid`.
pub fn word(choice: impl std::fmt::Debug) -> String {
    format!("{choice:?}").to_lowercase()
}

/// Names of the built-in scenarios.
pub fn names() -> impl Iterator<Item = &'static str> {
    BUILT_IN.into_iter().map(|(name, _)| name)
}

impl Source {
    /// The scenario that `name` means: a path if it contains a `/` or ends with `.toml`, else a built-in one.
    pub fn find(name: &str) -> Result<Self, SourceError> {
        let source = |text: &str, path| Self {
            name: name.to_owned(),
            text: text.to_owned(),
            path,
        };
        if name.contains('/') || name.ends_with(".toml") {
            let path = PathBuf::from(name);
            return match std::fs::read_to_string(&path) {
                Ok(text) => Ok(source(&text, Some(path))),
                Err(error) => Err(SourceError::Unreadable { path, source: error }),
            };
        }
        match BUILT_IN.into_iter().find(|(known, _)| *known == name) {
            Some((_, text)) => Ok(source(text, None)),
            None => Err(SourceError::Unknown {
                name: name.to_owned(),
            }),
        }
    }

    /// The scenario with `overrides`, texts `section.key=value`.
    pub fn scenario(&self, overrides: &[String]) -> Result<Scenario, ScenarioError> {
        Scenario::parse(&self.name, &self.text, overrides)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_built_in_scenario_is_valid() {
        for name in names() {
            let source = Source::find(name).unwrap();
            assert_eq!(source.path, None);
            let scenario = source.scenario(&[]).unwrap();
            assert_eq!(Scenario::parse(name, &scenario.to_toml(), &[]), Ok(scenario));
        }
    }

    #[test]
    fn a_path_is_a_file() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/scenarios/paper.toml");
        let file = Source::find(path).unwrap();
        assert_eq!(file.path, Some(PathBuf::from(path)));
        assert_eq!(file.text, Source::find("paper").unwrap().text);
    }

    #[test]
    fn what_does_not_exist_is_refused_with_what_does() {
        assert_eq!(
            Source::find("papre").unwrap_err().to_string(),
            "unknown scenario \"papre\"; the built-in ones are: paper, arm, elastic, elastic_arm, expected, face, conveyor, \
             insert, screws, peg, car_body, lever_0, lever_200, stiff, soft, slow_sensor, delayed_sensor, lossy, wrong_c, fast; a path \
             works too: it contains a / or ends with .toml"
        );
        let missing = Source::find("missing.toml").unwrap_err().to_string();
        assert!(
            missing.starts_with("the scenario missing.toml can't be read: "),
            "{missing}"
        );
    }
}
