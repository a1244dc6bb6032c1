//! Inverse kinematics by damped Newton steps: continuous in the pose, and always the same amount of work.

use super::{Axes, Unreachable, join};
use crate::{Pose, rotation};
use nalgebra::{Cholesky, Const, Matrix6};

/// Steps of one solution. From one set-point to the next (some mm) two are enough, from 0.1 rad in the joints five.
const STEPS: usize = 5;

/// Square of the damping over the square of the error: it vanishes towards the solution, where the steps are
/// Newton's and the error is squared each time, and keeps the first ones from overshooting.
const DAMPING: f64 = 0.02;

/// What damping is left at the solution, so that a singular Jacobian can be solved at all.
const LEAST_DAMPING: f64 = 1e-18;

/// Largest norm of the remaining error, m and rad together, that counts as solved: far below any encoder.
const RESIDUAL: f64 = 1e-9;

/// Smallest singular value of the Jacobian (m and rad together) that counts as regular. There, a joint moves 1 rad/s
/// for every 30 mm/s or mrad/s of the tool.
const SINGULAR: f64 = 0.03;

/// Position (m) and rotation vector (rad) from `actual` to `wanted`, both in r.
pub fn weighted_error(wanted: &Pose, actual: &Pose) -> Axes {
    join(
        wanted.translation.vector - actual.translation.vector,
        rotation::log(&(wanted.rotation * actual.rotation.inverse())),
    )
}

/// Axes at which `pose_and_jacobian` gives `wanted`, from `near` on.
///
/// Levenberg and Marquardt's step `dq = J^T (J J^T + l^2 I)^-1 e` with `l` proportional to the error `|e|`.
pub(super) fn solve(
    wanted: &Pose,
    near: &Axes,
    pose_and_jacobian: impl Fn(&Axes) -> (Pose, Matrix6<f64>),
) -> Result<Axes, Unreachable> {
    let mut axes = *near;
    for _ in 0..STEPS {
        let (pose, jacobian) = pose_and_jacobian(&axes);
        let error = weighted_error(wanted, &pose);
        let square = DAMPING * error.norm_squared() + LEAST_DAMPING;
        let Some(factor) = factorise(&jacobian, square) else {
            break;
        };
        axes += jacobian.tr_mul(&factor.solve(&error));
    }
    let (pose, jacobian) = pose_and_jacobian(&axes);
    let residual = weighted_error(wanted, &pose).norm();
    if residual.is_nan() || residual > RESIDUAL {
        return Err(Unreachable::Residual {
            residual,
            limit: RESIDUAL,
        });
    }
    let singular_value = smallest_singular_value(&jacobian);
    if singular_value < SINGULAR {
        return Err(Unreachable::Singular {
            singular_value,
            limit: SINGULAR,
        });
    }
    Ok(axes)
}

/// The smallest singular value of `jacobian` by inverse iteration: an upper bound, and sharp near a singularity,
/// where one direction dominates.
pub fn smallest_singular_value(jacobian: &Matrix6<f64>) -> f64 {
    let Some(factor) = factorise(jacobian, LEAST_DAMPING) else {
        return 0.0;
    };
    // A direction with a share of every singular vector that symmetry could leave out.
    let mut direction = Axes::new(0.31, 0.37, 0.41, 0.43, 0.47, 0.43);
    let mut growth = 0.0;
    for _ in 0..6 {
        let next = factor.solve(&direction);
        growth = next.norm();
        if growth.is_nan() || growth <= 0.0 {
            return 0.0;
        }
        direction = next / growth;
    }
    (1.0 / growth).sqrt()
}

fn factorise(jacobian: &Matrix6<f64>, damping: f64) -> Option<Cholesky<f64, Const<6>>> {
    Cholesky::new(jacobian * jacobian.transpose() + Matrix6::identity() * damping)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_smallest_singular_value_is_found() {
        let jacobian = Matrix6::from_fn(|i, j| {
            libm::sin((3 * i + 7 * j + i * j + 1) as f64) + if i == j { 0.3 } else { 0.0 }
        });
        for scale in [1.0, 1e-2, 1e-4] {
            let mut jacobian = jacobian;
            let nearly = jacobian.column(0) + jacobian.column(2) * scale;
            jacobian.set_column(2, &nearly);
            let exact = jacobian.singular_values().min();
            let found = smallest_singular_value(&jacobian);
            assert!(
                found >= exact * (1.0 - 1e-6) && found < 1.02 * exact + 1e-9,
                "{found} {exact}"
            );
        }
    }
}
