//! Laws beside the lower bound over conditions that their tuning never saw: gears that are not as assumed, speeds, levers,
//! periods and lost messages, one at a time.

mod report;

pub use report::{ConditionRow, Report};

use crate::bound::{BoundError, bound};
use crate::compare::{Summary, outcomes, variations};
use node::scenario::{Kinematics, Scenario, ScenarioError};

/// Real gear modes over the assumed ones.
const MODES: [f64; 7] = [0.85, 0.9, 0.95, 1.0, 1.05, 1.1, 1.15];
/// Real damping ratios of the gears.
const DAMPINGS: [f64; 4] = [0.01, 0.02, 0.05, 0.1];
/// Approach speeds, m/s.
const SPEEDS: [f64; 5] = [0.005, 0.010, 0.020, 0.050, 0.100];
/// Levers of the tcp along x of the sensor, real and assumed, m.
const LEVERS: [f64; 4] = [0.0, 0.05, 0.1, 0.2];
/// Periods, ticks of 1 ms.
const PERIODS: [i64; 4] = [1, 4, 8, 12];
/// Shares of the messages between the devices that are lost.
const LOSSES: [f64; 4] = [0.0, 0.05, 0.1, 0.2];
/// How long the tool moves at its speed before the contact, so that the ramp has faded, s.
const CRUISE_S: f64 = 0.5;

/// A scenario with one thing changed.
#[derive(Clone, Debug, PartialEq)]
pub struct Condition {
    /// What is changed, with its unit.
    pub what: &'static str,
    /// To what.
    pub value: String,
    /// The scenario.
    pub scenario: Scenario,
}

/// What to run under each condition.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Plan {
    /// Words of `controller.law`.
    pub laws: Vec<String>,
    /// Contact phases relative to T.
    pub phases: usize,
    /// Seeds for each of them.
    pub seeds: usize,
}

/// Why there is no table.
#[derive(Debug, thiserror::Error)]
pub enum ConditionsError {
    /// A condition can't be combined with the scenario.
    #[error(transparent)]
    Scenario(#[from] ScenarioError),
    /// No bound.
    #[error(transparent)]
    Bound(#[from] BoundError),
}

/// All conditions on the rest of `scenario`.
pub fn conditions(scenario: &Scenario) -> Result<Vec<Condition>, ScenarioError> {
    let mut all = Vec::new();
    let mut add = |what, value: String, overrides: &[String]| -> Result<(), ScenarioError> {
        let scenario = scenario.with(overrides)?;
        all.push(Condition {
            what,
            value,
            scenario,
        });
        Ok(())
    };
    let (robot, section) = match scenario.robot.kinematics {
        Kinematics::Gantry => (scenario.robot.gantry.gear_frequency_hz, "gantry"),
        Kinematics::Arm => (scenario.robot.arm.gear_frequency_hz, "arm"),
    };
    for ratio in MODES {
        let real = robot.map(|hz| hz * ratio);
        let overrides = [format!("robot.{section}.gear_frequency_hz={real:?}")];
        add("gear mode, real/assumed", ratio.to_string(), &overrides)?;
    }
    for damping in DAMPINGS {
        let overrides = [format!("robot.gear_damping={damping:?}")];
        add("gear damping", damping.to_string(), &overrides)?;
    }
    for speed in SPEEDS {
        let value = (1e3 * speed).to_string();
        add("approach mm/s", value, &approach(scenario, speed))?;
    }
    for lever in LEVERS {
        let [_, y, z] = scenario.tool.tcp_in_s_m;
        let of = |x: f64| {
            let sensor = &scenario.sensor;
            1.0 / sensor.stiffness_n_per_m + (x * x + y * y) / sensor.stiffness_nm_per_rad
        };
        let gains = pd_gains(scenario, of(lever) / of(scenario.tool.tcp_in_s_m[0]));
        let levers = ["tool", "controller"].map(|of| format!("{of}.tcp_in_s_m=[{lever:?}, {y:?}, {z:?}]"));
        add(
            "lever mm",
            (1e3 * lever).to_string(),
            &[&levers[..], &gains].concat(),
        )?;
    }
    for ticks in PERIODS {
        let gains = pd_gains(
            scenario,
            ticks as f64 / scenario.timing.command_period_ticks as f64,
        );
        let period = [format!("timing.command_period_ticks={ticks}")];
        add("T ms", ticks.to_string(), &[&period[..], &gains].concat())?;
    }
    for ratio in LOSSES {
        let overrides = [format!("network.loss_ratio={ratio:?}")];
        add("lost messages %", (1e2 * ratio).to_string(), &overrides)?;
    }
    Ok(all)
}

/// With `speed` (m/s), from far enough and for long enough.
fn approach(scenario: &Scenario, speed: f64) -> Vec<String> {
    let task = &scenario.task;
    let [x, y, z] = task.start_position_m;
    let way = z - scenario.object.height_m;
    let longer =
        (speed * CRUISE_S + speed * speed / scenario.controller.shaping.acceleration_m_per_s2 - way).max(0.0);
    let slower_s = (way / speed - way / task.approach_speed_m_per_s).max(0.0);
    vec![
        format!("task.approach_speed_m_per_s={speed:?}"),
        format!("task.start_position_m=[{x:?}, {y:?}, {:?}]", z + longer),
        format!("timing.duration_s={:?}", scenario.timing.duration_s + slower_s),
    ]
}

/// The gains of (1), which are per cycle and per force, times `factor`: as tuned per time and per deflection.
fn pd_gains(scenario: &Scenario, factor: f64) -> Vec<String> {
    let pd = &scenario.controller.pd;
    vec![
        format!(
            "controller.pd.proportional_m_per_n={:?}",
            pd.proportional_m_per_n * factor
        ),
        format!(
            "controller.pd.derivative_m_per_n={:?}",
            pd.derivative_m_per_n * factor
        ),
    ]
}

impl Plan {
    /// Runs under `conditions`.
    pub fn runs(&self, conditions: &[Condition]) -> usize {
        conditions.len() * self.laws.len() * self.phases * self.seeds
    }

    /// Run all laws under all `conditions`, calling `done` after every run. What can't be combined is refused before the
    /// first run.
    pub fn run(
        &self,
        conditions: &[Condition],
        done: impl Fn() + Sync,
    ) -> Result<Vec<ConditionRow>, ConditionsError> {
        let mut prepared = Vec::new();
        for Condition {
            what,
            value,
            scenario,
        } in conditions
        {
            let bound = bound(scenario)?;
            let laws = self
                .laws
                .iter()
                .map(|law| scenario.with(&[format!("controller.law={law}")]));
            prepared.push((*what, value, bound, laws.collect::<Result<Vec<_>, _>>()?));
        }
        let mut rows = Vec::new();
        for (what, value, bound, scenarios) in prepared {
            let mut add = |law: &str, runs, summary, failures: Vec<String>| {
                rows.push(ConditionRow {
                    condition: what.to_owned(),
                    value: value.clone(),
                    law: law.to_owned(),
                    runs,
                    failed: failures.len(),
                    reason: failures.into_iter().next(),
                    figures: summary,
                });
            };
            for (law, scenario) in self.laws.iter().zip(&scenarios) {
                let outcomes = outcomes(&variations(scenario, self.phases, self.seeds), &done);
                let failures = outcomes.iter().filter_map(|outcome| outcome.as_ref().err());
                let failures: Vec<_> = failures.map(ToString::to_string).collect();
                let good: Vec<_> = outcomes.into_iter().filter(Result::is_ok).collect();
                add(
                    law,
                    good.len() + failures.len(),
                    Summary::of(&good).map(Into::into),
                    failures,
                );
            }
            add("bound", 1, Some(bound.least.into()), Vec::new());
        }
        Ok(rows)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenarios::Source;

    #[test]
    fn every_condition_is_a_valid_scenario() {
        for name in ["elastic", "elastic_arm"] {
            let scenario = Source::find(name).unwrap().scenario(&[]).unwrap();
            let all = conditions(&scenario).unwrap();
            assert_eq!(all.len(), 28);
            let nominal = all.iter().filter(|condition| condition.scenario == scenario);
            // One of each kind changes nothing.
            assert_eq!(nominal.count(), 6);
        }
    }
}
