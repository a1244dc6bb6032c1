//! From what the task asks for to the set-points of the axes.

use super::Motion;
use super::plan::{Plan, bound_lead};
use crate::Settings;
use crate::contact::PREVIEW;
use crate::dofs::NORMAL;
use crate::expectation::Expectation;
use crate::limits::Limits;
use spatial::kinematics::{Axes, Unreachable};
use spatial::ports::{HORIZON, LIMIT_HOLD, LIMIT_LEAD, Law};
use std::f64::consts::TAU;

/// What a held robot swings with, in accelerations of its stop: it goes on as abruptly, and both swings may add up, on gears
/// that have just been made to ring.
const STOPS_AND_GOES_ON: f64 = 3.0;

impl Motion {
    /// Hold the set-point `commanded`, within `limits`: what is under way waits.
    pub(crate) fn hold(
        &mut self,
        settings: &Settings,
        limits: &mut Limits,
        commanded: &Axes,
    ) -> ([Axes; HORIZON], i32) {
        let mut held = [*commanded; HORIZON];
        let bits = limits.apply(&mut held) | LIMIT_HOLD;
        self.wait(settings.period_ticks);
        let acceleration = self.dynamics.advance(&held[0]);
        self.watch(settings, &held[0], &(acceleration * STOPS_AND_GOES_ON));
        let r_from_s = settings.kinematics.forward(&held[0]);
        let coordinates = self.frame.coordinates(&self.posture.hanging_tcp(&r_from_s));
        self.plan = Plan::stay(coordinates, held[0]);
        (held, bits)
    }

    /// The next set-points of the axes, one period apart, within `limits`, and the bits of the limits that bind.
    pub(crate) fn set_points(
        &mut self,
        settings: &Settings,
        expectation: &Expectation,
        limits: &mut Limits,
        tick: i64,
        actual: &Axes,
    ) -> Result<([Axes; HORIZON], i32), Unreachable> {
        // The first set-point is reached n_d + 1 periods from now.
        let reached: [i64; PREVIEW] =
            std::array::from_fn(|i| tick + (settings.lead() + i as i64) * settings.period_ticks);
        let leads = self.leads(settings);
        self.track(settings, reached[0] - settings.period_ticks);
        let mut known = None;
        let mut coordinates =
            reached.map(|tick| self.reference(settings, expectation, tick, leads, &mut known));
        let pressing = self.pressing().is_some();
        if pressing {
            let lowest = self.lowest(expectation, reached[0]);
            self.lowest_m = lowest;
            for (all, demand) in coordinates
                .iter_mut()
                .zip(self.demand(settings, &reached, actual))
            {
                *all = self.selection.merge(&demand, all);
                all[NORMAL] = all[NORMAL].max(lowest);
            }
        }
        let mut bits = self.bound(settings, limits, &mut coordinates) | self.lowered();
        let kinematics = &settings.kinematics;
        let axes = self
            .plan
            .inverse(kinematics, &self.frame, &self.posture, &coordinates)?;
        let mut set_points = if leads {
            let proposed = &settings.controller.proposed;
            let mut led = axes;
            let models_servo = settings.controller.law == Law::Elastic;
            if proposed.disturbance_feed_forward && pressing && !models_servo {
                let torque = self.torque(settings, &axes[0]);
                let deviations = self.disturbance.preview(&torque, settings.period_ticks);
                for (axes, deviation) in led.iter_mut().zip(deviations) {
                    *axes -= deviation;
                }
            }
            let mut targets = self.dynamics.targets(&led);
            if let Some(motion) = self.planned(&coordinates) {
                self.along_normal(settings, motion, &coordinates, &axes[0], &mut targets);
            }
            self.dynamics
                .follow(&targets, TAU * proposed.reference_bandwidth_hz)
        } else {
            std::array::from_fn(|i| axes[i])
        };
        let most = settings.controller.max_lead_m;
        let bound = bound_lead(kinematics, &self.posture, most, actual, &mut set_points);
        if bound {
            // The way waits for a robot that does not follow.
            self.wait(settings.period_ticks);
        }
        let limited = limits.apply(&mut set_points);
        bits |= limited | if bound { LIMIT_LEAD } else { 0 };
        let acceleration = self.dynamics.advance(&set_points[0]);
        self.watch(settings, &set_points[0], &acceleration);
        let commanded = if bound || limited != 0 {
            let r_from_s = kinematics.forward(&set_points[0]);
            self.frame.coordinates(&self.posture.hanging_tcp(&r_from_s))
        } else {
            coordinates[0]
        };
        self.plan = Plan {
            coordinates,
            axes,
            commanded,
        };
        Ok((set_points, bits))
    }

    /// Tell the detection what the filters' mean `acceleration` (rad/s^2) towards the next `set_point` (rad) makes swing; in
    /// contact nothing.
    fn watch(&mut self, settings: &Settings, set_point: &Axes, acceleration: &Axes) {
        let acceleration = match self.pressing() {
            None => self.tcp_acceleration(settings, set_point, acceleration),
            Some(_) => 0.0,
        };
        self.detector.follow(acceleration, settings.period_ticks);
    }
}
