//! What a sweep is: a TOML file.

use super::{Axis, SweepError};
use crate::scenarios::Source;
use crate::tuning::Gains;
use node::scenario::Scenario;
use serde::{Deserialize, Serialize};

/// Name and text of every built-in sweep.
const BUILT_IN: [(&str, &str); 2] = [
    ("smoke", include_str!("../../sweeps/smoke.toml")),
    ("shootout", include_str!("../../sweeps/shootout.toml")),
];

/// Names of the built-in sweeps.
pub fn names() -> impl Iterator<Item = &'static str> {
    BUILT_IN.into_iter().map(|(name, _)| name)
}

/// A sweep.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Definition {
    /// The scenario that all maps vary: a name, or a path.
    pub scenario: String,
    /// What is changed of it, texts `section.key=value`.
    #[serde(default)]
    pub set: Vec<String>,
    /// Control laws.
    pub laws: Vec<String>,
    /// With which gains; a law that has nothing to tune runs with what it has.
    pub gains: Gains,
    /// Contact phases of each cell.
    pub phases: usize,
    /// The maps.
    #[serde(rename = "map")]
    pub maps: Vec<MapDefinition>,
}

/// A map: one run for each law, value of x, value of y and contact phase.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MapDefinition {
    /// The name of its figure.
    pub name: String,
    /// What is said above the figure.
    pub title: String,
    /// Control laws, where they are not the sweep's.
    pub laws: Option<Vec<String>>,
    /// What is changed of the scenario beyond the sweep's `set`.
    #[serde(default)]
    pub set: Vec<String>,
    /// To the right.
    pub x: Values,
    /// Upwards.
    pub y: Values,
}

/// An axis and its values.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Values {
    /// What is varied.
    pub axis: Axis,
    /// From the origin on, in the axis's unit.
    pub values: Vec<f64>,
}

impl Definition {
    /// The sweep that `name` means: a path if it contains a `/` or ends with `.toml`, else a built-in one.
    pub fn find(name: &str) -> Result<Self, SweepError> {
        let text = if name.contains('/') || name.ends_with(".toml") {
            std::fs::read_to_string(name).map_err(|source| SweepError::File {
                path: name.into(),
                source,
            })?
        } else {
            let known = BUILT_IN.into_iter().find(|(known, _)| *known == name);
            let unknown = || SweepError::Unknown {
                name: name.to_owned(),
            };
            known.ok_or_else(unknown)?.1.to_owned()
        };
        Self::parse(name, &text)
    }

    /// The sweep in `text`; `name` stands for the file in errors.
    pub fn parse(name: &str, text: &str) -> Result<Self, SweepError> {
        let refuse = |message: String| SweepError::Definition {
            name: name.to_owned(),
            message,
        };
        let definition: Self = toml::from_str(text).map_err(|error| refuse(error.to_string()))?;
        if definition.phases == 0 || definition.phases > 1000 {
            let phases = definition.phases;
            return Err(refuse(format!("phases is {phases}; choose a number in 1..=1000")));
        }
        if definition.laws.is_empty() || definition.maps.is_empty() {
            return Err(refuse("no law or no map; name at least one of each".to_owned()));
        }
        for map in &definition.maps {
            let plain = |c: char| c.is_ascii_alphanumeric() || "-_".contains(c);
            if map.name.is_empty() || !map.name.chars().all(plain) {
                let name = &map.name;
                return Err(refuse(format!(
                    "a map is called {name:?}, which is no file's name; use letters, digits, - and _"
                )));
            }
            for values in [&map.x, &map.y] {
                if values.values.is_empty() || values.values.iter().any(|value| !value.is_finite()) {
                    let (name, axis) = (&map.name, values.axis.column());
                    return Err(refuse(format!(
                        "map {name} has no values, or no finite ones, along {axis}; give numbers"
                    )));
                }
            }
        }
        Ok(definition)
    }

    /// The laws of a map.
    pub fn laws<'a>(&'a self, map: &'a MapDefinition) -> &'a [String] {
        map.laws.as_deref().unwrap_or(&self.laws)
    }

    /// The scenario that the maps vary.
    pub fn scenario(&self) -> Result<Scenario, SweepError> {
        Ok(Source::find(&self.scenario)?.scenario(&self.set)?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_built_in_sweep_is_valid() {
        for name in names() {
            let definition = Definition::find(name).unwrap();
            crate::sweep::Plan::new(definition, &crate::tuning::Tuned::built_in().unwrap()).unwrap();
        }
    }

    #[test]
    fn what_makes_no_sense_is_refused() {
        let error = |name: &str| Definition::find(name).unwrap_err().to_string();
        assert!(
            error("somke").starts_with("unknown sweep \"somke\"; the built-in ones are: smoke, shootout;")
        );
        assert!(error("none.toml").starts_with("none.toml can't be read or written"));
        let text = BUILT_IN[0].1;
        for (from, to, message) in [
            (
                "phases = 1",
                "phases = 0",
                "the sweep a: phases is 0; choose a number in 1..=1000",
            ),
            ("laws = [", "lows = [", "unknown field `lows`"),
            ("\"delay\"", "\"dealy\"", "unknown variant `dealy`"),
            ("name = \"delay\"", "name = \"a/b\"", "which is no file's name"),
        ] {
            assert!(text.contains(from), "{from}");
            let error = Definition::parse("a", &text.replace(from, to))
                .unwrap_err()
                .to_string();
            assert!(error.contains(message), "{error}");
        }
    }
}
