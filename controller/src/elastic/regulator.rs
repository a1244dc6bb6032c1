//! The linear-quadratic regulator: the feedback that costs least.

use nalgebra::{Const, DimMin, SMatrix, ToTypenum};

/// How often the horizon is doubled: 2^14 periods are for ever.
const DOUBLINGS: usize = 14;

/// The gain K of `u = -K x` that minimises `sum x' Q x + r u^2` for `x+ = A x + b u`.
///
/// The Riccati equation `P = Q + A' P (1 + G P)^-1 A`, `G = b b' / r`, by doubling: each step squares the horizon's
/// length (Anderson, Int. J. Control 28 (1978) 295; Chu, Fan, Lin, Wang, Int. J. Control 77 (2004) 767).
/// `None` if that does not come to an end, which takes a plant that the input does not move.
pub fn gain<const N: usize>(
    a: &SMatrix<f64, N, N>,
    b: &SMatrix<f64, N, 1>,
    q: &SMatrix<f64, N, N>,
    r: f64,
) -> Option<SMatrix<f64, 1, N>>
where
    Const<N>: ToTypenum + DimMin<Const<N>, Output = Const<N>>,
{
    let one = SMatrix::<f64, N, N>::identity();
    let (mut power, mut reach, mut cost) = (*a, b * b.transpose() / r, *q);
    for _ in 0..DOUBLINGS {
        let between = (one + reach * cost).lu();
        let onwards = between.solve(&power)?;
        let reached = between.solve(&reach)?;
        cost += power.transpose() * cost * onwards;
        reach += power * reached * power.transpose();
        power *= onwards;
        cost = (cost + cost.transpose()) * 0.5;
        reach = (reach + reach.transpose()) * 0.5;
    }
    let weighted = b.transpose() * cost;
    let gain = weighted * a / (r + (weighted * b)[0]);
    gain.iter().all(|k| k.is_finite()).then_some(gain)
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Matrix1, Matrix2, Vector2};

    /// One state: `P = q + a^2 P r / (r + P)` in closed form.
    #[test]
    fn one_state_in_closed_form() {
        let (a, q, r) = (1.1, 2.0, 3.0);
        let k = gain(&Matrix1::new(a), &Matrix1::new(1.0), &Matrix1::new(q), r).unwrap()[0];
        let half = 0.5 * (q + r * (a * a - 1.0));
        let p = half + libm::sqrt(half * half + q * r);
        assert!((k - a * p / (r + p)).abs() < 1e-12, "{k}");
    }

    /// A double integrator: no other gain near costs less, and the recursion over a long horizon comes to the same.
    #[test]
    fn as_the_riccati_recursion() {
        let (a, b) = (Matrix2::new(1.0, 0.1, 0.0, 1.0), Vector2::new(0.005, 0.1));
        let (q, r) = (Matrix2::new(1.0, 0.0, 0.0, 0.0), 0.01);
        let k = gain(&a, &b, &q, r).unwrap();
        let mut p = q;
        let mut recursive = SMatrix::<f64, 1, 2>::zeros();
        for _ in 0..2000 {
            let weighted = b.transpose() * p;
            recursive = weighted * a / (r + (weighted * b)[0]);
            p = q + a.transpose() * p * (a - b * recursive);
        }
        assert!((k - recursive).norm() < 1e-9 * k.norm(), "{k} {recursive}");
    }
}
