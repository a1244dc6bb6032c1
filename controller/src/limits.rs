//! The last stage before a command leaves the controller: no set-point leaves the limits, whatever the laws ask for.
//!
//! Velocity, acceleration and jerk of the set-points, the ranges of the axes and the workspace of the tcp are kept by
//! construction: a set-point is sent only if a stop within all of them exists afterwards, and where what is asked for
//! has none, the nearest one that has. What breaks no limit goes through bit by bit.
//!
//! Model choice: a set-point leads its axis. To turn the acceleration of an axis around within a period, its set-point
//! jumps by `2 A / w^2` (A its acceleration limit, w its command filter's frequency): in terms of A, set-points
//! accelerate `1 / (w T)^2` times as much as axes. The limits here are those of set-points; the axes' own accelerations
//! are [`crate::command_dynamics`]'s.

mod axis;

pub use axis::{Bounds, Broken, Sent};

use crate::delivery::Followed;
use nalgebra::Vector3;
use node::scenario::Scenario;
use spatial::TICK_S;
use spatial::kinematics::{Axes, Kinematics};
use spatial::ports::{HORIZON, LIMIT_ACCELERATION, LIMIT_AXIS, LIMIT_VELOCITY, LIMIT_WORKSPACE};
use std::f64::consts::TAU;

/// A wall at this distance (m) from r's origin is none.
const NO_WALL_M: f64 = 10.0;

/// Halvings on the way from a stop to what is wanted.
const HALVINGS: usize = 12;

/// Steps within which a stop that is looked for ends.
const LONGEST_STOP: usize = 1024;

/// A box in r.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Workspace {
    minimum: Vector3<f64>,
    maximum: Vector3<f64>,
}

impl Workspace {
    /// From corner to corner, m in r.
    pub fn new(minimum: Vector3<f64>, maximum: Vector3<f64>) -> Self {
        Self { minimum, maximum }
    }

    /// Whether it has any wall.
    fn limits(&self) -> bool {
        self.minimum.iter().any(|wall| *wall > -NO_WALL_M)
            || self.maximum.iter().any(|wall| *wall < NO_WALL_M)
    }

    fn contains(&self, point: &Vector3<f64>) -> bool {
        (0..3).all(|i| (self.minimum[i]..=self.maximum[i]).contains(&point[i]))
    }

    /// The point of it that is nearest to `point` (m in r).
    pub fn nearest(&self, point: &Vector3<f64>) -> Vector3<f64> {
        point.sup(&self.minimum).inf(&self.maximum)
    }
}

/// The limits of the set-points, and what was sent.
#[derive(Clone, Debug)]
pub struct Limits {
    axes: [Bounds; 6],
    workspace: Workspace,
    kinematics: Kinematics,
    /// The tcp that the workspace holds for, in s, m.
    tcp_in_s: Vector3<f64>,
    sent: [Sent; 6],
}

impl Limits {
    /// The limits of `scenario`; at rest at `axes` (rad).
    pub fn new(scenario: &Scenario, axes: &Axes) -> Self {
        let (drives, controller) = (scenario.robot.drives(), &scenario.controller);
        let limits = &controller.limits;
        let period_s = scenario.timing.command_period_ticks as f64 * TICK_S;
        let turn = TAU * controller.filter_frequency_hz * period_s;
        let bounds = |i: usize| {
            let acceleration = controller.acceleration_limit_rad_per_s2[i];
            let change = acceleration * period_s * period_s * (1.0 + limits.lead_ratio / (turn * turn));
            Bounds {
                low: drives.axis_minimum_rad[i] + limits.axis_margin_rad,
                high: drives.axis_maximum_rad[i] - limits.axis_margin_rad,
                rate: limits.velocity_ratio * drives.velocity_limit_rad_per_s[i] * period_s,
                change,
                jerk: limits.reversal_ratio * change,
            }
        };
        Self {
            axes: std::array::from_fn(bounds),
            workspace: Workspace::new(
                limits.workspace_minimum_m.into(),
                limits.workspace_maximum_m.into(),
            ),
            kinematics: scenario.robot.kinematics(),
            tcp_in_s: controller.tcp_in_s_m.into(),
            sent: std::array::from_fn(|i| Sent::at_rest(axes[i])),
        }
    }

    /// The robot stands at `axes` (rad) as the first command is made.
    pub fn begin(&mut self, axes: &Axes) {
        self.sent = std::array::from_fn(|i| Sent::at_rest(axes[i]));
    }

    /// Where the axes are sent.
    pub fn sent(&self) -> &[Sent; 6] {
        &self.sent
    }

    /// The robot has `followed` other set-points than those sent last. Beyond the end of a horizon it stands: how it came
    /// to rest is its own affair.
    pub fn follow(&mut self, followed: &Followed) {
        self.sent = followed.before().sent;
        for axes in followed.set_points() {
            self.sent = std::array::from_fn(|axis| self.sent[axis].then(axes[axis]));
        }
        if let Some(end) = followed.set_points().last().filter(|_| followed.stands()) {
            self.sent = std::array::from_fn(|axis| Sent::at_rest(end[axis]));
        }
    }

    /// The tcp hangs at `tcp_in_s` (m).
    pub fn hang(&mut self, tcp_in_s: Vector3<f64>) {
        self.tcp_in_s = tcp_in_s;
    }

    /// The limits of the axes, per period.
    pub fn axes(&self) -> &[Bounds; 6] {
        &self.axes
    }

    /// The workspace of the tcp.
    pub fn workspace(&self) -> &Workspace {
        &self.workspace
    }

    /// Bring the next `set_points`, one period apart, within the limits; the bits of those that bind at the first one.
    ///
    /// The limits hold from command to command, and within each one's horizon.
    pub fn apply(&mut self, set_points: &mut [Axes; HORIZON]) -> i32 {
        let mut at = self.sent;
        let mut bits = 0;
        for (i, set_point) in set_points.iter_mut().enumerate() {
            let mut broken = 0;
            let mut next = at;
            for axis in 0..6 {
                let (sent, limit) = self.axes[axis].next(&at[axis], set_point[axis]);
                next[axis] = sent;
                broken |= limit.map_or(0, bit);
            }
            if self.workspace.limits() && !self.stops_within_workspace(&next) {
                next = self.within_workspace(&at, &next);
                broken |= LIMIT_WORKSPACE;
            }
            if broken != 0 {
                *set_point = Axes::from_fn(|axis, _| next[axis].position);
            }
            at = next;
            if i == 0 {
                (self.sent, bits) = (at, broken);
            }
        }
        bits
    }

    fn tcp(&self, sent: &[Sent; 6]) -> Vector3<f64> {
        let axes = Axes::from_fn(|axis, _| sent[axis].position);
        let r_from_s = self.kinematics.forward(&axes);
        r_from_s.translation.vector + r_from_s.rotation * self.tcp_in_s
    }

    /// Whether the tcp is in the workspace now and on the way to a stop of all axes.
    fn stops_within_workspace(&self, sent: &[Sent; 6]) -> bool {
        let mut at = *sent;
        for _ in 0..LONGEST_STOP {
            if !self.workspace.contains(&self.tcp(&at)) {
                return false;
            }
            if (0..6).all(|axis| self.axes[axis].rests(&at[axis])) {
                return true;
            }
            at = std::array::from_fn(|axis| self.axes[axis].brake(&at[axis]));
        }
        false
    }

    /// As far from the stop after `at` towards `wanted` as a stop within the workspace exists. By convexity no other
    /// limit is broken on that way.
    fn within_workspace(&self, at: &[Sent; 6], wanted: &[Sent; 6]) -> [Sent; 6] {
        let stop: [Sent; 6] = std::array::from_fn(|axis| self.axes[axis].brake(&at[axis]));
        let mut best = stop;
        let (mut within, mut beyond) = (0.0, 1.0);
        for _ in 0..HALVINGS {
            let share = 0.5 * (within + beyond);
            let tried: [Sent; 6] = std::array::from_fn(|axis| {
                let [from, to] = [stop[axis].position, wanted[axis].position];
                at[axis].then(from + share * (to - from))
            });
            let allowed = (0..6).all(|axis| self.axes[axis].judge(&at[axis], &tried[axis]).is_ok());
            if allowed && self.stops_within_workspace(&tried) {
                (within, best) = (share, tried);
            } else {
                beyond = share;
            }
        }
        best
    }
}

fn bit(broken: Broken) -> i32 {
    match broken {
        Broken::Acceleration => LIMIT_ACCELERATION,
        Broken::Velocity => LIMIT_VELOCITY,
        Broken::Range => LIMIT_AXIS,
    }
}
