//! `touchdown bench nodes`.

use super::{Header, ScenarioArgs, print, print_json};
use anyhow::Result;
use experiment::upkeep::{self, Row, StartUp};
use serde::Serialize;
use std::process::ExitCode;
use std::time::Duration;

/// What the three programs take of this machine in real time: shares of a core and page faults; and how long they take to start
#[derive(clap::Args)]
pub(crate) struct Args {
    #[command(flatten)]
    scenario: ScenarioArgs,
    /// How long they are watched, s; they touch the object within 2 s
    #[arg(long, default_value_t = 5.0, value_name = "S", value_parser = super::network::seconds)]
    seconds: f64,
    /// How often `touchdown run` is started
    #[arg(long, default_value_t = 5, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1000))]
    repetitions: u16,
    /// Print one JSON object instead of a table
    #[arg(long)]
    json: bool,
}

/// T, ticks: 250 Hz and 1 kHz.
const PERIODS_TICKS: [i64; 2] = [4, 1];

#[derive(Serialize)]
struct Report<'a> {
    #[serde(flatten)]
    header: Header<'a>,
    seconds: f64,
    repetitions: u16,
    start_up: StartUp,
    rows: &'a [Row],
}

pub(crate) fn run(args: &Args) -> Result<ExitCode> {
    let (source, scenario) = args.scenario.read()?;
    let stop = node::shell::signals()?;
    let (directory, programs) = args.scenario.programs(&source)?;
    let start_up = upkeep::start_up(&programs, args.repetitions, &directory.path().join("out"), &stop)?;
    let window = Duration::from_secs_f64(args.seconds);
    let mut rows = Vec::new();
    for period_ticks in PERIODS_TICKS {
        rows.extend(upkeep::measure(
            &programs,
            period_ticks,
            window,
            directory.path(),
            &stop,
        )?);
    }
    let report = Report {
        header: Header::new("bench nodes", &source, &scenario),
        seconds: args.seconds,
        repetitions: args.repetitions,
        start_up,
        rows: &rows,
    };
    match args.json {
        true => print_json(&report)?,
        false => print(text(&report))?,
    }
    Ok(ExitCode::SUCCESS)
}

fn text(report: &Report<'_>) -> String {
    let start_up = &report.start_up;
    let mut text = format!(
        "{}: what the programs take of this machine (touchdown bench nodes)\n\n\
         touchdown run: first tick after {:.2} s, contact after {:.2} s ({:.2} to {:.2} in {} runs)\n\n\
         in real time, {} s\n\
         cycles/s  program     core share %  minor faults  major faults  rights  fault\n",
        report.header.scenario,
        start_up.first_tick_s,
        start_up.first_contact_s,
        start_up.first_contact_s_min,
        start_up.first_contact_s_max,
        report.repetitions,
        report.seconds,
    );
    for row in report.rows {
        text += &format!(
            "{:8}  {:10}  {:12.1}  {:12}  {:12}  {:6}  {}\n",
            row.cycles_per_s,
            row.program,
            1e2 * row.core_share,
            row.minor_faults,
            row.major_faults,
            if row.realtime_rights { "yes" } else { "no" },
            row.fault.as_deref().unwrap_or("none"),
        );
    }
    text
}
