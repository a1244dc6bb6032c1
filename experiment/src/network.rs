//! The network between the devices, in process: it delivers every message at once, but for those that are lost.

use controller::Heard;
use lcmtypes::Message;
use node::scenario::Scenario;
use spatial::ports::{Deflections, ObjectPose, RobotState};

/// What has come through to the controller since its cycle before.
#[derive(Clone, Copy, Debug, Default)]
pub struct Arrived {
    state: Option<RobotState>,
    deflections: Option<Deflections>,
    object: Option<ObjectPose>,
}

impl Arrived {
    /// For the cycle at `tick`.
    pub fn heard(&self, tick: i64) -> Heard<'_> {
        Heard {
            tick,
            state: self.state.as_ref(),
            deflections: self.deflections.as_ref(),
            object: self.object.as_ref(),
        }
    }
}

/// What is under way.
#[derive(Debug)]
pub struct Network<'a> {
    scenario: &'a Scenario,
    arrived: Arrived,
}

impl<'a> Network<'a> {
    /// The network of `scenario`, over which nothing has come yet.
    pub fn new(scenario: &'a Scenario) -> Self {
        Self {
            scenario,
            arrived: Arrived::default(),
        }
    }

    /// `message`, unless it is lost.
    pub fn passes<M: Message>(&self, message: Option<M>) -> Option<M> {
        message.filter(|message| self.delivers(message))
    }

    fn delivers<M: Message>(&self, message: &M) -> bool {
        !self.scenario.loses(M::CHANNEL, message.stamp().step)
    }

    /// Take a tick's messages of robot and sensor: what comes through waits for the controller's next cycle. Where one is
    /// due, at a multiple of T, its tick and all that has come for it.
    pub fn take(
        &mut self,
        state: Option<RobotState>,
        sensed: &sensor_sim::Outputs,
    ) -> Option<(i64, Arrived)> {
        self.arrived.state = self.passes(state);
        // In place: a tick's samples are a thousand bytes, and wanted once in T.
        if self.delivers(&sensed.deflections) {
            self.arrived.deflections = Some(sensed.deflections);
        }
        self.arrived.object = self.passes(sensed.object_pose).or(self.arrived.object);
        Some((state?.stamp.step, std::mem::take(&mut self.arrived)))
    }
}
