//! Where the tcp is to be at the coming instants: on its way, in its posture, and where force laws ask for it.

use super::Motion;
use super::path::since;
use super::plan::Plan;
use super::sensed::Contact;
use crate::Settings;
use crate::approach::{Share, spread};
use crate::contact::{Aim, PREVIEW, Situation};
use crate::dofs::{Dofs, NORMAL};
use crate::expectation::Expectation;
use crate::law::feeds_forward;
use crate::shaping::Point;
use nalgebra::Vector3;
use spatial::TICK_S;
use spatial::kinematics::{Axes, join};

impl Motion {
    /// The lowest height of the hanging tcp at `tick`, m: where it presses at the end of the search.
    pub(super) fn lowest(&self, expectation: &Expectation, tick: i64) -> f64 {
        let end = self
            .path
            .map_or(f64::NEG_INFINITY, |path| path.end_m(expectation, tick));
        end - libm::fabs(self.desired_displacement[NORMAL])
    }

    /// Where the hanging tcp is to be at `tick` as far as no force law moves it: on the way to the object and with it,
    /// and in the posture that keeps the tool's reference; the deflected one is to keep to the way, so that the hanging
    /// one leads it ([`crate::shaping`]). What leads the robot is led here if the law is not fed
    /// forward.
    ///
    /// `known` is what stood in the posture for the instant before: shift, share and coordinates.
    pub(super) fn reference(
        &self,
        settings: &Settings,
        expectation: &Expectation,
        tick: i64,
        fed_forward: bool,
        known: &mut Option<(Vector3<f64>, f64, Dofs)>,
    ) -> Dofs {
        let kept = Share {
            value: self.share,
            ..Share::default()
        };
        let pressing = self.pressing();
        let tilt = pressing.map_or(kept, |contact| {
            let time = since(settings, contact.cycle_tick, tick);
            spread(time, contact.tilt_time_s)
        });
        let share = if fed_forward {
            tilt.value
        } else {
            self.dynamics.inverse(tilt.value, tilt.rate, tilt.acceleration)
        };
        let (distance, lead) = match pressing {
            // What the tool was led by then fades away.
            Some(Contact { met, .. }) if !self.inserts => {
                (met.distance, self.lead(settings, &met) * (1.0 - tilt.value))
            }
            _ => {
                let point = self.path.map_or(Point::default(), |path| path.at(settings, tick));
                (point.distance, self.lead(settings, &point))
            }
        };
        let shift = self.path.and_then(|path| path.shift(expectation, tick, distance));
        let shift = shift.unwrap_or_default() + self.led(settings, tick);
        let mut coordinates = match *known {
            Some((before, at, coordinates)) if before == shift && at == share => coordinates,
            _ => self.frame.coordinates(&self.posture.reference(shift, share)),
        };
        *known = Some((shift, share, coordinates));
        coordinates += lead;
        coordinates[NORMAL] -= distance;
        if let Some((fade, left)) = self.fade {
            coordinates += fade.at(since(settings, left, tick) + settings.period_s());
        }
        coordinates
    }

    /// What the force laws ask for at the ticks `reached`.
    /// `actual` are the newest encoder values.
    pub(super) fn demand(
        &mut self,
        settings: &Settings,
        reached: &[i64; PREVIEW],
        actual: &Axes,
    ) -> [Dofs; PREVIEW] {
        let Plan {
            coordinates,
            commanded,
            ..
        } = self.plan;
        let period_s = settings.period_s();
        let r_from_s = settings.kinematics.forward(actual);
        let actual = self.frame.coordinates(&self.posture.hanging_tcp(&r_from_s));
        let desired_wrench = join(settings.desired.force, settings.desired.moment);
        let (compliance, displacement) = (self.compliance, self.desired_displacement);
        let mut demand = self.force_control.demand(
            |dof| Aim {
                wrench: desired_wrench[dof],
                displacement: displacement[dof],
                compliance: compliance.along(dof),
            },
            |dof| Situation {
                commanded: commanded[dof],
                desired: coordinates[0][dof],
                desired_rate: (coordinates[1][dof] - coordinates[0][dof]) / period_s,
                actual: actual[dof],
                reached_s: reached.map(|tick| tick as f64 * TICK_S),
                period_s,
            },
        );
        // A lowered gain: of what the law asks for beyond what was asked for before, a share in each period. A lost object
        // is sought as fast as ever.
        let gain = if self.lost() { 1.0 } else { self.oscillation.gain() };
        if gain < 1.0 {
            let before = if feeds_forward(settings.controller.law) {
                coordinates[0]
            } else {
                commanded
            };
            let mut left = 1.0;
            for asked in &mut demand {
                left *= 1.0 - gain;
                *asked -= (*asked - before) * left;
            }
        }
        demand
    }
}
