//! The motion of a calibration: the tool rests in seven orientations, tilted about its tcp.
//!
//! About the tcp, since nothing of the tool is nearer to whatever stands below it: turned about the sensor, a tcp 0.1 m
//! aside would sink by 0.1 m times the tilt. The orientations are those that [`crate::calibration`] asks for: level, and
//! tilted about two horizontal axes, either way.

use crate::Settings;
use crate::approach::spread;
use nalgebra::Vector3;
use node::scenario;
use spatial::kinematics::{Axes, Unreachable};
use spatial::ports::HORIZON;
use spatial::{Pose, rotation};
use std::f64::consts::FRAC_PI_4;

/// Orientations in which the tool rests.
pub const RESTS: usize = 7;

/// Directions of the tilts' axes in the horizontal plane, in eighths of a turn, after the level rest: a way around with
/// few long moves.
const DIRECTIONS: [u8; RESTS - 1] = [0, 1, 2, 4, 5, 6];

/// Mean speed of a turn at most, rad/s. Model choice.
const TURN_RAD_PER_S: f64 = 0.5;

/// Rests and the moves between them: a path, and how far on it the set-points are.
///
/// On a move the sensor swings around the tcp with the approach's speed on average, 15/8 times that at most.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tilting {
    /// Nominal tcp at the start; its position stays.
    r_from_t: Pose,
    s_from_t: Pose,
    tilt_rad: f64,
    rest_s: f64,
    /// Mean speed of a move, rad/s.
    speed_rad_per_s: f64,
    /// Time on the path of the next cycle's first set-point, s.
    elapsed_s: f64,
    /// How fast that time passes, 0 to 1, and how fast it is to.
    pace: f64,
    wanted_pace: f64,
    begun: bool,
}

/// How long the path's time takes to stop or to go on, s.
const PACE_S: f64 = 0.4;

/// Where on the path a time is.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Progress {
    /// At rest `i` since so many s.
    Resting(usize, f64),
    /// So far (0 to 1) from rest `i` to the next one, or back to the start.
    Moving(usize, f64),
    /// Back at the start.
    Done,
}

impl Tilting {
    /// The calibration that `task` describes, for a tool with the tcp at `d` in s (m), from the start at `r_from_s`.
    pub fn new(task: &scenario::Task, d: Vector3<f64>, r_from_s: &Pose) -> Self {
        let s_from_t = Pose::translation(d.x, d.y, d.z);
        Self {
            r_from_t: r_from_s * s_from_t,
            s_from_t,
            tilt_rad: task.calibration_tilt_rad,
            rest_s: task.calibration_rest_s,
            // Without a lever only the turn counts.
            speed_rad_per_s: (task.approach_speed_m_per_s / d.norm()).min(TURN_RAD_PER_S),
            elapsed_s: 0.0,
            pace: 0.0,
            wanted_pace: 0.0,
            begun: false,
        }
    }

    /// Begin, or go on after a pause.
    pub(crate) fn go(&mut self) {
        // Its path begins at rest.
        if !self.begun {
            self.pace = 1.0;
        }
        self.begun = true;
        self.wanted_pace = 1.0;
    }

    /// Come to rest on the path.
    pub(crate) fn pause(&mut self) {
        self.wanted_pace = 0.0;
    }

    /// The robot rests, whatever has stopped it.
    pub(crate) fn halt(&mut self) {
        (self.pace, self.wanted_pace) = (0.0, 0.0);
    }

    /// Whether it leads the robot.
    pub(crate) fn begun(&self) -> bool {
        self.begun
    }

    /// The calibration that is asked for, from the axes `start` on; `None`: another task.
    pub(crate) fn of(settings: &Settings, start: &Axes) -> Option<Self> {
        let calibrates = settings.task.kind == scenario::TaskKind::Calibrate;
        let r_from_s = settings.kinematics.forward(start);
        calibrates.then(|| Self::new(&settings.task, settings.d, &r_from_s))
    }

    /// How long it takes, s.
    pub fn duration_s(&self) -> f64 {
        (0..RESTS).map(|i| self.rest_s + self.move_s(i)).sum()
    }

    /// The pose of the sensor frame at rest `i`.
    pub fn rest_pose(&self, i: usize) -> Pose {
        self.tilted(self.tilt(i))
    }

    /// The next set-points of the axes, one period apart, each on the branch of its predecessor (the first one `near`
    /// the set-point before), and whether the path waits: while the position of s would be further ahead of that at the
    /// `actual` axes than the bound of command minus actual.
    pub(crate) fn set_points(
        &mut self,
        settings: &Settings,
        actual: &Axes,
        near: &Axes,
    ) -> Result<([Axes; HORIZON], bool), Unreachable> {
        let (kinematics, period_s) = (&settings.kinematics, settings.period_s());
        let position = |pose: Pose| pose.translation.vector;
        let next = position(self.sensor_pose(self.elapsed_s));
        let lead_m = (next - position(kinematics.forward(actual))).norm();
        let waits = lead_m > settings.controller.max_lead_m;
        let mut axes = [*near; HORIZON];
        if waits {
            return Ok((axes, true));
        }
        let mut near = *near;
        for (i, slot) in axes.iter_mut().enumerate() {
            let ahead_s = i as f64 * period_s * self.pace;
            near = kinematics.inverse(&self.sensor_pose(self.elapsed_s + ahead_s), &near)?;
            *slot = near;
        }
        self.elapsed_s += period_s * self.pace;
        let most = period_s / PACE_S;
        self.pace += (self.wanted_pace - self.pace).clamp(-most, most);
        Ok((axes, false))
    }

    /// The rest that is measured now: in its second half the tool has stopped swinging.
    pub(crate) fn measuring(&self, settings: &Settings) -> Option<usize> {
        // Between two cycles; the next set-point lies a lead after the one that is reached now.
        let reached_s = self.elapsed_s - settings.lead() as f64 * settings.period_s();
        match self.progress(reached_s) {
            Progress::Resting(i, since) if since >= 0.5 * self.rest_s => Some(i),
            _ => None,
        }
    }

    /// Whether the set-points are back at the start.
    pub(crate) fn done(&self) -> bool {
        self.progress(self.elapsed_s) == Progress::Done
    }

    /// The pose of the sensor frame at `time` (s) on the path.
    fn sensor_pose(&self, time: f64) -> Pose {
        let tilt = match self.progress(time) {
            Progress::Resting(i, _) => self.tilt(i),
            Progress::Moving(i, share) => self.tilt(i) + (self.tilt(i + 1) - self.tilt(i)) * share,
            Progress::Done => self.tilt(0),
        };
        self.tilted(tilt)
    }

    fn progress(&self, time: f64) -> Progress {
        let mut since = time.max(0.0);
        for i in 0..RESTS {
            if since < self.rest_s {
                return Progress::Resting(i, since);
            }
            since -= self.rest_s;
            let move_s = self.move_s(i);
            if since < move_s {
                return Progress::Moving(i, spread(since, move_s).value);
            }
            since -= move_s;
        }
        Progress::Done
    }

    /// Duration of the move from rest `i` to the next, s.
    fn move_s(&self, i: usize) -> f64 {
        (self.tilt(i + 1) - self.tilt(i)).norm() / self.speed_rad_per_s
    }

    /// The rotation vector of rest `i` in r, rad, from the start's orientation; zero before the first and after the last
    /// direction.
    fn tilt(&self, i: usize) -> Vector3<f64> {
        match i.checked_sub(1).and_then(|i| DIRECTIONS.get(i)) {
            Some(&eighths) => {
                let (sine, cosine) = libm::sincos(f64::from(eighths) * FRAC_PI_4);
                Vector3::new(cosine, sine, 0.0) * self.tilt_rad
            }
            None => Vector3::zeros(),
        }
    }

    fn tilted(&self, tilt: Vector3<f64>) -> Pose {
        let turned = rotation::exp(tilt) * self.r_from_t.rotation;
        Pose::from_parts(self.r_from_t.translation, turned) * self.s_from_t.inverse()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Controller;
    use node::scenario::Scenario;
    use spatial::kinematics::Gantry;

    const PERIOD_S: f64 = 0.004;

    fn start() -> Pose {
        Pose::translation(-0.1, 0.0, 0.18)
    }

    fn settings() -> Settings {
        Controller::new(&Scenario::default()).settings
    }

    fn tilting() -> Tilting {
        Tilting::new(
            &scenario::Task::default(),
            Vector3::new(0.10, 0.0, -0.15),
            &start(),
        )
    }

    /// The first set-points of all cycles on a gantry that follows at once, and the rest measured then.
    fn cycles() -> Vec<(Axes, Option<usize>)> {
        let (settings, mut tilting, mut axes) = (settings(), tilting(), Gantry.inverse(&start()));
        tilting.go();
        let mut cycles = Vec::new();
        while !tilting.done() {
            let (set_points, waits) = tilting.set_points(&settings, &axes, &axes).unwrap();
            assert!(!waits);
            axes = set_points[0];
            cycles.push((axes, tilting.measuring(&settings)));
        }
        cycles
    }

    #[test]
    fn the_tcp_stays_where_it_is_and_nothing_jumps() {
        let cycles = cycles();
        let duration = tilting().duration_s();
        assert!(
            (cycles.len() as f64 * PERIOD_S - duration).abs() < PERIOD_S,
            "{duration} s"
        );
        let poses: Vec<Pose> = cycles.iter().map(|(axes, _)| Gantry.forward(axes)).collect();
        for pose in &poses {
            let tcp = (pose * Pose::translation(0.1, 0.0, -0.15)).translation.vector;
            assert!((tcp - Vector3::new(0.0, 0.0, 0.03)).norm() < 1e-12);
        }
        for three in poses.windows(3) {
            let [a, b, c] = [0, 1, 2].map(|i| three[i].translation.vector);
            let (speed, change) = (
                (c - b).norm() / PERIOD_S,
                (c - b * 2.0 + a).norm() / (PERIOD_S * PERIOD_S),
            );
            assert!(speed < 0.02 * 15.0 / 8.0 * 1.001, "{speed} m/s");
            // 10 / sqrt(3) way / time^2 of the quintic on the shortest way, 0.041 m in 2 s.
            assert!(change < 0.06, "{change} m/s^2");
        }
        let end = poses[poses.len() - 1];
        assert!((end.translation.vector - start().translation.vector).norm() < 1e-9);
    }

    #[test]
    fn it_measures_where_it_rests_in_seven_orientations() {
        let cycles = cycles();
        for i in 0..RESTS {
            let within: Vec<usize> = (0..cycles.len()).filter(|&k| cycles[k].1 == Some(i)).collect();
            assert!(
                (124..=126).contains(&within.len()),
                "{} cycles in rest {i}",
                within.len()
            );
            // It has been there for half a second.
            let pose = tilting().rest_pose(i);
            // The set-points are three periods ahead.
            let resting = &cycles[within[0] - 122..within[within.len() - 1] - 3];
            for (axes, _) in resting {
                let position = Gantry.forward(axes).translation.vector;
                assert!((position - pose.translation.vector).norm() < 1e-12);
            }
            let angle = pose.rotation.angle();
            assert!((angle - if i == 0 { 0.0 } else { 0.3 }).abs() < 1e-12);
            let apart = |j| tilting().rest_pose(j).rotation.angle_to(&pose.rotation);
            assert!((0..i).map(apart).fold(1.0, f64::min) > 0.2);
        }
    }

    /// A robot that is stuck is not left behind.
    #[test]
    fn the_path_waits_for_the_robot() {
        let (settings, mut tilting, stuck) = (settings(), tilting(), Gantry.inverse(&start()));
        let mut near = stuck;
        tilting.go();
        for _ in 0..20_000 {
            near = tilting.set_points(&settings, &stuck, &near).unwrap().0[0];
            assert!((near - stuck).xyz().norm() <= 3e-3);
        }
        assert!((near - stuck).xyz().norm() > 2.8e-3 && !tilting.done());
    }
}
