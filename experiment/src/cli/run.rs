//! `touchdown run`.

mod margins;
mod program;

use super::{Header, ScenarioArgs, distinct, print, print_json, progress, word};
use anyhow::{Context, Result};
use crossbeam::channel::Receiver;
use experiment::analyse::{Analysis, Headline};
use experiment::figure::{LabelledCurve, force_figure};
use experiment::launch::{self, LaunchError, Plan, Wiring};
use experiment::log::{Log, sidecar};
use experiment::metrics::Recording;
use experiment::out::Workplace;
use experiment::run_port::RunPort;
use experiment::scenarios::Source;
use experiment::table::{Row, Table};
use experiment::transcript::{self, Entry};
use margins::LoopMargins;
use node::scenario::Scenario;
use serde::Serialize;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Duration;

/// Run an experiment as three processes that talk over LCM: table, figure and recorded data
#[derive(clap::Args)]
pub(crate) struct Args {
    #[command(flatten)]
    scenario: ScenarioArgs,
    /// Control laws, one run each: pd, pd-reset, literal, proposed, impedance, ros2, fzi [default: pd,proposed; of a
    /// program proposed]
    #[arg(long, value_delimiter = ',')]
    laws: Vec<String>,
    /// Keep all that was said, as LCM event logs; beside each the scenario as it was resolved, seed and versions, and a
    /// report (HTML)
    #[arg(long)]
    record: bool,
    /// Directory for figure and data
    #[arg(long, default_value = "touchdown-out", value_name = "DIR")]
    out: PathBuf,
    /// UDP port of the run, which takes the next one too [default: a free one]
    #[arg(long)]
    port: Option<u16>,
    /// Seed of every random stream, instead of timing.seed
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(i64).range(0..))]
    seed: Option<i64>,
    /// Print one JSON object instead of a table
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct Report<'a> {
    #[serde(flatten)]
    header: Header<'a>,
    seed: i64,
    out: &'a Path,
    rows: Vec<Row>,
    margins: Vec<LoopMargins>,
}

/// One run to be made.
struct Run {
    law: String,
    scenario: Scenario,
    overrides: Vec<String>,
}

/// How long a port is listened to before it is used.
const QUIET: Duration = Duration::from_millis(200);
/// The figure's name.
const FIGURE: &str = "force.svg";
/// The scenario's name.
const SCENARIO: &str = "scenario.toml";

impl Args {
    /// What it is about.
    #[cfg(test)]
    pub(super) fn scenario(&self) -> &ScenarioArgs {
        &self.scenario
    }

    /// The files of one law.
    fn data(&self, law: &str) -> String {
        let base = self.out.join(law);
        let log = if self.record {
            format!("{0}.lcmlog, {0}.html, ", base.display())
        } else {
            String::new()
        };
        format!("{log}{}.csv", base.display())
    }
}

pub(crate) fn run(args: &Args) -> Result<ExitCode> {
    distinct("--laws", &args.laws)?;
    let (source, scenario) = args.scenario.read()?;
    let mut overrides = args.scenario.overrides.clone();
    overrides.extend(args.seed.map(|seed| format!("timing.seed={seed}")));
    let steps = !scenario.program.steps().is_empty();
    let laws = match (args.laws.as_slice(), steps) {
        ([], false) => ["pd", "proposed"].map(str::to_owned).to_vec(),
        ([], true) => vec!["proposed".to_owned()],
        (laws, _) => laws.to_vec(),
    };
    let runs = laws.iter().map(|law| {
        let mut overrides = overrides.clone();
        overrides.push(format!("controller.law={law}"));
        Ok(Run {
            law: law.clone(),
            scenario: source.scenario(&overrides)?,
            overrides,
        })
    });
    let runs: Vec<_> = runs.collect::<Result<_>>()?;

    let stop = node::shell::signals()?;
    let mut place = Workplace::new(&args.out)
        .with_context(|| format!("can't create a directory in {}", args.out.display()))?;
    if steps {
        return program::run(args, &source, &runs, place, &stop);
    }
    let measured = measure(args, &source, &runs, &mut place, &stop);
    // What is complete is kept, also of a run that gave no figures: it shows why.
    place
        .publish()
        .with_context(|| format!("can't write the results into {}", args.out.display()))?;
    let (rows, margins) = measured?;

    if args.json {
        print_json(&Report {
            header: Header::new("run", &source, &scenario),
            seed: args.seed.unwrap_or(scenario.timing.seed),
            out: &args.out,
            rows,
            margins,
        })?;
    } else {
        print(Table(&rows))?;
        let data: Vec<_> = laws.iter().map(|law| args.data(law)).collect();
        print(format_args!(
            "\nfigure: {}\ndata:   {}\n",
            args.out.join(FIGURE).display(),
            data.join(", ")
        ))?;
    }
    Ok(ExitCode::SUCCESS)
}

/// One run after the other, and the figure of all.
fn measure(
    args: &Args,
    source: &Source,
    runs: &[Run],
    place: &mut Workplace,
    stop: &Receiver<()>,
) -> Result<(Vec<Row>, Vec<LoopMargins>)> {
    let measured = experiment(args, source, runs, place, stop, |place, run, entries| {
        let Run { law, scenario, .. } = run;
        let (recording, measured) = Recording::from_transcript(scenario, &entries);
        place
            .result(format!("{law}.csv"), |path| fs::write(path, recording.csv()))
            .with_context(|| format!("can't write {law}.csv"))?;
        let curve = LabelledCurve::new(law, scenario, &recording, measured)
            .with_context(|| format!("law {law}, whose data are in {}", args.out.display()))?;
        let (gears, kinematics) = (word(scenario.robot.gears), word(scenario.robot.kinematics));
        let row = Row::single(&gears, &kinematics, law, curve.metrics);
        Ok(((row, LoopMargins::of(law, &entries)), curve))
    })?;
    let (told, curves): (Vec<_>, Vec<_>) = measured.into_iter().unzip();
    place.result(FIGURE.to_owned(), |path| force_figure(&curves, path))?;
    place.result(SCENARIO.to_owned(), |_| Ok::<_, io::Error>(()))?;
    Ok(told.into_iter().unzip())
}

/// The log of a run, and what belongs beside it.
fn keep(place: &mut Workplace, source: &Source, run: &Run, entries: &[Entry]) -> Result<()> {
    let log = format!("{}.lcmlog", run.law);
    let headline = Headline {
        scenario: &source.name,
        log: log.clone(),
        complaints: Vec::new(),
    };
    let analysis = Analysis::new(&run.scenario, &Log::of(Path::new(&log), entries.to_vec()));
    place
        .result(format!("{}.html", run.law), |path| {
            fs::write(path, analysis.html(&run.scenario, &headline))
        })
        .with_context(|| format!("can't write {}.html", run.law))?;
    place.result(log.clone(), |path| transcript::write_log(path, entries))?;
    let beside = sidecar::path(Path::new(&log));
    let text = sidecar::text(Path::new(&log), &source.name, &run.scenario);
    place
        .result(beside.display().to_string(), |path| fs::write(path, text))
        .with_context(|| format!("can't write {}", beside.display()))
}

/// Make one run after the other; what was said in it goes to `told`.
fn experiment<T>(
    args: &Args,
    source: &Source,
    runs: &[Run],
    place: &mut Workplace,
    stop: &Receiver<()>,
    mut told: impl FnMut(&mut Workplace, &Run, Vec<Entry>) -> Result<T>,
) -> Result<Vec<T>> {
    let port = match args.port {
        Some(port) => RunPort::fixed(port, QUIET)?,
        None => RunPort::free(QUIET)?,
    };
    let file = place.path().join(SCENARIO);
    fs::write(&file, &source.text).with_context(|| format!("can't write {}", file.display()))?;
    let mut all = Vec::new();
    for run in runs {
        let plan = Plan {
            programs: launch::programs()?,
            scenario: file.clone(),
            overrides: run.overrides.clone(),
            wiring: Wiring::shared(&port.device_url(), &port.simulation_url()),
            run_id: i64::from(std::process::id()),
            directory: place.path().to_owned(),
            // Everything is recorded anyway.
            flags: std::array::from_fn(|_| vec!["--no-flight".to_owned()]),
            through: Default::default(),
        };
        let progress = progress("{msg:10} {bar:40} {pos}/{len} ticks", run.scenario.timing.ticks())
            .with_message(run.law.clone());
        let entries = launch::record(&plan, stop, |tick| progress.set_position(tick.max(0) as u64));
        progress.finish_and_clear();
        let entries = match entries {
            Ok(entries) => entries,
            Err(error) => {
                let interrupted = matches!(error, LaunchError::Interrupted);
                // It shows what went wrong, as far as it goes; why it is not there would hide that.
                if args.record
                    && !interrupted
                    && let Ok(entries) = transcript::record(&plan.records())
                {
                    let _ = keep(place, source, run, &entries);
                }
                return Err(error.into());
            }
        };
        if args.record {
            keep(place, source, run, &entries)?;
        }
        all.push(told(place, run, entries)?);
    }
    Ok(all)
}
