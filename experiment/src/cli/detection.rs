//! `touchdown bench detection`.

use super::{FAILED, Header, ScenarioArgs, complain, print, print_json, progress};
use anyhow::Result;
use experiment::detection::{self, Alarms, Delay};
use serde::Serialize;
use std::fmt::Write;
use std::path::PathBuf;
use std::process::ExitCode;

/// False alarms of the contact detection per hour, in noise and under acceleration, and its delay over the speed
#[derive(clap::Args)]
pub(crate) struct Args {
    #[command(flatten)]
    scenario: ScenarioArgs,
    /// Simulated hours of noise alone
    #[arg(long, default_value_t = 10.0, value_name = "H", value_parser = hours)]
    noise_hours: f64,
    /// Simulated hours of approaches through empty space, with the whole plant
    #[arg(long, default_value_t = 1.0, value_name = "H", value_parser = hours)]
    acceleration_hours: f64,
    /// Speeds of the approach at which the delay is measured, mm/s
    #[arg(long, value_delimiter = ',', value_name = "MM/S", default_value = "0.5,1,2,5,10,20,50,100",
          value_parser = speed)]
    speeds: Vec<f64>,
    /// Contact phases for each speed
    #[arg(long, default_value_t = 12, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1000))]
    phases: u16,
    /// Draw the delay over the speed into this SVG file
    #[arg(long, value_name = "FILE")]
    figure: Option<PathBuf>,
    /// Print one JSON object instead of text
    #[arg(long)]
    json: bool,
}

fn number(text: &str, limits: std::ops::RangeInclusive<f64>, unit: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(value) if limits.contains(&value) => Ok(value),
        _ => Err(format!(
            "choose a number of {unit} from {} to {}",
            limits.start(),
            limits.end()
        )),
    }
}

fn hours(text: &str) -> Result<f64, String> {
    number(text, 0.0..=1e4, "hours")
}

fn speed(text: &str) -> Result<f64, String> {
    number(text, 0.5..=250.0, "mm/s")
}

#[derive(Serialize)]
struct Report<'a> {
    #[serde(flatten)]
    header: Header<'a>,
    noise: Alarms,
    acceleration: Alarms,
    phases: u16,
    delays: Vec<Delay>,
}

pub(crate) fn run(args: &Args) -> Result<ExitCode> {
    let (source, scenario) = args.scenario.read()?;
    let speeds: Vec<f64> = args.speeds.iter().map(|speed| 1e-3 * speed).collect();
    let steps = detection::watches(args.noise_hours)
        + detection::approaches(&scenario, args.acceleration_hours)
        + 2 * speeds.len() as u64;
    let progress = progress("{bar:40} {pos}/{len} {eta}", steps as i64);
    let report = Report {
        header: Header::new("bench detection", &source, &scenario),
        noise: detection::noise(&scenario, args.noise_hours, || progress.inc(1)),
        acceleration: detection::accelerations(&scenario, args.acceleration_hours, || progress.inc(1)),
        phases: args.phases,
        delays: detection::delays(&scenario, &speeds, args.phases.into(), || progress.inc(1)),
    };
    progress.finish_and_clear();
    if let Some(path) = &args.figure {
        detection::draw(&report.delays, &source.name, path)?;
    }
    if args.json {
        print_json(&report)?;
    } else {
        print(text(&report))?;
    }
    let missed = report
        .delays
        .iter()
        .filter(|delay| delay.both_s.is_none())
        .count();
    if missed > 0 {
        complain(format_args!(
            "at {missed} of {} speeds a run had a false alarm or no detection; see the table",
            report.delays.len()
        ));
        return Ok(ExitCode::from(FAILED));
    }
    Ok(ExitCode::SUCCESS)
}

fn text(report: &Report<'_>) -> String {
    let mut text = String::new();
    let alarms = [
        ("noise alone", &report.noise),
        ("accelerations", &report.acceleration),
    ];
    for (what, alarms) in alarms {
        let _ = writeln!(
            text,
            "{what}, {:.2} h: false contacts {} (threshold alone {}), false collisions {}",
            alarms.hours, alarms.both, alarms.threshold, alarms.collisions
        );
    }
    let _ = writeln!(text, "\napproach mm/s  threshold ms    with sum ms");
    let shown = |delay: Option<[f64; 2]>| {
        delay.map_or("-".to_owned(), |[mean, most]| {
            format!("{:.1} ({:.1})", 1e3 * mean, 1e3 * most)
        })
    };
    for delay in &report.delays {
        let _ = writeln!(
            text,
            "{:>13}  {:>12}  {:>13}",
            1e3 * delay.speed_m_per_s,
            shown(delay.threshold_s),
            shown(delay.both_s)
        );
    }
    let _ = writeln!(
        text,
        "\nfrom the first touch to the sample that detects it: mean (longest) of {} contact phases each",
        report.phases
    );
    text
}
