//! What of the plant a map varies.

use node::scenario::{Kinematics, Scenario};
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// A property of the plant that a map varies.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Axis {
    /// Stiffness of the contact while loading, c_in, N/m.
    ContactStiffness,
    /// Compliance that the controller assumes over the sensor's, both of translation and of rotation.
    ComplianceRatio,
    /// Delay of the sensor, ms: whole ticks.
    Delay,
    /// Lag of the robot's command filter behind a steady motion, 2 zeta / w, ms; the controller knows it.
    RobotLag,
    /// Mode of the gears of translation (of the arm: of its first joint), Hz; the others in proportion.
    GearMode,
    /// Command period T, ms: whole ticks.
    Period,
}

impl Axis {
    /// What it is called in figures, with its unit.
    pub fn label(&self) -> &'static str {
        match self {
            Self::ContactStiffness => "contact stiffness, N/m",
            Self::ComplianceRatio => "assumed / real compliance",
            Self::Delay => "delay of the sensor, ms",
            Self::RobotLag => "lag of the robot, ms",
            Self::GearMode => "gear mode, Hz",
            Self::Period => "command period T, ms",
        }
    }

    /// Its column in a file.
    pub fn column(&self) -> &'static str {
        match self {
            Self::ContactStiffness => "contact_stiffness_n_per_m",
            Self::ComplianceRatio => "compliance_ratio",
            Self::Delay => "delay_ms",
            Self::RobotLag => "robot_lag_ms",
            Self::GearMode => "gear_mode_hz",
            Self::Period => "period_ms",
        }
    }

    /// The texts that put `value` into a scenario like `scenario`.
    pub fn overrides(&self, value: f64, scenario: &Scenario) -> Vec<String> {
        match self {
            Self::ContactStiffness => vec![format!("object.indentation_n_per_m={value:?}")],
            Self::ComplianceRatio => {
                let sensor = &scenario.sensor;
                vec![
                    format!(
                        "controller.compliance_m_per_n={:?}",
                        value / sensor.stiffness_n_per_m
                    ),
                    format!(
                        "controller.compliance_rad_per_nm={:?}",
                        value / sensor.stiffness_nm_per_rad
                    ),
                ]
            }
            Self::Delay => vec![
                format!("sensor.delay_ticks={value:?}")
                    .trim_end_matches(".0")
                    .to_owned(),
            ],
            Self::RobotLag => {
                let frequency_hz = 2.0 * scenario.robot.filter_damping / (TAU * 1e-3 * value);
                ["robot", "controller"]
                    .map(|section| format!("{section}.filter_frequency_hz={frequency_hz:?}"))
                    .to_vec()
            }
            Self::GearMode => {
                let (section, own) = match scenario.robot.kinematics {
                    Kinematics::Gantry => ("gantry", scenario.robot.gantry.gear_frequency_hz),
                    Kinematics::Arm => ("arm", scenario.robot.arm.gear_frequency_hz),
                };
                let modes = own.map(|frequency_hz| frequency_hz * value / own[0]);
                vec![
                    "robot.gears=elastic".to_owned(),
                    format!("robot.{section}.gear_frequency_hz={modes:?}"),
                ]
            }
            Self::Period => vec![
                format!("timing.command_period_ticks={value:?}")
                    .trim_end_matches(".0")
                    .to_owned(),
            ],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_axis_changes_what_it_says() {
        let with = |axis: Axis, value: f64| {
            let scenario = Scenario::default();
            scenario.with(&axis.overrides(value, &scenario)).unwrap()
        };
        assert_eq!(with(Axis::ContactStiffness, 2e5).object.indentation_n_per_m, 2e5);
        assert_eq!(with(Axis::Delay, 12.0).sensor.delay_ticks, 12);
        assert_eq!(with(Axis::Period, 8.0).timing.command_period_ticks, 8);
        let gears = with(Axis::GearMode, 28.0).robot;
        assert_eq!(
            gears.gantry.gear_frequency_hz,
            [28.0, 28.0, 28.0, 40.0, 40.0, 40.0]
        );
        assert_eq!(gears.gears, node::scenario::Gears::Elastic);
        let wrong = with(Axis::ComplianceRatio, 1.5);
        assert_eq!(wrong.controller.compliance_m_per_n, 1.5 / 300e3);
        let slow = with(Axis::RobotLag, 2.0 * 0.8 / (TAU * 0.010));
        assert!((slow.robot.filter_frequency_hz - 10.0).abs() < 1e-12);
        assert_eq!(
            slow.robot.filter_frequency_hz,
            slow.controller.filter_frequency_hz
        );
    }
}
