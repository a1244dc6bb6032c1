//! A value of TOML into its place, if it fits.

use super::{
    choice::Choice,
    error::Refusal,
    names::Near,
    schema::{Slot, unit},
};
use std::ops::{Range, RangeInclusive};
use toml::{Spanned, de::DeValue};

/// A refusal and the bytes of the text that it is about.
pub(super) type Misfit = (Range<usize>, Refusal);

impl Slot<'_> {
    /// Takes `value` for the key `path`, or says all that keeps it from fitting.
    pub(super) fn put(self, path: &str, value: &Spanned<DeValue<'_>>) -> Result<(), Vec<Misfit>> {
        let here = |refusal| vec![(value.span(), refusal)];
        match self {
            Self::Number(place, limits) => *place = number(path, value.get_ref(), &limits).map_err(here)?,
            Self::Array(places, limits) => return array(places, path, value, &limits),
            Self::List(place, limits) => {
                let mut values = vec![0.0; value.get_ref().as_array().map_or(0, |items| items.len())];
                array(&mut values, path, value, &limits)?;
                *place = values;
            }
            Self::Integer(place, limits) => *place = integer(path, value.get_ref(), &limits).map_err(here)?,
            Self::Flag(place) => *place = flag(path, value.get_ref()).map_err(here)?,
            Self::Choice(place) => choose(place, path, value.get_ref()).map_err(here)?,
        }
        Ok(())
    }
}

fn array(
    places: &mut [f64],
    path: &str,
    value: &Spanned<DeValue<'_>>,
    limits: &RangeInclusive<f64>,
) -> Result<(), Vec<Misfit>> {
    let allowed = range(path, limits, decimal);
    let expected = places.len();
    let Some(items) = value.get_ref().as_array() else {
        let allowed = if expected == 0 {
            format!("values in {allowed}")
        } else {
            format!("{expected} values in {allowed}")
        };
        return Err(vec![(
            value.span(),
            wrong_type(path, value.get_ref(), "an array of numbers", allowed),
        )]);
    };
    if items.len() != expected {
        let (path, found) = (path.to_owned(), items.len());
        return Err(vec![(
            value.span(),
            Refusal::WrongCount {
                path,
                found,
                expected,
                allowed,
            },
        )]);
    }
    let mut misfits = Vec::new();
    for (i, (place, item)) in places.iter_mut().zip(items.iter()).enumerate() {
        match number(&format!("{path}[{i}]"), item.get_ref(), limits) {
            Ok(value) => *place = value,
            Err(refusal) => misfits.push((item.span(), refusal)),
        }
    }
    if misfits.is_empty() { Ok(()) } else { Err(misfits) }
}

fn number(path: &str, value: &DeValue<'_>, limits: &RangeInclusive<f64>) -> Result<f64, Refusal> {
    let number = match value {
        DeValue::Float(float) => float
            .as_str()
            .parse()
            .ok()
            .filter(|number: &f64| number.is_finite()),
        _ => whole(value).map(|whole| whole as f64),
    };
    match number {
        Some(number) => within(path, number, limits, decimal),
        None => {
            let allowed = format!("a value in {}", range(path, limits, decimal));
            Err(wrong_type(path, value, "a finite number", allowed))
        }
    }
}

fn integer(path: &str, value: &DeValue<'_>, limits: &RangeInclusive<i64>) -> Result<i64, Refusal> {
    let limits = i128::from(*limits.start())..=i128::from(*limits.end());
    match whole(value) {
        // Within limits that fit.
        Some(whole) => within(path, whole, &limits, i128::to_string).map(|whole| whole as i64),
        None => {
            let allowed = format!("a value in {}", range(path, &limits, i128::to_string));
            Err(wrong_type(path, value, "an integer", allowed))
        }
    }
}

/// TOML's integers have 64 bits; wider ones are read too, to be refused as out of range.
fn whole(value: &DeValue<'_>) -> Option<i128> {
    value
        .as_integer()
        .and_then(|integer| i128::from_str_radix(integer.as_str(), integer.radix()).ok())
}

fn flag(path: &str, value: &DeValue<'_>) -> Result<bool, Refusal> {
    let refusal = || wrong_type(path, value, "a truth value", "true or false".to_owned());
    value.as_bool().ok_or_else(refusal)
}

fn choose(place: &mut dyn Choice, path: &str, value: &DeValue<'_>) -> Result<(), Refusal> {
    let words = place.words().iter().map(|word| (*word, format!("{word:?}")));
    let allowed = words
        .clone()
        .map(|(_, quoted)| quoted)
        .collect::<Vec<_>>()
        .join(" or ");
    let Some(word) = value.as_str() else {
        return Err(wrong_type(path, value, "a word", allowed));
    };
    if place.choose(word) {
        return Ok(());
    }
    let path = path.to_owned();
    let near = Near::to(word, words);
    Err(Refusal::UnknownWord {
        path,
        word: word.to_owned(),
        allowed,
        near,
    })
}

/// `value` if it is within `limits`.
fn within<T: PartialOrd>(
    path: &str,
    value: T,
    limits: &RangeInclusive<T>,
    text: fn(&T) -> String,
) -> Result<T, Refusal> {
    let (side, limit) = if value < *limits.start() {
        ("below", limits.start())
    } else if value > *limits.end() {
        ("above", limits.end())
    } else {
        return Ok(value);
    };
    Err(Refusal::OutOfRange {
        path: path.to_owned(),
        value: with_unit(path, text(&value)),
        side,
        limit: with_unit(path, text(limit)),
        allowed: range(path, limits, text),
    })
}

fn wrong_type(path: &str, value: &DeValue<'_>, expected: &'static str, allowed: String) -> Refusal {
    let found = describe(value);
    Refusal::WrongType {
        path: path.to_owned(),
        found,
        expected,
        allowed,
    }
}

/// What a value of TOML is, in words.
pub(super) fn describe(value: &DeValue<'_>) -> String {
    match value {
        DeValue::String(text) => format!("{text:?}"),
        DeValue::Integer(integer) => integer.to_string(),
        DeValue::Float(float) => float.to_string(),
        DeValue::Boolean(flag) => flag.to_string(),
        DeValue::Datetime(_) => "a date or time".to_owned(),
        DeValue::Array(_) => "an array".to_owned(),
        DeValue::Table(_) => "a table".to_owned(),
    }
}

fn range<T>(path: &str, limits: &RangeInclusive<T>, text: fn(&T) -> String) -> String {
    with_unit(path, format!("{}..={}", text(limits.start()), text(limits.end())))
}

fn with_unit(path: &str, text: String) -> String {
    match unit(path) {
        "" => text,
        unit => format!("{text} {unit}"),
    }
}

/// A number as short as possible, with a power of ten where that is shorter to read.
pub(super) fn decimal(value: &f64) -> String {
    if *value == 0.0 || (1e-4..1e6).contains(&value.abs()) {
        value.to_string()
    } else {
        format!("{value:e}")
    }
}
