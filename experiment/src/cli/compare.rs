//! `touchdown compare`.

use super::{
    FAILED, Header, ScenarioArgs, complain, distinct, print, print_json, progress_of_runs, threads, word,
};
use anyhow::Result;
use experiment::compare::{Comparison, Matrix};
use experiment::table::{MoreFigures, Table};
use experiment::tuning::{Gains, Tuned};
use serde::Serialize;
use std::path::PathBuf;
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
    /// Control laws: pd, pd-reset, literal, proposed, impedance, elastic, ros2, fzi
    #[arg(long, value_delimiter = ',', default_value = "pd,proposed")]
    laws: Vec<String>,
    /// Gains: the scenario's own (default), tuned ones; a row for each
    #[arg(long, value_delimiter = ',', default_value = "default", value_parser = ["default", "tuned"])]
    gains: Vec<String>,
    /// File of tuned gains, written by touchdown tune [default: those that come with the program]
    #[arg(long, value_name = "FILE")]
    tuned: Option<PathBuf>,
    /// Contact phases relative to the command period, spread evenly
    #[arg(long, default_value_t = 12, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1000))]
    phases: u16,
    /// Seeds for each contact phase, from timing.seed on
    #[arg(long, default_value_t = 3, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1000))]
    seeds: u16,
    /// Show all figures: a second table
    #[arg(long)]
    all_figures: bool,
    #[command(flatten)]
    threads: super::Threads,
    /// Print one JSON object instead of a table
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct Report<'a> {
    #[serde(flatten)]
    header: Header<'a>,
    phases: u16,
    seeds: u16,
    #[serde(flatten)]
    comparison: &'a Comparison,
}

#[cfg(test)]
impl Args {
    /// What it is about.
    pub(super) fn scenario(&self) -> &ScenarioArgs {
        &self.scenario
    }
}

pub(crate) fn run(args: &Args) -> Result<ExitCode> {
    distinct("--robots", &args.robots)?;
    distinct("--kinematics", &args.kinematics)?;
    distinct("--laws", &args.laws)?;
    distinct("--gains", &args.gains)?;
    let (source, scenario) = args.scenario.read()?;
    let gains = args.gains.iter().map(|word| match word.as_str() {
        "tuned" => Gains::Tuned,
        _ => Gains::Default,
    });
    let matrix = Matrix {
        robots: or_own(&args.robots, word(scenario.robot.gears)),
        kinematics: or_own(&args.kinematics, word(scenario.robot.kinematics)),
        laws: args.laws.clone(),
        gains: gains.collect(),
        phases: args.phases.into(),
        seeds: args.seeds.into(),
    };
    let tuned = tuned(args.tuned.as_deref())?;
    let progress = progress_of_runs(matrix.runs());
    let comparison = threads(&args.threads, || {
        matrix.run(&scenario, &tuned, || progress.inc(1))
    })??;
    progress.finish_and_clear();
    if args.json {
        print_json(&Report {
            header: Header::new("compare", &source, &scenario),
            phases: args.phases,
            seeds: args.seeds,
            comparison: &comparison,
        })?;
    } else if !comparison.rows.is_empty() {
        print(Table(&comparison.rows))?;
        if args.all_figures {
            print(format_args!("\n{}", MoreFigures(&comparison.rows)))?;
        }
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

/// The gains of `file`, or those that come with the program.
pub(crate) fn tuned(file: Option<&std::path::Path>) -> Result<Tuned> {
    Ok(match file {
        Some(file) => Tuned::load(file)?,
        None => Tuned::built_in()?,
    })
}
