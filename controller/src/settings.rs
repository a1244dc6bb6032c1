//! What the scenario says, in the controller's terms, and what requests and steps have changed of it since.

use crate::elastic::Design;
use nalgebra::Vector3;
use node::scenario::{self, Scenario, TaskKind};
use spatial::kinematics::Kinematics;
use spatial::ports::Law;
use spatial::{Compliance, TICK_S, Wrench};
use std::f64::consts::TAU;
use std::sync::Arc;

/// What is in force now.
#[derive(Clone, Debug)]
pub(crate) struct Settings {
    pub(crate) seed: i64,
    pub(crate) period_ticks: i64,
    /// What the present step asks for; without a program the task as it is configured.
    pub(crate) task: scenario::Task,
    pub(crate) controller: scenario::Controller,
    pub(crate) kinematics: Kinematics,
    pub(crate) compliance: Compliance,
    pub(crate) d: Vector3<f64>,
    /// The wrench that is sought now, on its way to what is asked for.
    pub(crate) desired: Wrench,
    /// For the law of that name.
    pub(crate) elastic: Option<Arc<Design>>,
}

impl Settings {
    /// What `scenario` says.
    pub(crate) fn new(scenario: &Scenario) -> Self {
        let controller = &scenario.controller;
        Self {
            seed: scenario.timing.seed,
            period_ticks: scenario.timing.command_period_ticks,
            task: scenario.task.clone(),
            controller: controller.clone(),
            kinematics: scenario.robot.kinematics(),
            compliance: Compliance::isotropic(
                controller.compliance_m_per_n,
                controller.compliance_rad_per_nm,
            ),
            d: controller.tcp_in_s_m.into(),
            desired: Wrench {
                force: Vector3::z() * scenario.task.pressing_force_n(),
                moment: match scenario.task.kind {
                    TaskKind::Press => scenario.task.desired_moment_nm.into(),
                    TaskKind::Position | TaskKind::Calibrate => Vector3::zeros(),
                },
            },
            elastic: (controller.law == Law::Elastic)
                .then(|| Design::new(scenario).map(Arc::new))
                .flatten(),
        }
    }

    /// Periods from a cycle to the instant at which its first set-point is reached.
    pub(crate) fn lead(&self) -> i64 {
        self.controller.command_delay_periods + 1
    }

    /// The speed (m/s) at which the command is as far ahead of the actual pose as it may be, but for what acceleration
    /// adds: the tcp is sent where it arrives after the dead time, and the command filter lags by `2 zeta / w`. Faster, the
    /// way would wait and go on again and again.
    pub(crate) fn fastest_m_per_s(&self) -> f64 {
        let controller = &self.controller;
        let lag_s = 2.0 * controller.filter_damping / (TAU * controller.filter_frequency_hz);
        0.97 * controller.max_lead_m / (self.lead() as f64 * self.period_s() + lag_s)
    }

    /// T, s.
    pub(crate) fn period_s(&self) -> f64 {
        self.period_ticks as f64 * TICK_S
    }
}
