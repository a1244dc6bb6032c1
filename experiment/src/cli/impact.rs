//! `touchdown impact`.

mod flags;
mod question;

use super::{print, print_json};
use anyhow::{Context, Result};
use experiment::impact::simulated::Simulated;
use experiment::impact::{Library, Question, Report, Text, figure, scenario};
use experiment::scenarios::Source;
pub(super) use flags::Args;
pub(super) use question::Unanswerable;
use serde::Serialize;
use std::path::Path;
use std::process::ExitCode;

#[derive(Serialize)]
struct Single<'a> {
    command: &'static str,
    #[serde(flatten)]
    report: &'a Report,
    #[serde(skip_serializing_if = "<[_]>::is_empty")]
    left_out: &'a [&'static str],
    #[serde(skip_serializing_if = "Option::is_none")]
    figure: Option<&'a Path>,
}

#[derive(Serialize)]
struct Several<'a> {
    command: &'static str,
    reports: &'a [Report],
    #[serde(skip_serializing_if = "Option::is_none")]
    figure: Option<&'a Path>,
}

pub(crate) fn run(args: &Args) -> Result<ExitCode> {
    let library = match &args.materials {
        Some(path) => Library::with_file(path)?,
        None => Library::built_in()?,
    };
    if args.list {
        list(&library, args.json)?;
        return Ok(ExitCode::SUCCESS);
    }
    let (reports, left_out) = match &args.scenario {
        Some(name) => {
            let scenario = Source::find(name)?.scenario(&args.overrides)?;
            let report = args.further(scenario::question(&scenario, name)?).answer()?;
            let report = report.with_simulation(Simulated::of(&scenario)?);
            (vec![report], scenario::left_out(&scenario))
        }
        None => (answers(&args.questions(&library)?)?, Vec::new()),
    };
    if let Some(path) = &args.figure {
        figure::draw(&reports, path)?;
    }
    let figure = args.figure.as_deref();
    match (args.json, reports.as_slice()) {
        (true, [report]) => print_json(&Single {
            command: "impact",
            report,
            left_out: &left_out,
            figure,
        })?,
        (true, reports) => print_json(&Several {
            command: "impact",
            reports,
            figure,
        })?,
        (false, reports) => {
            print(Text(reports))?;
            for text in left_out {
                print(format_args!("Not in the assessment: {text}.\n"))?;
            }
            if let Some(path) = figure {
                print(format_args!("\nfigure: {}\n", path.display()))?;
            }
        }
    }
    Ok(ExitCode::SUCCESS)
}

fn answers(questions: &[Question]) -> Result<Vec<Report>> {
    let answer = |question: &Question| question.answer().with_context(|| question.name.clone());
    questions.iter().map(answer).collect()
}

/// What the library has, with its sources.
fn list(library: &Library, json: bool) -> Result<()> {
    if json {
        return print_json(library);
    }
    print("materials\n")?;
    for (name, entry) in &library.materials {
        print(format_args!(
            "  {name:18} E {:e} Pa, Poisson's ratio {}: {}\n",
            entry.youngs_modulus_pa, entry.poisson_ratio, entry.source
        ))?;
    }
    print("shapes\n")?;
    for (name, entry) in &library.shapes {
        print(format_args!(
            "  {name:18} --{}, n = {}, factor {:.5}: {}\n",
            entry.dimension, entry.exponent, entry.factor, entry.source
        ))?;
    }
    Ok(())
}
