//! What is published of the loop's margins, when it is assessed, and what is said when they are small.

use super::assumed::{Situation, seconds};
use super::{Loop, Response};
use crate::Controller;
use spatial::ports::{ControllerStatus, Law};

/// The least gain margin that is not warned of.
const LEAST_GAIN_MARGIN: f64 = 2.0;
/// The least phase margin that is not warned of, deg.
const LEAST_PHASE_MARGIN_DEG: f64 = 30.0;

/// The margins of the loop by what the controller assumes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Assessment {
    /// The law that closes the loop.
    pub law: Law,
    /// How many times as much the sensor may show before the loop becomes unstable, to a thousandth, at most 1000; below
    /// 1, at least 0.001: it is unstable, and stable with that share. 0: not assessed.
    pub gain_margin: f64,
    /// Least angle from -1 where the open loop has magnitude 1, rad; pi: it never has. Negative: the loop is unstable. 0: not
    /// assessed.
    pub phase_margin_rad: f64,
}

impl Assessment {
    /// Of the `law` whose loop is `closed`; `None`: that has no numbers.
    pub fn new(law: Law, closed: &Loop) -> Option<Self> {
        if !closed.finite() {
            return None;
        }
        let found = closed.margins();
        let (gain_margin, phase_margin_rad) = match found.stable {
            true => (found.gain_margin, found.phase_margin_rad),
            false => (closed.stable_share(), -closed.crossover().0),
        };
        Some(Self {
            law,
            gain_margin,
            phase_margin_rad,
        })
    }

    /// Not assessed.
    pub fn none(law: Law) -> Self {
        Self {
            law,
            gain_margin: 0.0,
            phase_margin_rad: 0.0,
        }
    }

    /// As it was published.
    pub fn of(status: &ControllerStatus) -> Self {
        Self {
            law: status.law,
            gain_margin: status.gain_margin,
            phase_margin_rad: status.phase_margin_rad,
        }
    }

    /// Whether there are margins.
    pub fn known(&self) -> bool {
        self.gain_margin > 0.0
    }

    /// What there is to warn of: a margin below its limit, and the remedy.
    pub fn concern(&self) -> Option<String> {
        if !self.known() {
            return Some(
                "the loop's margins are not assessed: what [controller.servo], [controller.gears] and \
                 [controller.elastic] assume can't be regulated"
                    .to_owned(),
            );
        }
        let degrees = self.phase_margin_rad.to_degrees();
        let said = if self.gain_margin < 1.0 {
            format!(
                "the loop is unstable by what [controller] assumes, its gain margin {:.3} instead of at least \
                 {LEAST_GAIN_MARGIN:.0}",
                self.gain_margin
            )
        } else if self.gain_margin < LEAST_GAIN_MARGIN {
            format!(
                "the loop's gain margin is {:.2} by what [controller] assumes, less than {LEAST_GAIN_MARGIN:.0} (phase \
                 margin {degrees:.0} deg)",
                self.gain_margin
            )
        } else if degrees < LEAST_PHASE_MARGIN_DEG {
            format!(
                "the loop's phase margin is {degrees:.0} deg by what [controller] assumes, less than \
                 {LEAST_PHASE_MARGIN_DEG:.0} deg (gain margin {:.2})",
                self.gain_margin
            )
        } else {
            return None;
        };
        Some(format!("{said}: {}", remedy(self.law)))
    }
}

/// What makes the margins of a law larger.
fn remedy(law: Law) -> &'static str {
    match law {
        Law::Pd | Law::PdReset => {
            "lower controller.pd.proportional_m_per_n and controller.pd.derivative_m_per_n"
        }
        Law::Literal => "it has no gain; choose controller.law = \"proposed\"",
        Law::Proposed => "lower controller.proposed.settled_filter_gain",
        Law::Impedance => {
            "raise controller.impedance.damping_ns_per_m, or lower controller.proposed.settled_filter_gain"
        }
        Law::Ros2 => "raise controller.ros2.damping_ratio",
        Law::Fzi => "lower controller.fzi.error_scale",
        // A slower Kalman filter: the effort moves bandwidth and margin alike.
        Law::Elastic => {
            "lower controller.elastic.unknown_acceleration_m_per_s2, or raise controller.elastic.deflection_noise_m"
        }
    }
}

/// What was assessed last, and whether it still holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Assessor {
    pub(crate) published: Assessment,
    /// Something that matters has changed since.
    pub(crate) due: bool,
}

impl Assessor {
    /// Nothing assessed yet.
    pub(crate) fn new(law: Law) -> Self {
        Self {
            published: Assessment::none(law),
            due: true,
        }
    }
}

/// A controller as it is when its margins are to be assessed.
pub struct ToAssess(Controller);

impl ToAssess {
    /// The margins, which takes as long as several cycles.
    pub fn found(&self) -> Assessment {
        let none = Assessment::none(self.0.assessor.published.law);
        self.0.margins().unwrap_or(none)
    }
}

impl Controller {
    /// Assess the loop's margins, once the tare is known, and anew after an accepted request or a new tare; the cycles from
    /// then on publish them. Says what they are, if that is new.
    ///
    /// Not part of a cycle: it allocates, and takes as long as several. Whoever drives the controller calls it between two,
    /// after each, so that what is published does not depend on how long it took. In real time
    /// [`Self::to_assess`] leaves it to another thread.
    pub fn assess(&mut self) -> Option<Assessment> {
        let found = self.to_assess()?.found();
        self.publish_assessment(found)
    }

    /// What is to be assessed, if anything is.
    pub fn to_assess(&mut self) -> Option<ToAssess> {
        if !self.assessor.due || self.motion.is_none() {
            return None;
        }
        self.assessor.due = false;
        Some(ToAssess(self.clone()))
    }

    /// Publish what has been `found` from now on; says what that is, if it is new.
    pub fn publish_assessment(&mut self, found: Assessment) -> Option<Assessment> {
        let before = std::mem::replace(&mut self.assessor.published, found);
        (found != before || !before.known()).then_some(found)
    }

    /// With the values that have been accepted, to which those in force are on their way.
    pub(super) fn margins(&self) -> Option<Assessment> {
        let accepted = &self.parameters.accepted;
        let situation = Situation {
            kinematics: &self.settings.kinematics,
            axes: &self.start,
            period_s: self.settings.period_s(),
            sensor_delay_s: seconds(self.delay_ticks),
            force_n: accepted.task.pressing_force_n(),
        };
        let controller = &accepted.controller;
        let law = situation.law(controller, self.settings.elastic.as_deref())?;
        let response = Response::new(&situation.plant(controller)?)?;
        Assessment::new(controller.law, &Loop::close(&response, &law))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::margins::{Answer, Point};
    use nalgebra::Complex;

    fn said(gain_margin: f64, degrees: f64) -> Option<String> {
        Assessment {
            law: Law::Proposed,
            gain_margin,
            phase_margin_rad: degrees.to_radians(),
        }
        .concern()
    }

    #[test]
    fn what_is_below_its_limit_is_named_with_limit_and_remedy() {
        assert_eq!(said(2.01, 30.1), None);
        let small = said(1.534, 42.4).unwrap();
        assert!(
            small.starts_with("the loop's gain margin is 1.53 by what [controller] assumes, less than 2 (phase margin 42 deg)")
                && small.ends_with(": lower controller.proposed.settled_filter_gain"),
            "{small}"
        );
        let late = said(7.0, 21.0).unwrap();
        assert!(
            late.starts_with("the loop's phase margin is 21 deg")
                && late.contains("less than 30 deg (gain margin 7.00)"),
            "{late}"
        );
        let unstable = said(0.5, -10.0).unwrap();
        assert!(
            unstable.contains("unstable") && unstable.contains("gain margin 0.500 instead of at least 2"),
            "{unstable}"
        );
        assert!(said(0.0, 0.0).unwrap().contains("not assessed"));
    }

    /// A law whose regulator has no finite gain.
    #[test]
    fn what_has_no_numbers_is_not_assessed() {
        let answer = |by_sensor| Answer {
            by_sensor,
            by_encoder: Complex::from(0.0),
        };
        let closed = |by_sensor: f64| Loop {
            points: vec![
                Point {
                    frequency_hz: 1.0,
                    answer: answer(Complex::from(by_sensor)),
                };
                2
            ],
            integrators: 0,
        };
        assert_eq!(Assessment::new(Law::Elastic, &closed(f64::NAN)), None);
        assert!(Assessment::new(Law::Elastic, &closed(0.5)).is_some());
    }
}
