//! White noise: standard normal numbers from a seeded stream.

use rand_core::{Rng, SeedableRng};
use rand_pcg::Pcg64;

/// A stream of standard normal numbers that its seed determines.
#[derive(Clone, Debug)]
pub struct Noise {
    random: Pcg64,
}

impl Noise {
    /// The stream of `seed`.
    pub fn new(seed: u64) -> Self {
        Self {
            random: Pcg64::seed_from_u64(seed),
        }
    }

    /// `N` standard normal numbers by Box and Muller: always `N` draws (`N + 1` if it is odd), so that the stream
    /// stays reproducible.
    pub fn normals<const N: usize>(&mut self) -> [f64; N] {
        let mut normals = [0.0; N];
        for pair in normals.chunks_mut(2) {
            let radius = (-2.0 * libm::log(self.uniform())).sqrt();
            let (sine, cosine) = libm::sincos(std::f64::consts::TAU * self.uniform());
            for (normal, part) in pair.iter_mut().zip([cosine, sine]) {
                *normal = radius * part;
            }
        }
        normals
    }

    /// Uniform in (0, 1]: the logarithm's argument is never zero.
    fn uniform(&mut self) -> f64 {
        const SCALE: f64 = 1.0 / (1u64 << 53) as f64;
        ((self.random.next_u64() >> 11) + 1) as f64 * SCALE
    }
}
