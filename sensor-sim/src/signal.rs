//! The sensor's signal chain: low pass, noise, quantisation, range, delay. What the controller gets to see.

use node::scenario;
use rand_core::{Rng, SeedableRng};
use rand_pcg::Pcg64;
use spatial::ports::{DEFLECTION_SAMPLES, DeflectionSample, SampleFlags};
use spatial::{Deflection, TICK_US, Wrench};

/// From the true deflection to delayed samples.
#[derive(Clone, Debug)]
pub struct SignalChain {
    /// Time constant of the low pass, s.
    time_constant_s: f64,
    /// rms of the white noise, quantum and range per component: three of translation (m), three of rotation (rad).
    noise: [f64; 6],
    quantum: [f64; 6],
    range: [f64; 6],
    delay_ticks: usize,
    filtered: [f64; 6],
    random: Pcg64,
    /// Samples by tick, as a ring.
    ring: Vec<DeflectionSample>,
}

impl SignalChain {
    /// The chain at rest at `deflection`.
    pub fn new(sensor: &scenario::Sensor, seed: i64, deflection: &Deflection) -> Self {
        let delay_ticks = usize::try_from(sensor.delay_ticks).unwrap_or(0);
        let both = |translation: f64, rotation: f64| {
            [
                translation,
                translation,
                translation,
                rotation,
                rotation,
                rotation,
            ]
        };
        Self {
            time_constant_s: 1.0 / (std::f64::consts::TAU * sensor.bandwidth_hz),
            noise: both(sensor.noise_translation_m, sensor.noise_rotation_rad),
            quantum: both(sensor.quantum_translation_m, sensor.quantum_rotation_rad),
            range: both(sensor.range_translation_m, sensor.range_rotation_rad),
            delay_ticks,
            filtered: components(deflection),
            random: Pcg64::seed_from_u64(seed as u64),
            ring: vec![DeflectionSample::default(); delay_ticks + DEFLECTION_SAMPLES],
        }
    }

    /// Let the low pass follow the deflection over one integration step of `step` s, in which it moves linearly
    /// from its value before to `deflection` (the mean is held: second order in the step).
    pub fn follow(&mut self, before: &Deflection, deflection: &Deflection, step: f64) {
        let weight = 1.0 - libm::exp(-step / self.time_constant_s);
        let (start, end) = (components(before), components(deflection));
        for i in 0..6 {
            self.filtered[i] += weight * (0.5 * (start[i] + end[i]) - self.filtered[i]);
        }
    }

    /// Take the sample of `tick` and return the eight newest that have come through the delay, newest first.
    pub fn sample(&mut self, tick: i64) -> [DeflectionSample; DEFLECTION_SAMPLES] {
        let normal = self.normals();
        let mut saturated = false;
        let measured: [f64; 6] = std::array::from_fn(|i| {
            let noisy = self.filtered[i] + self.noise[i] * normal[i];
            let quantised = if self.quantum[i] > 0.0 {
                libm::rint(noisy / self.quantum[i]) * self.quantum[i]
            } else {
                noisy
            };
            saturated |= quantised.abs() >= self.range[i];
            quantised.clamp(-self.range[i], self.range[i])
        });
        let length = self.ring.len();
        let slot = |tick: i64| tick.rem_euclid(length as i64) as usize;
        self.ring[slot(tick)] = DeflectionSample {
            utime: tick * TICK_US,
            deflection: deflection(measured),
            wrench: Wrench::default(),
            flags: SampleFlags {
                valid: true,
                saturated,
                wrench_measured: false,
            },
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

    /// Six standard normal numbers by Box and Muller: always six draws, so that one stream stays reproducible.
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

fn components(deflection: &Deflection) -> [f64; 6] {
    let (p, phi) = (deflection.translation, deflection.rotation);
    [p.x, p.y, p.z, phi.x, phi.y, phi.z]
}

fn deflection(c: [f64; 6]) -> Deflection {
    Deflection {
        translation: [c[0], c[1], c[2]].into(),
        rotation: [c[3], c[4], c[5]].into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chain(sensor: scenario::Sensor) -> SignalChain {
        SignalChain::new(&sensor, 7, &Deflection::default())
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

    #[test]
    fn a_step_passes_the_low_pass_and_the_delay() {
        let mut chain = chain(scenario::Sensor {
            delay_ticks: 4,
            bandwidth_hz: 200.0,
            ..quiet()
        });
        let step = Deflection {
            translation: [1e-3, 0.0, 0.0].into(),
            ..Default::default()
        };
        chain.sample(0);
        for tick in 1..=20 {
            chain.follow(&step, &step, 1e-3);
            let samples = chain.sample(tick);
            assert_eq!(samples[0].utime, (tick - 4) * 1000);
            assert_eq!(samples[0].flags.valid, tick >= 4);
            let after = (tick - 4).max(0) as f64 * 1e-3;
            let expected = 1e-3 * (1.0 - libm::exp(-std::f64::consts::TAU * 200.0 * after));
            assert!((samples[0].deflection.translation.x - expected).abs() < 1e-12);
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
            let newest = components(&chain.sample(tick)[0].deflection);
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
        let far = Deflection {
            translation: [0.1234567e-3, -2e-3, 0.0].into(),
            ..Default::default()
        };
        chain.follow(&far, &far, 1.0);
        let sample = chain.sample(0)[0];
        assert!((sample.deflection.translation.x - 0.123e-3).abs() < 1e-12);
        assert_eq!(sample.deflection.translation.y, -1.5e-3);
        assert!(sample.flags.saturated);
    }
}
