//! The question that the flags of `touchdown impact` ask.

use super::flags::{Args, Example};
use anyhow::Result;
use controller::impact::effective_mass::with_robot_kg;
use controller::impact::quantity::{COORDINATE, MASS};
use controller::impact::{KicksLaw, Rebound, Surface, ToolInertia};
use experiment::impact::library::DimensionName;
use experiment::impact::{Library, Question, TransientQuestion};
use nalgebra::Vector3;

/// A question that lacks something.
#[derive(Debug, thiserror::Error)]
pub(crate) enum Unanswerable {
    /// A value is missing.
    #[error("the {what} is missing; give {flag}, or a --scenario")]
    Missing { what: &'static str, flag: &'static str },
    /// A shape needs another dimension.
    #[error("the shape {shape} has no --{given}; give --{needed}")]
    Dimension {
        shape: String,
        given: DimensionName,
        needed: DimensionName,
    },
}

const SAMPLING_TIME_S: f64 = 0.004;

impl Args {
    /// What is asked without a scenario.
    pub(super) fn questions(&self, library: &Library) -> Result<Vec<Question>> {
        if let Some(Example::Table1) = self.example {
            return table_1(library, self);
        }
        let (name, surface, effective_modulus_pa) = self.surface(library)?;
        let question = Question {
            name,
            surface,
            effective_modulus_pa,
            effective_mass_kg: self.mass()?,
            speed_m_per_s: self.speed_m_per_s.ok_or(Unanswerable::Missing {
                what: "speed",
                flag: "--speed-m-per-s",
            })?,
            sampling_time_s: SAMPLING_TIME_S,
            controlled_peak_n: None,
            allowed_force_n: None,
            allowed_remaining_depth_m: None,
            transient: None,
        };
        Ok(vec![self.further(question)])
    }

    /// `question`, and what is asked of any impact.
    pub(super) fn further(&self, question: Question) -> Question {
        let transient = self.body_mass_kg.zip(self.body_stiffness_n_per_m);
        Question {
            sampling_time_s: self.sampling_time_s.unwrap_or(question.sampling_time_s),
            controlled_peak_n: self.controlled_peak_n,
            allowed_force_n: self.allowed_force_n.or(question.allowed_force_n),
            allowed_remaining_depth_m: self.allowed_remaining_m,
            transient: transient.map(|(body_mass_kg, body_stiffness_n_per_m)| TransientQuestion {
                robot_mass_kg: question.effective_mass_kg + 0.5 * self.moving_mass_kg.unwrap_or(0.0),
                body_mass_kg,
                body_stiffness_n_per_m,
                allowed_force_n: self.body_force_n,
            }),
            ..question
        }
    }

    /// What is struck, its name, and E* where it is known.
    fn surface(&self, library: &Library) -> Result<(String, Surface, Option<f64>)> {
        let rebound = Rebound::new(self.rebound_ratio.unwrap_or(1.0))?;
        if let Some(coefficient) = self.coefficient {
            let law = KicksLaw::new(coefficient, self.exponent.unwrap_or(1.0))?;
            return Ok(("impact".to_owned(), Surface { law, rebound }, None));
        }
        let name = self.shape.as_ref().ok_or(Unanswerable::Missing {
            what: "contact",
            flag: "--shape with its dimension and the materials (--tool and --object, or --effective-modulus-pa), or \
                   --indentation-n-per-m",
        })?;
        let shape = library.shape(name)?;
        let modulus = match (self.effective_modulus_pa, &self.tool, &self.object) {
            (Some(modulus), _, _) => modulus,
            (None, Some(tool), Some(object)) => {
                let [tool, object] = [
                    library.material(tool)?.material()?,
                    library.material(object)?.material()?,
                ];
                tool.effective_modulus_pa(&object)
            }
            _ => {
                return Err(Unanswerable::Missing {
                    what: "stiffness",
                    flag: "--tool and --object with materials, or --effective-modulus-pa",
                }
                .into());
            }
        };
        let law = shape.law(self.dimension(name, shape.dimension)?, modulus)?;
        let title = match (&self.tool, &self.object) {
            (Some(tool), Some(object)) => format!("{name}, {tool} on {object}"),
            _ => name.clone(),
        };
        Ok((title, Surface { law, rebound }, Some(modulus)))
    }

    /// The dimension that a shape needs.
    fn dimension(&self, shape: &str, needed: DimensionName) -> Result<f64, Unanswerable> {
        let given = [
            (DimensionName::RadiusM, self.radius_m, "--radius-m"),
            (DimensionName::SideM, self.side_m, "--side-m"),
            (
                DimensionName::HalfAngleRad,
                self.half_angle_rad,
                "--half-angle-rad",
            ),
        ];
        let mut flag = "";
        let mut found = None;
        for (name, value, flag_of) in given {
            if name == needed {
                (flag, found) = (flag_of, value);
            } else if value.is_some() {
                return Err(Unanswerable::Dimension {
                    shape: shape.to_owned(),
                    given: name,
                    needed,
                });
            }
        }
        found.ok_or(Unanswerable::Missing {
            what: "dimension of the shape",
            flag,
        })
    }

    /// The mass that strikes, kg.
    fn mass(&self) -> Result<f64> {
        let mass = self.mass_kg.ok_or(Unanswerable::Missing {
            what: "mass",
            flag: "--mass-kg",
        })?;
        if let Some(robot) = self.robot_mass_kg {
            return Ok(with_robot_kg(mass, robot)?);
        }
        let (Some(inertia), Some(centre), Some(tcp)) =
            (self.inertia_kg_m2, self.centre_of_mass_m, self.tcp_m)
        else {
            return Ok(MASS.check(mass)?);
        };
        let tool = ToolInertia::new(mass, inertia, centre)?;
        for coordinate in tcp {
            COORDINATE.check(coordinate)?;
        }
        Ok(tool.at_tcp_kg(tcp.into(), Vector3::z()))
    }
}

/// The paper's Table I: a flat punch of both set-ups, with the paper's round effective moduli.
fn table_1(library: &Library, args: &Args) -> Result<Vec<Question>> {
    let setups = [
        ("Fig. 1, steel on steel", 0.010, 100.0, 100e9),
        ("Fig. 6, steel on wood", 0.008, 4.0, 1e9),
    ];
    let question = |(name, radius_m, mass_kg, modulus): (&str, f64, f64, f64)| {
        Ok(args.further(Question {
            name: name.to_owned(),
            surface: Surface {
                law: library.shape("flat-punch")?.law(radius_m, modulus)?,
                rebound: Rebound::ELASTIC,
            },
            effective_modulus_pa: Some(modulus),
            effective_mass_kg: mass_kg,
            speed_m_per_s: 0.020,
            sampling_time_s: SAMPLING_TIME_S,
            controlled_peak_n: None,
            allowed_force_n: None,
            allowed_remaining_depth_m: None,
            transient: None,
        }))
    };
    setups.into_iter().map(question).collect()
}
