//! The object as the sensor sees it: eqs. (2) and (12) as a model that is measured once and then refined.

use crate::contact::{Aim, ContactSample, PREVIEW, Situation, Touch};
use crate::fading_memory::FadingMemory;
use node::scenario;

/// The proposed law: the object's coordinate along one degree of freedom, and from there to where the desired force
/// results.
///
/// Paper II-B, below (2): one time step in contact is enough to know the desired pose. So the first sample in contact
/// is taken fully; later ones only correct it, weighted low, because what changes is noise, bounces and vibration.
/// An object that moves is extrapolated to the instants at which the robot will be there: the prediction of the
/// desired trajectory that the paper's abstract speaks of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ObjectModel {
    object: FadingMemory,
}

impl ObjectModel {
    /// No object known.
    pub fn new(parameters: &scenario::Proposed) -> Self {
        Self {
            object: FadingMemory::new(
                parameters.object_motion.degree(),
                parameters.object_filter_gain,
                parameters.settled_filter_gain,
            ),
        }
    }

    /// The object moves with `rate` (m/s or rad/s) as the contact begins.
    pub fn expect(&mut self, rate: f64) {
        self.object.expect(rate);
    }

    /// Take one sample of (12) in contact. In a bounce it says nothing of the object: the tool's own motion would be
    /// taken for the object's. Where the contact is lost, the object is taken to begin at the tool, at rest, so that
    /// the tool advances no faster than `C f_d` lets it until it meets the object again.
    pub fn take(&mut self, sample: &ContactSample) {
        match sample.touch {
            Touch::Contact => self.object.take(sample.time_s, sample.object),
            Touch::Bounce => {}
            Touch::Lost => self.object.restart(sample.time_s, sample.object, 0.0),
        }
    }

    /// The object's coordinate and its rate; `None` before the first contact.
    pub fn object(&self) -> Option<(f64, f64)> {
        self.object.newest()
    }

    /// Where the object is at `time_s`; `None` before the first contact.
    pub fn at(&self, time_s: f64) -> Option<f64> {
        self.object.at(time_s).map(|(position, _)| position)
    }

    /// Paper (2), (11): where the hanging tcp has to be, `x_d = x_o - C f_d` with `x_o = x_a + C f` measured before,
    /// at the coming instants.
    pub fn desired(&self, aim: &Aim, situation: &Situation) -> [f64; PREVIEW] {
        situation.reached_s.map(|time_s| {
            self.at(time_s)
                .map_or(situation.desired, |object| object - aim.displacement)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use node::scenario::ObjectMotion;

    const AIM: Aim = Aim::PAPER;

    fn met(time_s: f64, object: f64) -> ContactSample {
        ContactSample {
            time_s,
            object,
            ..Default::default()
        }
    }

    fn situation() -> Situation {
        Situation {
            commanded: 0.5,
            desired: 0.4,
            desired_rate: 0.0,
            actual: 0.4,
            reached_s: std::array::from_fn(|i| 1.0 + 4e-3 * i as f64),
            period_s: 4e-3,
        }
    }

    #[test]
    fn the_first_sample_counts_fully_and_later_ones_correct() {
        let mut object = ObjectModel::new(&scenario::Proposed {
            object_filter_gain: 0.1,
            ..Default::default()
        });
        assert_eq!(object.desired(&AIM, &situation()), [0.4; PREVIEW]);
        object.take(&met(0.5, 0.010));
        assert_eq!(object.object(), Some((0.010, 0.0)));
        object.take(&met(0.501, 0.011));
        assert!((object.object().unwrap().0 - 0.0101).abs() < 1e-15);
        for desired in object.desired(&AIM, &situation()) {
            assert!((desired - (0.0101 - 280e-6)).abs() < 1e-15);
        }
    }

    #[test]
    fn a_bounce_tells_nothing_and_a_lost_object_begins_at_the_tool() {
        let mut object = ObjectModel::new(&scenario::Proposed {
            object_motion: ObjectMotion::Steady,
            ..Default::default()
        });
        object.expect(0.02);
        object.take(&met(0.5, 0.010));
        let mut bounced = |time, touch| {
            object.take(&ContactSample {
                touch,
                ..met(time, 0.011)
            });
            object.object()
        };
        assert_eq!(bounced(0.501, Touch::Bounce), Some((0.010, 0.02)));
        assert_eq!(bounced(0.502, Touch::Lost), Some((0.011, 0.0)));
    }

    #[test]
    fn a_moving_object_is_met_where_it_will_be() {
        let mut object = ObjectModel::new(&scenario::Proposed {
            object_filter_gain: 0.1,
            settled_filter_gain: 0.1,
            object_motion: ObjectMotion::Steady,
            ..Default::default()
        });
        for n in 0..950 {
            let time = f64::from(n) * 1e-3;
            object.take(&met(time, 0.02 * time));
        }
        let desired = object.desired(&AIM, &situation());
        for (desired, time) in desired.into_iter().zip(situation().reached_s) {
            assert!((desired - (0.02 * time - 280e-6)).abs() < 1e-12);
        }
    }
}
