//! Linear least squares over measurements of three components.

use super::CalibrationError;
use nalgebra::{SMatrix, SVector, Vector3};

/// The solution of a least-squares problem with `N` unknowns.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Fit<const N: usize> {
    /// The unknowns.
    pub(super) value: SVector<f64, N>,
    /// Their covariance, with the noise's variance taken from the residuals.
    pub(super) covariance: SMatrix<f64, N, N>,
    /// rms of a residual's component.
    pub(super) residual_rms: f64,
}

impl<const N: usize> Fit<N> {
    /// The standard deviation of unknown `i`.
    pub(super) fn sigma(&self, i: usize) -> f64 {
        self.covariance[(i, i)].sqrt()
    }
}

/// The x that minimises `sum |A_i x - y_i|^2` over the pairs (A_i, y_i), by the normal equations
/// `(sum A_i^T A_i) x = sum A_i^T y_i` and Cholesky; covariance `sigma^2 (sum A_i^T A_i)^-1` with
/// `sigma^2 = sum |A_i x - y_i|^2 / (3 n - N)`.
pub(super) fn fit<const N: usize>(
    equations: impl Iterator<Item = (SMatrix<f64, 3, N>, Vector3<f64>)> + Clone,
) -> Result<Fit<N>, CalibrationError> {
    let mut normal = SMatrix::<f64, N, N>::zeros();
    let mut right = SVector::<f64, N>::zeros();
    for (rows, y) in equations.clone() {
        normal += rows.transpose() * rows;
        right += rows.transpose() * y;
    }
    let factor = normal.cholesky().ok_or(CalibrationError::Singular)?;
    let value = factor.solve(&right);
    let (mut squares, mut count) = (0.0, 0);
    for (rows, y) in equations {
        squares += (rows * value - y).norm_squared();
        count += 3;
    }
    let freedom = (count - N as i32).max(1);
    Ok(Fit {
        value,
        covariance: factor.inverse() * (squares / f64::from(freedom)),
        residual_rms: (squares / f64::from(count.max(1))).sqrt(),
    })
}
