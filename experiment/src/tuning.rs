//! Tuned gains for every law, by a stated criterion within stated bounds and budget: the other half of an honest
//! comparison.
//!
//! Untuned laws look spectacularly bad and prove nothing. So each law has a row as it is configured (a peer's: as it is
//! published) and one that this search has found. It sees the plant through training runs only, whose contact phases and
//! seeds no comparison uses; what it found is judged on a held-out set of yet others.

mod entry;
mod search;
mod space;

pub use entry::{Entry, Tuned, TuningError};
pub use space::{Parameter, parameters};

use crate::compare::{outcomes, variations_from};
use crate::linear::{self, Margins};
use crate::metrics::{Metrics, NoFigures};
use node::scenario::{Law, Scenario, ScenarioError};
use search::Search;
use serde::{Deserialize, Serialize};

/// With which gains a law runs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Gains {
    /// Those of the scenario: of the peers' laws, what is published.
    #[default]
    Default,
    /// Those that `touchdown tune` has found.
    Tuned,
}

impl Gains {
    /// As it is spelt on the command line.
    pub fn word(&self) -> &'static str {
        match self {
            Self::Default => "default",
            Self::Tuned => "tuned",
        }
    }

    /// What is added to the name of a law.
    pub(crate) fn suffix(&self) -> &'static str {
        match self {
            Self::Default => "",
            Self::Tuned => " (tuned)",
        }
    }
}

/// What a search may cost, and on what it is judged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Budget {
    /// Points of the parameter space that are tried.
    pub evaluations: usize,
    /// Training runs of each point, and held-out runs of the best one: contact phases, one seed each.
    pub runs: usize,
    /// Shifts the points that the search begins with.
    pub seed: u64,
}

/// Contact phases from this one on, and seeds from this one on, are the training's; as many more are held out. A
/// comparison uses those from 0 on.
const FIRST: usize = 1000;

/// What a run costs that gives no figures: a latched fault.
pub const FAULTY: f64 = 100.0;
/// What a settling time counts that is none, s: the whole window.
const NEVER_S: f64 = crate::metrics::WINDOW_S;

/// The criterion of one run, without unit; smaller is better:
/// `IAE / (f_d 50 ms) + peak / (2 f_d) + set10 / 100 ms`. About 1 for a law that takes the object where it is, within what
/// the robot can do; a run that never settles counts its whole window, one that latches a fault [`FAULTY`].
pub fn criterion(outcome: &Result<Metrics, NoFigures>, desired_n: f64) -> f64 {
    let Ok(metrics) = outcome else { return FAULTY };
    let settling_s = if metrics.settling_10_s.is_nan() {
        NEVER_S
    } else {
        metrics.settling_10_s
    };
    let cost =
        metrics.iae_n_s / (0.050 * desired_n) + metrics.peak_n / (2.0 * desired_n) + settling_s / 0.100;
    cost.min(FAULTY)
}

/// Which runs a point is judged on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Set {
    /// Those that the search sees.
    Training,
    /// Those that it does not.
    HeldOut,
}

/// The mean criterion of `scenario` over `runs` runs of a set, with nothing that calms a law that swings up; the same
/// whatever the number of threads.
pub fn judge(scenario: &Scenario, set: Set, runs: usize) -> f64 {
    let first = match set {
        Set::Training => FIRST,
        Set::HeldOut => FIRST + runs,
    };
    let mut alone = scenario.clone();
    alone.controller.oscillation.enabled = false;
    let varied: Vec<Scenario> = (first..first + runs)
        .flat_map(|run| variations_from(&alone, run..run + 1, run as i64..run as i64 + 1))
        .collect();
    let desired_n = scenario.task.pressing_force_n();
    let costs = outcomes(&varied, || ())
        .into_iter()
        .map(|outcome| criterion(&outcome, desired_n));
    costs.sum::<f64>() / runs as f64
}

/// What a search has found.
#[derive(Clone, Debug, Serialize)]
pub struct Found {
    /// For the file of tuned gains.
    #[serde(flatten)]
    pub entry: Entry,
    /// Margins of the loop, by linear theory; `None`: the law has no linear model.
    pub margins: Option<Margins>,
    /// The bounds that were searched.
    pub parameters: Vec<Parameter>,
}

/// Tune the law of `scenario` within [`parameters`]; `name` says where the scenario comes from. `done` is called after
/// every evaluation. `None`: the law has nothing to tune.
pub fn tune(
    name: &str,
    scenario: &Scenario,
    budget: &Budget,
    done: impl Fn() + Sync,
) -> Result<Option<Found>, ScenarioError> {
    let parameters = parameters(scenario.controller.law);
    if parameters.is_empty() {
        return Ok(None);
    }
    let evaluate = |point: &[f64]| {
        let cost = scenario
            .with(&space::overrides(&space::at(parameters, point)))
            .map_or(FAULTY, |tried| judge(&tried, Set::Training, budget.runs));
        done();
        cost
    };
    let start = space::of(parameters, scenario);
    let search = Search {
        evaluations: budget.evaluations,
        seed: budget.seed,
    };
    let best = search.run(&start, evaluate);
    let values = space::at(parameters, &best);
    let tuned = scenario.with(&space::overrides(&values))?;
    let margins = linear::closed(&tuned).map(|found| found.margins());
    let entry = Entry {
        law: law_word(scenario.controller.law).to_owned(),
        robot: crate::scenarios::word(scenario.robot.gears),
        kinematics: crate::scenarios::word(scenario.robot.kinematics),
        scenario: name.to_owned(),
        evaluations: budget.evaluations,
        runs: budget.runs,
        criterion_default: judge(scenario, Set::HeldOut, budget.runs),
        criterion_training: judge(&tuned, Set::Training, budget.runs),
        criterion_held_out: judge(&tuned, Set::HeldOut, budget.runs),
        gain_margin: margins.map(|margins| margins.gain_margin),
        phase_margin_rad: margins.map(|margins| margins.phase_margin_rad),
        values,
    };
    Ok(Some(Found {
        entry,
        margins,
        parameters: parameters.to_vec(),
    }))
}

/// The law as a scenario spells it.
pub fn law_word(law: Law) -> &'static str {
    match law {
        Law::Pd => "pd",
        Law::PdReset => "pd-reset",
        Law::Literal => "literal",
        Law::Proposed => "proposed",
        Law::Impedance => "impedance",
        Law::Elastic => "elastic",
        Law::Ros2 => "ros2",
        Law::Fzi => "fzi",
    }
}
