//! Where a cell is listened to.

use super::{Heard, View};
use lcmtypes::{Lcm, LcmBuilder, LcmError, Subscription};
use spatial::ports::{ControllerStatus, Deflections, NodeStatus, ObjectPose, RobotState};

/// So many messages of a channel wait until they are looked at: a second's, at the pace of the clock.
const WAITING: usize = 1024;

/// The device channels of a cell.
pub struct Ear {
    nodes: Subscription<NodeStatus>,
    controllers: Subscription<ControllerStatus>,
    robots: Subscription<RobotState>,
    sensors: Subscription<Deflections>,
    objects: Subscription<ObjectPose>,
    _link: Lcm,
}

impl Ear {
    /// On the LCM URL of a cell's device channels.
    pub fn open(url: &str) -> Result<Self, LcmError> {
        let mut link = LcmBuilder::open(url)?;
        Ok(Self {
            nodes: link.subscribe(WAITING),
            controllers: link.subscribe(WAITING),
            robots: link.subscribe(WAITING),
            sensors: link.subscribe(WAITING),
            objects: link.subscribe(WAITING),
            _link: link.start()?,
        })
    }

    /// What has come since the last time. Never waits.
    pub fn drain(&self, view: &mut View) {
        for received in self.nodes.receiver().try_iter() {
            view.hear(&Heard::Node(received.message), received.received_at);
        }
        for received in self.sensors.receiver().try_iter() {
            view.hear(&Heard::Sensor(received.message), received.received_at);
        }
        for received in self.robots.receiver().try_iter() {
            view.hear(&Heard::Robot(received.message), received.received_at);
        }
        for received in self.objects.receiver().try_iter() {
            view.hear(&Heard::Object(received.message), received.received_at);
        }
        for received in self.controllers.receiver().try_iter() {
            view.hear(&Heard::Controller(received.message), received.received_at);
        }
    }
}
