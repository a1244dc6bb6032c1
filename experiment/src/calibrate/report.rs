//! A calibration as people and programs read it: a table, JSON, and TOML to paste into a scenario.

use controller::calibration::{Calibration, Estimate};
use nalgebra::Vector3;
use node::scenario;
use serde::Serialize;
use std::collections::BTreeMap;
use std::fmt::{Display, Formatter, Result};

/// One quantity that was learnt.
#[derive(Clone, Debug, PartialEq)]
pub struct Quantity {
    /// Name with the unit as a suffix, as a scenario spells it.
    pub key: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// One value, or three along x, y and z of s.
    pub values: Vec<f64>,
    /// Their standard deviations.
    pub sigmas: Vec<f64>,
    /// What `[controller]` has for it; empty: no key.
    pub configured: Vec<f64>,
}

/// All that was learnt, in the order of the table.
#[derive(Clone, Debug, PartialEq)]
pub struct Report {
    /// The quantities.
    pub quantities: Vec<Quantity>,
    /// rms of the residuals, names as of [`Quantity::key`].
    pub residuals: Vec<(&'static str, &'static str, f64)>,
    /// What the values rest on that was not measured.
    pub assumed: Option<String>,
    /// What could not be learnt, and why.
    pub missing: Option<String>,
}

impl Report {
    /// What `calibration` tells beside what `controller` assumes.
    pub fn new(calibration: &Calibration, controller: &scenario::Controller) -> Self {
        let mut quantities = vec![scalar(
            "compliance_m_per_n",
            "m/N",
            &calibration.compliance_m_per_n,
            Some(controller.compliance_m_per_n),
        )];
        let mut residuals = vec![
            ("residual_translation_m", "m", calibration.translation_residual_m),
            ("residual_rotation_rad", "rad", calibration.rotation_residual_rad),
        ];
        if let Ok(estimate) = &calibration.compliance_rad_per_nm {
            let configured = Some(controller.compliance_rad_per_nm);
            quantities.push(scalar("compliance_rad_per_nm", "rad/Nm", estimate, configured));
        }
        if let Some(tool) = &calibration.tool {
            let (mass, centre) = (controller.tool_mass_kg, controller.tool_centre_of_mass_in_s_m);
            quantities.push(scalar("tool_mass_kg", "kg", &tool.mass_kg, Some(mass)));
            quantities.push(vector(
                "tool_centre_of_mass_in_s_m",
                "m",
                &tool.centre_of_mass_in_s_m,
                &centre,
            ));
            quantities.push(vector("bias_force_n", "N", &tool.force_bias_n, &[]));
            quantities.push(vector("bias_moment_nm", "Nm", &tool.moment_bias_nm, &[]));
            residuals.push(("residual_force_n", "N", tool.force_residual_n));
            residuals.push(("residual_moment_nm", "Nm", tool.moment_residual_nm));
        }
        quantities.push(vector(
            "bias_translation_m",
            "m",
            &calibration.translation_bias_m,
            &[],
        ));
        quantities.push(vector(
            "bias_rotation_rad",
            "rad",
            &calibration.rotation_bias_rad,
            &[],
        ));
        Self {
            quantities,
            residuals,
            assumed: calibration
                .tool
                .is_none()
                .then(|| assumed(calibration, controller)),
            missing: calibration
                .compliance_rad_per_nm
                .as_ref()
                .err()
                .map(ToString::to_string),
        }
    }

    /// What belongs into a scenario, as TOML.
    pub fn to_toml(&self) -> String {
        let mut text = "[controller]\n".to_owned();
        for quantity in self
            .quantities
            .iter()
            .filter(|quantity| !quantity.configured.is_empty())
        {
            let list = |values: &[f64]| match values {
                [value] => number(*value),
                _ => format!(
                    "[{}]",
                    values.iter().map(|v| number(*v)).collect::<Vec<_>>().join(", ")
                ),
            };
            let sigmas: Vec<_> = quantity
                .sigmas
                .iter()
                .map(|sigma| format!("{sigma:.1e}"))
                .collect();
            text += &format!(
                "{} = {} # +- {} {}\n",
                quantity.key,
                list(&quantity.values),
                sigmas.join(", "),
                quantity.unit
            );
        }
        text
    }

    /// Values by their names, for JSON.
    pub fn values(&self) -> BTreeMap<&'static str, Value> {
        let quantities = self.quantities.iter().map(|quantity| {
            let told = Value::Learnt {
                value: Numbers::of(&quantity.values),
                standard_deviation: Numbers::of(&quantity.sigmas),
                configured: (!quantity.configured.is_empty()).then(|| Numbers::of(&quantity.configured)),
            };
            (quantity.key, told)
        });
        let residuals = self
            .residuals
            .iter()
            .map(|&(key, _, value)| (key, Value::Residual(value)));
        quantities.chain(residuals).collect()
    }
}

/// A quantity in JSON.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Value {
    /// One that was learnt.
    Learnt {
        /// The estimate.
        value: Numbers,
        /// Its standard deviation.
        standard_deviation: Numbers,
        /// What `[controller]` has for it.
        #[serde(skip_serializing_if = "Option::is_none")]
        configured: Option<Numbers>,
    },
    /// The rms of a residual.
    Residual(f64),
}

/// One number or three.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Numbers {
    /// One.
    One(f64),
    /// Several.
    Several(Vec<f64>),
}

impl Numbers {
    fn of(values: &[f64]) -> Self {
        match values {
            [value] => Self::One(*value),
            _ => Self::Several(values.to_vec()),
        }
    }
}

impl Display for Report {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        let line = |f: &mut Formatter<'_>, [name, unit, value, sigma, configured]: [&str; 5]| {
            let text = format!("{name:30}{unit:8}{value:>13}{sigma:>20}{configured:>13}");
            writeln!(f, "{}", text.trim_end())
        };
        line(
            f,
            ["quantity", "unit", "value", "standard deviation", "configured"],
        )?;
        for quantity in &self.quantities {
            for (i, (value, sigma)) in quantity.values.iter().zip(&quantity.sigmas).enumerate() {
                let axis = if quantity.values.len() > 1 {
                    [" x", " y", " z"][i % 3]
                } else {
                    ""
                };
                let configured = quantity
                    .configured
                    .get(i)
                    .map_or(String::new(), |value| number(*value));
                line(
                    f,
                    [
                        &format!("{}{axis}", quantity.key),
                        quantity.unit,
                        &number(*value),
                        &format!("{sigma:.1e}"),
                        &configured,
                    ],
                )?;
            }
        }
        for (key, unit, value) in &self.residuals {
            line(f, [key, unit, &number(*value), "", ""])?;
        }
        match &self.assumed {
            Some(assumed) => writeln!(f, "\n{assumed}"),
            None => Ok(()),
        }
    }
}

/// What the compliances rest on without a measured wrench.
fn assumed(calibration: &Calibration, controller: &scenario::Controller) -> String {
    let mass = number(controller.tool_mass_kg);
    let centre = match calibration.compliance_rad_per_nm {
        Ok(_) => ", the rotational one on controller.tool_centre_of_mass_in_s_m too",
        Err(_) => "",
    };
    format!("no wrench is measured: compliances rest on controller.tool_mass_kg = {mass}{centre}")
}

/// Six digits, as TOML has them: 3.3345e-6, 0.0299946, 4.0.
fn number(value: f64) -> String {
    let rounded = format!("{value:.5e}").parse().unwrap_or(value);
    format!("{rounded:?}")
}

fn scalar(
    key: &'static str,
    unit: &'static str,
    estimate: &Estimate<f64>,
    configured: Option<f64>,
) -> Quantity {
    Quantity {
        key,
        unit,
        values: vec![estimate.value],
        sigmas: vec![estimate.sigma],
        configured: configured.into_iter().collect(),
    }
}

fn vector(
    key: &'static str,
    unit: &'static str,
    estimate: &Estimate<Vector3<f64>>,
    configured: &[f64],
) -> Quantity {
    Quantity {
        key,
        unit,
        values: estimate.value.iter().copied().collect(),
        sigmas: estimate.sigma.iter().copied().collect(),
        configured: configured.to_vec(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use node::scenario::Scenario;

    fn report() -> Report {
        let estimate = |value, sigma| Estimate { value, sigma };
        let calibration = Calibration {
            tool: None,
            compliance_m_per_n: estimate(3.338_333e-6, 3.3e-9),
            compliance_rad_per_nm: Ok(estimate(2.492_14e-3, 1.2e-6)),
            translation_bias_m: Estimate {
                value: Vector3::new(1e-6, 0.0, -2e-6),
                sigma: Vector3::repeat(1e-7),
            },
            rotation_bias_rad: Estimate::default(),
            translation_residual_m: 8e-8,
            rotation_residual_rad: 1.7e-6,
        };
        Report::new(&calibration, &Scenario::default().controller)
    }

    /// What is printed to be pasted is read as what was found.
    #[test]
    fn the_toml_is_a_scenario() {
        let scenario = Scenario::parse("found.toml", &report().to_toml(), &[]).unwrap();
        assert_eq!(scenario.controller.compliance_m_per_n, 3.33833e-6);
        assert_eq!(scenario.controller.compliance_rad_per_nm, 2.49214e-3);
    }

    #[test]
    fn the_table_names_units_and_what_is_configured() {
        let table = report().to_string();
        let lines: Vec<_> = table.lines().collect();
        assert_eq!(
            lines[..3],
            [
                "quantity                      unit            value  standard deviation   configured",
                "compliance_m_per_n            m/N        3.33833e-6              3.3e-9   3.33333e-6",
                "compliance_rad_per_nm         rad/Nm     0.00249214              1.2e-6   0.00249333",
            ]
        );
        assert!(
            lines.contains(&"bias_translation_m z          m               -2e-6              1.0e-7"),
            "{table}"
        );
        assert!(table.ends_with(
            "tool_mass_kg = 4.0, the rotational one on controller.tool_centre_of_mass_in_s_m too\n"
        ));
    }
}
