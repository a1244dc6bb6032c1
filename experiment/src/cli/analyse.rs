//! `touchdown analyse`, and how a command takes a log.

use super::{FAILED, WrongUsage, complain, print, print_json};
use anyhow::{Context, Result};
use experiment::analyse::{Analysis, Headline};
use experiment::log::{Log, sidecar};
use experiment::scenarios::Source;
use lcmtypes::Suffix;
use node::scenario::Scenario;
use serde::Serialize;
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// What an event log tells: figures, gaps, clock offsets, latencies; also of one recorded on real devices
#[derive(clap::Args)]
#[command(after_help = "\
Any LCM event log: of `touchdown run --record`, of a node's --record, of lcm-logger. Without SIM_TRUTH in it, the force is
what the controller measured (CONTROLLER_STATUS), else the deflection by the assumed compliance.

Exit codes:
  0  the log is whole, and tells all
  1  it can't be read, or part of it can't be used (what can is told all the same)
  2  wrong usage, or no scenario")]
pub(crate) struct Args {
    #[command(flatten)]
    log: LogArgs,
    /// Write report.html, which needs no network and prints on A4, and each figure as SVG into a directory
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Print one JSON object instead of text
    #[arg(long)]
    json: bool,
}

/// A log, and the scenario it was recorded with.
#[derive(clap::Args)]
pub(super) struct LogArgs {
    /// The log
    #[arg(value_name = "LOG")]
    log: PathBuf,
    /// What ends the names of the cell's channels in a log of the network
    #[arg(long, default_value_t, value_name = "SUFFIX")]
    suffix: Suffix,
    /// The scenario that it was recorded with [default: the file beside it, LOG with the ending .toml]
    #[arg(long, value_name = "SCENARIO")]
    scenario: Option<String>,
    /// Replaces a value of the scenario, such as timing.seed=2 (repeatable)
    #[arg(long = "set", value_name = "KEY=VALUE")]
    overrides: Vec<String>,
}

/// What is wrong with a log, for programs.
#[derive(Serialize)]
pub(super) struct Head<'a> {
    command: &'static str,
    log: &'a Path,
    scenario: &'a str,
    configuration_hash: String,
    complaints: Vec<String>,
    foreign_channels: Vec<&'a str>,
}

#[derive(Serialize)]
struct Report<'a> {
    #[serde(flatten)]
    head: Head<'a>,
    #[serde(flatten)]
    analysis: Value,
}

impl LogArgs {
    /// What can be read of it.
    pub(super) fn open(&self) -> Result<Log> {
        Ok(Log::of_cell(&self.log, &self.suffix)?)
    }

    /// Its scenario.
    pub(super) fn scenario(&self) -> Result<(Source, Scenario)> {
        let source = match &self.scenario {
            Some(name) => Source::find(name)?,
            None => {
                let beside = sidecar::path(&self.log);
                if !beside.exists() {
                    let text = format!(
                        "there is no {} beside the log; name the scenario that it was recorded with by --scenario",
                        beside.display()
                    );
                    return Err(WrongUsage(text).into());
                }
                Source::find(&beside.display().to_string())?
            }
        };
        let scenario = source.scenario(&self.overrides)?;
        Ok((source, scenario))
    }

    /// What every JSON object about a log begins with.
    pub(super) fn head<'a>(
        &'a self,
        command: &'static str,
        log: &'a Log,
        (source, scenario): &'a (Source, Scenario),
    ) -> Head<'a> {
        Head {
            command,
            log: &self.log,
            scenario: &source.name,
            configuration_hash: format!("{:016x}", scenario.hash()),
            complaints: log.complaints(),
            foreign_channels: log.foreign.keys().map(String::as_str).collect(),
        }
    }
}

/// Tell what is wrong with a log, last; the exit code for it.
pub(super) fn conclude(log: &Log) -> ExitCode {
    let complaints = log.complaints();
    complaints.iter().for_each(complain);
    match complaints.is_empty() {
        true => ExitCode::SUCCESS,
        false => ExitCode::from(FAILED),
    }
}

/// Say what a log has beside what can be used.
pub(super) fn warn(log: &Log, scenario: &Scenario, analysis: &Analysis) {
    if !log.foreign.is_empty() {
        let names: Vec<_> = log.foreign.keys().map(String::as_str).collect();
        tracing::warn!(
            "channels that are not Touchdown's are left out: {}",
            names.join(", ")
        );
    }
    if let Some(found) = analysis.other_configuration {
        tracing::warn!(
            "the nodes ran with the configuration {found:016x}, the scenario's is {:016x}: name the one that was \
             recorded (--scenario, --set)",
            scenario.hash()
        );
    }
}

pub(crate) fn run(args: &Args) -> Result<ExitCode> {
    let log = args.log.open()?;
    let of = args.log.scenario()?;
    let analysis = Analysis::new(&of.1, &log);
    warn(&log, &of.1, &analysis);
    if args.json {
        print_json(&Report {
            head: args.log.head("analyse", &log, &of),
            analysis: analysis.json(),
        })?;
    } else {
        print(analysis.text(&of.1))?;
    }
    if let Some(out) = &args.out {
        write_report(&analysis, &of, &log, out)?;
    }
    Ok(conclude(&log))
}

fn write_report(
    analysis: &Analysis,
    (source, scenario): &(Source, Scenario),
    log: &Log,
    out: &Path,
) -> Result<()> {
    fs::create_dir_all(out).with_context(|| format!("can't create {}", out.display()))?;
    let write = |name: String, text: &str| {
        let path = out.join(name);
        fs::write(&path, text).with_context(|| format!("can't write {}", path.display()))
    };
    let headline = Headline {
        scenario: &source.name,
        log: log.path.display().to_string(),
        complaints: log.complaints(),
    };
    write("report.html".to_owned(), &analysis.html(scenario, &headline))?;
    for figure in analysis.figures(scenario) {
        write(format!("{}.svg", figure.name), &figure.svg)?;
    }
    Ok(())
}
