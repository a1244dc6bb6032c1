//! The sections of the controller that protect: detection by a cumulative sum, collisions, limits of the command.

use super::check::{Conflicts, short};
use super::{Law, Scenario, schema};

schema::section! {
    /// Contact detection by a cumulative sum beside the threshold, for slow approaches: what exceeds the allowance adds up
    /// from sample to sample.
    Cusum at "controller.cusum" {
        /// Whether it is used.
        enabled: bool = true;
        /// Force that adds nothing; at least 1.5 standard deviations of the noise are taken.
        allowance_n: f64 = 0.25, in 1e-3..=1e4;
        /// False alarms of the sum per hour that are accepted in noise: its limit follows from that and from the noise
        /// that the tare shows.
        false_alarms_per_h: f64 = 0.2, in 1e-6..=1e6;
    }
}

schema::section! {
    /// What counts as a collision: forces and moments at the tcp, along and about the axes of s, that stop the robot.
    Collision at "controller.collision" {
        /// Whether collisions are looked for.
        enabled: bool = true;
        /// Force along each axis in free motion, on top of what the acceleration causes.
        free_force_n: [f64; 3] = [30.0, 30.0, 30.0], in 1e-2..=1e6;
        /// Moment about each axis in free motion, likewise.
        free_moment_nm: [f64; 3] = [4.0, 4.0, 4.0], in 1e-3..=1e5;
        /// Force along each axis in contact, and while a calibration tilts the tool.
        contact_force_n: [f64; 3] = [300.0, 300.0, 300.0], in 1e-2..=1e6;
        /// Moment about each axis then.
        contact_moment_nm: [f64; 3] = [50.0, 50.0, 50.0], in 1e-3..=1e5;
    }
}

schema::section! {
    /// Oscillations of the contact force that grow: the gain of the law is lowered for them.
    Oscillation at "controller.oscillation" {
        /// Whether they are looked for.
        enabled: bool = true;
        /// Amplitude below which nothing counts as one.
        least_n: f64 = 2.0, in 1e-3..=1e5;
        /// How far the gain is lowered at most, as a share of the configured one.
        least_gain: f64 = 0.03125, in 1e-3..=1.0;
    }
}

schema::section! {
    /// Limits of the command, kept whatever the law asks for. Set-points lead their axes: their accelerations are larger.
    Limits at "controller.limits" {
        /// Distance that is kept to the ends of the axes; negative: the ranges are assumed to be wider than they are.
        axis_margin_rad: f64 = 0.0, in -1.0..=1.0;
        /// Velocity of a set-point over the axis's velocity limit.
        velocity_ratio: f64 = 1.0, in 0.001..=2.0;
        /// Acceleration of a set-point beyond the axis's limit A, in terms of A / (w T)^2, w that of the command filter.
        lead_ratio: f64 = 4.0, in 0.0..=100.0;
        /// By how much of the full acceleration that of a set-point may change within T.
        reversal_ratio: f64 = 1.5, in 0.001..=2.0;
        /// Lower corner of the tcp's workspace in r; 10 m away: no wall.
        workspace_minimum_m: [f64; 3] = [-10.0, -10.0, -10.0], in -10.0..=10.0;
        /// Upper corner of the tcp's workspace in r.
        workspace_maximum_m: [f64; 3] = [10.0, 10.0, 10.0], in -10.0..=10.0;
        /// Speed towards an object that was lost; no faster than the approach, nor than the allowed force of the impact
        /// permits.
        seek_speed_m_per_s: f64 = 0.010, in 1e-4..=1.0;
    }
}

impl Scenario {
    /// The command's limits must leave room for the start, the force limit for the desired force, and an impedance must
    /// be damped.
    pub(super) fn check_protection(&self, conflicts: &mut Conflicts) {
        let (task, limits) = (&self.task, &self.controller.limits);
        for i in 0..3 {
            let [low, high] = [limits.workspace_minimum_m[i], limits.workspace_maximum_m[i]];
            let start = task.start_position_m[i];
            conflicts.require(
                low < start && start < high,
                &["controller.limits.workspace_minimum_m", "controller.limits.workspace_maximum_m",
                  "task.start_position_m"],
                format!(
                    "task.start_position_m[{i}] is {} m, not within controller.limits.workspace_minimum_m[{i}] to \
                     workspace_maximum_m[{i}], {} to {} m; start elsewhere or widen the workspace",
                    short(start),
                    short(low),
                    short(high)
                ),
            );
        }
        let (drives, margin) = (self.robot.drives(), limits.axis_margin_rad);
        if let Ok(start) = self.start_axes() {
            for i in 0..6 {
                let [low, high] = [drives.axis_minimum_rad[i], drives.axis_maximum_rad[i]];
                // What lies outside the range itself is said elsewhere.
                let inside = low < high && (low..=high).contains(&start[i]);
                conflicts.require(
                    !inside || (low + margin <= start[i] && start[i] <= high - margin),
                    &["controller.limits.axis_margin_rad", "task.start_position_m"],
                    format!(
                        "task.start_position_m puts axis {i} at {} rad, nearer than controller.limits.axis_margin_rad, \
                         {} rad, to an end of {}..={} rad; start elsewhere or keep less distance",
                        short(start[i]),
                        short(margin),
                        short(low),
                        short(high)
                    ),
                );
            }
        }
        let [force, most] = [task.pressing_force_n(), task.max_contact_force_n];
        conflicts.require(
            force < most,
            &["task.max_contact_force_n", "task.desired_force_n"],
            format!(
                "task.max_contact_force_n is {} N, not above task.desired_force_n, {} N; allow more, or press less",
                short(most),
                short(force)
            ),
        );
        if self.controller.law == Law::Impedance {
            self.check_damping(conflicts);
        }
    }

    /// The damping ratio `D / (2 sqrt(M (1 / C + K)))` along the degrees of freedom that are force controlled: below 0.2
    /// the tool would swing on its object.
    fn check_damping(&self, conflicts: &mut Conflicts) {
        const LEAST: f64 = 0.2;
        let (controller, parameters) = (&self.controller, &self.controller.impedance);
        let [x, y, z] = controller.tcp_in_s_m;
        let lever = [y * y + z * z, x * x + z * z, x * x + y * y];
        for i in (0..6).filter(|&i| self.task.force_controlled.dofs()[i]) {
            let (mass, damping, stiffness, compliance, key) = if i < 3 {
                let compliance = controller.compliance_m_per_n + controller.compliance_rad_per_nm * lever[i];
                (
                    parameters.mass_kg,
                    parameters.damping_ns_per_m,
                    parameters.stiffness_n_per_m,
                    compliance,
                    "damping_ns_per_m",
                )
            } else {
                (
                    parameters.inertia_kg_m2,
                    parameters.damping_nms_per_rad,
                    parameters.stiffness_nm_per_rad,
                    controller.compliance_rad_per_nm,
                    "damping_nms_per_rad",
                )
            };
            let critical = 2.0 * (mass * (1.0 / compliance + stiffness)).sqrt();
            let [value, least] = [damping, LEAST * critical];
            conflicts.require(
                value >= least,
                &["controller.impedance.damping_ns_per_m", "controller.impedance.damping_nms_per_rad",
                  "controller.impedance.mass_kg", "controller.impedance.inertia_kg_m2",
                  "controller.impedance.stiffness_n_per_m", "controller.impedance.stiffness_nm_per_rad"],
                format!(
                    "controller.impedance.{key} is {}, a damping ratio of {} with that mass on the assumed sensor: the tool \
                     would swing; choose at least {}, or less mass",
                    short(value),
                    short(value / critical),
                    short(least)
                ),
            );
        }
    }
}
