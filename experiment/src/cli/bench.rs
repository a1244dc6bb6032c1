//! `touchdown bench`.

use super::{
    Header, ScenarioArgs, Threads, bare, cycle, detection, growth, mujoco, network, nodes, print, print_json,
};
use anyhow::Result;
use experiment::cost::{self, Scaling, median};
use experiment::in_process::{self, Part};
use serde::Serialize;
use spatial::TICK_S;
use std::process::ExitCode;

/// Measure how fast this machine is, and how well contacts are detected
#[derive(clap::Subcommand)]
pub(crate) enum Bench {
    Simulation(SimulationArgs),
    Controller(cycle::Args),
    Network(network::Args),
    Nodes(nodes::Args),
    Growth(growth::Args),
    Mujoco(mujoco::Args),
    #[command(hide = true)]
    Bare(bare::Args),
    Detection(detection::Args),
}

/// How many seconds are simulated, in process, in a second of one core, and how a sweep's runs share the cores
#[derive(clap::Args)]
pub(crate) struct SimulationArgs {
    #[command(flatten)]
    scenario: ScenarioArgs,
    /// Runs that are timed, after one that is not
    #[arg(long, default_value_t = 5, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1000))]
    repetitions: u16,
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
    repetitions: u16,
    ticks: i64,
    simulated_s_per_core_s: f64,
    simulated_s_per_core_s_min: f64,
    simulated_s_per_core_s_max: f64,
    ticks_per_core_s: f64,
    robot_us_per_tick: f64,
    sensor_us_per_tick: f64,
    controller_us_per_tick: f64,
    sweep: Scaling,
}

pub(crate) fn run(bench: &Bench) -> Result<ExitCode> {
    let code = match bench {
        Bench::Simulation(args) => simulation(args),
        Bench::Controller(args) => cycle::run(args),
        Bench::Network(args) => network::run(args),
        Bench::Nodes(args) => nodes::run(args),
        Bench::Growth(args) => growth::run(args),
        Bench::Mujoco(args) => mujoco::run(args),
        Bench::Bare(args) => bare::run(args),
        Bench::Detection(args) => detection::run(args),
    }?;
    // What is counted is the same, and a bare process is no measurement of its own.
    let timed = !matches!(bench, Bench::Detection(_) | Bench::Bare(_));
    if timed && cfg!(debug_assertions) {
        tracing::warn!("this was a debug build; `cargo build --release` gives the figures that count");
    }
    Ok(code)
}

fn simulation(args: &SimulationArgs) -> Result<ExitCode> {
    let (source, scenario) = args.scenario.read()?;
    let cores = || std::thread::available_parallelism().map_or(1, usize::from);
    let threads = args.threads.threads.map_or_else(cores, usize::from);
    let ticks = scenario.timing.ticks();
    let mut said = Vec::new();
    in_process::run(&scenario, |tick| said.push(*tick));
    let rates = cost::ticks_per_core_s(ticks, args.repetitions, || in_process::run(&scenario, |_| ()));
    // Each part on what the others have said.
    let us_per_tick = |part: Part| 1e6 * cost::part_s_per_tick(part, &scenario, &said, args.repetitions);
    let median = median(&rates);
    let report = Report {
        header: Header::new("bench simulation", &source, &scenario),
        repetitions: args.repetitions,
        ticks,
        simulated_s_per_core_s: median * TICK_S,
        simulated_s_per_core_s_min: rates[0] * TICK_S,
        simulated_s_per_core_s_max: rates[rates.len() - 1] * TICK_S,
        ticks_per_core_s: median,
        robot_us_per_tick: us_per_tick(Part::Robot),
        sensor_us_per_tick: us_per_tick(Part::Sensor),
        controller_us_per_tick: us_per_tick(Part::Controller),
        sweep: cost::scaling(&scenario, threads, args.repetitions)?,
    };
    if args.json {
        print_json(&report)?;
    } else {
        print(format_args!(
            "{}: simulated, in process: {:.1} s in a second of one core ({:.1} to {:.1} s in {} runs of {} ticks), \
             {:.0} ticks/s; us per tick, each part alone: robot {:.2}, sensor {:.2}, controller {:.2}\n\
             a sweep's runs on {} threads: {:.2} times as fast as on one ({:.2} to {:.2}), {:.2} of linear\n",
            report.header.scenario,
            report.simulated_s_per_core_s,
            report.simulated_s_per_core_s_min,
            report.simulated_s_per_core_s_max,
            report.repetitions,
            report.ticks,
            report.ticks_per_core_s,
            report.robot_us_per_tick,
            report.sensor_us_per_tick,
            report.controller_us_per_tick,
            report.sweep.threads,
            report.sweep.speed_up,
            report.sweep.speed_up_min,
            report.sweep.speed_up_max,
            report.sweep.speed_up_per_core,
        ))?;
    }
    Ok(ExitCode::SUCCESS)
}
