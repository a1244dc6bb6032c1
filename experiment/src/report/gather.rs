//! All runs of a report.

use super::origin::quoted;
use super::section::Planned;
use super::{Maps, Options, Origin, Report, ReportError};
use crate::sweep::{Cells, Definition, Plan, map_figure};
use crate::tuning::Tuned;
use std::path::Path;

/// What a report will run.
pub struct Work {
    options: Options,
    sections: Vec<Planned>,
    sweep: Plan,
}

impl Report {
    /// What `options` ask for; what makes no sense is refused here, before anything runs.
    pub fn plan(options: &Options, tuned: &Tuned) -> Result<Work, ReportError> {
        let planned = |name: &String| Planned::new(name, options);
        let mut definition = Definition::find(&options.sweep)?;
        definition.phases = options.sweep_phases;
        Ok(Work {
            sections: options.scenarios.iter().map(planned).collect::<Result<_, _>>()?,
            sweep: Plan::new(definition, tuned)?,
            options: options.clone(),
        })
    }
}

impl Work {
    /// Runs in all.
    pub fn runs(&self) -> usize {
        let sections: usize = self.sections.iter().map(Planned::runs).sum();
        sections + self.sweep.runs.len()
    }

    /// Run all of it. The sweep's runs go into the file `sweep_runs`; those that are there already are not run again.
    /// `done` is told of runs.
    pub fn run(
        self,
        tuned: &Tuned,
        sweep_runs: &Path,
        done: impl Fn(usize) + Sync,
    ) -> Result<Report, ReportError> {
        let runs = self.runs();
        let mut sections = Vec::new();
        for planned in &self.sections {
            sections.push(planned.run(tuned, &done)?);
        }
        let (plan, options) = (self.sweep, self.options);
        let (outcomes, _) = plan.run(sweep_runs, &done)?;
        let cells = Cells::new(&plan, &outcomes);
        let figure = |i| map_figure(&plan, &cells, i);
        let figures = (0..plan.definition.maps.len()).map(figure);
        let figures = figures.collect::<Result<_, _>>()?;
        let seed = plan.definition.scenario()?.timing.seed;
        Ok(Report {
            runs,
            sections,
            maps: Maps {
                origin: Origin {
                    command: format!(
                        "touchdown sweep {} --phases {}",
                        quoted(&options.sweep),
                        options.sweep_phases
                    ),
                    configuration_hash: format!("{:016x}", plan.hash()),
                    seeds: [seed, seed],
                },
                plan,
                cells,
                figures,
            },
            options,
        })
    }
}
