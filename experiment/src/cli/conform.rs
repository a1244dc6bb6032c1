//! `touchdown conform`.

use super::{FAILED, INTERRUPTED, complain, print, print_json};
use anyhow::Result;
use clap::Subcommand;
use experiment::conform::session::{self, ConformError, Options};
use experiment::conform::{Expectation, Finding, Table, Verdict, broken};
use node::key_file;
use node::scenario::Scenario;
use serde::Serialize;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Duration;

/// Check whether a robot's or a sensor's driver keeps the wire contract (lcmtypes/README.md) in real time, rule by rule
#[derive(clap::Args)]
pub(crate) struct Args {
    #[command(subcommand)]
    role: Role,
}

#[derive(Subcommand)]
enum Role {
    /// A robot; no controller may work beside. It is never enabled, unless --move asks for that
    Robot {
        #[command(flatten)]
        common: Common,
        /// Enable the robot: it is asked to stay where it stands, released, left alone until it latches
        /// FAULT_COMMAND_GAP, and reset
        #[arg(long = "move")]
        moved: bool,
        /// n_d of the robot: periods T from a command to its effect [default: 2]
        #[arg(long, value_name = "N", value_parser = clap::value_parser!(i64).range(0..=10))]
        delay_periods: Option<i64>,
        /// How long the robot waits beyond the end of the horizon, s [default: 0.02]
        #[arg(long, value_name = "S", value_parser = seconds)]
        command_gap_s: Option<f64>,
    },
    /// A sensor; beside a robot and a controller, or alone: who is missing is played
    Sensor {
        #[command(flatten)]
        common: Common,
    },
}

#[derive(clap::Args)]
struct Common {
    /// LCM URL of the device channels
    #[arg(long, default_value = "udpm://239.255.76.67:7667?ttl=0")]
    url: String,
    /// Sign with the key of the cell, and ask for signatures; of several the first signs
    #[arg(long, value_name = "FILE")]
    key: Vec<PathBuf>,
    /// How long to listen, s
    #[arg(long, default_value_t = 3.0, value_name = "S", value_parser = seconds)]
    listen_s: f64,
    /// Print one JSON object instead of a line per rule
    #[arg(long)]
    json: bool,
}

/// Seconds that a duration can be made of.
fn seconds(text: &str) -> Result<f64, String> {
    let value = text.parse().ok().filter(|value| (0.0..=600.0).contains(value));
    value.ok_or_else(|| format!("{text:?} is no number of seconds from 0 to 600"))
}

#[derive(Serialize)]
struct Report<'a> {
    command: &'static str,
    role: &'static str,
    url: &'a str,
    kept: usize,
    broken: usize,
    not_seen: usize,
    findings: &'a [Finding],
}

pub(crate) fn run(args: &Args) -> Result<ExitCode> {
    let usual = Scenario::default().robot;
    let (role, common, expectation) = match &args.role {
        Role::Robot {
            common,
            moved,
            delay_periods,
            command_gap_s,
        } => {
            let expectation = Expectation {
                delay_periods: delay_periods.unwrap_or(usual.command_delay_periods),
                command_gap_s: command_gap_s.unwrap_or(usual.command_gap_s),
                moved: *moved,
            };
            ("robot", common, expectation)
        }
        Role::Sensor { common } => {
            let (delay_periods, command_gap_s) = (usual.command_delay_periods, usual.command_gap_s);
            (
                "sensor",
                common,
                Expectation {
                    delay_periods,
                    command_gap_s,
                    moved: false,
                },
            )
        }
    };
    let options = Options {
        url: common.url.clone(),
        listen: Duration::from_secs_f64(common.listen_s),
        expectation,
        keys: key_file::read_all(&common.key)?,
    };
    let stop = node::shell::signals()?;
    let outcome = match &args.role {
        Role::Robot { .. } => session::robot(&options, stop),
        Role::Sensor { .. } => session::sensor(&options, stop),
    };
    let findings = match outcome {
        Err(error @ ConformError::Interrupted) => {
            complain(error);
            return Ok(ExitCode::from(INTERRUPTED));
        }
        outcome => outcome?,
    };
    if common.json {
        let count = |verdict| findings.iter().filter(|it| it.verdict == verdict).count();
        print_json(&Report {
            command: "conform",
            role,
            url: &common.url,
            kept: count(Verdict::Kept),
            broken: count(Verdict::Broken),
            not_seen: count(Verdict::NotSeen),
            findings: &findings,
        })?;
    } else {
        print(Table(&findings))?;
    }
    Ok(if broken(&findings) {
        ExitCode::from(FAILED)
    } else {
        ExitCode::SUCCESS
    })
}
