//! Why rests tell less than was asked of them.

use super::{MINIMUM_RESTS, MINIMUM_TILT_RAD};

/// Why a calibration, or a part of it, is impossible.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CalibrationError {
    /// Fewer rests than unknowns need.
    #[error("{found} rests, fewer than {MINIMUM_RESTS}; rest in more orientations")]
    TooFewRests {
        /// How many there are.
        found: usize,
    },
    /// Gravity hardly turns in the sensor's frame.
    #[error(
        "the rests tilt by {tilt_rad:.3} rad rms about the axis about which they tilt least, below \
         {MINIMUM_TILT_RAD} rad; tilt further about two horizontal axes (a turn about the vertical tells nothing)"
    )]
    TooLittleTilt {
        /// How far they tilt.
        tilt_rad: f64,
    },
    /// The weight is neither measured nor known.
    #[error(
        "no wrench is measured, so that the tool's mass must be known to learn the translational compliance; set \
         controller.tool_mass_kg"
    )]
    MassUnknown,
    /// The weight's lever is neither measured nor known.
    #[error(
        "no wrench is measured, so that the tool's centre of mass must be known to learn the rotational compliance; \
         set controller.tool_centre_of_mass_in_s_m"
    )]
    CentreUnknown,
    /// The normal equations have no unique solution.
    #[error("the measurements don't determine the unknowns; check that all of them are finite numbers")]
    Singular,
    /// A result that can't be.
    #[error(
        "{quantity} comes out as {value:.3e}, not as a positive number; check signs and frames of what the sensor puts \
         out, and that the tool's centre of mass is not at the sensor"
    )]
    NotPositive {
        /// The result and its unit.
        quantity: &'static str,
        /// What came out.
        value: f64,
    },
}
