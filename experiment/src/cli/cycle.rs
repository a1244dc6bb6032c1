//! `touchdown bench controller`.

use super::{Header, ScenarioArgs, distinct, print, print_json};
use anyhow::{Context, Result};
use experiment::in_process;
use hdrhistogram::Histogram;
use node::clock;
use node::scenario::Scenario;
use serde::Serialize;
use spatial::TICK_S;
use std::process::ExitCode;

/// How long one cycle of each law takes
#[derive(clap::Args)]
pub(crate) struct Args {
    #[command(flatten)]
    scenario: ScenarioArgs,
    /// Control laws
    #[arg(
        long,
        value_delimiter = ',',
        default_value = "pd,pd-reset,literal,proposed,impedance,ros2,fzi,elastic"
    )]
    laws: Vec<String>,
    /// How often the run's cycles are repeated and timed, after once that is not
    #[arg(long, default_value_t = 20, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1000))]
    repetitions: u16,
    /// Print one JSON object instead of a table
    #[arg(long)]
    json: bool,
}

/// No cycle is taken to last longer, ns.
const LONGEST_NS: u64 = 10_000_000_000;

/// How long a law's cycles take by the clock: what interrupts them counts.
#[derive(Serialize)]
struct Row {
    law: String,
    cycles: u64,
    p50_us: f64,
    p99_us: f64,
    p999_us: f64,
    max_us: f64,
    p999_per_period: f64,
}

#[derive(Serialize)]
struct Report<'a> {
    #[serde(flatten)]
    header: Header<'a>,
    processor: &'a str,
    period_us: f64,
    rows: &'a [Row],
}

pub(crate) fn run(args: &Args) -> Result<ExitCode> {
    distinct("--laws", &args.laws)?;
    let (source, scenario) = args.scenario.read()?;
    let laws = args.laws.iter().map(|law| {
        let scenario = scenario.with(&[format!("controller.law={law}")])?;
        measure(law, &scenario, args.repetitions)
    });
    let rows = laws.collect::<Result<Vec<_>>>()?;
    let (processor, period_us) = (processor(), period_us(&scenario));
    if args.json {
        print_json(&Report {
            header: Header::new("bench controller", &source, &scenario),
            processor: &processor,
            period_us,
            rows: &rows,
        })?;
        return Ok(ExitCode::SUCCESS);
    }
    let mut text = format!(
        "{}: time of one control cycle, T = {} ms, {processor}\n\n\
         law           cycles   p50 us   p99 us  p99.9 us   max us  p99.9 / T\n",
        source.name,
        period_us / 1e3,
    );
    for row in &rows {
        text += &format!(
            "{:10}  {:8}  {:7.1}  {:7.1}  {:8.1}  {:7.1}  {:8.2} %\n",
            row.law,
            row.cycles,
            row.p50_us,
            row.p99_us,
            row.p999_us,
            row.max_us,
            1e2 * row.p999_per_period,
        );
    }
    print(format_args!("{text}\n"))?;
    Ok(ExitCode::SUCCESS)
}

/// Time the cycles of a run of `scenario`, on what robot and sensor say in it.
fn measure(law: &str, scenario: &Scenario, repetitions: u16) -> Result<Row> {
    let mut said = Vec::new();
    in_process::run(scenario, |tick| said.push(*tick));
    let mut nanoseconds = Histogram::<u64>::new_with_bounds(1, LONGEST_NS, 3).context("no histogram")?;
    for repetition in 0..=repetitions {
        in_process::replay_cycles(scenario, &said, |cycle| {
            let started = clock::now();
            cycle();
            let took_ns = u64::try_from((clock::now() - started).as_nanos()).unwrap_or(LONGEST_NS);
            // The first time fills the caches.
            if repetition > 0 {
                nanoseconds.saturating_record(took_ns);
            }
        });
    }
    let us = |quantile: f64| 1e-3 * nanoseconds.value_at_quantile(quantile) as f64;
    Ok(Row {
        law: law.to_owned(),
        cycles: nanoseconds.len(),
        p50_us: us(0.5),
        p99_us: us(0.99),
        p999_us: us(0.999),
        max_us: us(1.0),
        p999_per_period: us(0.999) / period_us(scenario),
    })
}

fn period_us(scenario: &Scenario) -> f64 {
    1e6 * TICK_S * scenario.timing.command_period_ticks as f64
}

/// What the machine calls its processor.
fn processor() -> String {
    let about = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let name = about.lines().find(|line| line.starts_with("model name"));
    let name = name.and_then(|line| line.split_once(':'));
    name.map_or("unknown processor", |(_, name)| name.trim())
        .to_owned()
}
