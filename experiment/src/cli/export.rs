//! `touchdown export`.

use super::analyse::conclude;
use super::{WrongUsage, print};
use anyhow::Result;
use experiment::export::{write_csv, write_mcap};
use experiment::log::Log;
use lcmtypes::Suffix;
use std::path::PathBuf;
use std::process::ExitCode;

/// An event log for other programs: MCAP with JSON, which Foxglove shows as it is, or CSV
#[derive(clap::Args)]
#[command(after_help = "\
Names are those of lcmtypes/types/*.lcm, with their units.

Exit codes:
  0  all of the log is written
  1  it can't be read or written, or part of it can't be used (what can is written all the same)
  2  wrong usage")]
pub(crate) struct Args {
    /// The log
    #[arg(value_name = "LOG")]
    log: PathBuf,
    /// What ends the names of the cell's channels in a log of the network
    #[arg(long, default_value_t, value_name = "SUFFIX")]
    suffix: Suffix,
    /// Write one MCAP file, with a JSON schema for each channel
    #[arg(long, value_name = "FILE")]
    mcap: Option<PathBuf>,
    /// Write a table for each channel, CHANNEL.csv, into a directory
    #[arg(long, value_name = "DIR")]
    csv: Option<PathBuf>,
}

pub(crate) fn run(args: &Args) -> Result<ExitCode> {
    if args.mcap.is_none() && args.csv.is_none() {
        return Err(WrongUsage("nothing to write; name --mcap FILE, --csv DIR or both".to_owned()).into());
    }
    let log = Log::of_cell(&args.log, &args.suffix)?;
    if let Some(file) = &args.mcap {
        write_mcap(&log, file)?;
        print(format_args!("{}\n", file.display()))?;
    }
    if let Some(directory) = &args.csv {
        for file in write_csv(&log, directory)? {
            print(format_args!("{}\n", file.display()))?;
        }
    }
    Ok(conclude(&log))
}
