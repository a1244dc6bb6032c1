//! What protects the robot and what it touches: collisions, faults that hold, and the limits that every command passes.

use crate::Controller;
use crate::collision::Allowed;
use crate::motion::Sample;
use spatial::kinematics::Axes;
use spatial::ports::{Fault, HORIZON, LIMIT_LEAD};

impl Controller {
    /// Latch a collision that the newest sample completes.
    pub(crate) fn watch_for_collision(&mut self, sample: &Sample) {
        let wrench = self.contact_wrench(&sample.deflection);
        let Some(motion) = self.motion.as_mut().filter(|_| self.phases.well()) else {
            return;
        };
        let free = Allowed::Free {
            raised_n: motion.raised_n(),
            lever_m: self.settings.d.norm(),
        };
        if self.collision.exceeds(&free, &wrench) {
            motion.has_not_left();
        }
        let allowed = if motion.touches() {
            Allowed::Contact {
                normal_force_n: motion.normal_force_n(),
                most_n: self.settings.task.max_contact_force_n,
            }
        } else if self.tilting.is_some_and(|tilting| tilting.begun()) {
            Allowed::Tilting
        } else {
            free
        };
        if let Some(fault) = self.collision.take(&allowed, &wrench, sample.flags.saturated) {
            self.fail(fault);
            // Not where it was sent: whatever it met is in between.
            self.commanded = sample.axes;
        }
    }

    /// The next set-points of the axes, one period apart, within the limits. A pose that kinematics can't reach latches a
    /// fault. After any fault the axes stay at the set-point last given; after a collision, where they were as it was
    /// sampled.
    pub(crate) fn set_points(&mut self, tick: i64, actual: &Axes) -> [Axes; HORIZON] {
        match self.wanted(tick, actual) {
            Some((set_points, bits)) => {
                self.limits = bits;
                self.commanded = set_points[0];
                set_points
            }
            None => {
                let mut held = [self.commanded; HORIZON];
                self.limits = self.bounds.apply(&mut held);
                held
            }
        }
    }

    /// The set-points that the motion asks for, within the limits, and the bits of those that bind; `None`: to hold.
    fn wanted(&mut self, tick: i64, actual: &Axes) -> Option<([Axes; HORIZON], i32)> {
        let silent = self.sensor_silent_s(tick).max(self.robot_silent_s(tick)) > self.hold_s();
        let tilts = self.tilting.is_some_and(|tilting| tilting.begun());
        let motion = self
            .motion
            .as_mut()
            .filter(|_| self.phases.well() && !self.rejoins)?;
        let (settings, bounds) = (&self.settings, &mut self.bounds);
        if silent && !tilts {
            return Some(motion.hold(settings, bounds, &self.commanded));
        }
        let answer = match &mut self.tilting {
            Some(tilting) if tilting.begun() => {
                let asked = tilting.set_points(settings, actual, &self.commanded);
                asked.map(|(mut set_points, waits)| {
                    let bits = bounds.apply(&mut set_points);
                    (set_points, bits | if waits { LIMIT_LEAD } else { 0 })
                })
            }
            _ => motion.set_points(settings, &self.expectation, bounds, tick, actual),
        };
        if answer.is_err() {
            self.fail(Fault::Unreachable);
        }
        answer.ok()
    }
}
