//! The controller's messages: the command, and the status that people watch.

use crate::Controller;
use nalgebra::Vector3;
use spatial::kinematics::Axes;
use spatial::ports::{
    Authenticity, Command, ControllerPhase, ControllerStatus, Detection, HORIZON, ImpactAssessment,
    LIMIT_COLLISION_FORCE_X, LIMIT_DEFLECTION, LIMIT_DRIFT, LIMIT_VELOCITY, Role, Stamp,
};
use spatial::{Deflection, Pose, Wrench};

impl Controller {
    pub(crate) fn command(&self, tick: i64, enable: bool, axis_position: [Axes; HORIZON]) -> Command {
        Command {
            stamp: Stamp::lockstep(tick, self.settings.seed, Role::Controller),
            enable,
            axis_position,
            send_utime: 0,
            authenticity: Authenticity::default(),
        }
    }

    pub(crate) fn status(&self, tick: i64) -> ControllerStatus {
        let settings = &self.settings;
        let mut status = ControllerStatus {
            stamp: Stamp::lockstep(tick, settings.seed, Role::Controller),
            phase: self.phases.phase(),
            fault: self.phases.fault(),
            law: settings.controller.law,
            object_known: false,
            object_pose: Pose::identity(),
            object_velocity: Vector3::zeros(),
            tcp_pose: settings.kinematics.forward(&self.start),
            wrench: Wrench::default(),
            desired_wrench: settings.desired,
            force_error_n: 0.0,
            detection: Detection {
                statistic_n: 0.0,
                threshold_n: settings.controller.detection_threshold_n,
                contact_step: -1,
            },
            compliance: self.sensing.compliance(),
            compliance_confidence: self.sensing.confidence(),
            tare: self.sensing.zero(),
            impact: ImpactAssessment::default(),
            gain_margin: self.assessor.published.gain_margin,
            phase_margin_rad: self.assessor.published.phase_margin_rad,
            oscillation_n: 0.0,
            limits: self.limits,
            program_step: -1,
            task_step: self.requests.step,
            task_answer: self.requests.answer,
            task_parameter: self.requests.parameter,
            task_limit: self.requests.limit,
        };
        if let Some(step) = self.program.published() {
            status.program_step = step;
        }
        status.limits |= self.program.failed;
        if let Some(rest) = self.tilting.and_then(|tilting| tilting.measuring(settings)) {
            status.program_step = rest as i32;
        }
        let Some(motion) = &self.motion else {
            return status;
        };
        status.tcp_pose = *motion.tcp_pose();
        status.wrench = self.contact_wrench(motion.deflection());
        status.detection.statistic_n = motion.normal_force_n();
        status.detection.threshold_n = motion.threshold_n();
        status.force_error_n = motion.force_n() - settings.desired.force.z;
        status.impact = motion.impact();
        status.oscillation_n = motion.oscillation_n();
        if self.phases.phase() == ControllerPhase::Approach && motion.slowed(settings) {
            status.limits |= LIMIT_VELOCITY;
        }
        if self.sensing.drifts() {
            status.limits |= LIMIT_DRIFT;
        }
        if motion.saturated() {
            status.limits |= LIMIT_DEFLECTION;
        }
        if let Some(exceeded) = self.collision.exceeded() {
            status.detection.statistic_n = exceeded.value;
            status.detection.threshold_n = exceeded.limit;
            status.limits |= LIMIT_COLLISION_FORCE_X << exceeded.axis;
        }
        if let Some(contact_tick) = motion.contact_tick() {
            status.detection.contact_step = contact_tick;
        }
        if let Some((pose, velocity)) = motion.object() {
            status.object_known = true;
            status.object_pose = pose * self.expectation.t1_from_o();
            status.object_velocity = velocity;
        }
        status
    }

    /// The wrench at the tcp that the deflection beyond the tare stands for: (3)-(6) solved for the tcp.
    pub(crate) fn contact_wrench(&self, deflection: &Deflection) -> Wrench {
        let contact_only = *deflection - self.sensing.zero();
        let compliance = self.sensing.compliance();
        let solve =
            |c: &nalgebra::Matrix3<f64>, v: Vector3<f64>| c.try_inverse().map_or(Vector3::zeros(), |i| i * v);
        let force = solve(&compliance.translation, contact_only.translation);
        let moment_at_s = solve(&compliance.rotation, contact_only.rotation);
        Wrench {
            force,
            moment: moment_at_s - self.settings.d.cross(&force),
        }
    }
}
