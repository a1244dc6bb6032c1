//! `touchdown keygen`: a new key for a cell.

use super::{print, print_json};
use anyhow::Result;
use node::key_file;
use serde::Serialize;
use std::path::PathBuf;
use std::process::ExitCode;

/// Write a new key for a cell: its nodes (--key FILE) take nothing that is not signed with it
#[derive(clap::Args)]
#[command(after_help = "\
The file has 32 random bytes and mode 0600; a node refuses one that others can read, or that belongs to another user. Copy it to
all hosts of the cell, over a channel that nobody reads. Everyone who has it can command the robot.

To change the key without stopping the cell: give all nodes, one after another, --key OLD --key NEW, then --key NEW --key OLD, then
--key NEW.

Exit codes:
  0  written
  1  not written; a file that is there is never overwritten
  2  wrong usage")]
pub(crate) struct Args {
    /// The file
    file: PathBuf,
    /// Print one JSON object instead of a line
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct Report<'a> {
    command: &'static str,
    file: &'a std::path::Path,
    key_id: String,
}

pub(crate) fn run(args: &Args) -> Result<ExitCode> {
    let key = key_file::create(&args.file)?;
    let (file, key_id) = (args.file.as_path(), format!("{:08x}", key.id()));
    if args.json {
        let command = "keygen";
        print_json(&Report {
            command,
            file,
            key_id,
        })?;
    } else {
        print(format_args!("key {key_id}: {}\n", file.display()))?;
    }
    Ok(ExitCode::SUCCESS)
}
