//! `touchdown bound`.

use super::{Header, ScenarioArgs, print, print_json, word};
use anyhow::Result;
use experiment::bound::{Bound, bound};
use serde::Serialize;
use std::process::ExitCode;

/// What no controller can beat, even with a perfect model: peak, settling and IAE by linear programmes
#[derive(clap::Args)]
pub(crate) struct Args {
    #[command(flatten)]
    scenario: ScenarioArgs,
    /// Print one JSON object instead of a table
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct Report<'a> {
    #[serde(flatten)]
    header: Header<'a>,
    robot: String,
    kinematics: String,
    #[serde(flatten)]
    bound: &'a Bound,
}

pub(crate) fn run(args: &Args) -> Result<ExitCode> {
    let (source, scenario) = args.scenario.read()?;
    let bound = bound(&scenario)?;
    let (robot, kinematics) = (word(scenario.robot.gears), word(scenario.robot.kinematics));
    if args.json {
        print_json(&Report {
            header: Header::new("bound", &source, &scenario),
            robot,
            kinematics,
            bound: &bound,
        })?;
    } else {
        let task = &scenario.task;
        print(format_args!(
            "{robot} {kinematics}: {} N at {} mm/s, T = {} ms\n{bound}",
            task.desired_force_n,
            1e3 * task.approach_speed_m_per_s,
            scenario.timing.command_period_ticks,
        ))?;
    }
    Ok(ExitCode::SUCCESS)
}
