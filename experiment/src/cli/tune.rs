//! `touchdown tune`.

use super::{Header, ScenarioArgs, Threads, distinct, print, print_json, progress_of_runs, threads, word};
use anyhow::{Context, Result};
use experiment::tuning::{Budget, Found, Tuned, parameters, tune};
use node::scenario::{Scenario, ScenarioError};
use serde::Serialize;
use std::fmt::Write;
use std::path::PathBuf;
use std::process::ExitCode;

/// Find gains for laws: by a stated criterion, within stated bounds, for a stated budget
#[derive(clap::Args)]
#[command(after_help = "\
Criterion, mean over the runs, smaller is better (no unit):
  IAE / (f_d 50 ms) + peak / (2 f_d) + set10 / 100 ms
A run that never settles counts its whole window of 1.5 s as set10; one that latches a fault counts 100.

Bounds: touchdown tune --bounds. Values are searched on logarithmic scales and kept to three digits.

Training and held-out runs have contact phases and seeds of their own, which touchdown compare does not use. Margins are
those of the linear loop, broken at the sensor.")]
pub(crate) struct Args {
    #[command(flatten)]
    scenario: ScenarioArgs,
    /// What joins motors and links: rigid, elastic [default: the scenario's]
    #[arg(long, value_delimiter = ',', value_name = "GEARS")]
    robots: Vec<String>,
    /// Kinematics: gantry, arm [default: the scenario's]
    #[arg(long, value_delimiter = ',')]
    kinematics: Vec<String>,
    /// Control laws; those without gains are passed over
    #[arg(
        long,
        value_delimiter = ',',
        default_value = "pd,pd-reset,proposed,impedance,ros2,fzi"
    )]
    laws: Vec<String>,
    /// Points tried for each law and robot
    #[arg(long, default_value_t = 120, value_name = "N", value_parser = clap::value_parser!(u16).range(4..=10_000))]
    evaluations: u16,
    /// Training runs of each point, each with a contact phase and a seed of its own; as many held-out runs
    #[arg(long, default_value_t = 8, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1000))]
    runs: u16,
    /// Shifts the points that the search begins with
    #[arg(long, default_value_t = 0, value_name = "N")]
    seed: u64,
    /// Put what was found into this file; what it has of other laws and robots stays
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Print the bounds of each law, and search nothing
    #[arg(long)]
    bounds: bool,
    #[command(flatten)]
    threads: Threads,
    /// Print one JSON object instead of text
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct Report<'a> {
    #[serde(flatten)]
    header: Header<'a>,
    evaluations: u16,
    runs: u16,
    seed: u64,
    found: &'a [Found],
}

pub(crate) fn run(args: &Args) -> Result<ExitCode> {
    distinct("--robots", &args.robots)?;
    distinct("--kinematics", &args.kinematics)?;
    distinct("--laws", &args.laws)?;
    let (source, scenario) = args.scenario.read()?;
    let plan = plan(args, &scenario)?;
    if args.bounds {
        return bounds(&plan);
    }
    // What is wrong with the file shows before the search.
    let mut tuned = match &args.out {
        Some(path) if path.exists() => Tuned::load(path)?,
        _ => Tuned::default(),
    };
    let budget = Budget {
        evaluations: args.evaluations.into(),
        runs: args.runs.into(),
        seed: args.seed,
    };
    let progress = progress_of_runs(plan.len() * budget.evaluations);
    let mut found = Vec::new();
    for (i, scenario) in plan.iter().enumerate() {
        progress.set_position((i * budget.evaluations) as u64);
        let result = threads(&args.threads, || {
            tune(&source.name, scenario, &budget, || progress.inc(1))
        })??;
        found.extend(result);
    }
    progress.finish_and_clear();
    if let Some(path) = &args.out {
        found.iter().for_each(|found| tuned.put(found.entry.clone()));
        std::fs::write(path, tuned.to_toml())
            .with_context(|| format!("the tuned gains {} can't be written", path.display()))?;
    }
    if args.json {
        print_json(&Report {
            header: Header::new("tune", &source, &scenario),
            evaluations: args.evaluations,
            runs: args.runs,
            seed: args.seed,
            found: &found,
        })?;
    } else {
        print(text(&found))?;
    }
    Ok(ExitCode::SUCCESS)
}

/// Every law on every robot.
fn plan(args: &Args, scenario: &Scenario) -> Result<Vec<Scenario>, ScenarioError> {
    let own = |given: &[String], own: String| {
        if given.is_empty() {
            vec![own]
        } else {
            given.to_vec()
        }
    };
    let mut plan = Vec::new();
    for robot in own(&args.robots, word(scenario.robot.gears)) {
        for kinematics in own(&args.kinematics, word(scenario.robot.kinematics)) {
            for law in &args.laws {
                let varied = scenario.with(&[
                    format!("robot.gears={robot}"),
                    format!("robot.kinematics={kinematics}"),
                    format!("controller.law={law}"),
                ])?;
                if !parameters(varied.controller.law).is_empty() {
                    plan.push(varied);
                }
            }
        }
    }
    Ok(plan)
}

fn bounds(plan: &[Scenario]) -> Result<ExitCode> {
    let mut text = String::new();
    for scenario in plan {
        for parameter in parameters(scenario.controller.law) {
            let law = experiment::tuning::law_word(scenario.controller.law);
            writeln!(
                text,
                "{law:9}  {:42}  {:e} to {:e}",
                parameter.key, parameter.low, parameter.high
            )?;
        }
    }
    print(text)?;
    Ok(ExitCode::SUCCESS)
}

fn text(found: &[Found]) -> String {
    let mut text = String::from(
        "robot    kinematics  law        default  tuned: training  held out  gain margin  phase margin deg  values\n",
    );
    for Found { entry, margins, .. } in found {
        let margin = |value: Option<f64>| value.map_or_else(|| "-".to_owned(), |value| format!("{value:.2}"));
        let degrees = margins.map(|margins| margins.phase_margin_rad.to_degrees());
        let values: Vec<_> = entry
            .values
            .iter()
            .map(|(key, value)| format!("{}={value:?}", key.rsplit('.').next().unwrap_or(key)))
            .collect();
        text += &format!(
            "{:7}  {:10}  {:9}  {:7.2}  {:15.2}  {:8.2}  {:>11}  {:>16}  {}\n",
            entry.robot,
            entry.kinematics,
            entry.law,
            entry.criterion_default,
            entry.criterion_training,
            entry.criterion_held_out,
            margin(entry.gain_margin),
            degrees.map_or_else(|| "-".to_owned(), |degrees| format!("{degrees:.0}")),
            values.join(" ")
        );
    }
    text
}
