//! Values with their standard deviations, and what follows from them.

use super::CalibrationError;
use super::least_squares::Fit;
use nalgebra::{Matrix3, Vector3, Vector6};

/// A value and its standard deviation, both in the value's unit.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Estimate<T> {
    /// The least-squares estimate.
    pub value: T,
    /// Its standard deviation, from the residuals.
    pub sigma: T,
}

/// The first moment M c, or C_phi M c, with its covariance.
#[derive(Clone, Copy, Debug)]
pub(super) struct Moment {
    pub(super) value: Vector3<f64>,
    pub(super) covariance: Matrix3<f64>,
}

impl Moment {
    pub(super) fn of(fit: &Fit<6>) -> Self {
        Self {
            value: fit.value.fixed_rows::<3>(0).into_owned(),
            covariance: fit.covariance.fixed_view::<3, 3>(0, 0).into_owned(),
        }
    }
}

impl Fit<6> {
    /// The first and the last three unknowns.
    pub(super) fn halves(&self) -> (Estimate<Vector3<f64>>, Estimate<Vector3<f64>>) {
        let sigma = Vector6::from_fn(|i, _| self.sigma(i));
        let half = |start| Estimate {
            value: self.value.fixed_rows::<3>(start).into_owned(),
            sigma: sigma.fixed_rows::<3>(start).into_owned(),
        };
        (half(0), half(3))
    }
}

/// y_0 of a fit along gravity.
pub(super) fn bias(fit: &Fit<4>) -> Estimate<Vector3<f64>> {
    Estimate {
        value: fit.value.fixed_rows::<3>(1).into_owned(),
        sigma: Vector3::from_fn(|i, _| fit.sigma(i + 1)),
    }
}

/// The quotient of two independent estimates, with the error's propagation to first order.
pub(super) fn quotient(numerator: Estimate<f64>, denominator: Estimate<f64>) -> Estimate<f64> {
    let value = numerator.value / denominator.value;
    let (a, b) = (numerator.sigma, value * denominator.sigma);
    Estimate {
        value,
        sigma: (a * a + b * b).sqrt() / denominator.value.abs(),
    }
}

/// C_phi such that `b = C_phi h` in the least-squares sense, `b . h / h . h`; errors to first order around `b = C_phi h`.
pub(super) fn ratio(b: &Moment, h: &Moment) -> Estimate<f64> {
    let square = h.value.norm_squared();
    let value = b.value.dot(&h.value) / square;
    let along_h = |covariance: &Matrix3<f64>| h.value.dot(&(covariance * h.value));
    Estimate {
        value,
        sigma: (along_h(&b.covariance) + value * value * along_h(&h.covariance)).sqrt() / square,
    }
}

pub(super) fn positive(
    quantity: &'static str,
    estimate: Estimate<f64>,
) -> Result<Estimate<f64>, CalibrationError> {
    let value = estimate.value;
    if value > 0.0 && value.is_finite() {
        Ok(estimate)
    } else {
        Err(CalibrationError::NotPositive { quantity, value })
    }
}
