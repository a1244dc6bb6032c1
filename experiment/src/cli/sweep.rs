//! `touchdown sweep`.

use super::{Threads, compare, print, print_json, progress_of_runs, threads};
use anyhow::{Context, Result};
use experiment::sweep::{Cells, Definition, Plan, Verdict, cells_csv, map_figure, names, verdicts};
use rustix::time::{ClockId, clock_gettime};
use serde::Serialize;
use std::path::PathBuf;
use std::process::ExitCode;

/// Map stability and performance of laws over the plant: thousands of runs, resumable
#[derive(clap::Args)]
#[command(after_help = format!("\
Built-in sweeps: {}. A sweep is a TOML file; sweeps/ of the crate experiment has the built-in ones as examples.

Into --out go: runs.csv (every run; what is there already is not run again), cells.csv (mean and worst of each
cell, and what linear theory predicts of it) and a figure for each map. The files are the same whatever the
number of threads.", names().collect::<Vec<_>>().join(", ")))]
pub(crate) struct Args {
    /// A built-in sweep by its name, or a file by its path (with a / or ending with .toml)
    #[arg(default_value = "smoke")]
    sweep: String,
    /// Directory of what comes out [default: target/sweep/ and the sweep's name]
    #[arg(long, value_name = "DIRECTORY")]
    out: Option<PathBuf>,
    /// Contact phases of each cell [default: the sweep's]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1000))]
    phases: Option<u16>,
    /// Begin anew: forget the runs that are there
    #[arg(long)]
    fresh: bool,
    /// File of tuned gains, written by touchdown tune [default: those that come with the program]
    #[arg(long, value_name = "FILE")]
    tuned: Option<PathBuf>,
    #[command(flatten)]
    threads: Threads,
    /// Print one JSON object instead of a table
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct Report<'a> {
    command: &'static str,
    sweep: &'a str,
    configuration_hash: String,
    directory: String,
    runs: usize,
    runs_resumed: usize,
    simulated_s: f64,
    core_s: f64,
    simulated_s_per_core_s: f64,
    maps: &'a [Verdict],
}

impl Args {
    /// The runs that are asked for.
    pub(super) fn plan(&self) -> Result<Plan> {
        let mut definition = Definition::find(&self.sweep)?;
        definition.phases = self.phases.map_or(definition.phases, usize::from);
        let tuned = compare::tuned(self.tuned.as_deref())?;
        Ok(Plan::new(definition, &tuned)?)
    }
}

pub(crate) fn run(args: &Args) -> Result<ExitCode> {
    let plan = args.plan()?;
    let directory = args.out.clone().unwrap_or_else(|| {
        let name = args.sweep.rsplit('/').next().unwrap_or(&args.sweep);
        PathBuf::from("target/sweep").join(name.trim_end_matches(".toml"))
    });
    let unusable = || format!("the directory {} can't be written to", directory.display());
    std::fs::create_dir_all(&directory).with_context(unusable)?;
    let file = directory.join("runs.csv");
    if args.fresh && file.exists() {
        std::fs::remove_file(&file).with_context(unusable)?;
    }
    let progress = progress_of_runs(plan.runs.len());
    let before_s = core_time_s();
    let (outcomes, resumed) = threads(&args.threads, || {
        plan.run(&file, |runs| progress.inc(runs as u64))
    })??;
    let core_s = core_time_s() - before_s;
    progress.finish_and_clear();
    let cells = threads(&args.threads, || Cells::new(&plan, &outcomes))?;
    std::fs::write(directory.join("cells.csv"), cells_csv(&plan, &cells)).with_context(unusable)?;
    for (i, map) in plan.definition.maps.iter().enumerate() {
        let svg = map_figure(&plan, &cells, i)?;
        std::fs::write(directory.join(format!("{}.svg", map.name)), svg).with_context(unusable)?;
    }
    let verdicts = verdicts(&plan, &cells);
    let fresh_s: f64 = plan.runs[resumed..]
        .iter()
        .map(|run| run.scenario.timing.duration_s)
        .sum();
    let report = Report {
        command: "sweep",
        sweep: &args.sweep,
        configuration_hash: format!("{:016x}", plan.hash()),
        directory: directory.display().to_string(),
        runs: plan.runs.len(),
        runs_resumed: resumed,
        simulated_s: fresh_s,
        core_s,
        simulated_s_per_core_s: if core_s > 0.0 { fresh_s / core_s } else { 0.0 },
        maps: &verdicts,
    };
    if args.json {
        print_json(&report)?;
    } else {
        print(text(&report))?;
    }
    Ok(ExitCode::SUCCESS)
}

fn text(report: &Report<'_>) -> String {
    let mut text = String::from(
        "map        law        cells  settled  stable  theory agrees  else near its border  too hopeful  mean IAE of settled N s\n",
    );
    let count = |value: Option<usize>| value.map_or_else(|| "-".to_owned(), |value| value.to_string());
    for verdict in report.maps {
        let iae = verdict
            .mean_iae_n_s
            .map_or_else(|| "-".to_owned(), |iae| format!("{iae:.3}"));
        text += &format!(
            "{:9}  {:9}  {:5}  {:7}  {:6}  {:>13}  {:>20}  {:>11}  {:>23}\n",
            verdict.map,
            verdict.law,
            verdict.cells,
            verdict.settled_cells,
            verdict.stable_cells,
            count(verdict.agreeing_cells),
            count(verdict.near_border_cells),
            count(verdict.too_hopeful_cells),
            iae
        );
    }
    text += &format!(
        "\n{} runs in {} ({} resumed); simulated {:.0} s in {:.1} s of core time: {:.0} s in a second of one core\n",
        report.runs,
        report.directory,
        report.runs_resumed,
        report.simulated_s,
        report.core_s,
        report.simulated_s_per_core_s
    );
    text
}

/// What all threads of this process have had of the cores until now, s.
fn core_time_s() -> f64 {
    let time = clock_gettime(ClockId::ProcessCPUTime);
    time.tv_sec as f64 + 1e-9 * time.tv_nsec as f64
}
