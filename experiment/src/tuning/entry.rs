//! The file of tuned gains.

use super::{Gains, law_word, parameters, space};
use node::scenario::{Scenario, ScenarioError};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fmt::Write;
use std::io;
use std::path::{Path, PathBuf};

/// What comes with the program; `make tune` writes it.
const BUILT_IN: &str = include_str!("../../tuned.toml");

/// The tuned gains of one law on one robot.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Entry {
    /// What joins motor and link.
    pub robot: String,
    /// Kinematics.
    pub kinematics: String,
    /// Control law.
    pub law: String,
    /// The scenario it was tuned on.
    pub scenario: String,
    /// Points that were tried.
    pub evaluations: usize,
    /// Training runs of each, and held-out runs of the best.
    pub runs: usize,
    /// Mean criterion of the held-out runs with the scenario's own gains.
    pub criterion_default: f64,
    /// Mean criterion of the training runs.
    pub criterion_training: f64,
    /// Mean criterion of the held-out runs.
    pub criterion_held_out: f64,
    /// Of the loop, by linear theory; see [`crate::linear::Margins`].
    pub gain_margin: Option<f64>,
    /// Of the loop, by linear theory.
    pub phase_margin_rad: Option<f64>,
    /// Keys of the scenario and their values.
    pub values: BTreeMap<String, f64>,
}

impl Entry {
    fn key(&self) -> (&str, &str, &str) {
        (&self.robot, &self.kinematics, &self.law)
    }
}

/// All tuned gains.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Tuned {
    /// One for each law and robot.
    #[serde(default)]
    pub tuned: Vec<Entry>,
}

/// Why there are no tuned gains.
#[derive(Debug, thiserror::Error)]
pub enum TuningError {
    /// They do not fit the scenario.
    #[error(transparent)]
    Scenario(#[from] ScenarioError),
    /// Nobody has tuned this.
    #[error(
        "there are no tuned gains of law {law} on {robot} {kinematics}; find them: touchdown tune --laws {law} --robots \
         {robot} --kinematics {kinematics} --out FILE, then --tuned FILE"
    )]
    Missing {
        /// Control law.
        law: String,
        /// What joins motor and link.
        robot: String,
        /// Kinematics.
        kinematics: String,
    },
    /// The file can't be read or written.
    #[error("the tuned gains {} can't be read or written: {source}; name a file of touchdown tune", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// The file is none of ours.
    #[error("the tuned gains {name}: {message}; write the file with touchdown tune --out")]
    Format {
        /// The file.
        name: String,
        /// What is wrong.
        message: String,
    },
}

impl Tuned {
    /// Those that come with the program.
    pub fn built_in() -> Result<Self, TuningError> {
        Self::parse("that come with the program", BUILT_IN)
    }

    /// Those of the file `path`.
    pub fn load(path: &Path) -> Result<Self, TuningError> {
        let text = std::fs::read_to_string(path).map_err(|source| TuningError::File {
            path: path.to_owned(),
            source,
        })?;
        Self::parse(&path.display().to_string(), &text)
    }

    /// Those in `text`; `name` stands for the file in errors.
    pub fn parse(name: &str, text: &str) -> Result<Self, TuningError> {
        toml::from_str(text).map_err(|error| TuningError::Format {
            name: name.to_owned(),
            message: error.to_string().trim_end().to_owned(),
        })
    }

    /// The texts that put the gains of the law of `scenario` into it.
    pub fn overrides(&self, scenario: &Scenario) -> Result<Vec<String>, TuningError> {
        let law = scenario.controller.law;
        let robot = crate::scenarios::word(scenario.robot.gears);
        let kinematics = crate::scenarios::word(scenario.robot.kinematics);
        let key = (robot.as_str(), kinematics.as_str(), law_word(law));
        match self.tuned.iter().find(|entry| entry.key() == key) {
            Some(entry) => Ok(space::overrides(&entry.values)),
            None => Err(TuningError::Missing {
                law: law_word(law).to_owned(),
                robot,
                kinematics,
            }),
        }
    }

    /// `scenario` with these gains; `None`: its law has nothing to tune.
    pub fn apply(&self, gains: Gains, scenario: &Scenario) -> Result<Option<Scenario>, TuningError> {
        match gains {
            Gains::Default => Ok(Some(scenario.clone())),
            Gains::Tuned if parameters(scenario.controller.law).is_empty() => Ok(None),
            Gains::Tuned => Ok(Some(scenario.with(&self.overrides(scenario)?)?)),
        }
    }

    /// Replace what is known of the same law and robot.
    pub fn put(&mut self, entry: Entry) {
        self.tuned.retain(|known| known.key() != entry.key());
        self.tuned.push(entry);
        self.tuned.sort_by(|a, b| a.key().cmp(&b.key()));
    }

    /// The file, values to digits that count.
    pub fn to_toml(&self) -> String {
        let mut text = String::from(
            "# Tuned gains, written by `touchdown tune` (`make tune`): don't edit. Criterion, bounds and budget:\n\
             # `touchdown tune --help`. The criterion has no unit; margins are those of the linear loop.\n",
        );
        for entry in &self.tuned {
            let quoted = [
                ("robot", &entry.robot),
                ("kinematics", &entry.kinematics),
                ("law", &entry.law),
                ("scenario", &entry.scenario),
            ];
            text += "\n[[tuned]]\n";
            for (name, value) in quoted {
                text += &line(name, value.as_str());
            }
            // Writing to a string does not fail.
            let _ = writeln!(text, "evaluations = {}\nruns = {}", entry.evaluations, entry.runs);
            let numbers = [
                ("criterion_default", Some(entry.criterion_default)),
                ("criterion_training", Some(entry.criterion_training)),
                ("criterion_held_out", Some(entry.criterion_held_out)),
                ("gain_margin", entry.gain_margin),
                ("phase_margin_rad", entry.phase_margin_rad),
            ];
            for (name, value) in numbers {
                if let Some(value) = value {
                    let _ = writeln!(text, "{name} = {value:.3}");
                }
            }
            text += "\n[tuned.values]\n";
            for (key, value) in &entry.values {
                let key = line(key, 0);
                let _ = writeln!(text, "{} = {value:?}", key.trim_end_matches(" = 0\n"));
            }
        }
        text
    }
}

/// `key = value`, both quoted where TOML wants it.
fn line(key: &str, value: impl Into<toml::Value>) -> String {
    let table: toml::Table = [(key.to_owned(), value.into())].into_iter().collect();
    table.to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn entry(law: &str) -> Entry {
        Entry {
            robot: "rigid".to_owned(),
            kinematics: "gantry".to_owned(),
            law: law.to_owned(),
            scenario: "paper".to_owned(),
            evaluations: 10,
            runs: 2,
            criterion_default: 3.0,
            criterion_training: 1.5,
            criterion_held_out: 1.625,
            gain_margin: Some(2.5),
            phase_margin_rad: None,
            values: [("controller.pd.proportional_m_per_n".to_owned(), 3.21e-6)].into(),
        }
    }

    #[test]
    fn the_file_is_read_as_it_was_written() {
        let mut tuned = Tuned::default();
        for law in ["pd", "fzi", "pd"] {
            tuned.put(entry(law));
        }
        // Characters that Rust writes otherwise than TOML.
        let mut strange = entry("pd");
        (strange.scenario, strange.robot) = ("a\u{feff}\u{7f}\n'\"\\.toml".to_owned(), "\u{300}".to_owned());
        strange.values = [("a\u{feff}\n\"'".to_owned(), 1e-300)].into();
        tuned.put(strange);
        assert_eq!(tuned.tuned.len(), 3);
        assert_eq!(Tuned::parse("test", &tuned.to_toml()).unwrap(), tuned);
        assert_eq!(Tuned::built_in().unwrap().to_toml(), BUILT_IN);
    }

    #[test]
    fn tuned_gains_are_applied_or_missed_by_name() {
        let tuned = Tuned {
            tuned: vec![entry("pd")],
        };
        let with = |law: &str| {
            Scenario::default()
                .with(&[format!("controller.law={law}")])
                .unwrap()
        };
        let applied = tuned.apply(Gains::Tuned, &with("pd")).unwrap().unwrap();
        assert_eq!(applied.controller.pd.proportional_m_per_n, 3.21e-6);
        assert!(tuned.apply(Gains::Tuned, &with("literal")).unwrap().is_none());
        let error = tuned.apply(Gains::Tuned, &with("fzi")).unwrap_err().to_string();
        assert!(
            error.starts_with("there are no tuned gains of law fzi on rigid gantry; find them"),
            "{error}"
        );
    }

    /// Every law that has gains has tuned ones on every robot that it is for.
    #[test]
    fn what_comes_with_the_program_is_complete() {
        let tuned = Tuned::built_in().unwrap();
        for law in [
            "pd",
            "pd-reset",
            "proposed",
            "impedance",
            "elastic",
            "ros2",
            "fzi",
        ] {
            for robot in ["rigid", "elastic"] {
                if (law, robot) == ("elastic", "rigid") {
                    continue;
                }
                for kinematics in ["gantry", "arm"] {
                    let scenario = Scenario::default()
                        .with(&[
                            format!("controller.law={law}"),
                            format!("robot.gears={robot}"),
                            format!("robot.kinematics={kinematics}"),
                        ])
                        .unwrap();
                    assert!(tuned.apply(Gains::Tuned, &scenario).unwrap().is_some());
                }
            }
        }
    }
}
