//! What of each law is tuned, and within which bounds.

use node::scenario::{Law, Scenario};
use serde::Serialize;
use std::collections::BTreeMap;

/// A key of the scenario that is tuned; its bounds are searched on a logarithmic scale.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Parameter {
    /// The key.
    pub key: &'static str,
    /// Lower bound, in the key's unit.
    pub low: f64,
    /// Upper bound, in the key's unit.
    pub high: f64,
    /// Where it is now.
    #[serde(skip)]
    value: fn(&Scenario) -> f64,
}

macro_rules! parameter {
    ($section:ident.$key:ident, $low:literal..$high:literal) => {
        Parameter {
            key: concat!("controller.", stringify!($section), ".", stringify!($key)),
            low: $low,
            high: $high,
            value: |scenario| scenario.controller.$section.$key,
        }
    };
}

const PD: &[Parameter] = &[
    parameter!(pd.proportional_m_per_n, 3e-7..3e-5),
    parameter!(pd.derivative_m_per_n, 1e-8..1e-4),
];

const PROPOSED: &[Parameter] = &[
    parameter!(proposed.object_filter_gain, 3e-3..1.0),
    parameter!(proposed.settled_filter_gain, 1e-3..0.3),
    parameter!(proposed.reference_bandwidth_hz, 2.0..80.0),
];

const IMPEDANCE: &[Parameter] = &[
    parameter!(impedance.mass_kg, 0.05..50.0),
    parameter!(impedance.damping_ns_per_m, 3e1..2e4),
    parameter!(proposed.object_filter_gain, 3e-3..1.0),
    parameter!(proposed.settled_filter_gain, 1e-3..0.3),
];

const ROS2: &[Parameter] = &[
    parameter!(ros2.mass_kg, 0.5..50.0),
    parameter!(ros2.damping_ratio, 0.5..500.0),
    parameter!(ros2.stiffness_n_per_m, 1.0..1e4),
    parameter!(ros2.filter_gain, 0.02..1.0),
];

const FZI: &[Parameter] = &[
    parameter!(fzi.proportional_translation, 5e-4..0.5),
    parameter!(fzi.derivative_s, 1e-5..0.1),
];

const ELASTIC: &[Parameter] = &[
    parameter!(elastic.effort_s2, 1e-6..1e-3),
    parameter!(elastic.contact_weight, 1e-3..10.0),
    parameter!(elastic.unknown_acceleration_m_per_s2, 1e-2..10.0),
];

/// What of `law` is tuned; nothing of a law without gains.
pub fn parameters(law: Law) -> &'static [Parameter] {
    match law {
        Law::Pd | Law::PdReset => PD,
        Law::Proposed => PROPOSED,
        Law::Impedance => IMPEDANCE,
        Law::Ros2 => ROS2,
        Law::Fzi => FZI,
        Law::Elastic => ELASTIC,
        Law::Literal => &[],
    }
}

/// The values at a point of the unit cube, to three digits: what is judged is what is written down.
pub(super) fn at(parameters: &[Parameter], point: &[f64]) -> BTreeMap<String, f64> {
    let value = |(parameter, share): (&Parameter, &f64)| {
        let Parameter { key, low, high, .. } = parameter;
        let value = low * libm::pow(high / low, *share);
        let scale = libm::pow(10.0, libm::floor(libm::log10(value)) - 2.0);
        let digits = libm::rint(value / scale);
        // By way of the text, so that it is the shortest one.
        let rounded = format!("{digits}e{}", libm::rint(libm::log10(scale)) as i64);
        let rounded = rounded.parse().unwrap_or(value);
        ((*key).to_owned(), f64::clamp(rounded, *low, *high))
    };
    parameters.iter().zip(point).map(value).collect()
}

/// The texts that put `values` into a scenario.
pub(super) fn overrides(values: &BTreeMap<String, f64>) -> Vec<String> {
    values
        .iter()
        .map(|(key, value)| format!("{key}={value:?}"))
        .collect()
}

/// Where `scenario` is in the unit cube, if need be on its border.
pub(super) fn of(parameters: &[Parameter], scenario: &Scenario) -> Vec<f64> {
    let share = |parameter: &Parameter| {
        let Parameter { low, high, value, .. } = parameter;
        let value = f64::clamp(value(scenario), *low, *high);
        libm::log(value / low) / libm::log(high / low)
    };
    parameters.iter().map(share).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const LAWS: [Law; 8] = [
        Law::Pd,
        Law::PdReset,
        Law::Literal,
        Law::Proposed,
        Law::Impedance,
        Law::Elastic,
        Law::Ros2,
        Law::Fzi,
    ];

    #[test]
    fn all_bounds_are_allowed_and_both_ends_are_reached() {
        for law in LAWS {
            let parameters = parameters(law);
            for share in [0.0, 0.37, 1.0] {
                let values = at(parameters, &vec![share; parameters.len()]);
                Scenario::default().with(&overrides(&values)).unwrap();
                for parameter in parameters {
                    let found = values[parameter.key];
                    assert!((parameter.low..=parameter.high).contains(&found), "{found}");
                    assert!(share != 1.0 || found == parameter.high);
                }
            }
        }
    }

    #[test]
    fn a_scenario_is_found_again_in_its_space() {
        let scenario = Scenario::default();
        let values = at(ROS2, &of(ROS2, &scenario));
        assert_eq!(values["controller.ros2.mass_kg"], 7.7);
        assert_eq!(values["controller.ros2.damping_ratio"], 2.83);
        assert_eq!(values["controller.ros2.filter_gain"], 0.05);
    }
}
