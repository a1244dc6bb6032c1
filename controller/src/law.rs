//! The force laws behind one interface, for one degree of freedom each.

use crate::contact::{Aim, ContactSample, PREVIEW, Situation, Touch, Waypoint};
use crate::dofs::{Dofs, NORMAL, Selection};
use crate::elastic::Elastic;
use crate::fzi::Fzi;
use crate::impedance::Impedance;
use crate::literal::Literal;
use crate::object_model::ObjectModel;
use crate::pd::Pd;
use crate::ros2::Ros2;
use nalgebra::Vector3;
use node::scenario;
use spatial::ports::Law;

/// A law that moves the tcp along one degree of freedom, from the first contact on. Chosen in the configuration.
#[derive(Clone, Debug, PartialEq)]
#[expect(
    clippy::large_enum_variant,
    reason = "there are six per controller, and they are not moved"
)]
pub enum DofLaw {
    /// Eq. (1).
    Pd(Pd),
    /// Eq. (2) at each sample.
    Literal(Literal),
    /// Eqs. (2), (12) as an object model.
    Proposed(ObjectModel),
    /// The object model, approached as a mass with damper and spring.
    Impedance(Impedance),
    /// The object model behind elastic gears, along the normal.
    Elastic(Elastic),
    /// That of ROS 2's admittance controller.
    Ros2(Ros2),
    /// That of FZI's cartesian force controller.
    Fzi(Fzi),
}

impl DofLaw {
    /// The configured law for the degree of freedom `dof`.
    pub fn new(controller: &scenario::Controller, dof: usize) -> Self {
        let object = || ObjectModel::new(&controller.proposed);
        match controller.law {
            Law::Literal => Self::Literal(Literal::default()),
            // Along the normal `ForceControl::new` has the law for elastic gears.
            Law::Proposed | Law::Elastic => Self::Proposed(object()),
            Law::Impedance => Self::Impedance(Impedance::new(&controller.impedance, dof, object())),
            Law::PdReset => Self::Pd(Pd::new(&controller.pd, dof, true)),
            Law::Ros2 => Self::Ros2(Ros2::new(&controller.ros2, dof)),
            Law::Fzi => Self::Fzi(Fzi::new(&controller.fzi, dof)),
            Law::Pd => Self::Pd(Pd::new(&controller.pd, dof, false)),
        }
    }

    /// The object moves with `rate` (m/s or rad/s) as the contact begins: for a law that predicts it.
    pub fn expect(&mut self, rate: f64) {
        match self {
            Self::Pd(_) | Self::Literal(_) | Self::Elastic(_) | Self::Ros2(_) | Self::Fzi(_) => {}
            Self::Proposed(law) => law.expect(rate),
            Self::Impedance(law) => law.expect(rate),
        }
    }

    /// Take one sample in contact, in the order of sampling.
    pub fn take(&mut self, sample: &ContactSample) {
        match self {
            Self::Pd(law) => law.take(sample),
            Self::Literal(law) => law.take(sample),
            Self::Proposed(law) => law.take(sample),
            Self::Impedance(law) => law.take(sample),
            Self::Elastic(law) => law.take(sample),
            Self::Ros2(law) => law.take(sample),
            Self::Fzi(law) => law.take(sample),
        }
    }

    /// The coordinates (m or rad) for the coming instants, T apart.
    pub fn demand(&mut self, aim: &Aim, situation: &Situation) -> [f64; PREVIEW] {
        match self {
            Self::Pd(law) => [law.set_point(aim, situation.commanded); PREVIEW],
            Self::Literal(law) => [law.set_point(aim, situation.commanded); PREVIEW],
            Self::Proposed(law) => law.desired(aim, situation),
            Self::Impedance(law) => law.desired(aim, situation),
            Self::Elastic(law) => law.desired(aim, situation),
            Self::Ros2(law) => [law.set_point(aim, situation); PREVIEW],
            Self::Fzi(law) => [law.set_point(aim, situation); PREVIEW],
        }
    }

    /// The object's coordinate (m or rad) and its rate, as the law knows them.
    pub fn object(&self) -> Option<(f64, f64)> {
        match self {
            Self::Pd(law) => law.object(),
            Self::Literal(law) => law.object(),
            Self::Proposed(law) => law.object(),
            Self::Impedance(law) => law.object(),
            Self::Elastic(law) => law.object(),
            Self::Ros2(law) => law.object(),
            Self::Fzi(law) => law.object(),
        }
    }
}

/// Whether the law says where the robot is to be, which the feed-forward of Fig. 2 turns into set-points, already in
/// the approach; otherwise its word is the set-point, and the robot lags behind.
pub fn feeds_forward(law: Law) -> bool {
    matches!(law, Law::Proposed | Law::Impedance | Law::Elastic)
}

/// The law for each force controlled degree of freedom.
#[derive(Clone, Debug)]
pub struct ForceControl {
    selection: Selection,
    laws: [DofLaw; 6],
}

impl ForceControl {
    /// The configured law along the degrees of freedom of `selection`; along the normal, the one for `elastic` gears, if
    /// there is any.
    pub fn new(controller: &scenario::Controller, selection: Selection, elastic: Option<Elastic>) -> Self {
        let mut laws = std::array::from_fn(|dof| DofLaw::new(controller, dof));
        if let Some(elastic) = elastic {
            laws[NORMAL] = DofLaw::Elastic(elastic);
        }
        Self { selection, laws }
    }

    /// The command filters will be at the coordinate `waypoint` along the normal at `time_s` (s), when the next set-point
    /// begins to act: for a law that predicts the robot.
    pub fn track(&mut self, time_s: f64, waypoint: impl FnOnce() -> Waypoint) {
        if let DofLaw::Elastic(law) = &mut self.laws[NORMAL] {
            law.track(time_s, waypoint());
        }
    }

    /// The motion of the command filters along the normal that the last demand asked for, if a law plans it.
    pub fn motion(&self) -> Option<&[Waypoint; PREVIEW]> {
        match &self.laws[NORMAL] {
            DofLaw::Elastic(law) => law.motion(),
            _ => None,
        }
    }

    /// Act along `selection` from now on: a law that acts already goes on, the others begin anew.
    pub fn select(&mut self, controller: &scenario::Controller, selection: Selection) {
        for dof in selection.iter().filter(|dof| !self.selection.contains(*dof)) {
            self.laws[dof] = DofLaw::new(controller, dof);
        }
        self.selection = selection;
    }

    /// Take over the gains of the `controller` that can change in contact.
    pub fn retune(&mut self, controller: &scenario::Controller) {
        for (dof, law) in self.laws.iter_mut().enumerate() {
            if let DofLaw::Pd(law) = law {
                law.retune(&controller.pd, dof);
            }
        }
    }

    /// The object moves with `velocity` (m/s, in r) as the contact begins.
    pub fn expect(&mut self, velocity: &Vector3<f64>) {
        for (law, rate) in self.laws.iter_mut().zip(velocity) {
            law.expect(*rate);
        }
    }

    /// Take one sample in contact, a value for each degree of freedom.
    pub fn take(&mut self, sample: impl Fn(usize) -> ContactSample) {
        for dof in self.selection.iter() {
            let mut sample = sample(dof);
            // Only along the normal is a lost object sought; elsewhere what swings in the air would be followed.
            if dof != NORMAL && sample.touch == Touch::Lost {
                sample.touch = Touch::Bounce;
            }
            self.laws[dof].take(&sample);
        }
    }

    /// The coordinates for the coming instants, T apart; zero where no law acts.
    pub fn demand(
        &mut self,
        aim: impl Fn(usize) -> Aim,
        situation: impl Fn(usize) -> Situation,
    ) -> [Dofs; PREVIEW] {
        let mut demand = [Dofs::zeros(); PREVIEW];
        for dof in self.selection.iter() {
            let coordinates = self.laws[dof].demand(&aim(dof), &situation(dof));
            for (all, coordinate) in demand.iter_mut().zip(coordinates) {
                all[dof] = coordinate;
            }
        }
        demand
    }

    /// The object's coordinate (m or rad) along `dof` and its rate, if the law there knows them.
    pub fn object(&self, dof: usize) -> Option<(f64, f64)> {
        self.selection
            .contains(dof)
            .then(|| self.laws[dof].object())
            .flatten()
    }
}
