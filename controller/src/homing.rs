//! A controller that joins a robot away from its start, as after its own restart in the middle of an experiment.
//!
//! What the sensor bears there is not known: taken as zero force, 10 N that the tool presses with would be pressed in addition.
//! So nothing begins by itself, and a start leads the tool back first: up, to the start's height, then to the start, where
//! zero is taken anew and the task begins. Until then only changes of the force are known, which is enough to notice a
//! collision.

use crate::requests::Refusal;
use crate::{Controller, ControllerPhase};
use node::scenario::{Scenario, Step, StepKind};
use spatial::kinematics::Axes;
use spatial::ports::RobotState;

/// An axis farther from the start than that is away from it, rad.
const AWAY_RAD: f64 = 2e-3;

/// Where the robot was when it was joined.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Joined {
    AtStart,
    Away,
    /// On its way back.
    Returning,
}

/// The start of the task, and whether the robot has been there.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Homing {
    start: Option<Axes>,
    joined: Joined,
}

impl Homing {
    /// Of `scenario`'s start.
    pub(crate) fn new(scenario: &Scenario) -> Self {
        Self {
            start: scenario.start_axes().ok(),
            joined: Joined::AtStart,
        }
    }

    /// Whether the tare tells nothing.
    pub(crate) fn away(&self) -> bool {
        self.joined != Joined::AtStart
    }

    /// A way back that is stopped has to be begun again.
    pub(crate) fn abandon(&mut self) {
        if self.joined == Joined::Returning {
            self.joined = Joined::Away;
        }
    }
}

impl Controller {
    /// The robot is at `axes` when it is joined.
    pub(crate) fn join(&mut self, axes: &Axes) {
        let away = self
            .homing
            .start
            .is_some_and(|start| (start - axes).amax() > AWAY_RAD);
        if away {
            self.homing.joined = Joined::Away;
            self.started = true;
        }
    }

    /// Begin the way back.
    pub(crate) fn go_home(&mut self, tick: i64, state: &RobotState) -> Result<(), Refusal> {
        self.ready(tick, state)?;
        self.homing.joined = Joined::Returning;
        self.collision.reset();
        let task = &self.configured;
        let (now, start) = (
            self.settings.kinematics.forward(&self.commanded).translation.z,
            self.homing
                .start
                .map(|start| self.settings.kinematics.forward(&start).translation.z),
        );
        let step = |kind| Step {
            kind,
            speed_m_per_s: task.approach_speed_m_per_s,
            timeout_s: f64::INFINITY,
            ..Step::default()
        };
        let mut up = step(StepKind::Retract);
        up.distance_m = start.map_or(0.0, |start| (start - now).max(0.0));
        let mut back = step(StepKind::Move);
        back.position_m = task.start_position_m;
        self.program.go_home([up, back]);
        self.begin_step(tick);
        Ok(())
    }

    /// Take zero anew and let the task begin, once the tool rests at the start.
    pub(crate) fn arrive_home(&mut self, tick: i64) {
        let returns =
            self.homing.joined == Joined::Returning && self.phases.phase() == ControllerPhase::Ready;
        if returns && self.rests(tick) {
            self.homing.joined = Joined::AtStart;
            self.tare_anew(tick);
            self.started = false;
        }
    }
}
