//! The object as the sensor sees it: eqs. (2) and (12) as a model that is measured once and then refined.

use crate::command_dynamics::CommandDynamics;
use crate::contact::{Aim, ContactSample};
use node::scenario;
use spatial::ports::HORIZON;
use std::f64::consts::TAU;

/// The proposed law: the height of the object's surface along the contact's normal, and the way to where the
/// desired force results.
///
/// Paper II-B, below (2): the desired pose can be computed "from the measurements of a single time step with
/// contact". So the first sample in contact is taken fully; later ones only correct it, weighted low, because
/// the object stands still and what changes is noise, bounces and vibration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ObjectModel {
    gain: f64,
    /// Bandwidth of the reference model, rad/s.
    bandwidth: f64,
    aim: Aim,
    height_m: Option<f64>,
}

impl ObjectModel {
    /// No object known.
    pub fn new(parameters: &scenario::Proposed, aim: Aim) -> Self {
        Self {
            gain: parameters.object_filter_gain,
            bandwidth: TAU * parameters.reference_bandwidth_hz,
            aim,
            height_m: None,
        }
    }

    /// Take one sample of (12) in contact.
    pub fn take(&mut self, sample: &ContactSample) {
        self.height_m = Some(match self.height_m {
            None => sample.object_m,
            Some(height) => height + self.gain * (sample.object_m - height),
        });
    }

    /// Height of the object, m; `None` before the first contact.
    pub fn height_m(&self) -> Option<f64> {
        self.height_m
    }

    /// Paper (2): the height at which the hanging tcp has to be, `x_d = x_o - C f_d` along the normal, with
    /// `x_o = x_a + C f` measured before.
    pub fn desired_height_m(&self) -> Option<f64> {
        self.height_m
            .map(|height| height - self.aim.compliance_m_per_n * self.aim.desired_force_n)
    }

    /// The next set-points on the way to the desired height, along the reference model.
    pub fn set_points(&self, dynamics: &CommandDynamics) -> [f64; HORIZON] {
        let mut ahead = *dynamics;
        let target = self.desired_height_m().unwrap_or(dynamics.setpoint());
        std::array::from_fn(|_| {
            let setpoint = ahead.towards(target, self.bandwidth);
            ahead.advance(setpoint);
            setpoint
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_sample_counts_fully_and_later_ones_correct() {
        let parameters = scenario::Proposed {
            object_filter_gain: 0.1,
            ..Default::default()
        };
        let mut object = ObjectModel::new(
            &parameters,
            Aim {
                desired_force_n: 10.0,
                compliance_m_per_n: 28e-6,
            },
        );
        assert_eq!(object.desired_height_m(), None);
        object.take(&ContactSample {
            object_m: 0.010,
            ..Default::default()
        });
        assert_eq!(object.height_m(), Some(0.010));
        object.take(&ContactSample {
            object_m: 0.011,
            ..Default::default()
        });
        assert!((object.height_m().unwrap() - 0.0101).abs() < 1e-15);
        assert!((object.desired_height_m().unwrap() - (0.0101 - 280e-6)).abs() < 1e-15);
    }
}
