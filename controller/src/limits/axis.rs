//! The set-points of one axis: how far the next one may go so that the axis can still stop within its limits.

/// Where an axis is sent: position (rad), its change over the last period T (rad) and the change of that (rad).
///
/// In these units rates, accelerations and jerks are first, second and third differences of the set-points.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sent {
    /// Newest set-point, rad.
    pub position: f64,
    /// Velocity times T, rad.
    pub rate: f64,
    /// Acceleration times T^2, rad.
    pub change: f64,
}

impl Sent {
    /// At rest at `position` (rad).
    pub fn at_rest(position: f64) -> Self {
        Self {
            position,
            ..Self::default()
        }
    }

    /// After one more set-point, `position` (rad).
    pub fn then(&self, position: f64) -> Self {
        let rate = position - self.position;
        Self {
            position,
            rate,
            change: rate - self.rate,
        }
    }
}

/// What the set-points of an axis may do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Lower end, rad.
    pub low: f64,
    /// Upper end, rad.
    pub high: f64,
    /// Largest velocity, times T, rad.
    pub rate: f64,
    /// Largest acceleration, times T^2, rad.
    pub change: f64,
    /// Largest jerk, times T^3, rad.
    pub jerk: f64,
}

/// The limit that a set-point would break, now or on the way to a stop.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Broken {
    /// Acceleration or jerk; also a set-point that is no number.
    Acceleration,
    /// Velocity.
    Velocity,
    /// An end of the axis.
    Range,
}

/// Rounding that breaks no limit.
const SLACK: f64 = 1.0 + 1e-9;

/// Steps within which every stop that is looked for ends: 16 s at T = 4 ms.
const LONGEST_STOP: usize = 4096;

/// Halvings on the way from a stop to what is wanted.
const HALVINGS: usize = 20;

impl Bounds {
    /// The set-point after `sent` on the fastest way to `wanted` (rad) from which a stop within the limits exists, and the
    /// limit that kept it from `wanted`, which is otherwise returned bit by bit.
    ///
    /// A stop within the limits exists from `sent` if all set-points came from here; its next one is always possible, and
    /// by convexity of the limits so is all of the way from it towards what one period allows, up to some point, which is
    /// found by bisection. On that way the stop must not lead past `wanted`, lest the axis swing about it.
    pub fn next(&self, sent: &Sent, wanted: f64) -> (Sent, Option<Broken>) {
        let asked = sent.then(wanted);
        let Err(broken) = self.judge(sent, &asked) else {
            return (asked, None);
        };
        let mut best = self.brake(sent);
        let end = self.stop(&best);
        if wanted.is_finite() && end != wanted {
            let wanted = wanted.max(self.low).min(self.high);
            let (least, most) = (
                (sent.change - self.jerk).max(-self.change),
                (sent.change + self.jerk).min(self.change),
            );
            let upwards = end < wanted;
            let furthest = if upwards { most } else { least };
            let (mut within, mut beyond) = (best.change, furthest);
            let mut tried = self.changed(sent, furthest);
            for _ in 0..HALVINGS {
                let past = (self.stop(&tried) > wanted) == upwards;
                if past || self.judge(sent, &tried).is_err() {
                    beyond = tried.change;
                } else {
                    (within, best) = (tried.change, tried);
                    if within == furthest {
                        break;
                    }
                }
                tried = self.changed(sent, 0.5 * (within + beyond));
            }
        }
        (best, Some(broken))
    }

    /// After one more set-point with this `change` (rad).
    fn changed(&self, sent: &Sent, change: f64) -> Sent {
        let rate = sent.rate + change;
        Sent {
            position: sent.position + rate,
            rate,
            change,
        }
    }

    /// Where the stop that [`Bounds::brake`] leads to ends, rad.
    fn stop(&self, sent: &Sent) -> f64 {
        let mut at = *sent;
        for _ in 0..LONGEST_STOP {
            if self.rests(&at) {
                break;
            }
            at = self.brake(&at);
        }
        at.position
    }

    /// Whether `next` may follow `sent`, and then a stop within the limits.
    pub fn judge(&self, sent: &Sent, next: &Sent) -> Result<(), Broken> {
        let jerk = libm::fabs(next.change - sent.change);
        // Written such that what is not a number breaks a limit.
        if !(jerk <= self.jerk * SLACK && libm::fabs(next.change) <= self.change * SLACK) {
            return Err(Broken::Acceleration);
        }
        let coasting = next.rate + self.release(next.change);
        let fastest = self.rate * SLACK;
        if !(libm::fabs(next.rate) <= fastest && libm::fabs(coasting) <= fastest) {
            return Err(Broken::Velocity);
        }
        if self.stops_within(next, coasting) {
            Ok(())
        } else {
            Err(Broken::Range)
        }
    }

    /// Whether the stop that [`Bounds::brake`] leads to stays in the range; `coasting` is the rate (rad) once the
    /// acceleration is released.
    fn stops_within(&self, next: &Sent, coasting: f64) -> bool {
        let within = |position: f64| (self.low..=self.high).contains(&position);
        // More than the stop can take: most of the time both ends are further away.
        let left = libm::fabs(coasting);
        let steps =
            left / self.change + 2.0 * (left / self.jerk).sqrt() + libm::fabs(next.change) / self.jerk + 4.0;
        let way = steps * left.max(libm::fabs(next.rate)).max(libm::fabs(next.change));
        if within(next.position - way) && within(next.position + way) {
            return true;
        }
        let mut at = *next;
        for _ in 0..LONGEST_STOP {
            if !within(at.position) {
                return false;
            }
            if self.rests(&at) {
                return true;
            }
            at = self.brake(&at);
        }
        false
    }

    /// Whether the axis stands still, but for rounding.
    pub fn rests(&self, sent: &Sent) -> bool {
        let least = 1e-9 * self.change.min(self.jerk);
        libm::fabs(sent.rate) <= least && libm::fabs(sent.change) <= self.jerk
    }

    /// The next set-point on the fastest way to rest within acceleration and jerk, which ends without acceleration.
    ///
    /// Changes a, a - j, a - 2 j, ... down to zero add `g(a)` to the rate; so as long as the rate that would be left is
    /// positive, the next change is the least one with `rate + g(a) >= 0`.
    pub fn brake(&self, sent: &Sent) -> Sent {
        if self.rests(sent) {
            return Sent::at_rest(sent.position);
        }
        let coasting = sent.rate + self.release(sent.change);
        let sign = if coasting < 0.0 { -1.0 } else { 1.0 };
        let (rate, change) = (sign * sent.rate, sign * sent.change);
        let wanted = self.stopping(-rate);
        let (least, most) = (
            (change - self.jerk).max(-self.change),
            (change + self.jerk).min(self.change),
        );
        self.changed(sent, sign * wanted.max(least).min(most))
    }

    /// What the rate still gains (rad) while `change` (rad) falls to zero by the jerk each period:
    /// `n m - j n (n + 1) / 2` with `m = |change|`, `n = floor(m / j)`.
    fn release(&self, change: f64) -> f64 {
        let size = libm::fabs(change);
        let steps = libm::floor(size / self.jerk);
        libm::copysign(steps * size - 0.5 * self.jerk * steps * (steps + 1.0), change)
    }

    /// The change (rad) that, released from itself on, adds `gain` (rad) to the rate: the inverse of
    /// `g(a) = a + release(a)`, which is `(n + 1) m - j n (n + 1) / 2`.
    fn stopping(&self, gain: f64) -> f64 {
        let size = libm::fabs(gain);
        let steps = libm::floor(0.5 * ((1.0 + 8.0 * size / self.jerk).sqrt() - 1.0));
        libm::copysign(size / (steps + 1.0) + 0.5 * self.jerk * steps, gain)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn bounds() -> impl Strategy<Value = Bounds> {
        // From hardly to hard limited.
        (1e-4..4e-3, 1e-6..1e-3, 0.01..2.0).prop_map(|(rate, change, jerk)| Bounds {
            low: -0.1,
            high: 0.05,
            rate,
            change,
            jerk: jerk * change,
        })
    }

    proptest! {
        /// Whatever is wanted, jumps and what is no number included: no limit is left.
        #[test]
        fn no_sequence_of_wishes_leaves_the_limits(
            bounds in bounds(),
            wishes in proptest::collection::vec((0_u8..6, -0.2_f64..0.2, 1_usize..60), 1..30),
        ) {
            let mut sent = Sent::at_rest(0.0);
            for (kind, place, times) in wishes {
                for i in 0..times {
                    let wanted = match kind {
                        0 => place,
                        1 => if i % 2 == 0 { place } else { -place },
                        2 => sent.position + 1e-2 * place,
                        3 => f64::NAN,
                        4 => f64::INFINITY,
                        _ => bounds.high,
                    };
                    let (next, broken) = bounds.next(&sent, wanted);
                    prop_assert!(broken.is_some() || next.position == wanted);
                    prop_assert!((next.change - sent.change).abs() <= bounds.jerk * (1.0 + 1e-6));
                    prop_assert!(next.change.abs() <= bounds.change * (1.0 + 1e-6));
                    prop_assert!(next.rate.abs() <= bounds.rate * (1.0 + 1e-6));
                    prop_assert!((bounds.low..=bounds.high).contains(&next.position));
                    sent = next;
                }
            }
        }

        /// What is far away is reached, and held: no limit cycle is left.
        #[test]
        fn what_is_within_the_range_is_reached(bounds in bounds(), place in -0.09..0.04) {
            let mut sent = Sent::at_rest(0.0);
            for _ in 0..40_000 {
                sent = bounds.next(&sent, place).0;
            }
            prop_assert!((sent.position - place).abs() < 2.0 * bounds.change, "{sent:?} {place}");
        }

        /// The stop ends, at rest and without acceleration.
        #[test]
        fn braking_ends(bounds in bounds(), rate in -1.0..1.0, change in -1.0..1.0) {
            let mut at = Sent { position: 0.0, rate: rate * bounds.rate, change: change * bounds.change };
            let mut steps = 0;
            while !bounds.rests(&at) {
                let next = bounds.brake(&at);
                prop_assert!((next.change - at.change).abs() <= bounds.jerk * (1.0 + 1e-9));
                at = next;
                steps += 1;
                prop_assert!(steps < LONGEST_STOP, "{at:?}");
            }
        }
    }

    /// Within the limits nothing changes, to the last bit.
    #[test]
    fn what_is_allowed_is_sent_as_it_is() {
        let bounds = Bounds {
            low: -1.0,
            high: 1.0,
            rate: 4e-3,
            change: 1e-3,
            jerk: 1e-3,
        };
        let mut sent = Sent::at_rest(0.1);
        for i in 0..1000 {
            let wanted = 0.1 + 1e-3 * libm::sin(0.1 * f64::from(i));
            let (next, broken) = bounds.next(&sent, wanted);
            assert_eq!((next.position.to_bits(), broken), (wanted.to_bits(), None));
            sent = next;
        }
    }
}
