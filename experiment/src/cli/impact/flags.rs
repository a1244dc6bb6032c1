//! The flags of `touchdown impact`.

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
    pub(super) example: Option<Example>,

    /// Shape of the tool's tip (--list shows them)
    #[arg(long, value_name = "NAME", help_heading = "Contact")]
    pub(super) shape: Option<String>,
    /// Its radius
    #[arg(
        long,
        allow_negative_numbers = true,
        requires = "shape",
        help_heading = "Contact"
    )]
    pub(super) radius_m: Option<f64>,
    /// Its side
    #[arg(
        long,
        allow_negative_numbers = true,
        requires = "shape",
        help_heading = "Contact"
    )]
    pub(super) side_m: Option<f64>,
    /// Its angle between axis and flank
    #[arg(
        long,
        allow_negative_numbers = true,
        requires = "shape",
        help_heading = "Contact"
    )]
    pub(super) half_angle_rad: Option<f64>,
    /// Effective Young's modulus E* of tool and object
    #[arg(long, allow_negative_numbers = true, requires = "shape", conflicts_with_all = ["tool", "object"],
        help_heading = "Contact")]
    pub(super) effective_modulus_pa: Option<f64>,
    /// Material of the tool (--list shows them)
    #[arg(long, value_name = "MATERIAL", requires = "object", help_heading = "Contact")]
    pub(super) tool: Option<String>,
    /// Material of the object
    #[arg(long, value_name = "MATERIAL", requires = "tool", help_heading = "Contact")]
    pub(super) object: Option<String>,
    /// c_in itself, in N/m^n, instead of shape and materials
    #[arg(
        long = "indentation-n-per-m",
        id = "coefficient",
        value_name = "C_IN",
        allow_negative_numbers = true,
        conflicts_with = "shape",
        help_heading = "Contact"
    )]
    pub(super) coefficient: Option<f64>,
    /// n to it [default: 1]
    #[arg(
        long,
        value_name = "N",
        allow_negative_numbers = true,
        requires = "coefficient",
        help_heading = "Contact"
    )]
    pub(super) exponent: Option<f64>,
    /// c_re / c_in; 1 is elastic and the estimate of (18) [default: 1]
    #[arg(
        long,
        value_name = "RATIO",
        allow_negative_numbers = true,
        help_heading = "Contact"
    )]
    pub(super) rebound_ratio: Option<f64>,
    /// A TOML file with materials and shapes of your own
    #[arg(long, value_name = "FILE", help_heading = "Contact")]
    pub(super) materials: Option<PathBuf>,
    /// List materials and shapes with their sources
    #[arg(long, help_heading = "Contact")]
    pub(super) list: bool,

    /// Mass that strikes; with the next three, the tool's
    #[arg(long, allow_negative_numbers = true, help_heading = "Motion")]
    pub(super) mass_kg: Option<f64>,
    /// Principal moments of inertia: with them it is the effective mass at the tcp along z that strikes
    #[arg(long, value_name = "X,Y,Z", value_parser = coordinates, allow_negative_numbers = true,
        requires_all = ["mass_kg", "centre_of_mass_m", "tcp_m"], conflicts_with = "robot_mass_kg",
        help_heading = "Motion")]
    pub(super) inertia_kg_m2: Option<[f64; 3]>,
    /// Centre of mass, in the frame of the tcp's coordinates
    #[arg(
        long,
        value_name = "X,Y,Z",
        value_parser = coordinates,
        allow_negative_numbers = true,
        requires = "inertia_kg_m2",
        help_heading = "Motion"
    )]
    pub(super) centre_of_mass_m: Option<[f64; 3]>,
    /// Tool centre point
    #[arg(
        long,
        value_name = "X,Y,Z",
        value_parser = coordinates,
        allow_negative_numbers = true,
        requires = "inertia_kg_m2",
        help_heading = "Motion"
    )]
    pub(super) tcp_m: Option<[f64; 3]>,
    /// The robot's reflected mass along the normal, for a tool that is bolted to it without compliance: added
    #[arg(
        long,
        allow_negative_numbers = true,
        requires = "mass_kg",
        help_heading = "Motion"
    )]
    pub(super) robot_mass_kg: Option<f64>,
    /// Speed towards the object
    #[arg(long, allow_negative_numbers = true, help_heading = "Motion")]
    pub(super) speed_m_per_s: Option<f64>,

    /// How fast may it be for this force?
    #[arg(
        long,
        value_name = "FORCE_N",
        allow_negative_numbers = true,
        help_heading = "Limits"
    )]
    pub(super) allowed_force_n: Option<f64>,
    /// How fast may it be for this indentation to remain?
    #[arg(
        long,
        value_name = "DEPTH_M",
        allow_negative_numbers = true,
        help_heading = "Limits"
    )]
    pub(super) allowed_remaining_m: Option<f64>,
    /// Sampling time of the force control [default: 0.004, or the scenario's T]
    #[arg(long, allow_negative_numbers = true, help_heading = "Limits")]
    pub(super) sampling_time_s: Option<f64>,
    /// Peak of the controlled force, to compare with [default: the simulated one of a scenario]
    #[arg(
        long,
        value_name = "FORCE_N",
        allow_negative_numbers = true,
        help_heading = "Limits"
    )]
    pub(super) controlled_peak_n: Option<f64>,

    /// Effective mass of the body region, for v = F / sqrt(mu k)
    #[arg(
        long,
        allow_negative_numbers = true,
        requires = "body_stiffness_n_per_m",
        help_heading = "Transient contact with a person (an estimate, no certification)"
    )]
    pub(super) body_mass_kg: Option<f64>,
    /// Stiffness k of its contact
    #[arg(
        long,
        allow_negative_numbers = true,
        requires = "body_mass_kg",
        help_heading = "Transient contact with a person (an estimate, no certification)"
    )]
    pub(super) body_stiffness_n_per_m: Option<f64>,
    /// Force F that is allowed there
    #[arg(
        long,
        value_name = "FORCE_N",
        allow_negative_numbers = true,
        requires = "body_mass_kg",
        help_heading = "Transient contact with a person (an estimate, no certification)"
    )]
    pub(super) body_force_n: Option<f64>,
    /// Mass of the robot's moving parts: half of it strikes with the tool [default: the tool alone]
    #[arg(
        long,
        allow_negative_numbers = true,
        requires = "body_mass_kg",
        help_heading = "Transient contact with a person (an estimate, no certification)"
    )]
    pub(super) moving_mass_kg: Option<f64>,

    /// Draw force and depth over time and the peak over the speed into an SVG file
    #[arg(long, value_name = "FILE")]
    pub(super) figure: Option<PathBuf>,
    /// Print one JSON object instead of a table
    #[arg(long)]
    pub(super) json: bool,
}

#[derive(Clone, Copy, clap::ValueEnum)]
pub(crate) enum Example {
    /// Both set-ups of the paper's Table I
    #[value(name = "table-1")]
    Table1,
}

/// Three numbers, separated by commas.
fn coordinates(text: &str) -> Result<[f64; 3], String> {
    let numbers: Result<Vec<f64>, _> = text.split(',').map(|number| number.trim().parse()).collect();
    let three = numbers
        .ok()
        .and_then(|numbers| <[f64; 3]>::try_from(numbers).ok());
    three.ok_or_else(|| "give three numbers, separated by commas".to_owned())
}
