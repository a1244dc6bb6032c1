//! Every key of a scenario at, inside and beyond its limits: what is accepted runs, what is refused says why.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test fails by panicking")]

use experiment::in_process::{self, Tick};
use experiment::scenarios::Source;
use lcmtypes::Message;
use node::scenario::{Allowed, Key, Scenario};
use rayon::prelude::*;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// So long each runs, s: what the plant is made of for longer, since it may take that to swing up.
const SHORT_S: f64 = 0.024;
const LONG_S: f64 = 0.25;
/// Sections that the plant is made of.
const PLANT: [&str; 2] = ["robot", "sensor"];

/// Which of a number's values lies inside.
const INSIDE: usize = 1;

/// Values of `key` in TOML: at its limits and inside.
fn accepted(key: &Key) -> Vec<String> {
    let between = |limits: &std::ops::RangeInclusive<f64>| {
        let (start, end) = (*limits.start(), *limits.end());
        // Limits are some powers of ten apart, where both are positive.
        let middle = if start > 0.0 {
            libm::sqrt(start * end)
        } else {
            0.5 * (start + end)
        };
        [start, middle, end].map(|value| format!("{value:?}"))
    };
    match &key.allowed {
        Allowed::Number(limits) => between(limits).to_vec(),
        Allowed::Array(limits, count) => {
            let all = |value: String| format!("[{}]", vec![value; *count].join(", "));
            between(limits).map(all).to_vec()
        }
        Allowed::List(limits) => {
            let mut lists = between(limits)
                .map(|value| format!("[{value}, {value}]"))
                .to_vec();
            lists.extend([
                "[]".to_owned(),
                format!("[{:?}, {:?}]", limits.start(), limits.end()),
            ]);
            lists
        }
        Allowed::Integer(limits) => {
            let middle = limits.start() / 2 + limits.end() / 2;
            [*limits.start(), middle, *limits.end()]
                .map(|value| value.to_string())
                .to_vec()
        }
        Allowed::Flag => vec!["true".to_owned(), "false".to_owned()],
        Allowed::Word(words) => words.iter().map(|word| format!("{word:?}")).collect(),
    }
}

/// One value beyond each limit, in TOML, and how a refusal tells value and limit.
fn refused(key: &Key) -> Vec<(String, String)> {
    let told = |path: String, value: String, side: &str, limit: String| {
        let unit = if key.unit.is_empty() {
            String::new()
        } else {
            format!(" {}", key.unit)
        };
        format!("{path} is {value}{unit}, {side} the limit of {limit}{unit}; choose a value in ")
    };
    let number = |limits: &std::ops::RangeInclusive<f64>, path: &str, wrap: &dyn Fn(String) -> String| {
        let beyond =
            |limit: f64, outwards: f64| limit + outwards * if limit == 0.0 { 1.0 } else { libm::fabs(limit) };
        [("below", *limits.start(), -1.0), ("above", *limits.end(), 1.0)]
            .map(|(side, limit, outwards)| {
                let value = beyond(limit, outwards);
                (
                    wrap(format!("{value:?}")),
                    told(path.to_owned(), short(value), side, short(limit)),
                )
            })
            .to_vec()
    };
    match &key.allowed {
        Allowed::Number(limits) => number(limits, key.path, &|value| value),
        Allowed::Array(limits, count) => {
            let rest = vec![format!("{:?}", limits.start()); count - 1];
            let first = |value: String| format!("[{}]", [vec![value], rest.clone()].concat().join(", "));
            number(limits, &format!("{}[0]", key.path), &first)
        }
        Allowed::List(limits) => number(limits, &format!("{}[0]", key.path), &|value| format!("[{value}]")),
        Allowed::Integer(limits) => {
            let sides = [
                ("below", i128::from(*limits.start()), -1),
                ("above", i128::from(*limits.end()), 1),
            ];
            let one = |(side, limit, by): (&str, i128, i128)| {
                let value = (limit + by).to_string();
                (
                    value.clone(),
                    told(key.path.to_owned(), value, side, limit.to_string()),
                )
            };
            sides.map(one).to_vec()
        }
        Allowed::Flag | Allowed::Word(_) => Vec::new(),
    }
}

/// A number as messages have it.
fn short(value: f64) -> String {
    match libm::fabs(value) {
        magnitude if magnitude == 0.0 || (1e-4..1e6).contains(&magnitude) => value.to_string(),
        _ => format!("{value:e}"),
    }
}

/// The first message of `tick` that can't be published.
fn unusable(tick: &Tick) -> Option<String> {
    fn check<M: Message>(message: Option<&M>) -> Option<String> {
        let error = message?.encode().err()?;
        Some(format!("{}: {error}", M::CHANNEL))
    }
    let (sensor, controller) = (&tick.sensor, tick.controller.as_ref());
    check(Some(&tick.link_motion))
        .or_else(|| check(tick.robot_state.as_ref()))
        .or_else(|| check(Some(&sensor.tool_motion)))
        .or_else(|| check(Some(&sensor.truth)))
        .or_else(|| check(Some(&sensor.deflections)))
        .or_else(|| check(sensor.object_pose.as_ref()))
        .or_else(|| check(controller.map(|it| &it.command)))
        .or_else(|| check(controller.map(|it| &it.status)))
}

/// What is wrong with a run of `scenario`.
fn wrong(scenario: &Scenario, seconds: f64) -> Option<String> {
    let mut scenario = scenario.clone();
    scenario.timing.duration_s = seconds;
    let mut wrong = None;
    let run = AssertUnwindSafe(|| {
        in_process::run(&scenario, |tick| {
            if wrong.is_none() {
                wrong = unusable(tick).map(|what| format!("tick {}: {what}", tick.link_motion.stamp.step));
            }
        });
    });
    let panicked = catch_unwind(run).is_err().then(|| "it panics".to_owned());
    panicked.or(wrong)
}

/// How long `key` is tried on `base`.
fn seconds(base: &str, key: &Key) -> f64 {
    let plant = PLANT.contains(&key.section().split('.').next().unwrap_or_default());
    if plant && base == "elastic_arm" {
        LONG_S
    } else {
        SHORT_S
    }
}

/// Rigid gantry and elastic arm.
const BASES: [&str; 2] = ["paper", "elastic_arm"];

#[test]
fn what_is_accepted_runs() {
    let keys = Scenario::keys();
    let cases: Vec<_> = BASES
        .iter()
        .flat_map(|base| keys.iter().map(move |key| (base, key)))
        .flat_map(|(base, key)| {
            // What is inside on one of them: the plant of the other takes long to simulate.
            let inside = |i: &usize| *base == BASES[0] || *i != INSIDE;
            let values = accepted(key).into_iter().enumerate();
            values
                .filter(move |(i, _)| inside(i))
                .map(move |(_, value)| (base, key, value))
        })
        .collect();
    let results: Vec<_> = cases
        .par_iter()
        .map(|(base, key, value)| {
            let assignment = format!("{}={value}", key.path);
            match Source::find(base)
                .unwrap()
                .scenario(std::slice::from_ref(&assignment))
            {
                Ok(scenario) => {
                    let lost = wrong(&scenario, seconds(base, key));
                    (
                        true,
                        lost.map(|lost| format!("{base} --set {assignment}: {lost}")),
                    )
                }
                // Fine alone, not with the rest of the scenario: each line names a key.
                Err(error) => {
                    let text = error.to_string();
                    let tells = |line: &str| keys.iter().any(|key| line.contains(key.path));
                    let told = text.lines().all(tells);
                    (
                        false,
                        (!told).then(|| format!("{base} --set {assignment}: refused with {text}")),
                    )
                }
            }
        })
        .collect();
    let lost: Vec<_> = results.iter().filter_map(|(_, lost)| lost.clone()).collect();
    assert_eq!(lost, Vec::<String>::new());
    let ran = results.iter().filter(|(ran, _)| *ran).count();
    assert!(
        2 * ran > results.len(),
        "only {ran} of {} are accepted",
        results.len()
    );
}

#[test]
fn what_is_beyond_a_limit_is_refused_with_key_value_unit_and_limit() {
    let cases = Scenario::keys().into_iter().flat_map(|key| {
        let refused = refused(&key);
        refused
            .into_iter()
            .map(move |(value, told)| (key.path, value, told))
    });
    let mut count = 0;
    for (path, value, told) in cases {
        let error = Scenario::default()
            .with(&[format!("{path}={value}")])
            .unwrap_err()
            .to_string();
        assert!(error.contains(&told), "{error}\n{told}");
        count += 1;
    }
    assert!(count > 200, "{count}");
}
