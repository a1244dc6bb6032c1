//! The sensor's signal chain: low pass, noise, quantisation, range, delay. What the controller gets to see.

use node::scenario;
use rand_core::{Rng, SeedableRng};
use rand_pcg::Pcg64;
use spatial::ports::{DEFLECTION_SAMPLES, DeflectionSample, SampleFlags};
use spatial::{Deflection, TICK_S, TICK_US, Wrench};
use std::ops::Range;

/// What the sensor feels: three translations (m), rotations (rad), forces (N) and moments (Nm), in s.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Reading {
    /// Deflection s -> s'.
    pub deflection: Deflection,
    /// Wrench on the sensor at s: what the environment, gravity included, exerts on the tool, less the tool's inertia
    /// forces.
    pub wrench: Wrench,
}

/// From what the sensor feels to delayed samples.
///
/// Model choice: the wrench, where it is measured, has the low pass and the delay of the deflection and noise of its
/// own; drift is a bias that grows linearly from zero at the start.
#[derive(Clone, Debug)]
pub struct SignalChain {
    /// Time constant of the low pass, s.
    time_constant_s: f64,
    /// rms of the white noise per component.
    noise: [f64; 12],
    /// Quantum, range and drift per second of the deflection's components.
    quantum: [f64; 6],
    range: [f64; 6],
    drift: [f64; 6],
    wrench_measured: bool,
    /// Ticks in which the sensor drops out.
    dropout: Range<i64>,
    delay_ticks: usize,
    felt: [f64; 12],
    filtered: [f64; 12],
    random: Pcg64,
    /// Samples by tick, as a ring.
    ring: Vec<DeflectionSample>,
}

/// A first-order low pass over one step, solved in closed form for a signal that moves linearly within it:
/// `y(h) = e^-a y(0) + ((1 - e^-a)/a - e^-a) u(0) + (1 - (1 - e^-a)/a) u(h)` with `a = h / tau`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Weights {
    keep: f64,
    before: f64,
    after: f64,
}

impl SignalChain {
    /// The chain at rest at `reading`.
    pub fn new(sensor: &scenario::Sensor, seed: i64, reading: &Reading) -> Self {
        let delay_ticks = usize::try_from(sensor.delay_ticks).unwrap_or(0);
        let tick = |time_s: f64| libm::rint(time_s / TICK_S) as i64;
        let dropout_start = tick(sensor.dropout_start_s);
        Self {
            time_constant_s: 1.0 / (std::f64::consts::TAU * sensor.bandwidth_hz),
            noise: thrice([
                sensor.noise_translation_m,
                sensor.noise_rotation_rad,
                sensor.noise_force_n,
                sensor.noise_moment_nm,
            ]),
            quantum: thrice([sensor.quantum_translation_m, sensor.quantum_rotation_rad]),
            range: thrice([sensor.range_translation_m, sensor.range_rotation_rad]),
            drift: joined([sensor.drift_translation_m_per_s, sensor.drift_rotation_rad_per_s]),
            wrench_measured: sensor.wrench_measured,
            dropout: dropout_start..dropout_start + tick(sensor.dropout_duration_s),
            delay_ticks,
            felt: components(reading),
            filtered: components(reading),
            random: Pcg64::seed_from_u64(seed as u64),
            ring: vec![DeflectionSample::default(); delay_ticks + DEFLECTION_SAMPLES],
        }
    }

    /// The low pass over a step of `step` s.
    pub fn weights(&self, step: f64) -> Weights {
        let a = step / self.time_constant_s;
        let keep = libm::exp(-a);
        let mean = -libm::expm1(-a) / a;
        Weights {
            keep,
            before: mean - keep,
            after: 1.0 - mean,
        }
    }

    /// Let the low pass follow over one integration step, in which what the sensor feels moves linearly to `reading`.
    pub fn follow(&mut self, reading: &Reading, weights: &Weights) {
        let now = components(reading);
        let signals = self.felt.iter().zip(&now);
        for (filtered, (before, after)) in self.filtered.iter_mut().zip(signals) {
            *filtered = weights.keep * *filtered + weights.before * before + weights.after * after;
        }
        self.felt = now;
    }

    /// Take the sample of `tick` and return the eight newest that have come through the delay, newest first.
    pub fn sample(&mut self, tick: i64) -> [DeflectionSample; DEFLECTION_SAMPLES] {
        let length = self.ring.len();
        let slot = |tick: i64| tick.rem_euclid(length as i64) as usize;
        // Measured even if it is lost: the stream of random numbers goes on.
        let measured = self.measure(tick);
        self.ring[slot(tick)] = if self.dropout.contains(&tick) {
            DeflectionSample::default()
        } else {
            measured
        };
        let newest = tick - self.delay_ticks as i64;
        std::array::from_fn(|age| {
            let wanted = newest - age as i64;
            let sample = if wanted < 0 {
                DeflectionSample::default()
            } else {
                self.ring[slot(wanted)]
            };
            DeflectionSample {
                utime: wanted * TICK_US,
                ..sample
            }
        })
    }

    fn measure(&mut self, tick: i64) -> DeflectionSample {
        let time = tick as f64 * TICK_S;
        let normal = self.normals();
        let mut saturated = false;
        let deflection: [f64; 6] = std::array::from_fn(|i| {
            let noisy = self.filtered[i] + self.drift[i] * time + self.noise[i] * normal[i];
            let quantised = if self.quantum[i] > 0.0 {
                libm::rint(noisy / self.quantum[i]) * self.quantum[i]
            } else {
                noisy
            };
            saturated |= quantised.abs() >= self.range[i];
            quantised.clamp(-self.range[i], self.range[i])
        });
        let wrench = self.wrench_measured.then(|| {
            let normal = self.normals();
            std::array::from_fn(|i| self.filtered[6 + i] + self.noise[6 + i] * normal[i])
        });
        let wrench: [f64; 6] = wrench.unwrap_or_default();
        DeflectionSample {
            utime: tick * TICK_US,
            deflection: Deflection {
                translation: [deflection[0], deflection[1], deflection[2]].into(),
                rotation: [deflection[3], deflection[4], deflection[5]].into(),
            },
            wrench: Wrench {
                force: [wrench[0], wrench[1], wrench[2]].into(),
                moment: [wrench[3], wrench[4], wrench[5]].into(),
            },
            flags: SampleFlags {
                valid: true,
                saturated,
                wrench_measured: self.wrench_measured,
            },
        }
    }

    /// Six standard normal numbers by Box and Muller: always six draws, so that one stream stays
    /// reproducible.
    fn normals(&mut self) -> [f64; 6] {
        let mut normals = [0.0; 6];
        for pair in normals.chunks_exact_mut(2) {
            let radius = (-2.0 * libm::log(self.uniform())).sqrt();
            let (sine, cosine) = libm::sincos(std::f64::consts::TAU * self.uniform());
            pair[0] = radius * cosine;
            pair[1] = radius * sine;
        }
        normals
    }

    /// Uniform in (0, 1]: the logarithm's argument is never zero.
    fn uniform(&mut self) -> f64 {
        const SCALE: f64 = 1.0 / (1u64 << 53) as f64;
        ((self.random.next_u64() >> 11) + 1) as f64 * SCALE
    }
}

fn components(reading: &Reading) -> [f64; 12] {
    let Reading { deflection, wrench } = reading;
    joined(
        [
            deflection.translation,
            deflection.rotation,
            wrench.force,
            wrench.moment,
        ]
        .map(Into::into),
    )
}

/// Vectors, one after the other.
fn joined<const N: usize, const M: usize>(vectors: [[f64; 3]; N]) -> [f64; M] {
    std::array::from_fn(|i| vectors[i / 3][i % 3])
}

/// Each value for the three components of a vector.
fn thrice<const N: usize, const M: usize>(values: [f64; N]) -> [f64; M] {
    joined(values.map(|value| [value; 3]))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chain(sensor: scenario::Sensor) -> SignalChain {
        SignalChain::new(&sensor, 7, &Reading::default())
    }

    fn quiet() -> scenario::Sensor {
        scenario::Sensor {
            noise_translation_m: 0.0,
            noise_rotation_rad: 0.0,
            quantum_translation_m: 0.0,
            quantum_rotation_rad: 0.0,
            ..Default::default()
        }
    }

    fn deflected(translation: [f64; 3]) -> Reading {
        let mut reading = Reading::default();
        reading.deflection.translation = translation.into();
        reading
    }

    #[test]
    fn a_step_passes_the_low_pass_and_the_delay() {
        let mut chain = chain(scenario::Sensor {
            delay_ticks: 4,
            bandwidth_hz: 200.0,
            ..quiet()
        });
        let step = deflected([1e-3, 0.0, 0.0]);
        chain.sample(0);
        chain.felt = components(&step);
        let weights = chain.weights(1e-3);
        for tick in 1..=20 {
            chain.follow(&step, &weights);
            let samples = chain.sample(tick);
            assert_eq!(samples[0].utime, (tick - 4) * 1000);
            assert_eq!(samples[0].flags.valid, tick >= 4);
            let after = (tick - 4).max(0) as f64 * 1e-3;
            let expected = 1e-3 * (1.0 - libm::exp(-std::f64::consts::TAU * 200.0 * after));
            assert!((samples[0].deflection.translation.x - expected).abs() < 1e-12);
        }
    }

    #[test]
    fn a_ramp_passes_the_low_pass_exactly_in_steps_of_any_length() {
        let through = |steps: u32| {
            let mut chain = chain(quiet());
            let weights = chain.weights(1e-3 / f64::from(steps));
            for i in 1..=steps {
                chain.follow(
                    &deflected([1e-3 * f64::from(i) / f64::from(steps), 0.0, 0.0]),
                    &weights,
                );
            }
            chain.filtered[0]
        };
        let tau = 1.0 / (std::f64::consts::TAU * 200.0);
        let exact = 1.0 - tau / 1e-3 * (1.0 - libm::exp(-1e-3 / tau));
        for steps in [1, 5, 50] {
            assert!((through(steps) / 1e-3 / exact - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn noise_has_the_configured_rms_and_no_mean() {
        let mut chain = chain(scenario::Sensor {
            noise_translation_m: 2e-6,
            noise_rotation_rad: 40e-6,
            ..quiet()
        });
        let count = 20_000;
        let (mut sum, mut squares) = ([0.0; 6], [0.0; 6]);
        for tick in 0..count {
            let DeflectionSample {
                deflection, wrench, ..
            } = chain.sample(tick)[0];
            let newest = components(&Reading { deflection, wrench });
            for i in 0..6 {
                sum[i] += newest[i];
                squares[i] += newest[i] * newest[i];
            }
        }
        for i in 0..6 {
            let rms = if i < 3 { 2e-6 } else { 40e-6 };
            assert!((sum[i] / count as f64).abs() < 4.0 * rms / (count as f64).sqrt());
            assert!(((squares[i] / count as f64).sqrt() / rms - 1.0).abs() < 0.02);
        }
    }

    #[test]
    fn samples_are_quantised_and_saturate_at_the_range() {
        let mut chain = chain(scenario::Sensor {
            quantum_translation_m: 1e-6,
            range_translation_m: 1.5e-3,
            delay_ticks: 0,
            ..quiet()
        });
        let far = deflected([0.1234567e-3, -2e-3, 0.0]);
        let weights = chain.weights(1.0);
        chain.follow(&far, &weights);
        chain.follow(&far, &weights);
        let sample = chain.sample(0)[0];
        assert!((sample.deflection.translation.x - 0.123e-3).abs() < 1e-12);
        assert_eq!(sample.deflection.translation.y, -1.5e-3);
        assert!(sample.flags.saturated);
    }

    #[test]
    fn a_bias_drifts() {
        let mut chain = chain(scenario::Sensor {
            drift_translation_m_per_s: [1e-6, 0.0, -2e-6],
            drift_rotation_rad_per_s: [0.0, 3e-5, 0.0],
            delay_ticks: 0,
            ..quiet()
        });
        let drifted = chain.sample(2000)[0].deflection;
        assert!((drifted.translation - nalgebra::Vector3::new(2e-6, 0.0, -4e-6)).norm() < 1e-18);
        assert!((drifted.rotation.y - 6e-5).abs() < 1e-18);
    }

    #[test]
    fn samples_of_a_drop_out_are_invalid_and_the_noise_goes_on() {
        let noisy = scenario::Sensor {
            delay_ticks: 2,
            ..Default::default()
        };
        let mut whole = chain(noisy.clone());
        let mut broken = chain(scenario::Sensor {
            dropout_start_s: 0.005,
            dropout_duration_s: 0.003,
            ..noisy
        });
        for tick in 0..20 {
            let (whole, broken) = (whole.sample(tick), broken.sample(tick));
            for (whole, broken) in whole.iter().zip(&broken) {
                assert_eq!(whole.utime, broken.utime);
                if (5000..8000).contains(&broken.utime) {
                    assert!(!broken.flags.valid && broken.deflection == Deflection::default());
                } else {
                    assert_eq!(whole, broken);
                }
            }
        }
    }

    #[test]
    fn a_measured_wrench_is_flagged_and_leaves_the_deflection_its_bits_at_the_first_tick() {
        let measuring = scenario::Sensor {
            delay_ticks: 0,
            wrench_measured: true,
            noise_force_n: 0.0,
            noise_moment_nm: 0.0,
            ..Default::default()
        };
        let mut reading = Reading::default();
        reading.wrench.force.z = 10.0;
        reading.wrench.moment.x = -0.3;
        let sample = SignalChain::new(&measuring, 7, &reading).sample(0)[0];
        assert!(sample.flags.wrench_measured);
        assert_eq!(sample.wrench, reading.wrench);
        let plain = chain(scenario::Sensor {
            wrench_measured: false,
            ..measuring
        })
        .sample(0)[0];
        assert!(!plain.flags.wrench_measured && plain.wrench == Wrench::default());
        assert_eq!(sample.deflection, plain.deflection);
    }
}
