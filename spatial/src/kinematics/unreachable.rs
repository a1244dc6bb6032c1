//! Why there are no axes for a pose.

/// A pose that the axes can't take up, or only with unlimited speed.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum Unreachable {
    /// No axes lead there.
    #[error(
        "the pose is out of reach: the nearest one found is off by {residual}, not at most {limit} (m and rad \
         together); stay within the robot's working range"
    )]
    Residual {
        /// Norm of the remaining error of position (m) and rotation vector (rad).
        residual: f64,
        /// Largest residual that counts as solved.
        limit: f64,
    },
    /// The joints lose a degree of freedom.
    #[error(
        "the pose is next to a singularity: the smallest singular value of the Jacobian is {singular_value}, not at \
         least {limit}; keep away from stretched arm and aligned wrist"
    )]
    Singular {
        /// Smallest singular value of the Jacobian (m and rad together).
        singular_value: f64,
        /// Smallest one that counts as regular.
        limit: f64,
    },
}
