//! What the status tells of the motion.

use super::Motion;
use crate::Settings;
use crate::dofs::NORMAL;
use crate::impact::ImpactMonitor;
use nalgebra::Vector3;
use spatial::ports::ImpactAssessment;
use spatial::{Deflection, Pose};

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
        if self.contact.is_some() && self.selection.contains(NORMAL) {
            self.newest.wrench[NORMAL]
        } else {
            self.newest.normal_force_n
        }
    }

    /// Whether the object was lost and not found again down to the end of the search.
    pub(crate) fn lost_beyond_search(&self) -> bool {
        let at_end = self.plan.commanded[NORMAL] <= self.lowest_m + 1e-6;
        at_end && self.contact.is_some_and(|contact| contact.lost)
    }

    /// Whether the hanging tcp is where it is sent to, within `tolerance_m` (m).
    pub(crate) fn arrived(&self, tolerance_m: f64) -> bool {
        let at = self.frame.coordinates(&self.newest.hanging);
        libm::fabs(at[NORMAL] - self.plan.commanded[NORMAL]) <= tolerance_m
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
