//! `touchdown run`.

use super::{INTERRUPTED, ScenarioArgs, configuration_hash, print, print_json};
use anyhow::{Context, Result, bail};
use crossbeam::channel::Receiver;
use experiment::figure::{LabelledCurve, force_figure};
use experiment::launch::{self, LaunchError, Plan, Wiring};
use experiment::metrics::{Recording, WINDOW_S};
use experiment::run_port::RunPort;
use experiment::table::{Row, Table};
use experiment::transcript;
use indicatif::{ProgressBar, ProgressStyle};
use node::scenario::Scenario;
use serde::Serialize;
use std::fs;
use std::io::{IsTerminal, stderr};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Duration;

/// Run an experiment as three processes that talk over LCM: table, figure and recorded data
#[derive(clap::Args)]
pub(crate) struct Args {
    #[command(flatten)]
    scenario: ScenarioArgs,
    /// Control laws, one run each
    #[arg(long, value_delimiter = ',', default_value = "pd,proposed")]
    laws: Vec<String>,
    /// Directory for figure and data
    #[arg(long, default_value = "touchdown-out", value_name = "DIR")]
    out: PathBuf,
    /// UDP port of the run, which takes the next one too [default: a free one]
    #[arg(long)]
    port: Option<u16>,
    /// Seed of every random stream, instead of timing.seed
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(i64).range(0..))]
    seed: Option<i64>,
    /// Print one JSON object instead of a table
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct Report<'a> {
    command: &'static str,
    scenario: &'a str,
    configuration_hash: String,
    seed: i64,
    out: &'a Path,
    rows: Vec<Row>,
}

/// How long a port is listened to before it is used.
const QUIET: Duration = Duration::from_millis(200);

pub(crate) fn run(args: &Args) -> Result<ExitCode> {
    let (source, scenario) = args.scenario.read()?;
    let mut overrides = args.scenario.overrides.clone();
    overrides.extend(args.seed.map(|seed| format!("timing.seed={seed}")));
    let runs = args.laws.iter().map(|law| {
        let mut overrides = overrides.clone();
        overrides.push(format!("controller.law={law}"));
        Ok((law.as_str(), source.scenario(&overrides)?, overrides))
    });
    let runs: Vec<_> = runs.collect::<Result<_>>()?;

    let stop = node::shell::signals()?;
    fs::create_dir_all(&args.out)
        .with_context(|| format!("can't create the directory {}", args.out.display()))?;
    let file = args.out.join("scenario.toml");
    fs::write(&file, &source.text).with_context(|| format!("can't write {}", file.display()))?;
    let port = match args.port {
        Some(port) => RunPort::fixed(port, QUIET)?,
        None => RunPort::free(QUIET)?,
    };

    let (mut rows, mut curves) = (Vec::new(), Vec::new());
    for (law, scenario, overrides) in runs {
        let plan = Plan {
            programs: launch::programs()?,
            scenario: file.clone(),
            overrides,
            wiring: Wiring::shared(&port.device_url(), &port.simulation_url()),
            run_id: i64::from(std::process::id()),
            directory: args.out.clone(),
        };
        match experiment_of(law, &scenario, &plan, &stop) {
            Ok((row, curve)) => {
                rows.push(row);
                curves.push(curve);
            }
            Err(error) if matches!(error.downcast_ref(), Some(LaunchError::Interrupted)) => {
                super::complain("interrupted; all nodes are stopped");
                return Ok(ExitCode::from(INTERRUPTED));
            }
            Err(error) => return Err(error),
        }
    }
    let figure = args.out.join("force.svg");
    force_figure(&curves, &figure)?;

    if args.json {
        print_json(&Report {
            command: "run",
            scenario: &source.name,
            configuration_hash: configuration_hash(&scenario),
            seed: args.seed.unwrap_or(scenario.timing.seed),
            out: &args.out,
            rows,
        })?;
    } else {
        print(Table(&rows))?;
        let data = |law: &String| format!("{0}.lcmlog, {0}.csv", args.out.join(law).display());
        let data: Vec<_> = args.laws.iter().map(data).collect();
        print(format_args!(
            "\nfigure: {}\ndata:   {}\n",
            figure.display(),
            data.join(", ")
        ))?;
    }
    Ok(ExitCode::SUCCESS)
}

/// One run with one law: its records are written, its figures returned.
fn experiment_of(
    law: &str,
    scenario: &Scenario,
    plan: &Plan,
    stop: &Receiver<()>,
) -> Result<(Row, LabelledCurve)> {
    let progress = progress(law, scenario.timing.ticks());
    let entries = launch::run(plan, stop, |tick| progress.set_position(tick.max(0) as u64))?;
    progress.finish_and_clear();
    transcript::write_log(&plan.directory.join(format!("{law}.lcmlog")), &entries)?;
    let (recording, measured) = Recording::from_transcript(scenario, &entries);
    let csv = plan.directory.join(format!("{law}.csv"));
    fs::write(&csv, recording.csv()).with_context(|| format!("can't write {}", csv.display()))?;
    let Some(curve) = measured.and_then(|measured| LabelledCurve::new(law, scenario, &recording, measured))
    else {
        bail!(
            "law {law}: no contact, or less than {WINDOW_S} s after it, within {} s; raise timing.duration_s or \
             task.search_depth_m; the data are in {}",
            scenario.timing.duration_s,
            plan.directory.display()
        );
    };
    let (gears, kinematics) = (word(scenario.robot.gears), word(scenario.robot.kinematics));
    Ok((Row::single(&gears, &kinematics, law, curve.metrics), curve))
}

/// A choice as the scenario spells it: `Rigid` is `rigid`.
fn word(choice: impl std::fmt::Debug) -> String {
    format!("{choice:?}").to_lowercase()
}

/// On a terminal, and nowhere else.
fn progress(law: &str, ticks: i64) -> ProgressBar {
    if !stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let style = ProgressStyle::with_template("{msg:10} {bar:40} {pos}/{len} ticks");
    ProgressBar::new(ticks.max(0) as u64)
        .with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
        .with_message(law.to_owned())
}
