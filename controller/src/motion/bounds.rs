//! What the laws' wishes are bounded by before they become set-points: speed, force, workspace.

use super::Motion;
use crate::Settings;
use crate::contact::PREVIEW;
use crate::dofs::{Dofs, NORMAL};
use crate::limits::Limits;
use nalgebra::Vector3;
use spatial::ports::{LIMIT_FORCE, LIMIT_SEEK, LIMIT_WORKSPACE};

impl Motion {
    /// Bound the `coordinates` of the hanging tcp at the coming instants; the bits of what binds at the first of them.
    ///
    /// Laws take these coordinates for what they have asked for, so that none of them winds up; the last stage
    /// ([`Limits`]) is for what the way to the set-points adds.
    pub(super) fn bound(
        &self,
        settings: &Settings,
        limits: &Limits,
        coordinates: &mut [Dofs; PREVIEW],
    ) -> i32 {
        let mut bits = 0;
        let from = self.plan.coordinates[0][NORMAL];
        let step_m = self.seek_speed(settings).map(|speed| speed * settings.period_s());
        let deepest = self.deepest(settings);
        for (i, all) in coordinates.iter_mut().enumerate() {
            let mut binds = 0;
            let lowest = step_m.map(|step_m| from - step_m * (i + 1) as f64);
            if let Some(lowest) = lowest.filter(|lowest| all[NORMAL] < *lowest) {
                all[NORMAL] = lowest;
                binds |= LIMIT_SEEK;
            }
            if let Some(deepest) = deepest.filter(|deepest| all[NORMAL] < *deepest) {
                all[NORMAL] = deepest;
                binds |= LIMIT_FORCE;
            }
            let tcp = Vector3::new(all[0], all[1], all[2]);
            let inside = limits.workspace().nearest(&tcp);
            if inside != tcp {
                all.fixed_rows_mut::<3>(0).copy_from(&inside);
                binds |= LIMIT_WORKSPACE;
            }
            if i == 0 {
                bits = binds;
            }
        }
        bits
    }

    /// The speed (m/s) with which the tool may go on while it is in the air, since it may meet the object at any moment: in
    /// a bounce that of the approach, towards an object that is lost that of the search. `None`: it is in contact, or no law
    /// acts.
    fn seek_speed(&self, settings: &Settings) -> Option<f64> {
        let contact = self.pressing().filter(|_| self.selection.contains(NORMAL))?;
        let approach = settings.task.approach_speed_m_per_s;
        let speed = match contact.lost {
            true => settings.controller.limits.seek_speed_m_per_s.min(approach),
            false => approach,
        };
        let allowed = self
            .impact
            .as_ref()
            .map_or(speed, |impact| impact.allowed_speed_m_per_s(speed));
        (contact.lost || contact.airborne).then_some(allowed)
    }

    /// Where the tcp presses with the allowed force, m: that far below the object of the newest sample, `x_o - C f_max`.
    fn deepest(&self, settings: &Settings) -> Option<f64> {
        self.pressing()?;
        let object = self.newest.r_from_ta1.translation.vector[NORMAL];
        Some(object - self.compliance.along(NORMAL) * settings.task.max_contact_force_n)
    }
}
