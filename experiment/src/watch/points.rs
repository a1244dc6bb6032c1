//! What is plotted over time.

use spatial::ports::ControllerStatus;
use spatial::{TICK_S, Wrench};
use std::collections::VecDeque;

/// The plots show so much of the experiment's time, s.
pub const WINDOW_S: f64 = 10.0;

/// One cycle's plotted values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// Time of the experiment: tick times 1 ms, s.
    pub time_s: f64,
    /// Normal force at the tcp, N.
    pub force_n: f64,
    /// Desired normal force, N.
    pub desired_force_n: f64,
    /// Height of the tcp in r, m.
    pub tcp_height_m: f64,
    /// Height of the object in r, m; none before it is known.
    pub object_height_m: Option<f64>,
}

impl From<&ControllerStatus> for Point {
    fn from(status: &ControllerStatus) -> Self {
        let object = status.object_pose.translation.vector.z;
        Self {
            time_s: status.stamp.step as f64 * TICK_S,
            force_n: normal_force_n(status),
            desired_force_n: status.desired_wrench.force.z,
            tcp_height_m: status.tcp_pose.translation.vector.z,
            object_height_m: status.object_known.then_some(object),
        }
    }
}

/// The normal force at the tcp that the control law works with, N; 0 before there is one.
pub(super) fn normal_force_n(status: &ControllerStatus) -> f64 {
    let none_yet = status.wrench == Wrench::default() && status.force_error_n == 0.0;
    match none_yet {
        true => 0.0,
        false => status.desired_wrench.force.z + status.force_error_n,
    }
}

/// The points of the last [`WINDOW_S`], numbered since the start.
#[derive(Clone, Debug, Default)]
pub struct Points {
    kept: VecDeque<Point>,
    /// The number of the first one kept.
    first: u64,
}

impl Points {
    /// Add the newest one; one that is older than the newest begins anew.
    pub(super) fn push(&mut self, point: Point) {
        if let Some(newest) = self.kept.back() {
            if point.time_s == newest.time_s {
                return;
            }
            if point.time_s < newest.time_s {
                self.clear();
            }
        }
        self.kept.push_back(point);
        while self
            .kept
            .front()
            .is_some_and(|oldest| oldest.time_s < point.time_s - WINDOW_S)
        {
            self.kept.pop_front();
            self.first += 1;
        }
    }

    /// Forget all; who went on from any number before finds that it is gone.
    pub(super) fn clear(&mut self) {
        self.first += self.kept.len() as u64 + 1;
        self.kept.clear();
    }

    /// The number of the first one kept.
    pub fn first(&self) -> u64 {
        self.first
    }

    /// The number that the next one will have.
    pub fn next(&self) -> u64 {
        self.first + self.kept.len() as u64
    }

    /// Those that are kept from number `number` on, oldest first.
    pub fn since(&self, number: u64) -> impl Iterator<Item = &Point> {
        let skipped = usize::try_from(number.saturating_sub(self.first)).unwrap_or(usize::MAX);
        self.kept.iter().skip(skipped)
    }

    /// All that are kept, oldest first.
    pub fn iter(&self) -> impl Iterator<Item = &Point> {
        self.kept.iter()
    }
}
