//! What holds for every key of the schema and for every text.

use super::{PAPER, refusal};
use crate::scenario::{Allowed, Key, Scenario, value::decimal};
use proptest::{prelude::*, sample::Index};
use toml::de::DeValue;

/// A value that `key` accepts, as TOML: the limits for 0 and 1, between them otherwise.
fn accepted(key: &Key, at: f64) -> String {
    let number = |limits: &std::ops::RangeInclusive<f64>| {
        let value = limits.start() * (1.0 - at) + limits.end() * at;
        format!("{:?}", value.clamp(*limits.start(), *limits.end()))
    };
    match &key.allowed {
        Allowed::Number(limits) => number(limits),
        Allowed::Array(limits, count) => format!("[{}]", vec![number(limits); *count].join(", ")),
        Allowed::List(limits) => format!("[{}, {}]", number(limits), number(limits)),
        Allowed::Integer(limits) => {
            let value = *limits.start() as f64 * (1.0 - at) + *limits.end() as f64 * at;
            (value as i64).clamp(*limits.start(), *limits.end()).to_string()
        }
        Allowed::Flag => (at > 0.5).to_string(),
        Allowed::Word(words) => format!("{:?}", words[(at * (words.len() - 1) as f64).round() as usize]),
    }
}

/// Puts `value`, in TOML, at `path` without checking the scenario as a whole.
fn put(scenario: &mut Scenario, path: &str, value: &str) {
    let field = scenario.fields().find(|field| field.path == path).unwrap();
    field.slot.put(path, &DeValue::parse(value).unwrap()).unwrap();
}

/// The value of `path`, in TOML.
fn get(scenario: &mut Scenario, path: &str) -> String {
    scenario
        .fields()
        .find(|field| field.path == path)
        .unwrap()
        .slot
        .to_toml()
}

/// `limit` moved outwards by the factor (or, at 0, the amount) `by`.
fn beyond(limit: f64, outwards: f64, by: f64) -> f64 {
    limit + outwards * by * if limit == 0.0 { 1.0 } else { limit.abs() }
}

#[test]
fn every_default_is_accepted_and_means_itself() {
    for key in Scenario::keys() {
        let mut scenario = Scenario::default();
        put(&mut scenario, key.path, &key.default);
        assert_eq!(scenario, Scenario::default(), "{}", key.path);
    }
}

#[test]
fn integers_are_accepted_where_numbers_are_expected() {
    for key in Scenario::keys() {
        if let Allowed::Number(limits) = &key.allowed
            && limits.contains(&1.0)
        {
            let mut scenario = Scenario::default();
            put(&mut scenario, key.path, "1");
            assert_eq!(get(&mut scenario, key.path), "1.0");
        }
    }
}

#[test]
fn every_key_changes_the_hash() {
    let mut hashes = vec![Scenario::default().hash()];
    for key in Scenario::keys() {
        for at in [0.25, 0.75] {
            let value = accepted(&key, at);
            let mut scenario = Scenario::default();
            put(&mut scenario, key.path, &value);
            if scenario != Scenario::default() {
                hashes.push(scenario.hash());
            }
        }
    }
    // A flag can change once, and what has only one word can't.
    let keys = Scenario::keys();
    let count = |is: fn(&Allowed) -> bool| keys.iter().filter(|key| is(&key.allowed)).count();
    let fixed = count(|allowed| matches!(allowed, Allowed::Word([_])));
    let flags = count(|allowed| matches!(allowed, Allowed::Flag));
    assert!(
        hashes.len() > 2 * (keys.len() - fixed) - flags - 12,
        "{} hashes",
        hashes.len()
    );
    let all = hashes.len();
    hashes.sort_unstable();
    hashes.dedup();
    assert_eq!(hashes.len(), all);
}

#[test]
fn every_component_changes_the_hash() {
    let mut scenarios = vec![Scenario::default(); 7];
    for (i, scenario) in scenarios.iter_mut().take(6).enumerate() {
        scenario.robot.gantry.motor_inertia_kg_m2[i] += 1e-12;
    }
    let mut hashes: Vec<_> = scenarios.iter().map(Scenario::hash).collect();
    hashes.sort_unstable();
    hashes.dedup();
    assert_eq!(hashes.len(), 7);
}

proptest! {
    #[test]
    fn values_within_the_limits_are_accepted(key in any::<Index>(), at in prop_oneof![Just(0.0), Just(1.0), 0.0..1.0]) {
        let keys = Scenario::keys();
        let key = key.get(&keys);
        let (mut scenario, value) = (Scenario::default(), accepted(key, at));
        put(&mut scenario, key.path, &value);
        prop_assert_eq!(get(&mut scenario, key.path), value);
    }

    #[test]
    fn values_beyond_a_limit_are_refused_with_key_value_and_limit(
        key in any::<Index>(), component in 0_usize..6, above: bool, by in 1e-6..1e3
    ) {
        let keys = Scenario::keys();
        let key = key.get(&keys);
        let side = if above { "above" } else { "below" };
        let outside = |limits: &std::ops::RangeInclusive<f64>| {
            let (limit, outwards) = if above { (*limits.end(), 1.0) } else { (*limits.start(), -1.0) };
            (limit, beyond(limit, outwards, by))
        };
        let (path, value, text, limit) = match &key.allowed {
            Allowed::Number(limits) => {
                let (limit, value) = outside(limits);
                (key.path.to_owned(), decimal(&value), format!("{value:?}"), decimal(&limit))
            }
            Allowed::Array(limits, count) => {
                let ((limit, value), i) = (outside(limits), component % count);
                let mut texts = vec![format!("{:?}", limits.start()); *count];
                texts[i] = format!("{value:?}");
                (format!("{}[{i}]", key.path), decimal(&value), format!("[{}]", texts.join(",")), decimal(&limit))
            }
            Allowed::List(limits) => {
                let (limit, value) = outside(limits);
                let text = format!("[{:?}, {value:?}]", limits.start());
                (format!("{}[1]", key.path), decimal(&value), text, decimal(&limit))
            }
            Allowed::Integer(limits) => {
                let limit = if above { *limits.end() } else { *limits.start() };
                let value = i128::from(limit) + if above { 1 } else { -1 } * (1.0 + by) as i128;
                (key.path.to_owned(), value.to_string(), value.to_string(), limit.to_string())
            }
            Allowed::Flag | Allowed::Word(_) => return Ok(()),
        };
        let unit = if key.unit.is_empty() { String::new() } else { format!(" {}", key.unit) };
        let expected = format!("{path} is {value}{unit}, {side} the limit of {limit}{unit}; choose a value in ");
        let message = refusal(&format!("{} = {text}", key.path), &[]);
        prop_assert!(message.contains(&expected), "{message}\n{expected}");
    }

    #[test]
    fn order_and_comments_do_not_change_the_hash(
        keys in Just(Scenario::keys()).prop_shuffle(), comment in "[ -~]{0,10}"
    ) {
        let text: String =
            keys.iter().map(|key| format!("{} =   {} # {comment}\n\n", key.path, key.default)).collect();
        let scenario = Scenario::parse("shuffled.toml", &text, &[]).unwrap();
        prop_assert_eq!(scenario.hash(), Scenario::parse("paper.toml", PAPER, &[]).unwrap().hash());
    }

    #[test]
    fn no_text_ends_the_process(text in "\\PC*", key in any::<Index>(), at in any::<Index>()) {
        let keys = Scenario::keys();
        let key = key.get(&keys);
        let _ = Scenario::parse("a.toml", &text, &[format!("{}={text}", key.path), text.clone()]);

        let mut spoiled = PAPER.to_owned();
        let at = at.index(spoiled.len());
        spoiled.insert_str((0..=at).rev().find(|&at| spoiled.is_char_boundary(at)).unwrap_or(0), &text);
        let _ = Scenario::parse("a.toml", &spoiled, &[]).map_err(|error| error.to_string());
    }
}
