//! `touchdown bench`.

use super::{Header, ScenarioArgs, cycle, detection, print, print_json};
use anyhow::Result;
use crossbeam::channel::Receiver;
use experiment::in_process::{self, Part};
use experiment::launch::{self, Plan, Wiring};
use experiment::run_port::RunPort;
use experiment::scenarios::Source;
use node::clock;
use rustix::time::{ClockId, clock_gettime};
use serde::Serialize;
use spatial::TICK_S;
use std::path::Path;
use std::process::ExitCode;
use std::time::Duration;

/// Measure how fast this machine is, and how well contacts are detected
#[derive(clap::Subcommand)]
pub(crate) enum Bench {
    Simulation(SimulationArgs),
    Controller(cycle::Args),
    Network(NetworkArgs),
    Detection(detection::Args),
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
}

pub(crate) fn run(bench: &Bench) -> Result<ExitCode> {
    match bench {
        Bench::Simulation(args) => simulation(args),
        Bench::Controller(args) => cycle::run(args),
        Bench::Network(args) => network(args),
        Bench::Detection(args) => detection::run(args),
    }
}

fn simulation(args: &SimulationArgs) -> Result<ExitCode> {
    let (source, scenario) = args.scenario.read()?;
    if cfg!(debug_assertions) {
        tracing::warn!("this is a debug build; `cargo build --release` gives the figures that count");
    }
    let ticks = scenario.timing.ticks();
    let mut said = Vec::new();
    in_process::run(&scenario, |tick| said.push(*tick));
    let rates_of = |run: &dyn Fn()| {
        let rate = |_| {
            let start_s = core_time_s();
            run();
            ticks as f64 / (core_time_s() - start_s)
        };
        let mut rates: Vec<f64> = (0..args.repetitions).map(rate).collect();
        rates.sort_by(f64::total_cmp);
        rates
    };
    let rates = rates_of(&|| in_process::run(&scenario, |_| ()));
    // Each part on what the others have said.
    let us_per_tick = |part: Part| 1e6 / median(&rates_of(&|| in_process::replay(part, &scenario, &said)));
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
    };
    if args.json {
        print_json(&report)?;
    } else {
        print(format_args!(
            "simulated, in process: {:.1} s in a second of one core ({:.1} to {:.1} s in {} runs of {} ticks), \
             {:.0} ticks/s; us per tick, each part alone: robot {:.2}, sensor {:.2}, controller {:.2}\n",
            report.simulated_s_per_core_s,
            report.simulated_s_per_core_s_min,
            report.simulated_s_per_core_s_max,
            report.repetitions,
            report.ticks,
            report.ticks_per_core_s,
            report.robot_us_per_tick,
            report.sensor_us_per_tick,
            report.controller_us_per_tick,
        ))?;
    }
    Ok(ExitCode::SUCCESS)
}

/// How many ticks of lockstep the three processes do over LCM in a second, against the loop in one process
#[derive(clap::Args)]
pub(crate) struct NetworkArgs {
    #[command(flatten)]
    scenario: ScenarioArgs,
    /// Runs that are timed
    #[arg(long, default_value_t = 3, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1000))]
    repetitions: u16,
    /// Print one JSON object instead of text
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct NetworkReport<'a> {
    #[serde(flatten)]
    header: Header<'a>,
    repetitions: u16,
    ticks: i64,
    lockstep_ticks_per_s: f64,
    lockstep_ticks_per_s_min: f64,
    lockstep_ticks_per_s_max: f64,
    in_process_ticks_per_s: f64,
    start_up_s: f64,
}

fn network(args: &NetworkArgs) -> Result<ExitCode> {
    let (source, scenario) = args.scenario.read()?;
    let stop = node::shell::signals()?;
    // For nothing but the runs' records.
    let directory = tempfile::tempdir()?;
    let (mut rates, start_up_s) = lockstep_rates(args, &source, directory.path(), &stop)?;
    rates.sort_by(f64::total_cmp);
    let started = clock::now();
    in_process::run(&scenario, |_| ());
    let in_process_s = (clock::now() - started).as_secs_f64();
    let report = NetworkReport {
        header: Header::new("bench network", &source, &scenario),
        repetitions: args.repetitions,
        ticks: scenario.timing.ticks(),
        lockstep_ticks_per_s: median(&rates),
        lockstep_ticks_per_s_min: rates[0],
        lockstep_ticks_per_s_max: rates[rates.len() - 1],
        in_process_ticks_per_s: scenario.timing.ticks() as f64 / in_process_s,
        start_up_s,
    };
    if args.json {
        print_json(&report)?;
    } else {
        print(format_args!(
            "lockstep, three processes over LCM: {:.0} ticks/s ({:.0} to {:.0} in {} runs of {} ticks), first tick \
             after {:.2} s; one process: {:.0} ticks/s\n",
            report.lockstep_ticks_per_s,
            report.lockstep_ticks_per_s_min,
            report.lockstep_ticks_per_s_max,
            report.repetitions,
            report.ticks,
            report.start_up_s,
            report.in_process_ticks_per_s,
        ))?;
    }
    Ok(ExitCode::SUCCESS)
}

/// Ticks per second of each run, from the first status with a tick to the last; and the last run's start-up, s.
fn lockstep_rates(
    args: &NetworkArgs,
    source: &Source,
    directory: &Path,
    stop: &Receiver<()>,
) -> Result<(Vec<f64>, f64)> {
    let file = directory.join("scenario.toml");
    std::fs::write(&file, &source.text)?;
    let port = RunPort::free(Duration::from_millis(200))?;
    let plan = Plan {
        programs: launch::programs()?,
        scenario: file,
        overrides: args.scenario.overrides.clone(),
        wiring: Wiring::shared(&port.device_url(), &port.simulation_url()),
        run_id: i64::from(std::process::id()),
        directory: directory.to_owned(),
        flags: Default::default(),
        through: Default::default(),
    };
    let (mut rates, mut start_up_s) = (Vec::new(), 0.0);
    for _ in 0..args.repetitions {
        let started = clock::now();
        let mut first = None;
        let mut last = (0, started);
        launch::run(&plan, stop, |tick| {
            if tick >= 0 {
                last = (tick, clock::now());
                first.get_or_insert(last);
            }
        })?;
        let (tick, at) = first.unwrap_or(last);
        start_up_s = (at - started).as_secs_f64();
        rates.push((last.0 - tick) as f64 / (last.1 - at).as_secs_f64());
    }
    Ok((rates, start_up_s))
}

fn median(sorted: &[f64]) -> f64 {
    (sorted[(sorted.len() - 1) / 2] + sorted[sorted.len() / 2]) / 2.0
}

/// What this thread has had of a core until now, s.
fn core_time_s() -> f64 {
    let time = clock_gettime(ClockId::ThreadCPUTime);
    time.tv_sec as f64 + 1e-9 * time.tv_nsec as f64
}
