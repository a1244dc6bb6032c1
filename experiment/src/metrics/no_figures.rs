//! Why a run gave no figures.

use super::WINDOW_S;
use node::greeting::role_name;
use spatial::ports::{Fault, Role};

/// Why a run gave no figures.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum NoFigures {
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
    /// The tool never met the object.
    #[error(
        "no contact within {duration_s} s; raise timing.duration_s or task.search_depth_m, or check object.height_m"
    )]
    NoContact {
        /// Length of the run, s.
        duration_s: f64,
    },
    /// It ended too early.
    #[error(
        "contact at {contact_s:.3} s and end at {duration_s} s leave less than the \
         {WINDOW_S} s that are judged; raise timing.duration_s"
    )]
    TooShort {
        /// First contact, s.
        contact_s: f64,
        /// Length of the run, s.
        duration_s: f64,
    },
}

/// What of the scenario to look at.
fn remedy(fault: Fault) -> &'static str {
    match fault {
        Fault::ToleranceExceeded => {
            "what is in the way is stiffer or farther beside than task.tolerance_m allows: check object.origin_m, the \
             hole and its depth, or tolerate more"
        }
        Fault::SensorStale => "the sensor was silent for longer than controller.stale_fault_s",
        Fault::StateStale => "the robot was silent for longer than controller.stale_fault_s",
        Fault::ClockJump => {
            "the clock of a node was set while it worked; leave it to `chronyd` or `timesyncd`, which slew"
        }
        Fault::NoContact => "raise task.search_depth_m, or check object.height_m",
        Fault::AxisLimit => "check the axes' ranges in [robot] against the poses of [task]",
        Fault::VelocityLimit => "check the axes' velocity limits in [robot], or approach more slowly",
        Fault::Unreachable => "check the poses of [task] against the robot's reach",
        Fault::CommandInvalid => "the loop is unstable with these values; check [controller]",
        _ => "the recorded data show what came before",
    }
}
