//! The section `[task]`: what is asked for, and what can't be asked for together.

use super::check::{Conflicts, short};
use super::{ExpectedFrom, Scenario, TaskKind, ToolShape, schema};

schema::section! {
    /// What is asked for.
    Task at "task" with force_controlled: ForceControlled {
        /// What it is about.
        kind: TaskKind = TaskKind::Press;
        /// Where the tcp starts, in r.
        start_position_m: [f64; 3] = [0.0, 0.0, 0.030], in -10.0..=10.0;
        /// Standstill before the approach.
        standstill_s: f64 = 0.25, in 0.0..=60.0;
        /// Height in r at which the object is expected.
        expected_height_m: f64 = 0.0, in -10.0..=10.0;
        /// How far below that height to search; a position to be reached lies there.
        search_depth_m: f64 = 0.005, in 0.0..=1.0;
        /// How far the tcp may yield on the way to a position.
        tolerance_m: f64 = 0.001, in 1e-6..=0.1;
        /// Speed of the approach.
        approach_speed_m_per_s: f64 = 0.020, in 0.0005..=1.0;
        /// Desired normal force.
        desired_force_n: f64 = 10.0, in 0.1..=1e5;
        /// Desired moment about the tcp's x, y and z, in r; where that degree of freedom is force controlled.
        desired_moment_nm: [f64; 3] = [0.0, 0.0, 0.0], in -1e4..=1e4;
        /// Force that the impact may reach, on top of the controlled one, by the controller's assessment; a faster
        /// approach is slowed. 0: no limit.
        max_impact_force_n: f64 = 0.0, in 0.0..=1e6;
        /// Force along the normal that the contact may reach: no law presses harder, and what exceeds it stops the robot.
        max_contact_force_n: f64 = 300.0, in 0.1..=1e6;
        /// Whether the task begins by itself after the standstill; otherwise it waits for `TASK`.
        starts_by_itself: bool = true;
        /// How far a calibration tilts the tool about its tcp.
        calibration_tilt_rad: f64 = 0.3, in 0.1..=1.5;
        /// How long a calibration rests in each orientation; over the second half it measures.
        calibration_rest_s: f64 = 1.0, in 0.02..=60.0;
    }
}

schema::section! {
    /// Which degrees of freedom of the tcp, along and about the axes of r, follow the force law once there is contact;
    /// the others keep their reference.
    ForceControlled at "task.force_controlled" {
        /// Along x, with no force desired.
        x: bool = false;
        /// Along y, with no force desired.
        y: bool = false;
        /// Along z, the normal.
        z: bool = true;
        /// About x.
        about_x: bool = false;
        /// About y.
        about_y: bool = false;
        /// About z.
        about_z: bool = false;
    }
}

impl ForceControlled {
    /// All six, in the order of a wrench.
    pub fn dofs(&self) -> [bool; 6] {
        [self.x, self.y, self.z, self.about_x, self.about_y, self.about_z]
    }
}

impl Task {
    /// The force to press with, N: zero where no force is asked for.
    pub fn pressing_force_n(&self) -> f64 {
        match self.kind {
            TaskKind::Press => self.desired_force_n,
            TaskKind::Position | TaskKind::Calibrate => 0.0,
        }
    }
}

impl Scenario {
    /// What each kind of task needs.
    pub(super) fn check_kind(&self, conflicts: &mut Conflicts) {
        let (task, along_z) = (&self.task, self.task.force_controlled.z);
        let keys = &["task.kind", "task.force_controlled.z"];
        conflicts.require(
            task.kind != TaskKind::Press || along_z,
            keys,
            "task.kind is \"press\", but task.force_controlled.z is false: nothing would press; set it to true, or \
             task.kind = \"position\""
                .to_owned(),
        );
        conflicts.require(
            task.kind != TaskKind::Position || !along_z,
            keys,
            "task.kind is \"position\", but task.force_controlled.z is true: the position lies along z; set it to \
             false, or task.kind = \"press\""
                .to_owned(),
        );
        let selected = task.force_controlled.dofs();
        for (i, axis) in ["x", "y", "z"].into_iter().enumerate() {
            let moment = task.desired_moment_nm[i];
            conflicts.require(
                moment == 0.0 || selected[3 + i],
                &["task.desired_moment_nm", "task.force_controlled.about_x", "task.force_controlled.about_y",
                  "task.force_controlled.about_z"],
                format!(
                    "task.desired_moment_nm[{i}] is {} Nm, but task.force_controlled.about_{axis} is false; set it to \
                     true, or the moment to 0",
                    short(moment)
                ),
            );
        }
        for (i, lever) in [(0, self.tool.face_size_m[1]), (1, self.tool.face_size_m[0])] {
            let moment = task.desired_moment_nm[i];
            let reach = if self.tool.shape == ToolShape::Face {
                0.5 * lever
            } else {
                0.0
            };
            let most = task.desired_force_n * reach;
            conflicts.require(
                moment.abs() <= most || !selected[3 + i],
                &["task.desired_moment_nm", "tool.shape", "tool.face_size_m", "task.desired_force_n"],
                format!(
                    "task.desired_moment_nm[{i}] is {} Nm, more than the {} Nm that task.desired_force_n bears on the \
                     tool's face; choose a smaller moment, a larger face or more force",
                    short(moment),
                    short(most)
                ),
            );
        }
        conflicts.require(
            task.kind != TaskKind::Position || task.tolerance_m < self.sensor.range_translation_m,
            &["task.tolerance_m", "sensor.range_translation_m"],
            format!(
                "task.tolerance_m is {} m, not less than sensor.range_translation_m, {} m: it would never be seen to be \
                 exceeded; tolerate less, or widen the range",
                short(task.tolerance_m),
                short(self.sensor.range_translation_m)
            ),
        );
        conflicts.require(
            self.controller.expected.from != ExpectedFrom::ObjectSensor || self.object_sensor.enabled,
            &["controller.expected.from", "object_sensor.enabled"],
            "controller.expected.from is \"object-sensor\", but there is none: the approach would never begin; set \
             object_sensor.enabled = true, or expect the object from a \"model\" or \"nothing\""
                .to_owned(),
        );
    }
}
