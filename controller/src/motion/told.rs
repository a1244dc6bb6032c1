//! What the status tells of the motion.

use super::Motion;
use crate::Settings;
use crate::dofs::{Dofs, NORMAL};
use crate::impact::ImpactMonitor;
use nalgebra::Vector3;
use spatial::ports::ImpactAssessment;
use spatial::{Deflection, Pose, TICK_S};

/// The axes rest below that, rad/s.
const STILL_RAD_PER_S: f64 = 1e-4;

impl Motion {
    /// `r_from_ta1`: the deflected tcp at the newest sample.
    pub(crate) fn tcp_pose(&self) -> &Pose {
        &self.newest.r_from_ta1
    }

    pub(crate) fn deflection(&self) -> &Deflection {
        &self.newest.sample.deflection
    }

    /// Contact force along the normal at the newest sample as contact detection sees it, N.
    pub(crate) fn normal_force_n(&self) -> f64 {
        self.newest.normal_force_n
    }

    /// Contact force along the normal at the newest sample, N, with the moments that are controlled accounted for.
    pub(crate) fn force_n(&self) -> f64 {
        if self.pressing().is_some() && self.selection.contains(NORMAL) {
            self.newest.wrench[NORMAL]
        } else {
            self.newest.normal_force_n
        }
    }

    /// Whether the object was lost and not found again down to the end of the search.
    pub(crate) fn lost_beyond_search(&self) -> bool {
        let at_end = self.plan.commanded[NORMAL] <= self.lowest_m + 1e-6;
        at_end && self.lost()
    }

    /// Whether the hanging tcp is where it is sent to, within `tolerance_m` (m).
    pub(crate) fn arrived(&self, tolerance_m: f64) -> bool {
        let at = self.frame.coordinates(&self.newest.hanging);
        libm::fabs(at[NORMAL] - self.plan.commanded[NORMAL]) <= tolerance_m
    }

    /// Whether nothing has been touched for longer than any bounce, while a law acts.
    pub(crate) fn lost(&self) -> bool {
        self.pressing().is_some_and(|contact| contact.lost)
    }

    /// How far the deflected tcp has sunk since the contact was detected, m.
    pub(crate) fn sunk_m(&self) -> f64 {
        let height_m = self.newest.r_from_ta1.translation.vector[NORMAL];
        self.contact.map_or(0.0, |contact| contact.height_m - height_m)
    }

    /// Where the deflected tcp was when it met the object, m in r; `None`: it has met none.
    pub(crate) fn met_at_m(&self) -> Option<f64> {
        self.contact.map(|contact| contact.height_m)
    }

    /// Whether the way of a move, a retraction or a search has ended at `tick`.
    pub(crate) fn way_ended(&self, tick: i64) -> bool {
        let lasted_s = |start: i64| (tick - start) as f64 * TICK_S;
        let travels = self
            .travel
            .is_some_and(|it| lasted_s(it.start_tick) <= it.duration_s());
        let searches = self
            .spiral
            .is_some_and(|it| lasted_s(it.start_tick) <= it.duration_s());
        !travels && !searches
    }

    /// How far the tcp yields to what it touches at the newest sample, m.
    pub(crate) fn yields_by_m(&self) -> f64 {
        self.newest.yields_by_m
    }

    pub(crate) fn threshold_n(&self) -> f64 {
        self.detector.threshold_n()
    }

    /// The force that the recent accelerations can cause, N.
    pub(crate) fn raised_n(&self) -> f64 {
        self.detector.raised_n()
    }

    /// The tcp of the hanging tool in s, m.
    pub(crate) fn hanging_in_s(&self) -> Vector3<f64> {
        self.posture.hanging_tcp(&Pose::identity()).translation.vector
    }

    pub(crate) fn saturated(&self) -> bool {
        self.newest.sample.flags.saturated
    }

    /// The impact that the present speed would cause, or that of the contact.
    pub(crate) fn impact(&self) -> ImpactAssessment {
        self.impact
            .as_ref()
            .map(ImpactMonitor::assessment)
            .unwrap_or_default()
    }

    /// Whether the allowed force of the impact, or the bound of command minus actual, slows the approach.
    pub(crate) fn slowed(&self, settings: &Settings) -> bool {
        let requested = settings.task.approach_speed_m_per_s;
        let impact = self.impact.as_ref();
        settings.fastest_m_per_s() < requested
            || impact.is_some_and(|impact| impact.allowed_speed_m_per_s(requested) < requested)
    }

    /// Whether a law acts in contact.
    pub(crate) fn presses(&self) -> bool {
        self.pressing().is_some()
    }

    /// Whether the tool hangs freely and the set-points rest at `tick`.
    pub(crate) fn rests_free(&self, tick: i64) -> bool {
        let faded = self
            .fade
            .is_none_or(|(fade, left)| fade.at((tick - left) as f64 * TICK_S) == Dofs::zeros());
        let still = self.dynamics.reached().velocity.amax() < STILL_RAD_PER_S;
        self.contact.is_none() && faded && still && self.way_ended(tick)
    }

    /// Whether the tool touches what it may: a law acts, or the tool has not left yet what it was pressed on.
    pub(crate) fn touches(&self) -> bool {
        self.presses() || self.leaving.is_some()
    }

    /// The newest sample shows that the tool has not left yet.
    pub(crate) fn has_not_left(&mut self) {
        if let Some(last) = &mut self.leaving {
            *last = (*last).max(self.newest.sample.tick);
        }
    }

    pub(crate) fn in_contact(&self) -> bool {
        self.contact.is_some()
    }

    /// Tick of the sample that detected the contact.
    pub(crate) fn contact_tick(&self) -> Option<i64> {
        self.contact.map(|contact| contact.sample_tick)
    }

    /// `r_from_o` with the tcp's pose where no law knows the object, and its velocity, m/s; `None` before a contact.
    pub(crate) fn object(&self) -> Option<(Pose, Vector3<f64>)> {
        let known = |dof| self.force_control.object(dof);
        self.selection.iter().find_map(known)?;
        let mut coordinates = self.frame.coordinates(&self.newest.r_from_ta1);
        let mut velocity = Vector3::zeros();
        for (dof, (position, rate)) in (0..6).filter_map(|dof| Some((dof, known(dof)?))) {
            coordinates[dof] = position;
            if dof < 3 {
                velocity[dof] = rate;
            }
        }
        Some((self.frame.pose(&coordinates), velocity))
    }
}
