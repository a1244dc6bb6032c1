//! Why a run gave no calibration.

use controller::calibration::CalibrationError;
use controller::tilting::RESTS;
use node::greeting::role_name;
use spatial::kinematics::Unreachable;
use spatial::ports::{Fault, Role};

/// Why a run gave no calibration.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CalibrateError {
    /// The robot can't tilt that far.
    #[error(
        "rest {rest} of the calibration can't be reached: {reason}; lower task.calibration_tilt_rad or start elsewhere"
    )]
    Unreachable {
        /// Which, from 0.
        rest: usize,
        /// Why.
        reason: Unreachable,
    },
    /// An axis can't turn that far.
    #[error(
        "rest {rest} of the calibration puts axis {axis} at {angle_rad:.3} rad, outside {minimum_rad}..={maximum_rad} \
         rad; lower task.calibration_tilt_rad or start elsewhere"
    )]
    AxisRange {
        /// Which, from 0.
        rest: usize,
        /// The axis.
        axis: usize,
        /// Where it would be.
        angle_rad: f64,
        /// Its lower end.
        minimum_rad: f64,
        /// Its upper end.
        maximum_rad: f64,
    },
    /// The robot or the controller has given up.
    #[error("{} latched {fault:?} at tick {tick}; {}", role_name(*node), remedy(*fault))]
    Faulty {
        /// Who.
        node: Role,
        /// What.
        fault: Fault,
        /// Tick of the first message that tells it.
        tick: i64,
    },
    /// The run was over before the last rest.
    #[error(
        "the run ended before the last of {RESTS} rests was over, after {duration_s} s; raise timing.duration_s to \
         {needed_s:.1} s (a robot that lags further than controller.max_lead_m behind needs longer)"
    )]
    TooShort {
        /// How long it was, s.
        duration_s: f64,
        /// How long it must be, s.
        needed_s: f64,
    },
    /// Nothing was measured.
    #[error(
        "the sensor gave no valid sample in rest {rest}; raise task.calibration_rest_s, and check the sensor"
    )]
    NoSamples {
        /// Which, from 0.
        rest: usize,
    },
    /// The sensor was at the end of its range.
    #[error(
        "the sensor was at the end of its range in rest {rest}; lower task.calibration_tilt_rad, or use a stiffer \
         sensor or a lighter tool"
    )]
    Saturated {
        /// Which, from 0.
        rest: usize,
    },
    /// The rests don't tell enough.
    #[error(transparent)]
    Calibration(#[from] CalibrationError),
}

/// What of the scenario to look at.
fn remedy(fault: Fault) -> &'static str {
    match fault {
        Fault::SensorStale => "the sensor was silent for longer than controller.stale_fault_s",
        Fault::StateStale => "the robot was silent for longer than controller.stale_fault_s",
        _ => "lower task.calibration_tilt_rad or start elsewhere",
    }
}
