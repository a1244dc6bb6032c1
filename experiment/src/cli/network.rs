//! `touchdown bench network`.

use super::{Header, ScenarioArgs, WrongUsage, print, print_json};
use anyhow::{Result, ensure};
use experiment::in_process;
use experiment::wire_speed::cycles::{self, Amount, Pace, Receive, Row};
use experiment::wire_speed::ring::{self, Lockstep};
use experiment::wire_speed::signatures;
use node::clock;
use node::scenario::{Scenario, TimingMode};
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Duration;

/// How near the programs come to the wire's own speed: lockstep against three bare processes, and the controller's answer
/// against an echo
#[derive(clap::Args)]
pub(crate) struct Args {
    #[command(flatten)]
    scenario: ScenarioArgs,
    /// Runs in lockstep that are timed
    #[arg(long, default_value_t = 3, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1000))]
    repetitions: u16,
    /// How long each of them is timed, s
    #[arg(long, default_value_t = 2.0, value_name = "S", value_parser = seconds)]
    seconds: f64,
    /// Turns of each way of receiving, at each pace
    #[arg(long, default_value_t = 40, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1000))]
    turns: u16,
    /// Cycles of a turn that count
    #[arg(long, default_value_t = 250, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=100_000))]
    cycles: u32,
    /// A Python that has the package lcm [default: python3, if it has]
    #[arg(long, value_name = "PATH")]
    python: Option<PathBuf>,
    /// Print one JSON object instead of a table
    #[arg(long)]
    json: bool,
}

/// How long a run goes at most whose computation is timed, and after which answers are, s.
const LONGEST_S: f64 = 5.0;

#[derive(Serialize)]
struct Report<'a> {
    #[serde(flatten)]
    header: Header<'a>,
    repetitions: u16,
    /// Of the run in one process.
    ticks: i64,
    in_process_ticks_per_s: f64,
    #[serde(flatten)]
    lockstep: Lockstep,
    loop_p50_ratio: f64,
    loop_p999_ratio: f64,
    loop_1000_hz_p50_ratio: f64,
    loop_1000_hz_p999_ratio: f64,
    loop_back_to_back_p50_ratio: f64,
    loop_back_to_back_p999_ratio: f64,
    loops: &'a [Row],
    /// What a key adds in real time.
    signatures: &'a [signatures::Row],
}

/// How long something is timed.
pub(super) fn seconds(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(seconds) if (0.05..=3600.0).contains(&seconds) => Ok(seconds),
        _ => Err(format!("\"{text}\" is no time within 0.05..=3600 s")),
    }
}

/// Refuse a scenario in real time.
pub(super) fn in_lockstep(scenario: &Scenario) -> Result<()> {
    let mode = scenario.timing.mode;
    ensure!(
        mode == TimingMode::Lockstep,
        WrongUsage(format!(
            "timing.mode is {mode:?}, but this measures lockstep; leave it at lockstep"
        ))
    );
    Ok(())
}

pub(crate) fn run(args: &Args) -> Result<ExitCode> {
    let (source, scenario) = args.scenario.read()?;
    in_lockstep(&scenario)?;
    let ways = ways(args.python.as_deref())?;
    let stop = node::shell::signals()?;
    let (_directory, programs) = args.scenario.programs(&source)?;
    let amount = Amount {
        turns: args.turns,
        cycles: args.cycles,
    };
    let limited = format!("timing.duration_s={}", LONGEST_S.min(scenario.timing.duration_s));
    let timed = scenario.with(std::slice::from_ref(&limited))?;
    let started = clock::now();
    in_process::run(&timed, |_| ());
    let in_process_ticks_per_s = timed.timing.ticks() as f64 / (clock::now() - started).as_secs_f64();
    // A ring goes round for as long as it is looked at.
    let endless = programs.with("timing.duration_s=86400".to_owned());
    let window = Duration::from_secs_f64(args.seconds);
    let lockstep = ring::compare(&endless, &timed, args.repetitions, window, &stop)?;
    let paces = [Pace::HZ_250, Pace::HZ_1000, Pace::UNPACED];
    let loops = cycles::measure(&ways, &paces, amount, &programs.with(limited), &timed, &stop)?;
    let own = |pace: Pace| {
        let found = loops
            .iter()
            .find(|row| row.pace == pace.name && row.receive == Receive::Own.name());
        found.map_or([f64::NAN; 2], |row| [row.p50_ratio, row.p999_ratio])
    };
    let [at_250, at_1000, unpaced] = paces.map(own);
    let report = Report {
        header: Header::new("bench network", &source, &scenario),
        repetitions: args.repetitions,
        ticks: timed.timing.ticks(),
        in_process_ticks_per_s,
        lockstep,
        loop_p50_ratio: at_250[0],
        loop_p999_ratio: at_250[1],
        loop_1000_hz_p50_ratio: at_1000[0],
        loop_1000_hz_p999_ratio: at_1000[1],
        loop_back_to_back_p50_ratio: unpaced[0],
        loop_back_to_back_p999_ratio: unpaced[1],
        loops: &loops,
        signatures: &signatures::measure(&timed, args.repetitions),
    };
    if args.json {
        print_json(&report)?;
    } else {
        print(text(&report))?;
    }
    Ok(ExitCode::SUCCESS)
}

/// All ways of receiving that there are here.
fn ways(python: Option<&Path>) -> Result<Vec<Receive>> {
    let mut ways = vec![Receive::Raw, Receive::Own, Receive::Liblcm];
    match super::python::with("lcm", python) {
        Ok(python) => ways.push(Receive::Python(python)),
        Err(lacking) if python.is_some() => return Err(lacking.into()),
        Err(lacking) => tracing::warn!("no row for Python: {lacking}"),
    }
    Ok(ways)
}

fn text(report: &Report<'_>) -> String {
    let lockstep = &report.lockstep;
    let mut text = format!(
        "{}: how near the programs come to the wire's own speed (make bench: touchdown bench network)\n\n\
         lockstep, ticks/s: three programs over LCM {:.0} ({:.0} to {:.0} in {} runs), three bare processes {:.0};\n\
         ratio {:.2} ({:.2} to {:.2}); first tick after {:.2} s; one process: {:.0} ticks/s\n\
         computation, us: robot {:.1} and sensor {:.1} in a tick, controller {:.1} in a cycle\n\n\
         from SENSOR_DEFLECTION to the ROBOT_COMMAND that answers it, over the wire and back; in brackets the turns\n\
         pace          receive             cycles  lost   p50 us   p99 us  p99.9 us    max us  p50 / raw             p99.9 / raw\n",
        report.header.scenario,
        lockstep.lockstep_ticks_per_s,
        lockstep.lockstep_ticks_per_s_min,
        lockstep.lockstep_ticks_per_s_max,
        report.repetitions,
        lockstep.bare_ticks_per_s,
        lockstep.lockstep_ratio,
        lockstep.lockstep_ratio_min,
        lockstep.lockstep_ratio_max,
        lockstep.start_up_s,
        report.in_process_ticks_per_s,
        lockstep.robot_us_per_tick,
        lockstep.sensor_us_per_tick,
        lockstep.controller_us_per_cycle,
    );
    for row in report.loops {
        let turns = format!(
            "{:.2} ({:.2} to {:.2})",
            row.p50_ratio, row.p50_ratio_min, row.p50_ratio_max
        );
        text += &format!(
            "{:12}  {:18}  {:6}  {:4}  {:7.1}  {:7.1}  {:8.1}  {:8.1}  {turns:20}  {:11.2}\n",
            row.pace,
            row.receive,
            row.cycles,
            row.lost,
            row.p50_us,
            row.p99_us,
            row.p999_us,
            row.max_us,
            row.p999_ratio,
        );
    }
    text +=
        "\nwhat a key adds to a message in real time, ns of a core\nchannel            bytes   sign  check\n";
    for row in report.signatures {
        text += &format!(
            "{:17}  {:5}  {:5.0}  {:5.0}\n",
            row.channel, row.bytes, row.sign_ns, row.check_ns
        );
    }
    text
}
