//! The command line: one file per subcommand.

mod analyse;
mod bare;
mod bench;
mod bound;
mod calibrate;
mod compare;
mod conditions;
mod conform;
mod cycle;
mod detection;
mod doctor;
mod export;
mod free_motion;
mod growth;
mod impact;
mod keygen;
mod keys;
mod mujoco;
mod network;
mod nodes;
mod python;
mod replay;
mod report;
mod run;
mod spy;
mod sweep;
mod task;
mod tune;
mod up;
mod watch;

use anyhow::Result;
use clap::{Parser, Subcommand};
use controller::impact::ImpactError;
use experiment::bound::BoundError;
use experiment::impact::LibraryError;
use experiment::launch::LaunchError;
use experiment::report::ReportError;
pub(crate) use experiment::scenarios::word;
use experiment::scenarios::{Source, SourceError};
use experiment::sweep::SweepError;
use experiment::tuning::TuningError;
use experiment::up::UpError;
use experiment::wire_speed::Programs;
use impact::Unanswerable;
use indicatif::{ProgressBar, ProgressStyle};
use lcmtypes::LcmError;
use node::scenario::{Scenario, ScenarioError};
use serde::Serialize;
use std::fmt::Display;
use std::io::{ErrorKind, IsTerminal, Write, stderr, stdout};
use std::process::ExitCode;
use tempfile::TempDir;

/// The experiment, or what was checked, failed.
const FAILED: u8 = 1;
/// The command line or the configuration is wrong.
const WRONG_USAGE: u8 = 2;
/// A signal asked to end.
const INTERRUPTED: u8 = 130;

/// Contact force control for position-controlled robots: experiments and what they need.
#[derive(Parser)]
#[command(
    name = "touchdown",
    version,
    arg_required_else_help = true,
    after_help = "\
Exit codes:
  0    all is well
  1    the experiment or the check failed
  2    wrong usage or configuration
  130  interrupted"
)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    Run(run::Args),
    Up(up::Args),
    Task(task::Args),
    Keygen(keygen::Args),
    Analyse(analyse::Args),
    Replay(replay::Args),
    Watch(watch::Args),
    Spy(spy::Args),
    Export(export::Args),
    Compare(compare::Args),
    Tune(tune::Args),
    Sweep(sweep::Args),
    Report(report::Args),
    Calibrate(calibrate::Args),
    Impact(Box<impact::Args>),
    FreeMotion(free_motion::Args),
    Bound(bound::Args),
    Conditions(conditions::Args),
    #[command(subcommand)]
    Bench(bench::Bench),
    Doctor(doctor::Args),
    Conform(conform::Args),
    Keys(keys::Args),
}

/// A scenario as every subcommand takes it.
#[derive(clap::Args)]
struct ScenarioArgs {
    /// A built-in scenario by its name, or a file by its path (with a / or ending with .toml)
    #[arg(default_value = "paper")]
    scenario: String,
    /// Replaces a value of the scenario, such as task.desired_force_n=12 (repeatable)
    #[arg(long = "set", value_name = "KEY=VALUE")]
    overrides: Vec<String>,
}

impl ScenarioArgs {
    fn read(&self) -> Result<(Source, Scenario)> {
        let source = Source::find(&self.scenario)?;
        let scenario = source.scenario(&self.overrides)?;
        Ok((source, scenario))
    }

    /// The same for programs that are started: `source` as a file in a directory, which is removed when it is dropped.
    fn programs(&self, source: &Source) -> Result<(TempDir, Programs)> {
        let directory = tempfile::tempdir()?;
        let programs = Programs {
            scenario: directory.path().join("scenario.toml"),
            overrides: self.overrides.clone(),
        };
        std::fs::write(&programs.scenario, &source.text)?;
        Ok((directory, programs))
    }
}

/// What every JSON object about a scenario begins with.
#[derive(Serialize)]
struct Header<'a> {
    command: &'static str,
    scenario: &'a str,
    /// The hash of all resolved values: 16 hexadecimal digits.
    configuration_hash: String,
}

impl<'a> Header<'a> {
    fn new(command: &'static str, source: &'a Source, scenario: &Scenario) -> Self {
        Self {
            command,
            scenario: &source.name,
            configuration_hash: format!("{:016x}", scenario.hash()),
        }
    }
}

/// On how many threads to run.
#[derive(clap::Args)]
struct Threads {
    /// Threads to run on; the result is the same [default: one for each core]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
}

/// Run `work` on as many threads as were asked for.
fn threads<T: Send>(threads: &Threads, work: impl FnOnce() -> T + Send) -> Result<T> {
    let count = threads.threads.map_or(0, usize::from);
    Ok(rayon::ThreadPoolBuilder::new()
        .num_threads(count)
        .build()?
        .install(work))
}

/// A bar as `template` says over `steps` on a terminal, and nothing elsewhere.
fn progress(template: &str, steps: i64) -> ProgressBar {
    if !stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let style = ProgressStyle::with_template(template);
    ProgressBar::new(steps.max(0) as u64).with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
}

/// A bar over `runs`.
fn progress_of_runs(runs: usize) -> ProgressBar {
    progress("{bar:40} {pos}/{len} runs, {eta} left", runs as i64)
}

/// The program.
pub(crate) fn main() -> ExitCode {
    let cli = Cli::parse();
    node::shell::log_to_stderr();
    let outcome = match &cli.command {
        Command::Run(args) => run::run(args),
        Command::Up(args) => up::run(args),
        Command::Task(args) => task::run(args),
        Command::Keygen(args) => keygen::run(args),
        Command::Analyse(args) => analyse::run(args),
        Command::Replay(args) => replay::run(args),
        Command::Watch(args) => watch::run(args),
        Command::Spy(args) => spy::run(args),
        Command::Export(args) => export::run(args),
        Command::Compare(args) => compare::run(args),
        Command::Tune(args) => tune::run(args),
        Command::Sweep(args) => sweep::run(args),
        Command::Report(args) => report::run(args),
        Command::Calibrate(args) => calibrate::run(args),
        Command::Impact(args) => impact::run(args),
        Command::FreeMotion(args) => free_motion::run(args),
        Command::Bound(args) => bound::run(args),
        Command::Conditions(args) => conditions::run(args),
        Command::Bench(bench) => bench::run(bench),
        Command::Doctor(args) => doctor::run(args),
        Command::Conform(args) => conform::run(args),
        Command::Keys(args) => keys::run(args),
    };
    outcome.unwrap_or_else(|error| {
        if error
            .chain()
            .any(|cause| matches!(cause.downcast_ref(), Some(LaunchError::Interrupted)))
        {
            complain("interrupted; all nodes are stopped");
            return ExitCode::from(INTERRUPTED);
        }
        complain(node::shell::told(&error));
        let configuration = |cause: &(dyn std::error::Error + 'static)| {
            cause.is::<ScenarioError>()
                || cause.is::<SourceError>()
                || cause.is::<Twice>()
                || cause.is::<WrongUsage>()
                || matches!(cause.downcast_ref(), Some(LcmError::Url { .. }))
                || cause.is::<Unanswerable>()
                || cause.is::<LibraryError>()
                || cause.is::<ImpactError>()
                || cause.is::<TuningError>()
                || cause.is::<SweepError>()
                || cause.is::<BoundError>()
                || cause.is::<ReportError>()
                || cause.is::<UpError>()
        };
        let wrong_usage = error.chain().any(configuration);
        ExitCode::from(if wrong_usage { WRONG_USAGE } else { FAILED })
    })
}

/// Arguments that make no sense together.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
struct WrongUsage(String);

/// A list that names something twice.
#[derive(Debug, thiserror::Error)]
#[error("{flag} names {value:?} twice; name each once")]
struct Twice {
    flag: &'static str,
    value: String,
}

/// Refuse a list that names something twice.
fn distinct(flag: &'static str, values: &[String]) -> Result<(), Twice> {
    let twice = (1..values.len()).find(|&i| values[..i].contains(&values[i]));
    match twice.map(|i| values[i].clone()) {
        Some(value) => Err(Twice { flag, value }),
        None => Ok(()),
    }
}

/// An error on stderr.
fn complain(error: impl Display) {
    // Without stderr there is nobody left to tell.
    let _ = writeln!(stderr(), "error: {error}");
}

/// Data on stdout. A reader that has seen enough (`| head`) is no error.
fn print(data: impl Display) -> Result<()> {
    match write!(stdout(), "{data}").and_then(|()| stdout().flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => Err(error.into()),
        _ => Ok(()),
    }
}

/// One JSON object on stdout.
fn print_json(object: &impl Serialize) -> Result<()> {
    print(format_args!("{}\n", serde_json::to_string_pretty(object)?))
}
