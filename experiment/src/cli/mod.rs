//! The command line: one file per subcommand.

mod bench;
mod compare;
mod doctor;
mod run;

use anyhow::Result;
use clap::{Parser, Subcommand};
use experiment::scenarios::{Source, SourceError};
use node::scenario::{Scenario, ScenarioError};
use serde::Serialize;
use std::fmt::Display;
use std::io::{ErrorKind, Write, stderr, stdout};
use std::process::ExitCode;

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
    Compare(compare::Args),
    #[command(subcommand)]
    Bench(bench::Bench),
    Doctor(doctor::Args),
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
}

/// The program.
pub(crate) fn main() -> ExitCode {
    let cli = Cli::parse();
    node::shell::log_to_stderr();
    let outcome = match &cli.command {
        Command::Run(args) => run::run(args),
        Command::Compare(args) => compare::run(args),
        Command::Bench(bench) => bench::run(bench),
        Command::Doctor(args) => doctor::run(args),
    };
    outcome.unwrap_or_else(|error| {
        complain(format_args!("{error:#}"));
        let configuration = |cause: &(dyn std::error::Error + 'static)| {
            cause.is::<ScenarioError>() || cause.is::<SourceError>()
        };
        let wrong_usage = error.chain().any(configuration);
        ExitCode::from(if wrong_usage { WRONG_USAGE } else { FAILED })
    })
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

/// The hash of all resolved values as JSON carries it: 16 hexadecimal digits.
fn configuration_hash(scenario: &Scenario) -> String {
    format!("{:016x}", scenario.hash())
}
