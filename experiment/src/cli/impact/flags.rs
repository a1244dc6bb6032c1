//! The flags of `touchdown impact`, and the question that they ask.

use anyhow::Result;
use controller::impact::effective_mass::with_robot_kg;
use controller::impact::quantity::{COORDINATE, MASS};
use controller::impact::{KicksLaw, Rebound, Surface, ToolInertia};
use experiment::impact::library::DimensionName;
use experiment::impact::{Library, Question, TransientQuestion};
use nalgebra::Vector3;
use std::path::PathBuf;

/// Assess an impact: peak force, depth and time of a tool that strikes an object, and how fast it may be
#[derive(clap::Args)]
#[command(
    arg_required_else_help = true,
    after_help = "\
Examples:
  touchdown impact --example table-1
  touchdown impact --shape flat-punch --radius-m 0.008 --mass-kg 4 --effective-modulus-pa 1e9 --speed-m-per-s 0.02
  touchdown impact --shape sphere --radius-m 0.005 --tool steel --object aluminium --rebound-ratio 4 \\
      --mass-kg 1.8 --speed-m-per-s 0.02 --allowed-force-n 100 --figure impact.svg
  touchdown impact --scenario arm"
)]
pub(crate) struct Args {
    /// Take everything from a scenario, and compare with its simulation
    #[arg(long, value_name = "NAME", conflicts_with_all = ["example", "shape", "coefficient", "mass_kg", "speed_m_per_s",
        "robot_mass_kg", "rebound_ratio"])]
    pub(super) scenario: Option<String>,
    /// Replaces a value of the scenario, such as task.approach_speed_m_per_s=0.05 (repeatable)
    #[arg(long = "set", value_name = "KEY=VALUE", requires = "scenario")]
    pub(super) overrides: Vec<String>,
    /// A worked example: table-1 of the paper
    #[arg(long, value_enum, conflicts_with_all = ["shape", "coefficient", "mass_kg", "speed_m_per_s", "robot_mass_kg",
        "rebound_ratio"])]
    example: Option<Example>,

    /// Shape of the tool's tip (--list shows them)
    #[arg(long, value_name = "NAME", help_heading = "Contact")]
    shape: Option<String>,
    /// Its radius
    #[arg(
        long,
        allow_negative_numbers = true,
        requires = "shape",
        help_heading = "Contact"
    )]
    radius_m: Option<f64>,
    /// Its side
    #[arg(
        long,
        allow_negative_numbers = true,
        requires = "shape",
        help_heading = "Contact"
    )]
    side_m: Option<f64>,
    /// Its angle between axis and flank
    #[arg(
        long,
        allow_negative_numbers = true,
        requires = "shape",
        help_heading = "Contact"
    )]
    half_angle_rad: Option<f64>,
    /// Effective Young's modulus E* of tool and object
    #[arg(long, allow_negative_numbers = true, requires = "shape", conflicts_with_all = ["tool", "object"],
        help_heading = "Contact")]
    effective_modulus_pa: Option<f64>,
    /// Material of the tool (--list shows them)
    #[arg(long, value_name = "MATERIAL", requires = "object", help_heading = "Contact")]
    tool: Option<String>,
    /// Material of the object
    #[arg(long, value_name = "MATERIAL", requires = "tool", help_heading = "Contact")]
    object: Option<String>,
    /// c_in itself, in N/m^n, instead of shape and materials
    #[arg(
        long = "indentation-n-per-m",
        id = "coefficient",
        value_name = "C_IN",
        allow_negative_numbers = true,
        conflicts_with = "shape",
        help_heading = "Contact"
    )]
    coefficient: Option<f64>,
    /// n to it [default: 1]
    #[arg(
        long,
        value_name = "N",
        allow_negative_numbers = true,
        requires = "coefficient",
        help_heading = "Contact"
    )]
    exponent: Option<f64>,
    /// c_re / c_in; 1 is elastic and the estimate of (18) [default: 1]
    #[arg(
        long,
        value_name = "RATIO",
        allow_negative_numbers = true,
        help_heading = "Contact"
    )]
    rebound_ratio: Option<f64>,
    /// A TOML file with materials and shapes of your own
    #[arg(long, value_name = "FILE", help_heading = "Contact")]
    pub(super) materials: Option<PathBuf>,
    /// List materials and shapes with their sources
    #[arg(long, help_heading = "Contact")]
    pub(super) list: bool,

    /// Mass that strikes; with the next three, the tool's
    #[arg(long, allow_negative_numbers = true, help_heading = "Motion")]
    mass_kg: Option<f64>,
    /// Principal moments of inertia: with them it is the effective mass at the tcp along z that strikes
    #[arg(long, value_name = "X,Y,Z", value_parser = coordinates, allow_negative_numbers = true,
        requires_all = ["mass_kg", "centre_of_mass_m", "tcp_m"], conflicts_with = "robot_mass_kg",
        help_heading = "Motion")]
    inertia_kg_m2: Option<[f64; 3]>,
    /// Centre of mass, in the frame of the tcp's coordinates
    #[arg(
        long,
        value_name = "X,Y,Z",
        value_parser = coordinates,
        allow_negative_numbers = true,
        requires = "inertia_kg_m2",
        help_heading = "Motion"
    )]
    centre_of_mass_m: Option<[f64; 3]>,
    /// Tool centre point
    #[arg(
        long,
        value_name = "X,Y,Z",
        value_parser = coordinates,
        allow_negative_numbers = true,
        requires = "inertia_kg_m2",
        help_heading = "Motion"
    )]
    tcp_m: Option<[f64; 3]>,
    /// The robot's reflected mass along the normal, for a tool that is bolted to it without compliance: added
    #[arg(
        long,
        allow_negative_numbers = true,
        requires = "mass_kg",
        help_heading = "Motion"
    )]
    robot_mass_kg: Option<f64>,
    /// Speed towards the object
    #[arg(long, allow_negative_numbers = true, help_heading = "Motion")]
    speed_m_per_s: Option<f64>,

    /// How fast may it be for this force?
    #[arg(
        long,
        value_name = "FORCE_N",
        allow_negative_numbers = true,
        help_heading = "Limits"
    )]
    allowed_force_n: Option<f64>,
    /// How fast may it be for this indentation to remain?
    #[arg(
        long,
        value_name = "DEPTH_M",
        allow_negative_numbers = true,
        help_heading = "Limits"
    )]
    allowed_remaining_m: Option<f64>,
    /// Sampling time of the force control [default: 0.004, or the scenario's T]
    #[arg(long, allow_negative_numbers = true, help_heading = "Limits")]
    sampling_time_s: Option<f64>,
    /// Peak of the controlled force, to compare with [default: the simulated one of a scenario]
    #[arg(
        long,
        value_name = "FORCE_N",
        allow_negative_numbers = true,
        help_heading = "Limits"
    )]
    controlled_peak_n: Option<f64>,

    /// Effective mass of the body region, for v = F / sqrt(mu k)
    #[arg(
        long,
        allow_negative_numbers = true,
        requires = "body_stiffness_n_per_m",
        help_heading = "Transient contact with a person (an estimate, no certification)"
    )]
    body_mass_kg: Option<f64>,
    /// Stiffness k of its contact
    #[arg(
        long,
        allow_negative_numbers = true,
        requires = "body_mass_kg",
        help_heading = "Transient contact with a person (an estimate, no certification)"
    )]
    body_stiffness_n_per_m: Option<f64>,
    /// Force F that is allowed there
    #[arg(
        long,
        value_name = "FORCE_N",
        allow_negative_numbers = true,
        requires = "body_mass_kg",
        help_heading = "Transient contact with a person (an estimate, no certification)"
    )]
    body_force_n: Option<f64>,
    /// Mass of the robot's moving parts: half of it strikes with the tool [default: the tool alone]
    #[arg(
        long,
        allow_negative_numbers = true,
        requires = "body_mass_kg",
        help_heading = "Transient contact with a person (an estimate, no certification)"
    )]
    moving_mass_kg: Option<f64>,

    /// Draw force and depth over time and the peak over the speed into an SVG file
    #[arg(long, value_name = "FILE")]
    pub(super) figure: Option<PathBuf>,
    /// Print one JSON object instead of a table
    #[arg(long)]
    pub(super) json: bool,
}

#[derive(Clone, Copy, clap::ValueEnum)]
enum Example {
    /// Both set-ups of the paper's Table I
    #[value(name = "table-1")]
    Table1,
}

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

/// Three numbers, separated by commas.
fn coordinates(text: &str) -> Result<[f64; 3], String> {
    let numbers: Result<Vec<f64>, _> = text.split(',').map(|number| number.trim().parse()).collect();
    let three = numbers
        .ok()
        .and_then(|numbers| <[f64; 3]>::try_from(numbers).ok());
    three.ok_or_else(|| "give three numbers, separated by commas".to_owned())
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
