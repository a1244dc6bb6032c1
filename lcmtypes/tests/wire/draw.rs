//! Where the values of samples come from: readable ones, and such of arbitrary bits.

use nalgebra::{Matrix3, Vector3, Vector6};
use spatial::Pose;
use spatial::kinematics::{Axes, quaternion};

/// A source of values.
pub(crate) trait Draw {
    /// A finite number.
    fn real(&mut self) -> f64;
    /// Any integer.
    fn integer(&mut self) -> i64;
    /// A unit quaternion (w, x, y, z).
    fn quaternion(&mut self) -> [f64; 4];
    /// Whether an optional value is given.
    fn given(&mut self) -> bool;

    fn count(&mut self, limit: usize) -> usize {
        usize::try_from(self.integer().rem_euclid(limit as i64)).expect("below the limit")
    }
    fn int(&mut self) -> i32 {
        self.integer() as i32
    }
    /// A time that is accepted, us.
    fn utime(&mut self) -> i64 {
        self.integer() % 9_000_000_000_000_000
    }
    /// A tick that is accepted.
    fn step(&mut self) -> i64 {
        self.integer().rem_euclid(9_000_000_000_000)
    }
    fn bool(&mut self) -> bool {
        self.integer() & 1 == 1
    }
    fn one_of<T: Copy>(&mut self, all: &[T]) -> T {
        all[self.count(all.len())]
    }
    fn vector(&mut self) -> Vector3<f64> {
        Vector3::from_fn(|_, _| self.real())
    }
    fn axes(&mut self) -> Axes {
        Vector6::from_fn(|_, _| self.real())
    }
    fn matrix(&mut self) -> Matrix3<f64> {
        Matrix3::from_fn(|_, _| self.real())
    }
    fn pose(&mut self) -> Pose {
        Pose::from_parts(self.vector().into(), quaternion(self.quaternion()))
    }
}

/// 0.25, -1.25, 2.25, ... and 1001, 1002, ...: every member differs from its neighbours. Of an enumeration, one of the
/// values that follow the first: those that come to its end later change no sample.
#[derive(Default)]
pub(crate) struct Counting {
    reals: f64,
    integers: i64,
    choices: usize,
}

impl Draw for Counting {
    fn real(&mut self) -> f64 {
        let sign = if self.reals % 2.0 == 0.0 { 1.0 } else { -1.0 };
        self.reals += 1.0;
        sign * (self.reals - 0.75)
    }
    fn integer(&mut self) -> i64 {
        self.integers += 1;
        1000 + self.integers
    }
    fn one_of<T: Copy>(&mut self, all: &[T]) -> T {
        self.integer();
        self.choices += 1;
        all[1 + self.choices % (all.len().min(4) - 1)]
    }
    fn quaternion(&mut self) -> [f64; 4] {
        [0.8, 0.0, -0.6, 0.0]
    }
    fn given(&mut self) -> bool {
        true
    }
}

/// Bits of a generator (splitmix64), with a liking for the edges.
pub(crate) struct Arbitrary(pub(crate) u64);

impl Draw for Arbitrary {
    fn real(&mut self) -> f64 {
        const EDGES: [f64; 6] = [0.0, -0.0, 5e-324, -2e-308, f64::MAX, f64::MIN_POSITIVE];
        let bits = self.integer().cast_unsigned();
        match f64::from_bits(bits) {
            value if value.is_finite() && bits & 3 != 0 => value,
            _ => EDGES[self.count(EDGES.len())],
        }
    }
    fn integer(&mut self) -> i64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        (z ^ (z >> 31)).cast_signed()
    }
    fn quaternion(&mut self) -> [f64; 4] {
        let q = [(); 4].map(|()| self.integer() as f64);
        let norm = q.iter().map(|c| c * c).sum::<f64>().sqrt();
        // Not quite normalised: it must stay so.
        q.map(|c| c / norm * (1.0 + 1e-7))
    }
    fn given(&mut self) -> bool {
        self.bool()
    }
}
