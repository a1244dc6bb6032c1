//! The free motion to the object, where it may be and how it moves.

use crate::Settings;
use crate::approach::Approach;
use crate::expectation::Expectation;
use crate::impact::ImpactMonitor;
use crate::shaping::{Point, Shape};
use nalgebra::Vector3;
use spatial::TICK_S;

/// The free motion that has begun.
#[derive(Clone, Copy, Debug)]
pub(super) struct Path {
    approach: Approach,
    start_tick: i64,
    /// Where the object was expected at the start, m in r.
    expected: Option<Vector3<f64>>,
    /// Way over which the tcp joins the motion of the object, m.
    free_m: f64,
    /// Height at which it ends if the object stays where it is expected, m in r.
    end_m: f64,
}

impl Path {
    /// From the height `start_m` (m) of the hanging tcp at `tick`, with changes of speed of `shape`, no faster than `impact`
    /// allows.
    pub(super) fn new(
        settings: &Settings,
        expectation: &Expectation,
        shape: Shape,
        impact: Option<&ImpactMonitor>,
        start_m: f64,
        tick: i64,
    ) -> Self {
        let (task, expected) = (&settings.task, &settings.controller.expected);
        let allowed = |speed: f64| {
            let speed = speed.min(settings.fastest_m_per_s());
            impact.map_or(speed, |impact| impact.allowed_speed_m_per_s(speed))
        };
        let speed = allowed(task.approach_speed_m_per_s);
        let reached = tick + settings.lead() * settings.period_ticks;
        let object = expectation
            .at(reached as f64 * TICK_S)
            .map(|(position, _)| position);
        let expected_m = object.map_or(task.expected_height_m, |object| object.z);
        let end_m = expected_m - task.search_depth_m;
        // The least way worth speaking of.
        let length_m = (start_m - end_m).max(1e-4);
        let (approach, free_m) = match object {
            Some(_) => {
                let free_m = (start_m - expected_m - expected.search_margin_m).clamp(5e-5, length_m - 5e-5);
                let slow = allowed(expected.search_speed_m_per_s);
                (
                    Approach::with_search(shape, free_m, speed, length_m - free_m, slow),
                    free_m,
                )
            }
            None => (Approach::new(shape, length_m, speed), length_m),
        };
        Self {
            approach,
            start_tick: tick,
            expected: object,
            free_m,
            end_m,
        }
    }

    /// Let the robot catch up for `ticks`.
    pub(super) fn wait(&mut self, ticks: i64) {
        self.start_tick += ticks;
    }

    /// The height at which it ends, with an object that has moved until `tick`, m in r.
    pub(super) fn end_m(&self, expectation: &Expectation, tick: i64) -> f64 {
        let moved = self
            .shift(expectation, tick, self.free_m)
            .map_or(0.0, |shift| shift.z);
        self.end_m + moved
    }

    /// How long it has lasted at `tick`, s.
    pub(super) fn lasted_s(&self, tick: i64) -> f64 {
        (tick - self.start_tick) as f64 * TICK_S
    }

    /// How long it lasts at most, s.
    pub(super) fn duration_s(&self) -> f64 {
        self.approach.duration()
    }

    /// Where on it the robot is to be at `tick`.
    pub(super) fn at(&self, settings: &Settings, tick: i64) -> Point {
        self.approach.at(since(settings, self.start_tick, tick))
    }

    /// How far the tcp has gone along with the object at `tick`, after `distance_m` (m) of the way, m in r: it joins the
    /// object's motion over the free way.
    pub(super) fn shift(
        &self,
        expectation: &Expectation,
        tick: i64,
        distance_m: f64,
    ) -> Option<Vector3<f64>> {
        let (now, _) = expectation.at(tick as f64 * TICK_S)?;
        Some((now - self.expected?) * (distance_m / self.free_m).min(1.0))
    }
}

/// Time (s) at `tick` since the first set-point of the cycle at `start` is reached.
pub(super) fn since(settings: &Settings, start: i64, tick: i64) -> f64 {
    (tick - start - settings.lead() * settings.period_ticks) as f64 * TICK_S
}
