//! Whether the robot's axes can do what the task asks for.

use super::{
    Drives, Kinematics, Scenario,
    check::{Conflicts, short},
};
use spatial::kinematics::{Axes, Unreachable, join};

/// The keys of an axis conflict: the same ones in either section.
struct Keys {
    range: &'static [&'static str],
    start: &'static [&'static str],
    end: &'static [&'static str],
    speed: &'static [&'static str],
}

macro_rules! keys {
    ($section:literal $(, $base:literal)?) => {
        Keys {
            range: &[concat!($section, ".axis_minimum_rad"), concat!($section, ".axis_maximum_rad")],
            start: &[
                "task.start_position_m",
                concat!($section, ".axis_minimum_rad"),
                concat!($section, ".axis_maximum_rad"),
                "tool.tcp_in_s_m",
                $($base,)?
            ],
            end: &[
                "task.search_depth_m",
                "task.expected_height_m",
                concat!($section, ".axis_minimum_rad"),
                concat!($section, ".axis_maximum_rad"),
                "tool.tcp_in_s_m",
                $($base,)?
            ],
            speed: &["task.approach_speed_m_per_s", concat!($section, ".velocity_limit_rad_per_s")],
        }
    };
}

impl Scenario {
    /// Ranges of the axes against start and end of the search, and their speeds against that of the approach.
    pub(super) fn check_axes(&self, conflicts: &mut Conflicts) {
        let keys = match self.robot.kinematics {
            Kinematics::Gantry => keys!("robot.gantry"),
            Kinematics::Arm => keys!("robot.arm", "robot.arm.base_position_m"),
        };
        let (drives, task) = (self.robot.drives(), &self.task);
        let section = drives.section;
        for i in 0..6 {
            let [low, high] = [drives.axis_minimum_rad[i], drives.axis_maximum_rad[i]];
            conflicts.require(
                low < high,
                keys.range,
                format!(
                    "{section}.axis_minimum_rad[{i}] is {} rad, not below {section}.axis_maximum_rad[{i}], {} rad; \
                     leave the axis room to move",
                    short(low),
                    short(high),
                ),
            );
        }

        let [x, y, _] = task.start_position_m;
        let end = self.axes_at([x, y, task.expected_height_m - task.search_depth_m]);
        match (self.start_axes(), end) {
            (Ok(start), end) => {
                self.check_speed(conflicts, &keys, &drives, &start);
                for i in outside(&drives, &start) {
                    conflicts.require(
                        false,
                        keys.start,
                        format!(
                            "task.start_position_m puts axis {i} at {} rad, outside {}; start elsewhere or widen the \
                             axis",
                            short(start[i]),
                            range(&drives, i),
                        ),
                    );
                }
                match end {
                    Ok(end) => {
                        // What was wrong at the start is said already.
                        let start = outside(&drives, &start).collect::<Vec<_>>();
                        for i in outside(&drives, &end).filter(|i| !start.contains(i)) {
                            conflicts.require(
                                false,
                                keys.end,
                                format!(
                                    "task.search_depth_m ends the search with axis {i} at {} rad, outside {}; search \
                                     less deep or widen the axis",
                                    short(end[i]),
                                    range(&drives, i),
                                ),
                            );
                        }
                    }
                    Err(reason) => refuse(conflicts, keys.end, "the end of task.search_depth_m", &reason),
                }
            }
            (Err(reason), _) => refuse(conflicts, keys.start, "task.start_position_m", &reason),
        }
    }

    fn check_speed(&self, conflicts: &mut Conflicts, keys: &Keys, drives: &Drives, start: &Axes) {
        let speed = self.task.approach_speed_m_per_s;
        let down = join([0.0, 0.0, -speed].into(), [0.0; 3].into());
        let jacobian = self.robot.kinematics().jacobian(start);
        let rates = jacobian.lu().solve(&down).unwrap_or_default();
        for i in 0..6 {
            let [rate, limit] = [rates[i].abs(), drives.velocity_limit_rad_per_s[i]];
            conflicts.require(
                rate <= limit,
                keys.speed,
                format!(
                    "task.approach_speed_m_per_s is {} m/s and turns axis {i} with {} rad/s, above \
                     {}.velocity_limit_rad_per_s[{i}], {} rad/s; approach more slowly",
                    short(speed),
                    short(rate),
                    drives.section,
                    short(limit),
                ),
            );
        }
    }
}

fn refuse(conflicts: &mut Conflicts, keys: &'static [&'static str], what: &str, reason: &Unreachable) {
    conflicts.require(false, keys, format!("{what} can't be reached: {reason}"));
}

impl Scenario {
    /// Whether all `axes` are within their ranges.
    pub(super) fn within_range(&self, axes: &Axes) -> bool {
        outside(&self.robot.drives(), axes).next().is_none()
    }
}

/// The axes that are outside their (sensible) range.
fn outside(drives: &Drives, axes: &Axes) -> impl Iterator<Item = usize> {
    (0..6).filter(|&i| {
        let [low, high] = [drives.axis_minimum_rad[i], drives.axis_maximum_rad[i]];
        low < high && !(low..=high).contains(&axes[i])
    })
}

fn range(drives: &Drives, i: usize) -> String {
    let section = drives.section;
    format!(
        "{section}.axis_minimum_rad[{i}] to {section}.axis_maximum_rad[{i}], {}..={} rad",
        short(drives.axis_minimum_rad[i]),
        short(drives.axis_maximum_rad[i]),
    )
}
