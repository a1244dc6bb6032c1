//! The object as the sensor sees it: eqs. (2) and (12) as a model that is measured once and then refined.

use node::scenario;

/// The height of the object's surface along the contact's normal.
///
/// Paper II-B, below (2): the desired pose can be computed "from the measurements of a single time step with
/// contact". So the first sample in contact is taken fully; later ones only correct it, weighted low, because
/// the object stands still and what changes is noise, bounces and vibration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ObjectModel {
    gain: f64,
    height_m: Option<f64>,
}

impl ObjectModel {
    /// No object known.
    pub fn new(parameters: &scenario::Proposed) -> Self {
        Self {
            gain: parameters.object_filter_gain,
            height_m: None,
        }
    }

    /// Take the height `measured_m` of the deflected tcp in contact: one sample of (12).
    pub fn update(&mut self, measured_m: f64) {
        self.height_m = Some(match self.height_m {
            None => measured_m,
            Some(height) => height + self.gain * (measured_m - height),
        });
    }

    /// Height of the object, m; `None` before the first contact.
    pub fn height_m(&self) -> Option<f64> {
        self.height_m
    }

    /// Paper (2): the height at which the hanging tcp has to be, `x_d = x_o - C f_d` along the normal, with
    /// `x_o = x_a + C f` measured before.
    pub fn desired_height(&self, compliance_m_per_n: f64, desired_force_n: f64) -> Option<f64> {
        self.height_m
            .map(|height| height - compliance_m_per_n * desired_force_n)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_sample_counts_fully_and_later_ones_correct() {
        let mut object = ObjectModel::new(&scenario::Proposed {
            object_filter_gain: 0.1,
            ..Default::default()
        });
        assert_eq!(object.desired_height(28e-6, 10.0), None);
        object.update(0.010);
        assert_eq!(object.height_m(), Some(0.010));
        object.update(0.011);
        assert!((object.height_m().unwrap() - 0.0101).abs() < 1e-15);
        assert!((object.desired_height(28e-6, 10.0).unwrap() - (0.0101 - 280e-6)).abs() < 1e-15);
    }
}
