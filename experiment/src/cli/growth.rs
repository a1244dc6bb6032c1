//! `touchdown bench growth`.

use super::network::in_lockstep;
use super::{Header, ScenarioArgs, print, print_json};
use anyhow::{Context, Result};
use experiment::growth::{self, Amount, Growth};
use serde::Serialize;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Duration;

/// How costs grow with the rate of the cycles, the number of cells on this machine and the length of a log
#[derive(clap::Args)]
pub(crate) struct Args {
    #[command(flatten)]
    scenario: ScenarioArgs,
    /// How often each rate and each number of cells has its turn
    #[arg(long, default_value_t = 5, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1000))]
    turns: u16,
    /// Cycles of a turn of a rate
    #[arg(long, default_value_t = 500, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=100_000))]
    cycles: u32,
    /// How long a turn of a number of cells is timed, s
    #[arg(long, default_value_t = 2.0, value_name = "S", value_parser = super::network::seconds)]
    seconds: f64,
    /// Numbers of cells
    #[arg(long, value_name = "N", value_delimiter = ',', default_value = "1,2,4,8,16")]
    cells: Vec<u8>,
    /// Lengths of logs, s, from the shortest on
    #[arg(long, value_name = "S", value_delimiter = ',', default_value = "3,6,12,24,48", value_parser = super::network::seconds)]
    logs: Vec<f64>,
    /// Directory for figures, growth-*.svg [default: none]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Print one JSON object instead of tables
    #[arg(long)]
    json: bool,
}

/// How long the run goes at most that the controller goes through before it is measured, s.
const LONGEST_S: f64 = 5.0;

#[derive(Serialize)]
struct Report<'a> {
    #[serde(flatten)]
    header: Header<'a>,
    turns: u16,
    cycles: u32,
    seconds: f64,
    #[serde(flatten)]
    growth: &'a Growth,
}

pub(crate) fn run(args: &Args) -> Result<ExitCode> {
    let (source, scenario) = args.scenario.read()?;
    in_lockstep(&scenario)?;
    let stop = node::shell::signals()?;
    let (directory, programs) = args.scenario.programs(&source)?;
    let with_duration = |duration_s: f64| programs.with(format!("timing.duration_s={duration_s:?}"));
    let limited_s = LONGEST_S.min(scenario.timing.duration_s);
    let timed = scenario.with(&[format!("timing.duration_s={limited_s:?}")])?;
    let amount = Amount {
        turns: args.turns,
        cycles: args.cycles,
        window: Duration::from_secs_f64(args.seconds),
        cells: args.cells.iter().copied().map(usize::from).collect(),
        logs_s: args.logs.clone(),
    };
    let programs = [&with_duration(limited_s), &with_duration(86400.0)];
    let growth = growth::measure(programs, &timed, &amount, directory.path(), &stop)?;
    if let Some(out) = &args.out {
        std::fs::create_dir_all(out).with_context(|| format!("can't create {}", out.display()))?;
        growth.draw(out)?;
    }
    match args.json {
        true => print_json(&Report {
            header: Header::new("bench growth", &source, &scenario),
            turns: args.turns,
            cycles: args.cycles,
            seconds: args.seconds,
            growth: &growth,
        })?,
        false => print(text(&source.name, &growth))?,
    }
    Ok(ExitCode::SUCCESS)
}

fn text(scenario: &str, growth: &Growth) -> String {
    let mut text = format!(
        "{scenario}: how costs grow (make speed: touchdown bench growth)\n\n\
         cycles/s  controller: % of a core  us per cycle\n"
    );
    for row in &growth.rates {
        text += &format!(
            "{:8.0}  {:23.1}  {:12.1}\n",
            row.cycles_per_s,
            1e2 * row.core_share,
            row.core_us_per_cycle
        );
    }
    text += "\ncells  network             all in lockstep, ticks/s  each: core us per tick\n";
    for row in &growth.cells {
        let network = match row.one_network {
            true => "one, with suffixes",
            false => "ports of its own",
        };
        text += &format!(
            "{:5}  {network:18}  {:24.0}  {:22.1}\n",
            row.cells, row.ticks_per_s, row.core_us_per_tick
        );
    }
    text += "\nlog s  log MiB  analyse: core s  MiB at most  replay: core s  MiB at most\n";
    for row in &growth.logs {
        text += &format!(
            "{:5.0}  {:7.1}  {:15.3}  {:11.0}  {:14.3}  {:11.0}\n",
            row.log_s, row.log_mib, row.analyse_core_s, row.analyse_mib, row.replay_core_s, row.replay_mib
        );
    }
    text
}
