//! The sensor's signal chain: low pass, noise, quantisation, range, delay. What the controller gets to see.

use crate::noise::Noise;
use node::scenario;
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
    random: Noise,
    /// Samples by tick, as a ring.
    ring: Vec<DeflectionSample>,
}

/// A first-order low pass over one step, solved in closed form for a signal that is quadratic within it.
///
/// With `a = h / tau` and the moments `I_k`, the integrals of `a e^(-a (1 - s)) s^k` over s from 0 to 1:
/// `y(h) = e^-a y(0) + (I_0 - 3 I_1 + 2 I_2) u(0) + 4 (I_1 - I_2) u(h/2) + (2 I_2 - I_1) u(h)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Weights {
    keep: f64,
    before: f64,
    middle: f64,
    after: f64,
}

impl SignalChain {
    /// The chain at rest at `reading`.
    pub fn new(sensor: &scenario::Sensor, seed: i64, reading: &Reading) -> Self {
        let delay_ticks = usize::try_from(sensor.delay_ticks).unwrap_or(0);
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
            dropout: dropout(sensor.dropout_start_s, sensor.dropout_duration_s),
            delay_ticks,
            felt: components(reading),
            filtered: components(reading),
            random: Noise::new(seed as u64),
            ring: vec![DeflectionSample::default(); delay_ticks + DEFLECTION_SAMPLES],
        }
    }

    /// The low pass over a step of `step` s.
    pub fn weights(&self, step: f64) -> Weights {
        let a = step / self.time_constant_s;
        let first = 1.0 + libm::expm1(-a) / a;
        let second = 1.0 - 2.0 * first / a;
        Weights {
            keep: libm::exp(-a),
            before: -libm::expm1(-a) - 3.0 * first + 2.0 * second,
            middle: 4.0 * (first - second),
            after: 2.0 * second - first,
        }
    }

    /// Let the low pass follow over one integration step to `end`, along a parabola through `middle`, or straight.
    pub fn follow(&mut self, middle: Option<&Reading>, end: &Reading, weights: &Weights) {
        let end = components(end);
        let straight = || std::array::from_fn(|i| 0.5 * (self.felt[i] + end[i]));
        let middle: [f64; 12] = middle.map_or_else(straight, components);
        let signals = if self.wrench_measured { 12 } else { 6 };
        for i in 0..signals {
            self.filtered[i] = weights.keep * self.filtered[i]
                + weights.before * self.felt[i]
                + weights.middle * middle[i]
                + weights.after * end[i];
        }
        self.felt = end;
    }

    /// Take the sample of `tick` and return the eight newest that have come through the delay, newest first.
    pub fn sample(&mut self, tick: i64) -> [DeflectionSample; DEFLECTION_SAMPLES] {
        let length = self.ring.len();
        let slot = tick.rem_euclid(length as i64) as usize;
        // Measured even if it is lost: the stream of random numbers goes on.
        let measured = self.measure(tick);
        self.ring[slot] = if self.dropout.contains(&tick) {
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
                let before = self.delay_ticks + age;
                self.ring[(slot + length - before) % length]
            };
            DeflectionSample {
                utime: wanted * TICK_US,
                ..sample
            }
        })
    }

    fn measure(&mut self, tick: i64) -> DeflectionSample {
        let time = tick as f64 * TICK_S;
        let normal: [f64; 6] = self.random.normals();
        let mut saturated = false;
        let deflection: [f64; 6] = std::array::from_fn(|i| {
            let noisy = self.filtered[i] + self.drift[i] * time + self.noise[i] * normal[i];
            let quantised = quantised(noisy, self.quantum[i]);
            saturated |= quantised.abs() >= self.range[i];
            quantised.clamp(-self.range[i], self.range[i])
        });
        let wrench = self.wrench_measured.then(|| {
            let normal: [f64; 6] = self.random.normals();
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
}

/// The multiple of `quantum` that is nearest to `value`; `value` itself if the quantum is 0.
pub(crate) fn quantised(value: f64, quantum: f64) -> f64 {
    if quantum > 0.0 {
        libm::rint(value / quantum) * quantum
    } else {
        value
    }
}

/// The ticks of a drop-out that begins at `start` and lasts `duration`, both in s.
pub(crate) fn dropout(start: f64, duration: f64) -> Range<i64> {
    let tick = |time: f64| libm::rint(time / TICK_S) as i64;
    tick(start)..tick(start) + tick(duration)
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
mod tests;
