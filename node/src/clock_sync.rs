//! How a peer's clock differs from the own one, measured from four time stamps in the ordinary messages; pure.
//!
//! A command leaves here at `t1` and reaches the peer at `t2`, the peer's next message leaves there at `t3` and arrives
//! here at `t4`: `t1` and `t4` on the own clock, `t2` and `t3` on the peer's. Then the peer is ahead by
//! `((t2 - t1) + (t3 - t4)) / 2`, wrong by at most half the round trip `(t4 - t1) - (t3 - t2)`, however the delays of the
//! two ways differ (Mills, "Internet time synchronization", IEEE Trans. Communications 39, 1991). Only exchanges whose round
//! trip was short say much: of each tenth of a second the shortest is kept, and a line is fitted to those of 8 s.

use spatial::ports::ClockEcho;

/// Exchanges that are kept.
const KEPT: usize = 80;
/// The shortest round trip of so long a time is kept, us.
const SPAN_US: i64 = 100_000;
/// Kept exchanges that an estimate can be based on.
const ENOUGH: usize = 3;
/// Clocks drift by no more than that: quartz oscillators, ten times over.
const DRIFT: f64 = 200e-6;
/// A clock that is farther off than the bounds allow, us, has jumped ...
const JUMP_US: f64 = 2_000.0;
/// ... if so many exchanges in a row say so.
const JUMP_EXCHANGES: u32 = 3;
/// Longer round trips say nothing, us.
const LONGEST_US: i64 = 1_000_000;

/// One exchange.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Exchange {
    /// Its middle on the own clock, us.
    own_utime: i64,
    /// How far the peer's clock is ahead, us.
    ahead_us: f64,
    /// Half of the round trip, us.
    bound_us: f64,
}

/// How the peer's clock goes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Estimate {
    /// How far the peer's clock is ahead of the own one, us.
    pub ahead_us: f64,
    /// The estimate is wrong by at most this much, us.
    pub bound_us: f64,
    /// How much faster the peer's clock goes, 1.
    pub rate: f64,
}

/// What the exchanges with one peer tell of its clock.
#[derive(Clone, Debug)]
pub struct ClockSync {
    kept: [Exchange; KEPT],
    count: usize,
    next: usize,
    /// The shortest of the present tenth of a second, and when that began.
    best: Option<Exchange>,
    began_utime: i64,
    last_sent_utime: i64,
    /// Exchanges in a row that contradict what is known.
    contradicting: u32,
    /// How far the clock has jumped, us, until that is asked for.
    jumped_us: Option<f64>,
}

impl Default for ClockSync {
    fn default() -> Self {
        Self {
            kept: [Exchange::default(); KEPT],
            count: 0,
            next: 0,
            best: None,
            began_utime: i64::MIN,
            last_sent_utime: 0,
            contradicting: 0,
            jumped_us: None,
        }
    }
}

impl ClockSync {
    /// A message of the peer with this `echo` has arrived at `arrived_utime` (us, own clock). One exchange of a command
    /// counts: the first. Returns its round trip, us.
    pub fn take(&mut self, echo: &ClockEcho, arrived_utime: i64) -> Option<i64> {
        let ClockEcho {
            command_send_utime: sent,
            receive_utime,
            send_utime,
        } = *echo;
        if sent == 0 || sent <= self.last_sent_utime {
            return None;
        }
        let there = send_utime.checked_sub(receive_utime)?;
        let round_trip = arrived_utime.checked_sub(sent)?.checked_sub(there)?;
        if there < 0 || !(0..LONGEST_US).contains(&round_trip) {
            return None;
        }
        self.last_sent_utime = sent;
        let exchange = Exchange {
            own_utime: sent + (arrived_utime - sent) / 2,
            ahead_us: 0.5 * ((receive_utime - sent) as f64 + (send_utime - arrived_utime) as f64),
            bound_us: 0.5 * round_trip as f64,
        };
        if self.contradicts(&exchange, arrived_utime) {
            return Some(round_trip);
        }
        if arrived_utime.saturating_sub(self.began_utime) >= SPAN_US {
            self.keep();
            self.began_utime = arrived_utime;
        }
        if self.best.is_none_or(|best| exchange.bound_us < best.bound_us) {
            self.best = Some(exchange);
        }
        Some(round_trip)
    }

    /// Whether `exchange` can't be what is known of the clock. One that has jumped is measured anew: what was known of it says
    /// nothing any more.
    fn contradicts(&mut self, exchange: &Exchange, utime: i64) -> bool {
        let off = self.estimate(utime).map_or(0.0, |known| {
            let off = exchange.ahead_us - known.ahead_us;
            let allowed = exchange.bound_us + known.bound_us + JUMP_US;
            if libm::fabs(off) > allowed { off } else { 0.0 }
        });
        self.contradicting = if off == 0.0 { 0 } else { self.contradicting + 1 };
        if self.contradicting >= JUMP_EXCHANGES {
            *self = Self {
                last_sent_utime: self.last_sent_utime,
                jumped_us: Some(off),
                ..Self::default()
            };
        }
        off != 0.0
    }

    /// How far the peer's clock has jumped since this was asked last, us.
    pub fn jump(&mut self) -> Option<f64> {
        self.jumped_us.take()
    }

    fn keep(&mut self) {
        if let Some(best) = self.best.take() {
            self.kept[self.next] = best;
            self.next = (self.next + 1) % KEPT;
            self.count = (self.count + 1).min(KEPT);
        }
    }

    /// Whether enough is known for an estimate to be used.
    pub fn ready(&self) -> bool {
        self.count >= ENOUGH
    }

    /// The peer's clock at `utime` of the own one (us); `None`: nothing is known of it.
    ///
    /// The line through those of the kept exchanges that were not slower than twice the fastest: least squares. The bound
    /// holds whatever the delays are: what one exchange proves, that which proves most after as much drift as there may be
    /// since, plus what the line and it differ by.
    pub fn estimate(&self, utime: i64) -> Option<Estimate> {
        let all = || self.kept[..self.count].iter().chain(&self.best);
        let fastest = all().min_by(|a, b| a.bound_us.total_cmp(&b.bound_us))?;
        let good = || all().filter(|it| it.bound_us <= 2.0 * fastest.bound_us + 1.0);
        let seconds = |it: &Exchange| 1e-6 * (it.own_utime - fastest.own_utime) as f64;
        let n = good().count() as f64;
        let mean = |value: &dyn Fn(&Exchange) -> f64| good().map(value).sum::<f64>() / n;
        let (time, ahead) = (mean(&|it| seconds(it)), mean(&|it| it.ahead_us));
        let spread = mean(&|it| (seconds(it) - time) * (seconds(it) - time));
        // A slope needs a second at least: over less the delays' jitter is all it would show.
        let slope = match spread {
            0.1.. => mean(&|it| (seconds(it) - time) * (it.ahead_us - ahead)) / spread,
            _ => 0.0,
        };
        let at = |s: f64| ahead + slope * (s - time);
        let ahead_us = at(1e-6 * (utime - fastest.own_utime) as f64);
        let proves = |it: &Exchange| it.bound_us + DRIFT * libm::fabs((utime - it.own_utime) as f64);
        let best = all().min_by(|a, b| proves(a).total_cmp(&proves(b)))?;
        Some(Estimate {
            ahead_us,
            bound_us: proves(best) + libm::fabs(ahead_us - best.ahead_us),
            rate: 1e-6 * slope,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// 8 s of exchanges every 4 ms with a peer that is ahead by 12 ms and 20 ppm: each way takes what `delays` says, us.
    fn measured(mut delays: impl FnMut(i64) -> [i64; 2]) -> (ClockSync, i64) {
        let mut sync = ClockSync::default();
        let mut now = 5_000_000;
        for i in 0..2000 {
            now += 4_000;
            let [there, back] = delays(i);
            let peer = |own: i64| own + 12_000 + (own as f64 * 20e-6) as i64;
            let echo = ClockEcho {
                command_send_utime: now,
                receive_utime: peer(now + there),
                send_utime: peer(now + there + 300),
            };
            sync.take(&echo, now + there + 300 + back);
        }
        (sync, now)
    }

    fn true_ahead_us(now: i64) -> f64 {
        12_000.0 + now as f64 * 20e-6
    }

    #[test]
    fn offset_and_rate_are_found_under_jitter() {
        // Mostly some 100 us, sometimes a millisecond more.
        let (sync, now) = measured(|i| {
            [
                100 + i * 37 % 90,
                100 + i * 53 % 120 + if i % 7 == 0 { 1000 } else { 0 },
            ]
        });
        let found = sync.estimate(now).unwrap();
        assert!((found.ahead_us - true_ahead_us(now)).abs() < 30.0, "{found:?}");
        assert!((found.rate - 20e-6).abs() < 5e-6, "{found:?}");
        assert!(found.bound_us < 300.0, "{found:?}");
    }

    proptest! {
        /// However the two ways differ, the estimate is wrong by at most its bound.
        #[test]
        fn the_bound_holds(there in 20i64..2000, back in 20i64..2000, jitter in 1i64..2000, seed in 1i64..1000) {
            let (sync, now) = measured(|i| {
                [there + (i * seed * 7919) % jitter, back + (i * seed * 104_729) % jitter]
            });
            let found = sync.estimate(now).unwrap();
            // 1 us of rounding in each stamp.
            prop_assert!((found.ahead_us - true_ahead_us(now)).abs() <= found.bound_us + 2.0, "{:?}", found);
        }
    }

    #[test]
    fn a_clock_that_jumps_is_measured_anew() {
        let (mut sync, mut now) = measured(|_| [100, 100]);
        assert_eq!(sync.jump(), None);
        let ahead = -1_000_000;
        for _ in 0..200 {
            now += 4_000;
            let echo = ClockEcho {
                command_send_utime: now,
                receive_utime: now + ahead + 100,
                send_utime: now + ahead + 400,
            };
            sync.take(&echo, now + 500);
        }
        let jump = sync.jump().unwrap();
        assert!(
            (jump - (ahead as f64 - true_ahead_us(now))).abs() < 200.0,
            "{jump}"
        );
        assert!(sync.ready() && sync.jump().is_none());
        let found = sync.estimate(now).unwrap();
        assert!((found.ahead_us - ahead as f64).abs() < 10.0, "{found:?}");
    }

    #[test]
    fn what_can_not_be_is_not_taken() {
        let mut sync = ClockSync::default();
        let echo = |sent, received, left| ClockEcho {
            command_send_utime: sent,
            receive_utime: received,
            send_utime: left,
        };
        for (echo, arrived) in [
            (echo(0, 10, 20), 30),
            (echo(100, 50, 40), 200),
            (echo(100, 50, 60), 90),
            (echo(i64::MIN, i64::MAX, i64::MIN), i64::MAX),
            (echo(100, 50, 60), 100 + 2_000_000),
        ] {
            assert_eq!(sync.take(&echo, arrived), None, "{echo:?}");
        }
        assert_eq!(sync.estimate(0), None);
        assert_eq!(sync.take(&echo(100, 50, 60), 200), Some(90));
        assert_eq!(sync.take(&echo(100, 50, 60), 300), None, "the same command");
    }
}
