//! How a step's motion begins: at rest, or out of whatever motion is left off, without a jump and without turning back.

use super::{Fade, Motion, Path, Plan, Spiral, Travel};
use crate::Settings;
use crate::approach::spread;
use crate::command_dynamics::{CommandDynamics, Target};
use crate::dofs::{Dofs, NORMAL, Selection};
use crate::elastic::Elastic;
use crate::expectation::Expectation;
use crate::impact::ImpactMonitor;
use crate::law::{ForceControl, feeds_forward};
use crate::motion::path::since;
use crate::motion::statics::tcp_compliance;
use nalgebra::Vector3;
use node::scenario;
use spatial::kinematics::Axes;
use spatial::{Compliance, TICK_S};

impl Motion {
    /// Move down along the normal until the object is met, then act along `selection`.
    pub(crate) fn begin_approach(
        &mut self,
        settings: &Settings,
        expectation: &Expectation,
        selection: Selection,
        tick: i64,
    ) {
        let fresh = self.contact.is_none() && self.path.is_none() && self.fade.is_none();
        let start_m = if fresh {
            self.plan.coordinates[0][NORMAL]
        } else {
            self.leave_off(settings, 0.0, feeds_forward(settings.controller.law), tick);
            self.contact = None;
            self.share = 0.0;
            self.force_control = ForceControl::new(
                &settings.controller,
                selection,
                settings.elastic.clone().map(Elastic::new),
            );
            let normal_in_s = self.frame.pose(&Dofs::zeros()).rotation.inverse() * Vector3::z();
            self.impact = ImpactMonitor::new(&settings.controller, &settings.task, normal_in_s).ok();
            self.base(0.0)[NORMAL]
        };
        self.inserts = false;
        self.settled_cycles = 0;
        self.select(settings, selection);
        self.go_down(settings, expectation, start_m, tick);
    }

    /// Go on down to a position, acting along `selection` in contact.
    pub(crate) fn begin_insertion(
        &mut self,
        settings: &Settings,
        expectation: &Expectation,
        selection: Selection,
        tick: i64,
    ) {
        match self.pressing() {
            Some(contact) => {
                let taken = spread(since(settings, contact.cycle_tick, tick), contact.tilt_time_s);
                self.leave_off(
                    settings,
                    taken.value,
                    feeds_forward(settings.controller.law),
                    tick,
                );
                self.select(settings, selection);
                let start_m = self.base(taken.value)[NORMAL];
                self.go_down(settings, expectation, start_m, tick);
            }
            None => self.begin_approach(settings, expectation, selection, tick),
        }
        self.inserts = true;
    }

    /// The way down along the normal, from the coordinate `start_m` (m) on.
    fn go_down(&mut self, settings: &Settings, expectation: &Expectation, start_m: f64, tick: i64) {
        let (shape, impact) = (self.shape, self.impact.as_ref());
        self.path = Some(Path::new(settings, expectation, shape, impact, start_m, tick));
    }

    /// Begin to press with another force: what was settled is so no more.
    pub(crate) fn begin_pressing(&mut self) {
        self.settled_cycles = 0;
    }

    /// Press on, and move along a spiral with turns `pitch_m` (m) apart out to `radius_m` (m) at `speed` (m/s).
    pub(crate) fn begin_search(
        &mut self,
        settings: &Settings,
        selection: Selection,
        step: &scenario::Step,
        tick: i64,
    ) {
        self.select(settings, selection);
        self.spiral = Some(Spiral::new(
            self.shape,
            step.pitch_m,
            step.radius_m,
            step.speed_m_per_s.min(settings.fastest_m_per_s()),
            tick,
        ));
    }

    /// Move freely to where the nominal tcp is at `position` (m in r).
    pub(crate) fn begin_move(&mut self, settings: &Settings, position: Vector3<f64>, speed: f64, tick: i64) {
        self.release(settings, 0.0, tick);
        self.contact = None;
        let from = self.base(0.0).fixed_rows::<3>(0).into_owned();
        let way = position + self.sag - from;
        self.travel = Some(Travel::new(
            self.shape,
            way,
            speed.min(settings.fastest_m_per_s()),
            tick,
        ));
    }

    /// Leave the object upwards, by `distance_m` (m).
    pub(crate) fn begin_retraction(&mut self, settings: &Settings, distance_m: f64, speed: f64, tick: i64) {
        self.release(settings, 0.0, tick);
        let way = Vector3::z() * distance_m;
        self.travel = Some(Travel::new(
            self.shape,
            way,
            speed.min(settings.fastest_m_per_s()),
            tick,
        ));
    }

    /// The retraction is over: nothing is touched.
    pub(crate) fn end_retraction(&mut self) {
        self.contact = None;
    }

    /// Come to rest and hold, in contact with the posture that is taken.
    pub(crate) fn stop(&mut self, settings: &Settings, tick: i64) {
        let share = self.pressing().map_or(self.share, |contact| {
            let taken = spread(since(settings, contact.cycle_tick, tick), contact.tilt_time_s);
            // The posture comes to rest as all the motion does.
            taken.value
                + Fade::way_to_rest(&Dofs::ith(0, taken.rate))
                    .x
                    .min(1.0 - taken.value)
        });
        self.release(settings, share, tick);
    }

    /// At rest at the axes `commanded`, where a fault has stopped the robot.
    pub(crate) fn recover(&mut self, settings: &Settings, commanded: &Axes, tick: i64) {
        let controller = &settings.controller;
        self.dynamics = CommandDynamics::new(
            controller.filter_frequency_hz,
            controller.filter_damping,
            controller.acceleration_limit_rad_per_s2.into(),
            settings.period_ticks,
            *commanded,
        );
        let r_from_s = settings.kinematics.forward(commanded);
        let coordinates = self.frame.coordinates(&self.posture.hanging_tcp(&r_from_s));
        self.plan = Plan::stay(coordinates, *commanded);
        self.stop(settings, tick);
    }

    /// The law's whole gain again, for a new start.
    pub(crate) fn restore_gain(&mut self) {
        self.oscillation.restore();
    }

    /// Take over parameters that act in contact.
    pub(crate) fn retune(&mut self, settings: &Settings) {
        self.force_control.retune(&settings.controller);
        self.detector
            .set_threshold(settings.controller.detection_threshold_n);
    }

    /// Let the robot catch up for `ticks`.
    pub(super) fn wait(&mut self, ticks: i64) {
        if let Some(path) = &mut self.path {
            path.wait(ticks);
        }
        if let Some(travel) = &mut self.travel {
            travel.start_tick += ticks;
        }
        if let Some(spiral) = &mut self.spiral {
            spiral.start_tick += ticks;
        }
    }

    /// How far the step's ways lead from the start at `tick`, m in r; that of the approach apart.
    pub(super) fn led(&self, settings: &Settings, tick: i64) -> Vector3<f64> {
        let travelled = |it: Travel| it.at(since(settings, it.start_tick, tick));
        let searched = |it: Spiral| it.at(since(settings, it.start_tick, tick));
        self.anchor
            + self.travel.map_or(Vector3::zeros(), travelled)
            + self.spiral.map_or(Vector3::zeros(), searched)
    }

    /// No law acts any more, and the motion comes to rest with the share `share` of the posture.
    fn release(&mut self, settings: &Settings, share: f64, tick: i64) {
        if self.pressing().is_some() {
            // The tool swings with what it is released from, as if it had been accelerated by that.
            let mass_kg = settings.controller.apparent_mass_kg;
            if mass_kg > 0.0 {
                self.detector
                    .follow(self.force_n() / mass_kg, settings.period_ticks);
            }
        }
        let approached = self.path.is_some();
        let touches = self.contact.is_some() || self.newest.normal_force_n > self.detector.threshold_n();
        self.leave_off(settings, share, true, tick);
        if approached && let Some((fade, left)) = self.fade {
            // The way on which it comes to rest still may meet the object.
            let lag = settings.lead() * settings.period_ticks;
            self.leaving = Some(left + (fade.lasts_s() / TICK_S) as i64 + lag);
        } else if touches {
            self.leaving = Some(self.newest.sample.tick);
        }
        if let Some(contact) = &mut self.contact {
            contact.released = true;
        }
        self.inserts = false;
        self.share = share;
    }

    /// Leave the present motion off: it comes to rest where it can without turning back, which becomes the anchor of
    /// what follows.
    fn leave_off(&mut self, settings: &Settings, share: f64, leads: bool, tick: i64) {
        let (at, rate) = self.state(settings, leads);
        let rest = at + Fade::way_to_rest(&rate);
        self.path = None;
        self.travel = None;
        self.spiral = None;
        self.anchor = Vector3::zeros();
        self.anchor = (rest - self.base(share)).fixed_rows::<3>(0).into_owned();
        self.fade = Some((Fade::new(at - self.base(share), rate), tick));
    }

    /// Coordinates of the hanging tcp at the anchor with the share `share` of the posture.
    fn base(&self, share: f64) -> Dofs {
        self.frame
            .coordinates(&self.posture.reference(self.anchor, share))
    }

    /// Whether the axes are led, so that they are where they are to be: by a law that is fed forward, and on all ways but
    /// the approach by every law.
    pub(super) fn leads(&self, settings: &Settings) -> bool {
        feeds_forward(settings.controller.law) || (self.fade.is_some() && self.path.is_none())
    }

    /// Coordinates and their rates when the next set-point begins to act: of the simulated axes; where what follows does
    /// not lead them, the coordinates are those of the set-point, which they follow. Its own rate would mean nothing: such
    /// a law may make it jump.
    fn state(&self, settings: &Settings, leads: bool) -> (Dofs, Dofs) {
        let Target {
            position, velocity, ..
        } = self.dynamics.reached();
        let coordinates = |axes| {
            let r_from_s = settings.kinematics.forward(axes);
            self.frame.coordinates(&self.posture.hanging_tcp(&r_from_s))
        };
        let at = coordinates(&position);
        let rate = (coordinates(&(position + velocity * TICK_S)) - at) / TICK_S;
        if leads {
            (at, rate)
        } else {
            (self.plan.commanded, rate)
        }
    }

    fn select(&mut self, settings: &Settings, selection: Selection) {
        if selection != self.selection {
            self.selection = selection;
            self.force_control.select(&settings.controller, selection);
            self.plan_compliance(&settings.compliance);
        }
    }

    /// Take the compliance of the sensor for that along the selected degrees of freedom.
    fn plan_compliance(&mut self, compliance: &Compliance) {
        self.compliance = tcp_compliance(compliance, &self.posture, &self.r_from_s, &self.selection);
    }
}
