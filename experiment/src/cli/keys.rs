//! `touchdown keys`: the reference of all keys of a scenario.

use super::{WrongUsage, print, print_json};
use anyhow::Result;
use experiment::keys::{Entry, Markdown, Text, entries};
use serde::Serialize;
use std::process::ExitCode;

/// Every key of a scenario with unit, limits, default and meaning
#[derive(clap::Args)]
pub(crate) struct Args {
    /// Only keys with this word in their name or meaning, such as `threshold` or `controller.pd`
    #[arg(default_value = "", hide_default_value = true)]
    word: String,
    /// Print all of them as docs/configuration.md has them
    #[arg(long, conflicts_with_all = ["word", "json"])]
    markdown: bool,
    /// Print one JSON object instead of text
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct Report {
    command: &'static str,
    keys: Vec<Entry>,
}

pub(crate) fn run(args: &Args) -> Result<ExitCode> {
    let keys = entries(&args.word);
    if keys.is_empty() {
        let text = format!(
            "no key has {:?} in its name or meaning; `touchdown keys` lists all",
            args.word
        );
        return Err(WrongUsage(text).into());
    }
    match (args.json, args.markdown) {
        (true, _) => print_json(&Report {
            command: "keys",
            keys,
        })?,
        (false, true) => print(Markdown)?,
        (false, false) => print(Text(&args.word))?,
    }
    Ok(ExitCode::SUCCESS)
}
