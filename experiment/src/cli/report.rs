//! `touchdown report`.

use super::{Threads, compare, distinct, print, print_json, progress_of_runs, threads};
use anyhow::{Context, Result};
use experiment::report::{Options, Report};
use experiment::scenarios;
use serde::Serialize;
use std::path::PathBuf;
use std::process::ExitCode;

/// Write one HTML file that shows laws, scenarios and maps, each with the command that makes it again
#[derive(clap::Args)]
#[command(after_help = "\
The file needs no network and no other file. It is the same whatever the number of threads. The runs of the maps are kept \
beside it: what is there already is not run again.")]
pub(crate) struct Args {
    /// Directory of report.html, and of the maps' runs
    #[arg(long, value_name = "DIRECTORY", default_value = "target/report")]
    out: PathBuf,
    /// Scenarios, by name or path [default: all built-in ones]
    #[arg(long, value_delimiter = ',', value_name = "NAME")]
    scenarios: Vec<String>,
    /// Contact phases relative to the command period, spread evenly
    #[arg(long, default_value_t = 12, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1000))]
    phases: u16,
    /// Seeds for each contact phase, from timing.seed on
    #[arg(long, default_value_t = 1, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1000))]
    seeds: u16,
    /// Sweep whose maps are shown: a built-in one by its name, or a file by its path
    #[arg(long, default_value = "shootout", value_name = "SWEEP")]
    sweep: String,
    /// Contact phases of each cell of the maps
    #[arg(long, default_value_t = 1, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1000))]
    sweep_phases: u16,
    /// Run the maps anew: forget the runs that are there
    #[arg(long)]
    fresh: bool,
    /// File of tuned gains, written by touchdown tune [default: those that come with the program]
    #[arg(long, value_name = "FILE")]
    tuned: Option<PathBuf>,
    #[command(flatten)]
    threads: Threads,
    /// Print one JSON object instead of the file's name
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct Written<'a> {
    command: &'static str,
    file: String,
    bytes: usize,
    runs: usize,
    scenarios: &'a [String],
    phases: usize,
    seeds: usize,
    sweep: &'a str,
    sweep_phases: usize,
}

impl Args {
    fn options(&self) -> Result<Options> {
        distinct("--scenarios", &self.scenarios)?;
        let all = || scenarios::names().map(str::to_owned).collect();
        Ok(Options {
            scenarios: match self.scenarios.is_empty() {
                true => all(),
                false => self.scenarios.clone(),
            },
            phases: self.phases.into(),
            seeds: self.seeds.into(),
            sweep: self.sweep.clone(),
            sweep_phases: self.sweep_phases.into(),
        })
    }
}

pub(crate) fn run(args: &Args) -> Result<ExitCode> {
    let options = args.options()?;
    let tuned = compare::tuned(args.tuned.as_deref())?;
    let work = Report::plan(&options, &tuned)?;
    let unusable = || format!("the directory {} can't be written to", args.out.display());
    std::fs::create_dir_all(&args.out).with_context(unusable)?;
    let runs = args.out.join("runs.csv");
    if args.fresh && runs.exists() {
        std::fs::remove_file(&runs).with_context(unusable)?;
    }
    let progress = progress_of_runs(work.runs());
    let report = threads(&args.threads, || {
        work.run(&tuned, &runs, |runs| progress.inc(runs as u64))
    })??;
    progress.finish_and_clear();
    let html = report.html()?;
    let file = args.out.join("report.html");
    std::fs::write(&file, &html).with_context(unusable)?;
    if args.json {
        print_json(&Written {
            command: "report",
            file: file.display().to_string(),
            bytes: html.len(),
            runs: report.runs,
            scenarios: &options.scenarios,
            phases: options.phases,
            seeds: options.seeds,
            sweep: &options.sweep,
            sweep_phases: options.sweep_phases,
        })?;
    } else {
        print(format_args!("{}\n", file.display()))?;
    }
    Ok(ExitCode::SUCCESS)
}

#[cfg(test)]
mod tests {
    use super::super::{Cli, Command};
    use super::*;
    use clap::Parser;

    fn parsed(command: &str) -> Command {
        Cli::try_parse_from(command.split_ascii_whitespace())
            .unwrap()
            .command
    }

    /// Every command that a report shows is one, and what it would call its configuration hash stands beside it.
    #[test]
    fn every_command_of_a_report_gives_its_hash() {
        let small = "touchdown report --scenarios paper,elastic_arm,wrong_c --phases 1 --sweep smoke";
        let Command::Report(args) = parsed(small) else {
            panic!("{small}");
        };
        let tuned = compare::tuned(None).unwrap();
        let work = Report::plan(&args.options().unwrap(), &tuned).unwrap();
        let directory = tempfile::tempdir().unwrap();
        let report = work
            .run(&tuned, &directory.path().join("runs.csv"), |_| ())
            .unwrap();
        let sections = report.sections.iter();
        let shown = sections.flat_map(|section| {
            let panels = section.panels.iter().map(|panel| &panel.origin);
            [&section.origin].into_iter().chain(panels)
        });
        let mut told = 0;
        for origin in shown.chain([&report.maps.origin]) {
            let hash = match parsed(&origin.command) {
                Command::Run(args) => args.scenario().read().unwrap().1.hash() as u64,
                Command::Compare(args) => args.scenario().read().unwrap().1.hash() as u64,
                Command::Sweep(args) => args.plan().unwrap().hash(),
                _ => panic!("{}", origin.command),
            };
            assert_eq!(
                format!("{hash:016x}"),
                origin.configuration_hash,
                "{}",
                origin.command
            );
            told += 1;
        }
        assert_eq!(told, 1 + 7 + 1 + 8 + 1 + 2 + 1);
        let html = report.html().unwrap();
        let again = html.rsplit("<code class=\"command\">").next().unwrap();
        let Command::Report(args) = parsed(again.split('<').next().unwrap()) else {
            panic!("{again}");
        };
        assert_eq!(args.options().unwrap(), report.options);
    }
}
