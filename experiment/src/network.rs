//! The network between the devices, in process: it delivers every message at once, but for those that are lost.

use lcmtypes::Message;
use node::scenario::Scenario;
use spatial::ports::{Deflections, ObjectPose};

/// What has come through to the controller.
#[derive(Debug)]
pub struct Network<'a> {
    scenario: &'a Scenario,
    deflections: Option<Deflections>,
    object_pose: Option<ObjectPose>,
}

impl<'a> Network<'a> {
    /// The network of `scenario`, over which nothing has come yet.
    pub fn new(scenario: &'a Scenario) -> Self {
        Self {
            scenario,
            deflections: None,
            object_pose: None,
        }
    }

    /// `message`, unless it is lost.
    pub fn passes<M: Message>(&self, message: Option<M>) -> Option<M> {
        message.filter(|message| !self.scenario.loses(M::CHANNEL, message.stamp().step))
    }

    /// Keep what comes of a tick's messages of the sensor until the controller's next cycle.
    pub fn take(&mut self, sensed: &sensor_sim::Outputs) {
        self.deflections = self.passes(Some(sensed.deflections)).or(self.deflections);
        self.object_pose = self.passes(sensed.object_pose).or(self.object_pose);
    }

    /// The newest deflections that have come; `None`: none yet.
    pub fn deflections(&self) -> Option<&Deflections> {
        self.deflections.as_ref()
    }

    /// The object's pose, if one has come since this was asked last.
    pub fn object_pose(&mut self) -> Option<ObjectPose> {
        self.object_pose.take()
    }
}
