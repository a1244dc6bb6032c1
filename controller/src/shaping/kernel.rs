//! A window in time whose spectrum is small from a frequency on.
//!
//! `w(t) = 1/T (1 + sum c_m cos(2 pi m t / T))` on 0..T, m = 1..N. Its spectrum is, with x = f T,
//! `H(x) = sinc(x) prod (1 - x^2/z_n^2) / (1 - x^2/n^2)`, n = 1..N: the first N zeros of a plain average are moved to any
//! z_n. They are moved to `z_n = s sqrt(A^2 + (n - 1/2)^2)`, those of Dolph and Chebyshev's window with
//! `cosh(pi A) = 1 / ripple`, the shortest one there is, stretched by s such that the next one joins those that remain at
//! N + 1, N + 2, ... (Taylor's window).

use std::f64::consts::{PI, TAU};

/// Terms N. Model choice: more make the window shorter by some per cent, and its ends higher.
const TERMS: usize = 8;

/// What a window may be asked for: above, it is hardly more than two steps, below, N zeros are too few.
const LARGEST_RIPPLE: f64 = 0.1;
const SMALLEST_RIPPLE: f64 = 1e-5;

/// The window.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Kernel {
    /// T, s.
    duration: f64,
    /// c_m.
    coefficients: [f64; TERMS],
}

/// The window's integrals over time from its start on.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Moments {
    /// Its integral W: from 0 to 1.
    pub(super) value: f64,
    /// The integral of W, s.
    pub(super) once: f64,
    /// The integral of that, s^2.
    pub(super) twice: f64,
}

impl Moments {
    /// Those of a window of no duration, `time` (s) after it.
    pub(super) fn of_step(time: f64) -> Self {
        Self {
            value: 1.0,
            once: time,
            twice: 0.5 * time * time,
        }
    }
}

impl Kernel {
    /// The window whose spectrum is at most `ripple` (of 1 at no frequency) from `edge_hz` on. Validity: within 0.1 to 1e-3;
    /// at 1e-4 it is exceeded twofold.
    pub fn new(edge_hz: f64, ripple: f64) -> Self {
        let a = libm::acosh(1.0 / ripple.clamp(SMALLEST_RIPPLE, LARGEST_RIPPLE)) / PI;
        let zero_square = |n: f64| a * a + (n - 0.5) * (n - 0.5);
        let next = TERMS as f64 + 1.0;
        let stretch = next / libm::sqrt(zero_square(next));
        let square = |n: usize| (n * n) as f64;
        let coefficient = |m: usize| {
            let moved: f64 = (1..=TERMS)
                .map(|n| 1.0 - square(m) / (stretch * stretch * zero_square(n as f64)))
                .product();
            let plain: f64 = (1..=TERMS)
                .filter(|&n| n != m)
                .map(|n| 1.0 - square(m) / square(n))
                .product();
            -moved / plain
        };
        Self {
            duration: stretch * a / edge_hz,
            coefficients: std::array::from_fn(|i| coefficient(i + 1)),
        }
    }

    /// T, s.
    pub fn duration(&self) -> f64 {
        self.duration
    }

    /// Its integrals `time` (s) after its start.
    pub(super) fn moments(&self, time: f64) -> Moments {
        let t = self.duration;
        let u = (time / t).min(1.0);
        let (sine, cosine) = libm::sincos(TAU * u);
        // Sine and cosine of 2 pi m u, from those of one m to those of the next.
        let (mut s, mut c) = (sine, cosine);
        let mut inside = Moments {
            value: u,
            once: 0.5 * u * u,
            twice: u * u * u / 6.0,
        };
        for (i, &coefficient) in self.coefficients.iter().enumerate() {
            let w = TAU * (i + 1) as f64;
            let share = coefficient / w;
            inside.value += share * s;
            inside.once += share / w * (1.0 - c);
            inside.twice += share / w * (u - s / w);
            (s, c) = (s * cosine + c * sine, c * cosine - s * sine);
        }
        let after = (time - t).max(0.0);
        Moments {
            value: inside.value,
            once: inside.once * t + after,
            twice: inside.twice * t * t + inside.once * t * after + 0.5 * after * after,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn window(kernel: &Kernel, time: f64) -> f64 {
        let sum: f64 = (1..)
            .zip(&kernel.coefficients)
            .map(|(m, c)| c * libm::cos(TAU * f64::from(m) * time / kernel.duration))
            .sum();
        (1.0 + sum) / kernel.duration
    }

    /// Magnitude of the window's Fourier transform at `hz`, by the trapezoidal rule.
    fn spectrum(kernel: &Kernel, hz: f64) -> f64 {
        let steps = 4000;
        let h = kernel.duration / f64::from(steps);
        let (mut re, mut im) = (0.0, 0.0);
        for i in 0..steps {
            let t = h * f64::from(i);
            let (s, c) = libm::sincos(TAU * hz * t);
            re += h * window(kernel, t) * c;
            im += h * window(kernel, t) * s;
        }
        libm::hypot(re, im)
    }

    #[test]
    fn the_spectrum_is_below_the_ripple_from_the_edge_on() {
        for (ripple, excess) in [(0.1, 1.3), (0.03, 1.3), (0.01, 1.3), (1e-3, 1.3), (1e-4, 2.0)] {
            let kernel = Kernel::new(15.0, ripple);
            let worst = (0..600)
                .map(|i| spectrum(&kernel, 15.0 + 0.25 * f64::from(i)))
                .fold(0.0, f64::max);
            assert!(
                worst < excess * ripple,
                "{worst} for {ripple}, {} s",
                kernel.duration
            );
            assert!((spectrum(&kernel, 0.0) - 1.0).abs() < 1e-9);
            // The shortest window there can be is that of Dolph and Chebyshev.
            let shortest = libm::acosh(1.0 / ripple) / (PI * 15.0);
            assert!(kernel.duration < 1.2 * shortest, "{}", kernel.duration / shortest);
        }
    }

    /// It is never negative, so that the acceleration keeps to its limit, and begins and ends far below its largest value.
    #[test]
    fn it_only_averages() {
        for ripple in [0.05, 0.01, 1e-4] {
            let kernel = Kernel::new(15.0, ripple);
            let largest = window(&kernel, 0.5 * kernel.duration);
            for i in 0..=1000 {
                let w = window(&kernel, kernel.duration * f64::from(i) / 1000.0);
                assert!(w > 0.0 && w <= largest * (1.0 + 1e-9), "{w} of {largest}");
            }
        }
    }

    proptest! {
        #[test]
        fn the_moments_are_integrals_of_each_other(share in 0.01..1.5_f64, ripple in 1e-5..0.3) {
            let kernel = Kernel::new(12.0, ripple);
            let time = share * kernel.duration;
            let h = 1e-5;
            let (before, now, after) = (kernel.moments(time - h), kernel.moments(time), kernel.moments(time + h));
            prop_assert!(((after.twice - before.twice) / (2.0 * h) - now.once).abs() < 1e-8);
            // Where the window ends, so does its smoothness.
            prop_assume!((share - 1.0).abs() > 1e-3);
            prop_assert!(((after.once - before.once) / (2.0 * h) - now.value).abs() < 1e-6);
        }
    }
}
