//! A quantity that swings about a mean which moves slowly: how far it comes between two instants.

use std::f64::consts::{PI, TAU};

/// A quantity and its first two derivatives in time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Course {
    /// The quantity.
    pub value: f64,
    /// Its rate of change, 1/s.
    pub rate: f64,
    /// The rate's rate of change, 1/s^2.
    pub change: f64,
}

/// Least and greatest value from `start` to `end`, `time` s later, of what swings with `w` rad/s:
/// `x = m + a cos(w t + phase)` with `m = x + x'' / w^2` and `a^2 = (x - m)^2 + (x' / w)^2`, at worst of both ends.
pub fn range([start, end]: [&Course; 2], w: f64, time: f64) -> (f64, f64) {
    let mean = |x: &Course| x.value + x.change / (w * w);
    let amplitude = |x: &Course| {
        let (off, slope) = (x.change / (w * w), x.rate / w);
        (off * off + slope * slope).sqrt()
    };
    // The angle to the next crest, 0 to 2 pi; the trough is half a turn from it.
    let to_crest = libm::atan2(start.rate * w, -start.change).rem_euclid(TAU);
    let to_trough = (to_crest + PI).rem_euclid(TAU);
    let angle = w * time;
    let (mut least, mut greatest) = (start.value.min(end.value), start.value.max(end.value));
    if to_crest <= angle {
        greatest = greatest.max((mean(start) + amplitude(start)).max(mean(end) + amplitude(end)));
    }
    if to_trough <= angle {
        least = least.min((mean(start) - amplitude(start)).min(mean(end) - amplitude(end)));
    }
    (least, greatest)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against the exact extremes of a swing about a mean that drifts by a hundredth of the amplitude.
    #[test]
    fn crest_and_trough_are_found_where_they_are() {
        let (w, drift) = (6000.0, 0.01);
        let at = |t: f64| Course {
            value: libm::cos(w * t) + drift * t / 1e-3,
            rate: -w * libm::sin(w * t) + drift / 1e-3,
            change: -w * w * libm::cos(w * t),
        };
        for i in 0..200 {
            for time in [1e-5, 1e-4, 3e-4, 6e-4, 1e-3] {
                let start = f64::from(i) * 1e-5;
                let (least, greatest) = range([&at(start), &at(start + time)], w, time);
                let values = (0..=1000).map(|k| at(start + time * f64::from(k) / 1000.0).value);
                let exact = values.fold((2.0_f64, -2.0_f64), |(a, b), x| (a.min(x), b.max(x)));
                assert!((exact.0 - least).abs() < 0.012 && (exact.1 - greatest).abs() < 0.012);
            }
        }
    }
}
