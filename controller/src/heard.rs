//! What has come since the cycle before: a cycle runs every T with what there is of it.
//!
//! A state that is missing costs no cycle. Samples of the sensor wait for the encoder readings that belong to them, which
//! the next state brings along; meanwhile the robot is taken to follow what it was sent, and set-points go on from there.

use crate::delivery::Modelled;
use crate::motion::Sample;
use crate::phases::Event;
use crate::transform::deflection_at_tcp;
use crate::{Controller, ControllerPhase};
use nalgebra::Vector3;
use node::scenario::Pairing;
use spatial::kinematics::Axes;
use spatial::ports::{DeflectionSample, Deflections, Fault, ObjectPose, RobotState};
use spatial::{TICK_S, TICK_US};
use std::f64::consts::TAU;

/// Periods T without anything new from robot or sensor after which the robot is held (DESIGN.md section 6).
pub(crate) const HOLD_PERIODS: i64 = 3;

/// The tick of a cycle, and the checked messages that have come since the one before; `None`: none.
///
/// Their `utime` counts from the same instant as the tick does, in us.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Heard<'a> {
    /// The cycle's tick, by which the command is stamped: later than that of the cycle before, by T where none was missed.
    pub tick: i64,
    /// The newest state of the robot.
    pub state: Option<&'a RobotState>,
    /// The newest deflections.
    pub deflections: Option<&'a Deflections>,
    /// The newest pose of the object that a non-contact sensor sees.
    pub object: Option<&'a ObjectPose>,
}

impl<'a> Heard<'a> {
    /// What answers `state`, where all has come that belongs to its tick.
    pub fn complete(
        state: &'a RobotState,
        deflections: &'a Deflections,
        object: Option<&'a ObjectPose>,
    ) -> Self {
        Self {
            tick: state.stamp.step,
            state: Some(state),
            deflections: Some(deflections),
            object,
        }
    }
}

impl Controller {
    /// Take the robot's `state` in the cycle at `tick`; whether the controller itself has stood still before it for too long,
    /// which is a fault: no cycle has told of that silence, and what it knows of robot and object is that old.
    pub(crate) fn hear_robot(&mut self, state: &RobotState, tick: i64) -> bool {
        let stood_still = self.motion.is_some() && self.phases.well() && self.robot_stale(tick);
        if stood_still {
            self.fail(Fault::StateStale);
        }
        self.encoders.update(state);
        if state.stamp.utime > self.newest_state_utime {
            self.newest_state_utime = state.stamp.utime;
            self.state_tick = tick;
        }
        if self.phases.phase() == ControllerPhase::Init {
            self.start = state.axis_position[0];
            self.commanded = self.start;
            self.bounds.begin(&self.start);
            self.join(&state.axis_position[0]);
            self.phases.take(Event::Joined);
        }
        self.robot = Some(*state);
        stood_still
    }

    /// Go on from the set-points that the robot follows: of the commands it has taken that of `command_step` is the newest, as
    /// its state tells in the cycle at `tick`. `None`: no state, so that it is taken to have taken all. A controller that has
    /// `stood_still` holds it where it has come to, not where it was sent before.
    pub(crate) fn follow_robot(&mut self, tick: i64, command_step: Option<i64>, stood_still: bool) {
        if let Some(followed) = self.delivery.followed(tick, command_step) {
            if let (Some(reached), true) = (followed.set_points().last(), stood_still) {
                self.commanded = *reached;
            }
            self.bounds.follow(&followed);
            if let Some(motion) = &mut self.motion {
                motion.follow(&self.settings, tick, &followed);
            }
        }
    }

    /// What is modelled of the robot before this cycle's command; while it is held by a fault, or tilted, no motion models how
    /// it follows.
    pub(crate) fn modelled(&self) -> Modelled {
        let tilts = self.tilting.is_some_and(|tilting| tilting.begun());
        let leads = self.phases.well() && !tilts;
        let motion = self.motion.as_ref().filter(|_| leads);
        Modelled {
            sent: *self.bounds.sent(),
            dynamics: motion.map(|motion| *motion.dynamics()),
        }
    }

    /// Take the samples of `deflections` that are new, and those that have waited, in the cycle at `tick`.
    pub(crate) fn hear_sensor(&mut self, deflections: Option<&Deflections>, tick: i64) {
        let samples = deflections.iter().flat_map(|it| it.samples.iter().rev());
        for sample in samples {
            if self.sensing.usable(sample) && sample.utime > self.newest_sample_utime {
                self.newest_sample_utime = sample.utime;
                self.heard_tick = tick;
                self.delay_ticks = tick - sample.utime / TICK_US;
                self.waiting.push(sample);
            }
        }
        while let Some(sample) = self.waiting.oldest().filter(|sample| self.pairs(sample)) {
            self.waiting.go_on();
            self.take(&sample, tick);
        }
    }

    /// One sample of the sensor, paired with the axes at its instant.
    fn take(&mut self, sample: &DeflectionSample, tick: i64) {
        let deflection = self.sensing.deflection(sample);
        let (axes, time_s) = self.paired_with(sample, tick);
        let Some(motion) = &mut self.motion else {
            let normal_in_s = self.settings.kinematics.forward(&self.start).rotation.inverse() * Vector3::z();
            let at_tcp = deflection_at_tcp(&deflection, self.settings.d);
            self.sensing
                .take_at_rest(sample, normal_in_s.dot(&at_tcp.translation));
            return;
        };
        let taken = Sample {
            time_s,
            tick: sample.utime / TICK_US,
            deflection,
            flags: sample.flags,
            axes,
        };
        let approaching = self.phases.phase() == ControllerPhase::Approach;
        motion.take(&self.settings, &self.expectation, &taken, approaching, tick);
        match motion.contact_tick() {
            Some(contact_tick) => {
                let in_contact_s = (taken.tick - contact_tick) as f64 * TICK_S;
                self.sensing.take_in_contact(sample, in_contact_s);
            }
            // A tilted tool hangs in another way.
            None if self.tilting.is_some_and(|tilting| tilting.begun()) => {}
            None => self.sensing.take_free(motion.normal_force_n()),
        }
        self.watch_for_collision(&taken);
    }

    /// The instant (us) of the axes that belong to a sample: less what the sensor's low pass delays, which shows the
    /// deflection of 1 / (2 pi f) ago.
    fn instant_us(&self, sample: &DeflectionSample) -> f64 {
        let lag_us = 1e6 / (TAU * self.settings.controller.sensor_bandwidth_hz);
        sample.utime as f64 - lag_us
    }

    /// Whether the encoder readings that belong to a sample are there.
    fn pairs(&self, sample: &DeflectionSample) -> bool {
        match self.settings.controller.pairing {
            Pairing::Sampling => self.encoders.reach(self.instant_us(sample)),
            Pairing::Arrival => true,
        }
    }

    /// The axes that belong to a sample, and when (s).
    fn paired_with(&self, sample: &DeflectionSample, tick: i64) -> (Axes, f64) {
        match self.settings.controller.pairing {
            Pairing::Sampling => {
                let utime = self.instant_us(sample);
                (self.encoders.at(utime), 1e-6 * utime)
            }
            Pairing::Arrival => (self.encoders.newest(), tick as f64 * TICK_S),
        }
    }

    /// Where the axes are at `tick`, rad: at the reading of the newest `state`, gone on as fast as they were then.
    pub(crate) fn actual(&self, state: &RobotState, tick: i64) -> Axes {
        let longest = HOLD_PERIODS * self.settings.period_ticks;
        match (tick - self.state_tick).clamp(0, longest) {
            0 => state.axis_position[0],
            age => state.axis_position[0] + state.axis_velocity * (age as f64 * TICK_S),
        }
    }

    /// How long the sensor has brought nothing new, s.
    pub(crate) fn sensor_silent_s(&self, tick: i64) -> f64 {
        (tick - self.heard_tick) as f64 * TICK_S
    }

    /// How long the robot has, s.
    pub(crate) fn robot_silent_s(&self, tick: i64) -> f64 {
        (tick - self.state_tick) as f64 * TICK_S
    }

    /// After how long a silence the robot is held, s.
    pub(crate) fn hold_s(&self) -> f64 {
        HOLD_PERIODS as f64 * self.settings.period_s()
    }

    /// Whether the robot has been silent for so long that it is a fault. It speaks once in a period.
    pub(crate) fn robot_stale(&self, tick: i64) -> bool {
        self.robot_silent_s(tick) > self.settings.controller.stale_fault_s.max(self.hold_s())
    }
}
