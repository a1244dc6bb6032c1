//! `touchdown calibrate`.

use super::{FAILED, Header, ScenarioArgs, complain, print, print_json, progress};
use anyhow::{Context, Result};
use experiment::calibrate::{self, Report, Value};
use experiment::launch::{self, Plan, Wiring};
use experiment::run_port::RunPort;
use experiment::scenarios::Source;
use serde::Serialize;
use std::collections::BTreeMap;
use std::fs;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Duration;

/// Learn compliances, mass, centre of mass and biases of sensor and tool, from rests in tilted orientations
#[derive(clap::Args)]
pub(crate) struct Args {
    #[command(flatten)]
    scenario: ScenarioArgs,
    /// File for what belongs into a scenario, as TOML, instead of printing it
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// UDP port of the run, which takes the next one too [default: a free one]
    #[arg(long)]
    port: Option<u16>,
    /// Print one JSON object instead of a table
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct Printed<'a> {
    #[serde(flatten)]
    header: Header<'a>,
    #[serde(flatten)]
    values: BTreeMap<&'static str, Value>,
    /// What the values rest on that was not measured.
    assumed: Option<&'a str>,
    /// What could not be learnt, and why.
    missing: Option<&'a str>,
}

/// How long a port is listened to before it is used.
const QUIET: Duration = Duration::from_millis(200);

pub(crate) fn run(args: &Args) -> Result<ExitCode> {
    let source = Source::find(&args.scenario.scenario)?;
    let read = |overrides: &[String]| source.scenario(overrides);
    let overrides = calibrate::overrides(&args.scenario.overrides, read)?;
    let scenario = read(&overrides)?;
    calibrate::check(&scenario)?;

    let stop = node::shell::signals()?;
    // For nothing but the run's records.
    let directory = tempfile::tempdir()?;
    let file = directory.path().join("scenario.toml");
    fs::write(&file, &source.text).with_context(|| format!("can't write {}", file.display()))?;
    let port = match args.port {
        Some(port) => RunPort::fixed(port, QUIET)?,
        None => RunPort::free(QUIET)?,
    };
    let plan = Plan {
        programs: launch::programs()?,
        scenario: file,
        overrides,
        wiring: Wiring::shared(&port.device_url(), &port.simulation_url()),
        run_id: i64::from(std::process::id()),
        directory: directory.path().to_owned(),
        flags: Default::default(),
        through: Default::default(),
    };
    let progress = progress("calibrate {bar:40} {pos}/{len} ticks", scenario.timing.ticks());
    let entries = launch::run(&plan, &stop, |tick| progress.set_position(tick.max(0) as u64))?;
    progress.finish_and_clear();
    let calibration = calibrate::from_transcript(&scenario, &entries)?;
    let report = Report::new(&calibration, &scenario.controller);

    if args.json {
        print_json(&Printed {
            header: Header::new("calibrate", &source, &scenario),
            values: report.values(),
            assumed: report.assumed.as_deref(),
            missing: report.missing.as_deref(),
        })?;
    } else {
        print(&report)?;
        if args.out.is_none() {
            print(format_args!("\n{}", report.to_toml()))?;
        }
    }
    // Last: what was learnt is not lost with a file that can't be written.
    if let Some(out) = &args.out {
        fs::write(out, report.to_toml()).with_context(|| format!("can't write {}", out.display()))?;
    }
    // What was learnt is printed all the same.
    match &report.missing {
        Some(missing) => {
            complain(missing);
            Ok(ExitCode::from(FAILED))
        }
        None => Ok(ExitCode::SUCCESS),
    }
}
