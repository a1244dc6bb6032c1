//! The assessment in the running controller: before, at and after the contact.

use super::bounce::second_impact_speed_ratio;
use super::speed::SpeedEstimate;
use super::strike::{Striker, Surface};
use super::{ImpactError, KicksLaw, Rebound, ToolInertia};
use nalgebra::Vector3;
use node::scenario;
use spatial::ports::ImpactAssessment;

/// Watches the approach and says what impact its speed would cause; once there is contact, what impact it was.
///
/// All it knows of tool and object is assumed (`[controller.impact]`); what they are is another entry of the scenario.
#[derive(Clone, Debug, PartialEq)]
pub struct ImpactMonitor {
    surface: Surface,
    effective_mass_kg: f64,
    /// Highest approach speed for the allowed force; `None`: any force is allowed.
    speed_limit_m_per_s: Option<f64>,
    speed: SpeedEstimate,
    /// Speed of the object towards the tool, as expected.
    object_m_per_s: f64,
    /// The speed measured at the contact.
    contact_speed_m_per_s: Option<f64>,
}

/// The smallest force that can be asked for, N: none at all would forbid any contact.
const LEAST_FORCE_N: f64 = 1e-6;

impl ImpactMonitor {
    /// With what the `controller` assumes of a tool whose tcp strikes along `normal_in_s`, for the allowed force of
    /// the `task`.
    pub fn new(
        controller: &scenario::Controller,
        task: &scenario::Task,
        normal_in_s: Vector3<f64>,
    ) -> Result<Self, ImpactError> {
        let assumed = &controller.impact;
        let surface = Surface {
            law: KicksLaw::new(assumed.indentation_n_per_m, assumed.exponent)?,
            rebound: Rebound::new(assumed.rebound_ratio)?,
        };
        let tool = ToolInertia::new(
            assumed.tool_mass_kg,
            assumed.tool_inertia_kg_m2,
            assumed.centre_of_mass_in_s_m,
        )?;
        let effective_mass_kg = tool.at_tcp_kg(controller.tcp_in_s_m.into(), normal_in_s);
        let allowed_n = (task.max_impact_force_n > 0.0).then(|| task.max_impact_force_n.max(LEAST_FORCE_N));
        // The faster one of the first two impacts counts.
        let faster = second_impact_speed_ratio(&surface.rebound, assumed.exponent).max(1.0);
        let speed_limit = allowed_n.map(|force| {
            let speed = surface.speed_for_force_m_per_s(effective_mass_kg, force)?;
            Ok::<_, ImpactError>(speed / faster)
        });
        Ok(Self {
            surface,
            effective_mass_kg,
            speed_limit_m_per_s: speed_limit.transpose()?,
            speed: SpeedEstimate::default(),
            object_m_per_s: 0.0,
            contact_speed_m_per_s: None,
        })
    }

    /// The approach speed (m/s) that is allowed where `requested` is asked for.
    pub fn allowed_speed_m_per_s(&self, requested: f64) -> f64 {
        self.speed_limit_m_per_s
            .map_or(requested, |limit| requested.min(limit))
    }

    /// Take one sample before the contact, or the one that detects it: see [`SpeedEstimate::take`]. The object is
    /// expected to come towards the tool with `object_m_per_s`.
    pub fn take(&mut self, time_s: f64, [tcp_m, hanging_m]: [f64; 2], object_m_per_s: f64) {
        if self.contact_speed_m_per_s.is_none() {
            self.speed.take(time_s, tcp_m, hanging_m);
            self.object_m_per_s = object_m_per_s;
        }
    }

    /// The sample taken last has detected the contact.
    pub fn contact(&mut self) {
        self.contact_speed_m_per_s
            .get_or_insert(self.speed.at_contact(self.object_m_per_s));
    }

    /// The impact that the present speed would cause; after the contact, the one that the speed measured at the contact
    /// has caused. Without a speed towards the object there is none.
    pub fn assessment(&self) -> ImpactAssessment {
        let speed = self
            .contact_speed_m_per_s
            .unwrap_or_else(|| self.speed.present() + self.object_m_per_s);
        let none = ImpactAssessment {
            speed_m_per_s: speed,
            effective_mass_kg: self.effective_mass_kg,
            speed_limit_m_per_s: self.speed_limit_m_per_s.unwrap_or(0.0),
            ..ImpactAssessment::default()
        };
        Striker::new(self.effective_mass_kg, speed).map_or(none, |striker| {
            let impact = self.surface.struck_by(&striker);
            ImpactAssessment {
                peak_force_n: impact.peak_force_n,
                maximum_depth_m: impact.maximum_depth_m,
                characteristic_time_s: impact.characteristic_time_s(),
                ..none
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use node::scenario::{Allowed, Controller, Scenario, Task};

    fn monitor(max_impact_force_n: f64) -> ImpactMonitor {
        let task = Task {
            max_impact_force_n,
            ..Task::default()
        };
        ImpactMonitor::new(&Controller::default(), &task, Vector3::z()).unwrap()
    }

    /// 107.264 N at 20 mm/s (PLANT.md section 5): 53.632 N allow half of it.
    #[test]
    fn the_allowed_force_limits_the_speed() {
        let limited = monitor(53.632).allowed_speed_m_per_s(0.02);
        assert!((limited - 0.01).abs() < 1e-6, "{limited}");
        assert_eq!(monitor(53.632).allowed_speed_m_per_s(0.005), 0.005);
        // Off an elastic object the tool comes back 1.638 times as fast.
        let mut controller = Controller::default();
        controller.impact.rebound_ratio = 1.0;
        let task = Task {
            max_impact_force_n: 53.632,
            ..Task::default()
        };
        let elastic = ImpactMonitor::new(&controller, &task, Vector3::z()).unwrap();
        let limited = elastic.allowed_speed_m_per_s(0.02);
        assert!((limited - 0.01 / 1.638).abs() < 1e-5, "{limited}");
        assert_eq!(monitor(0.0).allowed_speed_m_per_s(1.0), 1.0);
        assert_eq!(monitor(0.0).assessment().speed_limit_m_per_s, 0.0);
    }

    #[test]
    fn the_impact_is_told_before_and_kept_after_the_contact() {
        let mut monitor = monitor(0.0);
        assert_eq!(monitor.assessment().peak_force_n, 0.0);
        let height = |tick: i32| -2e-5 * f64::from(tick);
        (0..100).for_each(|tick| monitor.take(f64::from(tick) * 1e-3, [height(tick); 2], 0.0));
        let before = monitor.assessment();
        assert!((before.peak_force_n - 107.264).abs() < 0.001 && (before.speed_m_per_s - 0.02).abs() < 1e-9);
        // pi/2 sqrt(M / c_in) to get in, half of that out with c_re = 4 c_in.
        assert!(
            (before.characteristic_time_s - 0.7898e-3).abs() < 1e-7,
            "{before:?}"
        );
        monitor.take(0.1, [height(99), height(100)], 0.0);
        monitor.contact();
        let after = monitor.assessment();
        assert!((after.peak_force_n - 107.264).abs() < 0.1, "{after:?}");
        // Pressing says nothing new.
        (100..200).for_each(|tick| monitor.take(f64::from(tick) * 1e-3, [height(99); 2], 0.0));
        monitor.contact();
        assert_eq!(monitor.assessment(), after);
    }

    /// What a scenario may say, an assessment can be made of: at any corner of the ranges.
    #[test]
    fn no_scenario_is_beyond_the_assessment() {
        let keys: Vec<_> = Scenario::keys()
            .into_iter()
            .filter(|key| key.section() == "controller.impact" || key.path == "controller.tcp_in_s_m")
            .collect();
        assert_eq!(keys.len(), 7);
        for corner in 0..1 << keys.len() {
            let overrides = keys.iter().enumerate().map(|(i, key)| {
                let end = |limits: &std::ops::RangeInclusive<f64>| match corner >> i & 1 {
                    0 => *limits.start(),
                    _ => *limits.end(),
                };
                match &key.allowed {
                    Allowed::Number(limits) => format!("{}={:?}", key.path, end(limits)),
                    Allowed::Array(limits, count) => format!("{}={:?}", key.path, vec![end(limits); *count]),
                    other => panic!("{}: {other:?}", key.path),
                }
            });
            let overrides: Vec<_> = overrides.collect();
            let scenario = Scenario::default().with(&overrides).unwrap();
            for max_impact_force_n in [0.0, 1e-300, 1.0, 1e6] {
                let task = Task {
                    max_impact_force_n,
                    ..Task::default()
                };
                let monitor = ImpactMonitor::new(&scenario.controller, &task, Vector3::z()).unwrap();
                assert!(monitor.allowed_speed_m_per_s(1.0) > 0.0, "{overrides:?}");
            }
        }
    }
}
