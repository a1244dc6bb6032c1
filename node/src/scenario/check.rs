//! Values that are fine alone and can't be together.

mod steps;

use super::{Scenario, SensorOutput, value::decimal};

/// Values that can't be together.
pub(super) struct Conflict {
    /// The keys concerned, the one to blame first.
    pub(super) keys: &'static [&'static str],
    /// What is wrong, the limit and the remedy.
    pub(super) text: String,
}

/// What the sensor's translation under load depends on.
const DEFLECTED_BY: &[&str] = &[
    "sensor.range_translation_m",
    "sensor.stiffness_n_per_m",
    "tool.mass_kg",
    "task.desired_force_n",
];

/// What the sensor's rotation under load depends on.
const TURNED_BY: &[&str] = &[
    "sensor.range_rotation_rad",
    "sensor.stiffness_nm_per_rad",
    "tool.mass_kg",
    "tool.centre_of_mass_in_s_m",
    "tool.tcp_in_s_m",
    "task.desired_force_n",
];

pub(super) struct Conflicts(Vec<Conflict>);

impl Conflicts {
    /// Notes the conflict of `keys` unless `holds`.
    pub(super) fn require(&mut self, holds: bool, keys: &'static [&'static str], text: String) {
        if !holds {
            self.0.push(Conflict { keys, text });
        }
    }
}

impl Scenario {
    /// Everything that can't be together in this scenario.
    pub(super) fn conflicts(&self) -> Vec<Conflict> {
        let mut conflicts = Conflicts(Vec::new());
        self.check_task(&mut conflicts);
        self.check_axes(&mut conflicts);
        self.check_steps(&mut conflicts);
        self.check_links(&mut conflicts);
        self.check_deflection(&mut conflicts);
        self.check_profile(&mut conflicts);
        self.check_kind(&mut conflicts);
        self.check_program(&mut conflicts);
        self.check_servo(&mut conflicts);
        self.check_shaping(&mut conflicts);
        self.check_output(&mut conflicts);
        self.check_adaptation(&mut conflicts);
        self.check_object_sensor(&mut conflicts);
        self.check_protection(&mut conflicts);
        conflicts.0
    }

    /// Whether all values can be together, as [`Scenario::load`] asks for: of a scenario whose values were set one by
    /// one.
    pub fn is_consistent(&self) -> bool {
        self.conflicts().is_empty()
    }

    fn check_task(&self, conflicts: &mut Conflicts) {
        let (task, height) = (&self.task, self.object_height_at_start_m());

        let [tare, standstill] = [self.controller.tare_s, task.standstill_s];
        conflicts.require(
            tare <= standstill,
            &["controller.tare_s", "task.standstill_s"],
            format!(
                "controller.tare_s is {} s, longer than task.standstill_s, {} s; tare within the standstill",
                short(tare),
                short(standstill),
            ),
        );

        let [start, end] = [
            task.start_position_m[2],
            task.expected_height_m - task.search_depth_m,
        ];
        conflicts.require(
            start > end,
            &[
                "task.start_position_m",
                "task.expected_height_m",
                "task.search_depth_m",
            ],
            format!(
                "task.start_position_m[2] is {} m, not above the end of the search, task.expected_height_m - \
                 task.search_depth_m, {} m; start higher or search deeper",
                short(start),
                short(end),
            ),
        );

        let tcp = self.hanging_tcp_height_m();
        conflicts.require(
            height < tcp,
            &[
                "object.height_m",
                "object.swing_amplitude_m",
                "object.profile_height_m",
                "task.start_position_m",
                "tool.mass_kg",
            ],
            format!(
                "object.height_m is {} m, not below the hanging tool's tcp at {} m; start higher or lower the object",
                short(height),
                short(tcp),
            ),
        );
    }

    fn check_output(&self, conflicts: &mut Conflicts) {
        conflicts.require(
            self.controller.sensor_output == SensorOutput::Deflection || self.sensor.wrench_measured,
            &["controller.sensor_output", "sensor.wrench_measured"],
            "controller.sensor_output is \"force\", but the sensor measures no wrench; set sensor.wrench_measured = \
             true or controller.sensor_output = \"deflection\""
                .to_owned(),
        );
    }

    fn check_profile(&self, conflicts: &mut Conflicts) {
        let (times, heights) = (&self.object.profile_time_s, &self.object.profile_height_m);
        conflicts.require(
            times.len() == heights.len(),
            &["object.profile_time_s", "object.profile_height_m"],
            format!(
                "object.profile_time_s has {} values, object.profile_height_m {}; list a height for each time",
                times.len(),
                heights.len(),
            ),
        );
        for pair in times.windows(2) {
            conflicts.require(
                pair[0] < pair[1],
                &["object.profile_time_s"],
                format!(
                    "object.profile_time_s goes from {} s to {} s; list increasing times",
                    short(pair[0]),
                    short(pair[1]),
                ),
            );
        }
    }

    fn check_deflection(&self, conflicts: &mut Conflicts) {
        let force = self.task.desired_force_n.max(self.program.largest_force_n());
        let sensor = &self.sensor;
        let [hanging, pressing] = [self.deflection_under(0.0), self.deflection_under(force)];
        let largest =
            |a: [f64; 3], b: [f64; 3]| a.iter().chain(&b).fold(0.0_f64, |most, x| most.max(x.abs()));
        let what = format!(
            "the tool, hanging freely or pressing with task.desired_force_n or a step's, {} N,",
            short(force)
        );
        let remedy = "stiffen the sensor, widen its range or load it less";

        let [translation, range] = [largest(hanging.0, pressing.0), sensor.range_translation_m];
        conflicts.require(
            translation < range,
            DEFLECTED_BY,
            format!(
                "{what} deflects the sensor by {} m, not less than sensor.range_translation_m, {} m; {remedy}",
                short(translation),
                short(range),
            ),
        );

        let [rotation, range] = [largest(hanging.1, pressing.1), sensor.range_rotation_rad];
        conflicts.require(
            rotation < range,
            TURNED_BY,
            format!(
                "{what} turns the sensor by {} rad, not less than sensor.range_rotation_rad, {} rad; {remedy}",
                short(rotation),
                short(range),
            ),
        );
    }
}

/// `value` with as many digits as a reader needs.
pub(super) fn short(value: f64) -> String {
    decimal(&format!("{value:.5e}").parse().unwrap_or(value))
}
