//! `touchdown bench mujoco`.

use super::{Header, ScenarioArgs, print, print_json, python};
use anyhow::Result;
use experiment::mujoco::{Row, compare};
use serde::Serialize;
use std::path::PathBuf;
use std::process::ExitCode;

/// How fast the tool, its sensor and its contact are integrated, beside MuJoCo at equal accuracy
#[derive(clap::Args)]
pub(crate) struct Args {
    #[command(flatten)]
    scenario: ScenarioArgs,
    /// How often each is timed, in turns
    #[arg(long, default_value_t = 5, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1000))]
    repetitions: u16,
    /// A Python that has the package mujoco [default: python3]
    #[arg(long, value_name = "PATH")]
    python: Option<PathBuf>,
    /// Print one JSON object instead of a table
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct Report<'a> {
    #[serde(flatten)]
    header: Header<'a>,
    repetitions: u16,
    rows: &'a [Row],
}

pub(crate) fn run(args: &Args) -> Result<ExitCode> {
    let (source, scenario) = args.scenario.read()?;
    let python = python::with("mujoco", args.python.as_deref())?;
    let rows = compare(&python, &scenario, args.repetitions)?;
    if args.json {
        print_json(&Report {
            header: Header::new("bench mujoco", &source, &scenario),
            repetitions: args.repetitions,
            rows: &rows,
        })?;
        return Ok(ExitCode::SUCCESS);
    }
    let mut text = format!(
        "{}: the tool on its sensor, touched by an object, at equal accuracy (touchdown bench mujoco)\n\n\
         method                step us  error um  simulated s / core s  touchdown / it\n",
        source.name
    );
    for row in &rows {
        text += &format!(
            "{:20}  {:7.2}  {:8.3}  {:20.2}  {:14.1}\n",
            row.method,
            1e6 * row.step_s,
            1e6 * row.error_m,
            row.simulated_s_per_core_s,
            row.touchdown_ratio,
        );
    }
    print(text)?;
    Ok(ExitCode::SUCCESS)
}
