//! `touchdown run` of a scenario with a program: what became of each step.

use super::margins::LoopMargins;
use super::{Args, Run, SCENARIO, experiment};
use crate::cli::{Header, print, print_json};
use ::experiment::metrics::Recording;
use ::experiment::out::Workplace;
use ::experiment::program::{StepResult, Steps, results, succeeded};
use ::experiment::scenarios::Source;
use ::experiment::transcript;
use anyhow::{Context, Result};
use crossbeam::channel::Receiver;
use serde::Serialize;
use spatial::ports::ControllerStatus;
use std::path::Path;
use std::process::ExitCode;
use std::{fs, io};

/// What one law made of the program.
#[derive(Serialize)]
struct Outcome {
    law: String,
    succeeded: bool,
    steps: Vec<StepResult>,
    margins: LoopMargins,
}

#[derive(Serialize)]
struct Report<'a> {
    #[serde(flatten)]
    header: Header<'a>,
    seed: i64,
    out: &'a Path,
    programs: &'a [Outcome],
}

/// Run the program with each law and tell the results; exit code 1 if a step failed.
pub(super) fn run(
    args: &Args,
    source: &Source,
    runs: &[Run],
    mut place: Workplace,
    stop: &Receiver<()>,
) -> Result<ExitCode> {
    let outcomes = experiment(args, source, runs, &mut place, stop, |place, run, entries| {
        let scenario = &run.scenario;
        let (recording, _) = Recording::from_transcript(scenario, &entries);
        let law = &run.law;
        place
            .result(format!("{law}.csv"), |path| fs::write(path, recording.csv()))
            .with_context(|| format!("can't write {law}.csv"))?;
        let steps = results(scenario, transcript::messages::<ControllerStatus>(&entries));
        Ok(Outcome {
            law: law.clone(),
            succeeded: succeeded(&steps),
            margins: LoopMargins::of(law, &entries),
            steps,
        })
    });
    if outcomes.is_ok() {
        place.result(SCENARIO.to_owned(), |_| Ok::<_, io::Error>(()))?;
    }
    place
        .publish()
        .with_context(|| format!("can't write the results into {}", args.out.display()))?;
    let outcomes = outcomes?;
    if args.json {
        print_json(&Report {
            header: Header::new("run", source, &args.scenario.read()?.1),
            seed: runs[0].scenario.timing.seed,
            out: &args.out,
            programs: &outcomes,
        })?;
    } else {
        for Outcome { law, steps, .. } in &outcomes {
            print(format_args!("law {law}; data: {}\n", args.data(law)))?;
            print(format_args!("{}\n", Steps(steps)))?;
        }
    }
    let all_well = outcomes.iter().all(|outcome| outcome.succeeded);
    Ok(if all_well {
        ExitCode::SUCCESS
    } else {
        ExitCode::from(crate::cli::FAILED)
    })
}
