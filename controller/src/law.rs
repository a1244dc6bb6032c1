//! The laws along the contact's normal behind one interface.

use crate::command_dynamics::CommandDynamics;
use crate::contact::{Aim, ContactSample};
use crate::literal::Literal;
use crate::object_model::ObjectModel;
use crate::pd::Pd;
use node::scenario;
use spatial::ports::{HORIZON, Law};

/// A law that moves the tool along the contact's normal, from the first contact on. Chosen in the configuration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum NormalLaw {
    /// Eq. (1).
    Pd(Pd),
    /// Eq. (2) at each sample.
    Literal(Literal),
    /// Eqs. (2), (12) as an object model.
    Proposed(ObjectModel),
}

impl NormalLaw {
    /// The configured law. A law that does not exist yet is refused with the configuration and never comes here.
    pub fn new(controller: &scenario::Controller, aim: Aim) -> Self {
        match controller.law {
            Law::Literal => Self::Literal(Literal::new(aim)),
            Law::Proposed => Self::Proposed(ObjectModel::new(&controller.proposed, aim)),
            _ => Self::Pd(Pd::new(&controller.pd, aim)),
        }
    }

    /// Whether set-points are led by the inverse of the command dynamics (the feed-forward of Fig. 2), already in
    /// the approach; otherwise the robot lags behind its commands.
    pub fn feeds_forward(&self) -> bool {
        matches!(self, Self::Proposed(_))
    }

    /// Take one sample in contact, in the order of sampling.
    pub fn take(&mut self, sample: &ContactSample) {
        match self {
            Self::Pd(law) => law.take(sample),
            Self::Literal(law) => law.take(sample),
            Self::Proposed(law) => law.take(sample),
        }
    }

    /// The heights (m) for the next set-points, T apart; the first one takes effect where `dynamics` stands.
    pub fn set_points(&mut self, dynamics: &CommandDynamics) -> [f64; HORIZON] {
        match self {
            Self::Pd(law) => [law.set_point(dynamics.setpoint()); HORIZON],
            Self::Literal(law) => [law.set_point(dynamics.setpoint()); HORIZON],
            Self::Proposed(law) => law.set_points(dynamics),
        }
    }

    /// The height of the object's surface as the law knows it, m.
    pub fn object_height_m(&self) -> Option<f64> {
        match self {
            Self::Proposed(law) => law.height_m(),
            Self::Literal(law) => law.object_height_m(),
            Self::Pd(law) => law.object_height_m(),
        }
    }
}
