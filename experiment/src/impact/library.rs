//! Materials and indenter shapes by name, each with its source.

use controller::impact::{Dimension, ImpactError, KicksLaw, Material, Shape};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fmt::{Display, Formatter};
use std::io;
use std::path::{Path, PathBuf};

/// What comes with the program.
const BUILT_IN: &str = include_str!("../../impact/library.toml");

/// Materials and shapes by name.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Library {
    /// Materials.
    pub materials: BTreeMap<String, MaterialEntry>,
    /// Indenter shapes.
    pub shapes: BTreeMap<String, ShapeEntry>,
}

/// A material and where its values come from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MaterialEntry {
    /// Young's modulus E, Pa.
    pub youngs_modulus_pa: f64,
    /// Poisson's ratio.
    pub poisson_ratio: f64,
    /// Where they come from.
    pub source: String,
}

/// A shape of an indenter and where its coefficient comes from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ShapeEntry {
    /// What makes one indenter of this shape.
    pub dimension: DimensionName,
    /// n of (13).
    pub exponent: f64,
    /// The numerical factor of c_in, see [`Shape`].
    pub factor: f64,
    /// Where they come from.
    pub source: String,
}

/// The dimension that a shape has.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum DimensionName {
    /// A radius, m.
    RadiusM,
    /// The side of a square, m.
    SideM,
    /// The angle between axis and flank, rad.
    HalfAngleRad,
}

impl DimensionName {
    /// The dimension of this name with `value` in its unit.
    pub fn of(self, value: f64) -> Dimension {
        match self {
            Self::RadiusM | Self::SideM => Dimension::Length(value),
            Self::HalfAngleRad => Dimension::HalfAngle(value),
        }
    }
}

impl Display for DimensionName {
    fn fmt(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::RadiusM => "radius-m",
            Self::SideM => "side-m",
            Self::HalfAngleRad => "half-angle-rad",
        })
    }
}

/// Why a library can't be used.
#[derive(Debug, thiserror::Error)]
pub enum LibraryError {
    /// The file can't be read.
    #[error("the materials {} can't be read: {source}; name an existing TOML file", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// It is no library.
    #[error(
        "{place}: {message}; a material has youngs_modulus_pa, poisson_ratio and source, a shape dimension, exponent, \
         factor and source (`touchdown impact --list` shows them)"
    )]
    Malformed {
        /// File, line and column.
        place: String,
        /// What is wrong.
        message: String,
    },
    /// An entry has an impossible value.
    #[error("{kind} {name:?} of {file}: {reason}")]
    Entry {
        /// The file.
        file: String,
        /// `material` or `shape`.
        kind: &'static str,
        /// Its name.
        name: String,
        /// What is wrong with it.
        reason: ImpactError,
    },
    /// There is nothing of this name.
    #[error("unknown {kind} {name:?}; known are {known}; your own come with --materials FILE")]
    Unknown {
        /// `material` or `shape`.
        kind: &'static str,
        /// The name.
        name: String,
        /// All names.
        known: String,
    },
}

impl Library {
    /// What comes with the program.
    pub fn built_in() -> Result<Self, LibraryError> {
        Self::parse("the built-in library", BUILT_IN)
    }

    /// What comes with the program, and the entries of the file at `path`, which take precedence.
    pub fn with_file(path: &Path) -> Result<Self, LibraryError> {
        let text = std::fs::read_to_string(path).map_err(|source| LibraryError::Unreadable {
            path: path.to_owned(),
            source,
        })?;
        let mut library = Self::built_in()?;
        let own = Self::parse(&path.display().to_string(), &text)?;
        library.materials.extend(own.materials);
        library.shapes.extend(own.shapes);
        Ok(library)
    }

    /// The library in `text`, all entries checked; `file` names it in errors.
    pub fn parse(file: &str, text: &str) -> Result<Self, LibraryError> {
        let library: Self = toml::from_str(text).map_err(|error| LibraryError::Malformed {
            place: place(file, text, error.span().map_or(0, |span| span.start)),
            message: error.message().to_owned(),
        })?;
        let refused = |kind, name: &String| {
            let (file, name) = (file.to_owned(), name.clone());
            move |reason| LibraryError::Entry {
                file,
                kind,
                name,
                reason,
            }
        };
        for (name, entry) in &library.materials {
            entry.material().map_err(refused("material", name))?;
        }
        for (name, entry) in &library.shapes {
            entry.shape().map_err(refused("shape", name))?;
        }
        Ok(library)
    }

    /// The material of this name.
    pub fn material(&self, name: &str) -> Result<&MaterialEntry, LibraryError> {
        find("material", &self.materials, name)
    }

    /// The shape of this name.
    pub fn shape(&self, name: &str) -> Result<&ShapeEntry, LibraryError> {
        find("shape", &self.shapes, name)
    }
}

impl MaterialEntry {
    /// As footnote 9 takes it.
    pub fn material(&self) -> Result<Material, ImpactError> {
        Material::new(self.youngs_modulus_pa, self.poisson_ratio)
    }
}

impl ShapeEntry {
    fn shape(&self) -> Result<Shape, ImpactError> {
        Shape::new(self.factor, self.exponent)
    }

    /// Paper (13) for an indenter of this shape with `dimension` in its unit, on a body with E* in Pa.
    pub fn law(&self, dimension: f64, effective_modulus_pa: f64) -> Result<KicksLaw, ImpactError> {
        self.shape()?
            .law(self.dimension.of(dimension), effective_modulus_pa)
    }
}

fn find<'a, T>(
    kind: &'static str,
    entries: &'a BTreeMap<String, T>,
    name: &str,
) -> Result<&'a T, LibraryError> {
    entries.get(name).ok_or_else(|| LibraryError::Unknown {
        kind,
        name: name.to_owned(),
        known: entries.keys().map(String::as_str).collect::<Vec<_>>().join(", "),
    })
}

/// File, line and column of the byte at `offset` of `text`.
fn place(file: &str, text: &str, offset: usize) -> String {
    let before = text.get(..offset).unwrap_or(text);
    let line = before.rsplit('\n').next().unwrap_or_default();
    format!(
        "{file}:{}:{}",
        before.matches('\n').count() + 1,
        line.chars().count() + 1
    )
}

#[cfg(test)]
mod tests;
