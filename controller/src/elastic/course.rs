//! Where the command filters have been, and will be until the next set-point acts.

use crate::contact::Waypoint;

/// The longest delay of a sample and the time until a command acts, in the shortest period of 1 ms.
const KNOTS: usize = 96;

/// The filters' way along the normal: knots a period apart, the acceleration linear between them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Course {
    knots: [(f64, Waypoint); KNOTS],
    next: usize,
    count: usize,
}

impl Default for Course {
    fn default() -> Self {
        Self {
            knots: [(0.0, Waypoint::default()); KNOTS],
            next: 0,
            count: 0,
        }
    }
}

impl Course {
    /// The filters are at `waypoint` at `time_s` (s), whatever was said of this instant and of later ones.
    pub fn push(&mut self, time_s: f64, waypoint: Waypoint) {
        while self.count > 0 && self.newest().0 >= time_s {
            self.next = (self.next + KNOTS - 1) % KNOTS;
            self.count -= 1;
        }
        self.knots[self.next] = (time_s, waypoint);
        self.next = (self.next + 1) % KNOTS;
        self.count = (self.count + 1).min(KNOTS);
    }

    /// When the newest knot is, s, and where.
    pub fn newest(&self) -> (f64, Waypoint) {
        self.knots[(self.next + KNOTS - 1) % KNOTS]
    }

    /// Where the filters are at `time_s` (s); beyond the knots, on from the nearest one.
    pub fn at(&self, time_s: f64) -> Waypoint {
        let mut after = self.newest();
        for back in 2..=self.count.max(1) {
            let knot = self.knots[(self.next + KNOTS - back) % KNOTS];
            if time_s >= after.0 {
                break;
            }
            if time_s >= knot.0 {
                return between(&knot, &after, time_s);
            }
            after = knot;
        }
        let time = time_s - after.0;
        let Waypoint { position, rate, .. } = after.1;
        Waypoint {
            position: position + rate * time,
            ..after.1
        }
    }
}

/// The acceleration linear between two knots, from the earlier one on.
fn between(from: &(f64, Waypoint), to: &(f64, Waypoint), time_s: f64) -> Waypoint {
    let (span, time) = (to.0 - from.0, time_s - from.0);
    let Waypoint {
        position,
        rate,
        change,
    } = from.1;
    let jerk = (to.1.change - change) / span;
    Waypoint {
        position: position + time * (rate + time * (change / 2.0 + time * jerk / 6.0)),
        rate: rate + time * (change + time * jerk / 2.0),
        change: change + time * jerk,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_way_with_constant_jerk_is_found_again() {
        let way = |t: f64| Waypoint {
            position: 0.3 + 0.1 * t + t * t * t,
            rate: 0.1 + 3.0 * t * t,
            change: 6.0 * t,
        };
        let mut course = Course::default();
        for i in 0..200 {
            let t = 4e-3 * f64::from(i);
            course.push(t, way(t));
        }
        for back in 0..90 {
            let t = 199.0 * 4e-3 - 3.7e-3 * f64::from(back);
            let (found, real) = (course.at(t), way(t));
            assert!((found.position - real.position).abs() < 1e-12);
            assert!((found.rate - real.rate).abs() < 1e-10);
            assert!((found.change - real.change).abs() < 1e-9);
        }
    }

    /// What turns out otherwise replaces what was said of the same instant and of all later ones.
    #[test]
    fn a_way_is_taken_back_and_said_anew() {
        let at = |position| Waypoint {
            position,
            ..Waypoint::default()
        };
        let mut course = Course::default();
        for i in 0..10 {
            course.push(f64::from(i), at(1.0));
        }
        course.push(7.0, at(2.0));
        assert_eq!(course.newest(), (7.0, at(2.0)));
        assert_eq!(course.at(6.0), at(1.0));
        assert_eq!(course.at(9.0), at(2.0));
    }
}
