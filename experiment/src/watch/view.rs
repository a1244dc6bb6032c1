//! What has been heard: pure, a function of messages and of time.

use super::points::{Point, Points};
use super::rows::{NodeRow, Snapshot};
use super::stream::Stream;
use spatial::ports::{ControllerStatus, Deflections, NodeStatus, ObjectPose, RobotState, Role};
use std::time::{Duration, Instant};

/// So many processes are told apart: one per role, and some that should not be there.
const MOST: usize = 8;
/// A process is shown for so long after its last message, unless it is the last one in its role.
const REMEMBERED: Duration = Duration::from_secs(10);

/// A message of a cell.
#[derive(Clone, Copy, Debug)]
#[expect(clippy::large_enum_variant, reason = "none is kept")]
pub enum Heard {
    /// `NODE_STATUS`.
    Node(NodeStatus),
    /// `CONTROLLER_STATUS`.
    Controller(ControllerStatus),
    /// `ROBOT_STATE`.
    Robot(RobotState),
    /// `SENSOR_DEFLECTION`.
    Sensor(Deflections),
    /// `OBJECT_POSE`.
    Object(ObjectPose),
}

/// The newest of something, and when it came.
pub(super) type Newest<T> = Option<(T, Instant)>;

/// What has been heard of a cell.
#[derive(Clone, Debug, Default)]
pub struct View {
    /// Processes, in the order of their roles.
    nodes: Vec<(NodeStatus, Instant)>,
    /// By role.
    streams: [Option<Stream>; 3],
    pub(super) controller: Newest<ControllerStatus>,
    pub(super) robot: Newest<RobotState>,
    pub(super) sensor: Newest<Deflections>,
    pub(super) object: Newest<ObjectPose>,
    points: Points,
}

impl View {
    /// A message has come `now`.
    pub fn hear(&mut self, heard: &Heard, now: Instant) {
        match heard {
            Heard::Node(status) => self.hear_node(status, now),
            Heard::Controller(status) => {
                self.stream(Role::Controller, status.stamp.boot_id, status.stamp.step, now);
                let anew = |(last, _): &(ControllerStatus, _)| last.stamp.boot_id != status.stamp.boot_id;
                if self.controller.as_ref().is_some_and(anew) {
                    self.points.clear();
                }
                self.points.push(Point::from(status));
                self.controller = Some((*status, now));
            }
            Heard::Robot(state) => {
                self.stream(Role::Robot, state.stamp.boot_id, state.stamp.step, now);
                self.robot = Some((*state, now));
            }
            Heard::Sensor(deflections) => {
                self.stream(
                    Role::Sensor,
                    deflections.stamp.boot_id,
                    deflections.stamp.step,
                    now,
                );
                self.sensor = Some((*deflections, now));
            }
            Heard::Object(pose) => self.object = Some((*pose, now)),
        }
    }

    /// What is plotted.
    pub fn points(&self) -> &Points {
        &self.points
    }

    /// What is shown `now`.
    pub fn snapshot(&self, now: Instant) -> Snapshot {
        let mut nodes: Vec<NodeRow> = Vec::new();
        for role in [Role::Robot, Role::Sensor, Role::Controller] {
            let mut own = self
                .nodes
                .iter()
                .filter(|(status, _)| status.role == role)
                .peekable();
            if own.peek().is_none() {
                nodes.push(NodeRow::unheard(role));
            }
            nodes.extend(own.map(|(status, heard)| {
                let stream = self.streams[role as usize].as_ref();
                let stream = stream.filter(|stream| stream.boot_id == status.stamp.boot_id);
                NodeRow::new(status, *heard, stream, now)
            }));
        }
        Snapshot::new(nodes, self, now)
    }

    fn hear_node(&mut self, status: &NodeStatus, now: Instant) {
        let same =
            |known: &NodeStatus| (known.role, known.stamp.boot_id) == (status.role, status.stamp.boot_id);
        match self.nodes.iter_mut().find(|(known, _)| same(known)) {
            Some(known) => *known = (*status, now),
            None => {
                let gone = |heard: &Instant| now.saturating_duration_since(*heard) >= REMEMBERED;
                self.nodes
                    .retain(|(known, heard)| known.role != status.role || !gone(heard));
                if self.nodes.len() < MOST {
                    self.nodes.push((*status, now));
                }
            }
        }
    }

    fn stream(&mut self, role: Role, boot_id: i64, step: i64, now: Instant) {
        match &mut self.streams[role as usize] {
            Some(stream) if stream.boot_id == boot_id => stream.hear(step, now),
            stream => *stream = Some(Stream::new(boot_id, step, now)),
        }
    }
}
