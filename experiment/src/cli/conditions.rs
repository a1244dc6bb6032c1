//! `touchdown conditions`.

use super::{Header, ScenarioArgs, distinct, print, print_json, progress_of_runs, word};
use anyhow::Result;
use experiment::conditions::{ConditionRow, Plan, Report as Table, conditions};
use serde::Serialize;
use std::process::ExitCode;

/// Laws beside the lower bound, with gears that are not as assumed, other speeds, levers and periods, and lost messages
#[derive(clap::Args)]
pub(crate) struct Args {
    #[command(flatten)]
    scenario: ScenarioArgs,
    /// Control laws
    #[arg(long, value_delimiter = ',', default_value = "elastic,pd")]
    laws: Vec<String>,
    /// Contact phases relative to the command period, spread evenly
    #[arg(long, default_value_t = 12, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1000))]
    phases: u16,
    /// Seeds for each contact phase, from timing.seed on
    #[arg(long, default_value_t = 5, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1000))]
    seeds: u16,
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
    rows: &'a [ConditionRow],
}

pub(crate) fn run(args: &Args) -> Result<ExitCode> {
    distinct("--laws", &args.laws)?;
    let (source, scenario) = args.scenario.read()?;
    let plan = Plan {
        laws: args.laws.clone(),
        phases: args.phases.into(),
        seeds: args.seeds.into(),
    };
    let conditions = conditions(&scenario)?;
    let progress = progress_of_runs(plan.runs(&conditions));
    let rows = plan.run(&conditions, || progress.inc(1))?;
    progress.finish_and_clear();
    if args.json {
        print_json(&Report {
            header: Header::new("conditions", &source, &scenario),
            phases: args.phases,
            seeds: args.seeds,
            rows: &rows,
        })?;
    } else {
        let (robot, kinematics) = (word(scenario.robot.gears), word(scenario.robot.kinematics));
        let seed = scenario.timing.seed;
        print(format_args!(
            "{robot} {kinematics}: mean (worst) of {} runs each, contact phases {} x seeds {} from {seed} on\n\n{}\n",
            plan.phases * plan.seeds,
            plan.phases,
            plan.seeds,
            Table(&rows)
        ))?;
    }
    // A law that fails under a condition is a finding, and a row.
    Ok(ExitCode::SUCCESS)
}
