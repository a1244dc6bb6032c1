//! `touchdown bench`.

use super::{ScenarioArgs, configuration_hash, print, print_json};
use anyhow::Result;
use experiment::in_process;
use rustix::time::{ClockId, clock_gettime};
use serde::Serialize;
use spatial::TICK_S;
use std::process::ExitCode;

/// Measure how fast this machine is
#[derive(clap::Subcommand)]
pub(crate) enum Bench {
    Simulation(SimulationArgs),
}

/// How many seconds are simulated, in process, in a second of one core
#[derive(clap::Args)]
pub(crate) struct SimulationArgs {
    #[command(flatten)]
    scenario: ScenarioArgs,
    /// Runs that are timed, after one that is not
    #[arg(long, default_value_t = 5, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1000))]
    repetitions: u16,
    /// Print one JSON object instead of text
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct Report<'a> {
    command: &'static str,
    scenario: &'a str,
    configuration_hash: String,
    repetitions: u16,
    ticks: i64,
    simulated_s_per_core_s: f64,
    simulated_s_per_core_s_min: f64,
    simulated_s_per_core_s_max: f64,
    ticks_per_core_s: f64,
}

pub(crate) fn run(bench: &Bench) -> Result<ExitCode> {
    match bench {
        Bench::Simulation(args) => simulation(args),
    }
}

fn simulation(args: &SimulationArgs) -> Result<ExitCode> {
    let (source, scenario) = args.scenario.read()?;
    if cfg!(debug_assertions) {
        tracing::warn!("this is a debug build; `cargo build --release` gives the figures that count");
    }
    let ticks = scenario.timing.ticks();
    in_process::run(&scenario, |_| ());
    let mut rates: Vec<f64> = (0..args.repetitions)
        .map(|_| {
            let start_s = core_time_s();
            in_process::run(&scenario, |_| ());
            ticks as f64 / (core_time_s() - start_s)
        })
        .collect();
    rates.sort_by(f64::total_cmp);
    let median = (rates[(rates.len() - 1) / 2] + rates[rates.len() / 2]) / 2.0;
    let report = Report {
        command: "bench simulation",
        scenario: &source.name,
        configuration_hash: configuration_hash(&scenario),
        repetitions: args.repetitions,
        ticks,
        simulated_s_per_core_s: median * TICK_S,
        simulated_s_per_core_s_min: rates[0] * TICK_S,
        simulated_s_per_core_s_max: rates[rates.len() - 1] * TICK_S,
        ticks_per_core_s: median,
    };
    if args.json {
        print_json(&report)?;
    } else {
        print(format_args!(
            "simulated, in process: {:.1} s in a second of one core ({:.1} to {:.1} s in {} runs of {} ticks), \
             {:.0} ticks/s\n",
            report.simulated_s_per_core_s,
            report.simulated_s_per_core_s_min,
            report.simulated_s_per_core_s_max,
            report.repetitions,
            report.ticks,
            report.ticks_per_core_s,
        ))?;
    }
    Ok(ExitCode::SUCCESS)
}

/// What this thread has had of a core until now, s.
fn core_time_s() -> f64 {
    let time = clock_gettime(ClockId::ThreadCPUTime);
    time.tv_sec as f64 + 1e-9 * time.tv_nsec as f64
}
