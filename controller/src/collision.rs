//! What stops the robot: a force where none may be, or more than may be.
//!
//! The second level beside contact detection. It looks at the wrench at the tcp, axis by axis: along and about the axes
//! of s (which the tool's frame is parallel to), beyond the tare.

use node::scenario;
use spatial::ports::Fault;
use spatial::{Wrench, kinematics::join};

/// What is allowed now.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Allowed {
    /// Next to nothing: the tool moves freely.
    Free {
        /// The force (N) that the recent accelerations can cause.
        raised_n: f64,
        /// The lever (m) with which it acts.
        lever_m: f64,
    },
    /// The tool's own weight, which a calibration tilts.
    Tilting,
    /// A contact.
    Contact {
        /// The force (N) along the normal, as the deflection of the tcp shows it.
        normal_force_n: f64,
        /// What it may be at most, N.
        most_n: f64,
    },
}

/// What exceeded which limit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Exceeded {
    /// [`Fault::Collision`] or, along the normal in contact, [`Fault::ForceLimit`].
    pub fault: Fault,
    /// Axis: force x, y, z, moment x, y, z.
    pub axis: usize,
    /// Its force (N) or moment (Nm).
    pub value: f64,
    /// The limit, likewise.
    pub limit: f64,
}

/// How many samples in a row must say so: one alone may be a slip of the sensor.
const IN_A_ROW: u32 = 2;

/// How many saturated samples in a row are no impact any more.
const SATURATED_IN_A_ROW: u32 = 100;

/// Looks for collisions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CollisionWatch {
    enabled: bool,
    free: [f64; 6],
    contact: [f64; 6],
    in_a_row: u32,
    saturated: u32,
    first: Option<Exceeded>,
}

impl CollisionWatch {
    /// With the thresholds that `controller` says.
    pub fn new(controller: &scenario::Controller) -> Self {
        let collision = &controller.collision;
        let six = |[fx, fy, fz]: [f64; 3], [mx, my, mz]: [f64; 3]| [fx, fy, fz, mx, my, mz];
        Self {
            enabled: collision.enabled,
            free: six(collision.free_force_n, collision.free_moment_nm),
            contact: six(collision.contact_force_n, collision.contact_moment_nm),
            in_a_row: 0,
            saturated: 0,
            first: None,
        }
    }

    /// Take the wrench at the tcp that one sample shows, which may be `saturated`; the fault that it completes.
    pub fn take(&mut self, allowed: &Allowed, wrench: &Wrench, saturated: bool) -> Option<Fault> {
        self.saturated = if saturated { self.saturated + 1 } else { 0 };
        let found = self.find(allowed, wrench);
        self.in_a_row = if found.is_some() { self.in_a_row + 1 } else { 0 };
        if self.in_a_row >= IN_A_ROW {
            self.first = self.first.or(found);
            return found.map(|exceeded| exceeded.fault);
        }
        // In the air, too: a sensor at the end of its range would not tell a contact. A calibration asks for it, and says so.
        let asked_for = matches!(allowed, Allowed::Tilting);
        (!asked_for && self.saturated >= SATURATED_IN_A_ROW).then_some(Fault::DeflectionSaturated)
    }

    /// Whether `wrench` is more than `allowed`.
    pub fn exceeds(&self, allowed: &Allowed, wrench: &Wrench) -> bool {
        self.find(allowed, wrench).is_some()
    }

    /// Forget what was seen: what begins now begins anew.
    pub fn reset(&mut self) {
        (self.in_a_row, self.saturated, self.first) = (0, 0, None);
    }

    /// The first thing that was too much.
    pub fn exceeded(&self) -> Option<&Exceeded> {
        self.first.as_ref()
    }

    /// The axis that exceeds its limit by the largest factor.
    fn find(&self, allowed: &Allowed, wrench: &Wrench) -> Option<Exceeded> {
        if let Allowed::Contact {
            normal_force_n,
            most_n,
        } = *allowed
            && normal_force_n > most_n
        {
            return Some(Exceeded {
                fault: Fault::ForceLimit,
                axis: crate::dofs::NORMAL,
                value: normal_force_n,
                limit: most_n,
            });
        }
        if !self.enabled {
            return None;
        }
        let shown = join(wrench.force, wrench.moment);
        let limit = |axis: usize| match *allowed {
            Allowed::Free { raised_n, lever_m } => {
                self.free[axis] + if axis < 3 { raised_n } else { raised_n * lever_m }
            }
            Allowed::Tilting | Allowed::Contact { .. } => self.contact[axis],
        };
        let over = |axis: usize| libm::fabs(shown[axis]) / limit(axis);
        let axis = (0..6).max_by(|a, b| over(*a).total_cmp(&over(*b)))?;
        (over(axis) > 1.0).then(|| Exceeded {
            fault: Fault::Collision,
            axis,
            value: shown[axis],
            limit: limit(axis),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;

    const FREE: Allowed = Allowed::Free {
        raised_n: 10.0,
        lever_m: 0.2,
    };

    fn watch() -> CollisionWatch {
        CollisionWatch::new(&scenario::Controller::default())
    }

    fn in_contact(normal_force_n: f64) -> Allowed {
        Allowed::Contact {
            normal_force_n,
            most_n: 300.0,
        }
    }

    fn wrench(axis: usize, value: f64) -> Wrench {
        let mut all = [0.0; 6];
        all[axis] = value;
        let [fx, fy, fz, mx, my, mz] = all;
        Wrench {
            force: Vector3::new(fx, fy, fz),
            moment: Vector3::new(mx, my, mz),
        }
    }

    /// 30 N and 10 N of inertia; 4 Nm and 0.2 m times 10 N; 300 N and 50 Nm in contact; each axis by its name.
    #[test]
    fn each_axis_has_its_threshold_in_each_phase() {
        let contact = in_contact(10.0);
        for axis in 0..6 {
            let force = axis < 3;
            for (allowed, limit) in [
                (FREE, if force { 40.0 } else { 6.0 }),
                (Allowed::Tilting, if force { 300.0 } else { 50.0 }),
                (contact, if force { 300.0 } else { 50.0 }),
            ] {
                for sign in [-1.0, 1.0] {
                    let mut watch = watch();
                    let below = wrench(axis, 0.99 * sign * limit);
                    assert!((0..10).all(|_| watch.take(&allowed, &below, false).is_none()));
                    let above = wrench(axis, 1.01 * sign * limit);
                    assert_eq!(watch.take(&allowed, &above, false), None, "one sample alone");
                    assert_eq!(watch.take(&allowed, &above, false), Some(Fault::Collision));
                    let found = watch.exceeded().unwrap();
                    assert_eq!((found.axis, found.value), (axis, 1.01 * sign * limit));
                    assert!((found.limit - limit).abs() < 1e-12);
                }
            }
        }
    }

    #[test]
    fn too_much_along_the_normal_is_the_force_limit() {
        let mut watch = watch();
        let allowed = in_contact(301.0);
        let nothing = Wrench::default();
        assert_eq!(watch.take(&allowed, &nothing, false), None);
        assert_eq!(watch.take(&allowed, &nothing, false), Some(Fault::ForceLimit));
        let found = watch.exceeded().unwrap();
        assert_eq!((found.axis, found.value, found.limit), (2, 301.0, 300.0));
        watch.reset();
        assert_eq!(watch.exceeded(), None);
        assert_eq!(watch.take(&allowed, &nothing, false), None, "one sample alone");
    }

    #[test]
    fn a_sensor_that_stays_at_the_end_of_its_range_is_a_fault() {
        for allowed in [in_contact(0.0), FREE] {
            let mut watch = watch();
            let mut answers = (0..100).map(|_| watch.take(&allowed, &Wrench::default(), true));
            assert!(answers.by_ref().take(99).all(|answer| answer.is_none()));
            assert_eq!(answers.next(), Some(Some(Fault::DeflectionSaturated)));
        }
    }
}
