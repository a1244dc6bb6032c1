//! `touchdown compare`.

use super::{FAILED, ScenarioArgs, complain, configuration_hash, distinct, print, print_json, word};
use anyhow::Result;
use experiment::compare::{Comparison, Matrix};
use experiment::table::Table;
use indicatif::{ProgressBar, ProgressStyle};
use serde::Serialize;
use std::io::{IsTerminal, stderr};
use std::process::ExitCode;

/// Compare laws over contact phases and seeds, in process and on all cores
#[derive(clap::Args)]
pub(crate) struct Args {
    #[command(flatten)]
    scenario: ScenarioArgs,
    /// What joins motors and links: rigid, elastic [default: the scenario's]
    #[arg(long, value_delimiter = ',', value_name = "GEARS")]
    robots: Vec<String>,
    /// Kinematics: gantry, arm [default: the scenario's]
    #[arg(long, value_delimiter = ',')]
    kinematics: Vec<String>,
    /// Control laws: pd, pd-reset, literal, proposed, impedance
    #[arg(long, value_delimiter = ',', default_value = "pd,proposed")]
    laws: Vec<String>,
    /// Contact phases relative to the command period, spread evenly
    #[arg(long, default_value_t = 12, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1000))]
    phases: u16,
    /// Seeds for each contact phase, from timing.seed on
    #[arg(long, default_value_t = 3, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1000))]
    seeds: u16,
    /// Print one JSON object instead of a table
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct Report<'a> {
    command: &'static str,
    scenario: &'a str,
    configuration_hash: String,
    phases: u16,
    seeds: u16,
    #[serde(flatten)]
    comparison: &'a Comparison,
}

pub(crate) fn run(args: &Args) -> Result<ExitCode> {
    distinct("--robots", &args.robots)?;
    distinct("--kinematics", &args.kinematics)?;
    distinct("--laws", &args.laws)?;
    let (source, scenario) = args.scenario.read()?;
    let matrix = Matrix {
        robots: or_own(&args.robots, word(scenario.robot.gears)),
        kinematics: or_own(&args.kinematics, word(scenario.robot.kinematics)),
        laws: args.laws.clone(),
        phases: args.phases.into(),
        seeds: args.seeds.into(),
    };
    let progress = progress(matrix.runs());
    let comparison = matrix.run(&scenario, || progress.inc(1))?;
    progress.finish_and_clear();
    if args.json {
        print_json(&Report {
            command: "compare",
            scenario: &source.name,
            configuration_hash: configuration_hash(&scenario),
            phases: args.phases,
            seeds: args.seeds,
            comparison: &comparison,
        })?;
    } else if !comparison.rows.is_empty() {
        print(Table(&comparison.rows))?;
        print(caption(args))?;
    }
    comparison.failures.iter().for_each(complain);
    Ok(ExitCode::from(if comparison.failures.is_empty() {
        0
    } else {
        FAILED
    }))
}

/// `given`, or the scenario's `own` where nothing is.
fn or_own(given: &[String], own: String) -> Vec<String> {
    if given.is_empty() {
        vec![own]
    } else {
        given.to_vec()
    }
}

fn caption(args: &Args) -> String {
    match u32::from(args.phases) * u32::from(args.seeds) {
        1 => String::new(),
        runs => format!(
            "\nmean (worst) of {runs} runs each: contact phases {} x seeds {}\n",
            args.phases, args.seeds
        ),
    }
}

/// On a terminal, and nowhere else.
pub(super) fn progress(runs: usize) -> ProgressBar {
    if !stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let style = ProgressStyle::with_template("{bar:40} {pos}/{len} runs, {eta} left");
    ProgressBar::new(runs as u64).with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
}
