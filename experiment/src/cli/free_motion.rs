//! `touchdown free-motion`.

use super::{Header, ScenarioArgs, print, print_json};
use anyhow::Result;
use experiment::free_motion::{FreeMotion, Table, Way, measure};
use node::scenario::Profile;
use serde::Serialize;
use std::process::ExitCode;

/// Move the tool from rest to rest with nothing in its way, shaped and as a trapezoid: what is left swinging
#[derive(clap::Args)]
pub(crate) struct Args {
    #[command(flatten)]
    scenario: ScenarioArgs,
    /// Length of the way, m, downwards
    #[arg(long, default_value_t = 0.15, value_name = "M", value_parser = metres)]
    length: f64,
    /// Speed, m/s
    #[arg(long, default_value_t = 0.25, value_name = "M_PER_S", value_parser = metres)]
    speed: f64,
    /// Multiples of the frequencies of tool and gears that the controller assumes instead
    #[arg(long, value_delimiter = ',', default_value = "0.9,1,1.1", value_name = "RATIOS", value_parser = ratio)]
    assumed: Vec<f64>,
    /// Print one JSON object instead of a table
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct Report<'a> {
    #[serde(flatten)]
    header: Header<'a>,
    length_m: f64,
    speed_m_per_s: f64,
    acceleration_m_per_s2: f64,
    rows: &'a [FreeMotion],
}

pub(crate) fn run(args: &Args) -> Result<ExitCode> {
    let (source, scenario) = args.scenario.read()?;
    let way = Way {
        length_m: args.length,
        speed_m_per_s: args.speed,
    };
    let mut rows = vec![measure(&scenario, way, Profile::Trapezoid, 1.0)?];
    for ratio in &args.assumed {
        rows.push(measure(&scenario, way, Profile::Smooth, *ratio)?);
    }
    let acceleration_m_per_s2 = scenario.controller.shaping.acceleration_m_per_s2;
    if args.json {
        print_json(&Report {
            header: Header::new("free-motion", &source, &scenario),
            length_m: way.length_m,
            speed_m_per_s: way.speed_m_per_s,
            acceleration_m_per_s2,
            rows: &rows,
        })?;
    } else {
        let robot = format!("{:?} {:?}", scenario.robot.gears, scenario.robot.kinematics).to_lowercase();
        print(format_args!(
            "{robot}: {} mm with {} mm/s and {acceleration_m_per_s2} m/s^2\n{}\n",
            1e3 * way.length_m,
            1e3 * way.speed_m_per_s,
            Table(&rows)
        ))?;
    }
    Ok(ExitCode::SUCCESS)
}

fn metres(text: &str) -> Result<f64, String> {
    bounded(text, 1e-3..=1.0)
}

fn ratio(text: &str) -> Result<f64, String> {
    bounded(text, 0.5..=2.0)
}

fn bounded(text: &str, limits: std::ops::RangeInclusive<f64>) -> Result<f64, String> {
    let value: f64 = text.parse().map_err(|_| format!("{text:?} is no number"))?;
    if limits.contains(&value) {
        Ok(value)
    } else {
        Err(format!(
            "{value} is outside {} to {}",
            limits.start(),
            limits.end()
        ))
    }
}
