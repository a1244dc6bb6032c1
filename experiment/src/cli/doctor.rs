//! `touchdown doctor`.

use super::{print, print_json};
use anyhow::Result;
use experiment::doctor::{Finding, Options, Table, examine, exit_code};
use serde::Serialize;
use std::process::ExitCode;

/// Examine whether this host is fit for LCM over UDP multicast; each finding with the command that mends it
#[derive(clap::Args)]
pub(crate) struct Args {
    /// Print one JSON object instead of text
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct Report<'a> {
    command: &'static str,
    findings: &'a [Finding],
}

pub(crate) fn run(args: &Args) -> Result<ExitCode> {
    let findings = examine(&Options::default());
    if args.json {
        print_json(&Report {
            command: "doctor",
            findings: &findings,
        })?;
    } else {
        print(Table(&findings))?;
    }
    Ok(ExitCode::from(exit_code(&findings)))
}
