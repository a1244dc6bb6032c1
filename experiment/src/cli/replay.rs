//! `touchdown replay`.

use super::analyse::{Head, LogArgs, conclude};
use super::{FAILED, complain, print, print_json};
use anyhow::Result;
use experiment::replay::{Difference, replay};
use serde::Serialize;
use std::process::ExitCode;

/// The controller once more on what it has heard: are its commands and statuses the same, bit for bit?
#[derive(clap::Args)]
#[command(after_help = "\
In lockstep any log will do that begins with the run. In real time it takes the controller's own record, which has what each
cycle had heard (HEARD_*): `touchdown run --record`, or the controller's --record.

Exit codes:
  0  all is equal
  1  there is a difference, or the log can't be replayed to its end
  2  wrong usage, or no scenario")]
pub(crate) struct Args {
    #[command(flatten)]
    log: LogArgs,
    /// Print one JSON object instead of text
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct Report<'a> {
    #[serde(flatten)]
    head: Head<'a>,
    equal_commands: usize,
    equal_statuses: usize,
    difference: Option<Difference>,
    stopped: Option<String>,
}

pub(crate) fn run(args: &Args) -> Result<ExitCode> {
    let log = args.log.open()?;
    let of = args.log.scenario()?;
    let found = replay(&of.1, &log)?;
    let (commands, statuses) = (found.commands, found.statuses);
    if args.json {
        print_json(&Report {
            head: args.log.head("replay", &log, &of),
            equal_commands: commands,
            equal_statuses: statuses,
            difference: found.difference.clone(),
            stopped: found.stopped.clone(),
        })?;
    } else {
        let until = if found.difference.is_some() {
            " before the first difference"
        } else {
            ""
        };
        print(format_args!(
            "{commands} commands and {statuses} statuses equal{until}\n"
        ))?;
    }
    let concluded = conclude(&log);
    let mut well = true;
    for trouble in found
        .difference
        .iter()
        .map(ToString::to_string)
        .chain(found.stopped)
    {
        well = false;
        complain(trouble);
    }
    Ok(if well { concluded } else { ExitCode::from(FAILED) })
}
