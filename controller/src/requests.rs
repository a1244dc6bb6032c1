//! What people and scripts ask for over `TASK`, and how it is answered.
//!
//! A request takes effect in the cycle that follows it. Actions change the phase; parameters are checked, accepted
//! together or not at all, and slewed ([`crate::parameters`]).

use crate::parameters::{FORCE, IN_THE_LOOP, OutOfRange, WRENCH};
use crate::phases::Event;
pub(crate) use crate::readiness::Refusal;
use crate::readiness::{self, Evidence};
use crate::{Controller, ControllerPhase};
use node::scenario::{StepKind, TaskKind};
use spatial::Pose;
use spatial::ports::{Fault, ParameterAnswer, RobotState, Task, TaskAction};

/// The newest request and its answer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Requests {
    /// Who has asked last, and for the how many-th time.
    sender: Option<(i64, i64)>,
    /// What the coming cycle is to do.
    action: TaskAction,
    pub(crate) step: i64,
    pub(crate) answer: ParameterAnswer,
    pub(crate) parameter: i32,
    pub(crate) limit: f64,
}

impl Default for Requests {
    fn default() -> Self {
        Self {
            sender: None,
            action: TaskAction::None,
            step: 0,
            answer: ParameterAnswer::None,
            parameter: -1,
            limit: 0.0,
        }
    }
}

impl Requests {
    fn reply(&mut self, answer: ParameterAnswer, parameter: Option<usize>, limit: f64) {
        self.answer = answer;
        self.parameter = parameter.and_then(|it| i32::try_from(it).ok()).unwrap_or(-1);
        self.limit = limit;
    }
}

impl Controller {
    /// Take a checked request; the next cycle follows it and answers. One that repeats the last one of its sender, or is
    /// older, is none.
    ///
    /// Not part of the cycle: checking parameters allocates.
    pub fn request(&mut self, task: &Task) {
        let (sender, count) = (task.stamp.boot_id, task.stamp.step);
        if self
            .requests
            .sender
            .is_some_and(|(known, last)| known == sender && count <= last)
        {
            return;
        }
        self.requests.sender = Some((sender, count));
        self.requests.step = count;
        self.requests.action = TaskAction::None;
        let values = task.parameters.values();
        let given = || (0..).zip(&values).filter_map(|(i, value)| Some((i, (*value)?)));
        let unsought = given()
            .map(|(i, _)| i)
            .find(|i| WRENCH.contains(i) && !self.seeks_force());
        if let Some(parameter) = unsought {
            return self
                .requests
                .reply(ParameterAnswer::WrongPhase, Some(parameter), 0.0);
        }
        if let Err(OutOfRange { parameter, limit }) = self.parameters.accept(&values) {
            return self
                .requests
                .reply(ParameterAnswer::OutOfRange, Some(parameter), limit);
        }
        for (i, value) in given() {
            self.configured = self.parameters.accepted.task.clone();
            if i == FORCE {
                self.settings.task.desired_force_n = value;
            }
            self.parameters.lead(&mut self.settings, i, value);
            self.assessor.due |= IN_THE_LOOP.contains(&i);
        }
        let last = given().last();
        self.requests.reply(
            ParameterAnswer::Accepted,
            last.map(|(i, _)| i),
            last.map_or(0.0, |(_, value)| value),
        );
        self.requests.action = task.action;
    }

    /// Whether the present step seeks a force.
    fn seeks_force(&self) -> bool {
        self.program.kind() != Some(StepKind::Insert) && self.settings.task.kind == TaskKind::Press
    }

    /// Do what was asked for last, in the cycle at `tick` with the newest `state` of the robot.
    pub(crate) fn follow_request(&mut self, tick: i64, state: &RobotState) {
        let action = std::mem::take(&mut self.requests.action);
        let outcome = match action {
            TaskAction::None => return,
            TaskAction::Start if self.phases.phase() == ControllerPhase::Ready => {
                self.released = false;
                self.start(tick, state)
            }
            TaskAction::Start if !self.phases.well() => Err(latched()),
            TaskAction::Stop => {
                self.stop(tick);
                Ok(())
            }
            TaskAction::Reset => self.reset(tick, state),
            TaskAction::Tare if self.phases.phase() == ControllerPhase::Ready && self.rests(tick) => {
                self.tare_anew(tick);
                Ok(())
            }
            TaskAction::Start | TaskAction::Tare => Err(Refusal {
                answer: ParameterAnswer::WrongPhase,
                limit: 0.0,
            }),
            TaskAction::Release => {
                self.stop(tick);
                (self.released, self.rejoins) = (true, true);
                Ok(())
            }
        };
        if let Err(Refusal { answer, limit }) = outcome {
            self.requests.reply(answer, None, limit);
        }
    }

    /// Begin by itself, if that is configured and has not happened yet; why not is published as an answer.
    pub(crate) fn start_by_itself(&mut self, tick: i64, state: &RobotState) {
        match self.start(tick, state) {
            Ok(()) if self.requests.sender.is_none() => self.requests = Requests::default(),
            Ok(()) => {}
            Err(Refusal { answer, limit }) => self.requests.reply(answer, None, limit),
        }
    }

    /// Begin the configured task or program, or say why not.
    fn start(&mut self, tick: i64, state: &RobotState) -> Result<(), Refusal> {
        if self.homing.away() {
            return self.go_home(tick, state);
        }
        self.ready(tick, state)?;
        self.started = true;
        self.collision.reset();
        if let Some(motion) = &mut self.motion {
            motion.restore_gain();
        }
        if self.settings.task.kind == TaskKind::Calibrate {
            return self.begin_calibration();
        }
        self.program.start(&self.configured);
        self.begin_step(tick);
        Ok(())
    }

    fn begin_calibration(&mut self) -> Result<(), Refusal> {
        let Some(tilting) = &mut self.tilting else {
            return Err(Refusal {
                answer: ParameterAnswer::WrongPhase,
                limit: 0.0,
            });
        };
        tilting.go();
        self.phases.take(Event::Works(ControllerPhase::Calibrate));
        Ok(())
    }

    /// Come to rest and hold, whatever is done.
    fn stop(&mut self, tick: i64) {
        self.started = true;
        self.homing.abandon();
        if !self.phases.well() {
            return;
        }
        if self.phases.phase() == ControllerPhase::Calibrate {
            if let Some(tilting) = &mut self.tilting {
                tilting.pause();
            }
            self.phases.take(Event::Rests);
        } else if self.program.step().is_some() {
            self.program.end();
            if let Some(motion) = &mut self.motion {
                motion.stop(&self.settings, tick);
            }
            self.phases.take(Event::Rests);
        }
    }

    /// Clear a latched fault whose cause is gone: at rest where the fault has stopped the robot, until a new start.
    fn reset(&mut self, tick: i64, state: &RobotState) -> Result<(), Refusal> {
        if self.phases.well() {
            return Ok(());
        }
        let fresh_s = self.settings.controller.stale_fault_s;
        let saturated = self.motion.as_ref().is_some_and(|motion| motion.saturated());
        let silent = self.sensor_silent_s(tick) > fresh_s || self.robot_stale(tick);
        if silent || saturated || state.fault != Fault::None {
            return Err(latched());
        }
        let tared = self.motion.is_some();
        self.phases.take(Event::Resets { tared });
        self.collision.reset();
        self.started = true;
        self.homing.abandon();
        self.program.end();
        if let Some(tilting) = &mut self.tilting {
            tilting.halt();
        }
        self.rejoins = !crate::follows(state);
        if let Some(motion) = &mut self.motion {
            motion.recover(&self.settings, &self.commanded, tick);
        }
        Ok(())
    }

    /// Whether nothing moves and nothing is touched, so that zero force can be taken anew.
    pub(crate) fn rests(&self, tick: i64) -> bool {
        self.motion.as_ref().is_some_and(|motion| motion.rests_free(tick))
    }

    /// Take what the sensor shows from now on as zero.
    pub(crate) fn tare_anew(&mut self, tick: i64) {
        self.sensing.tare_anew();
        self.motion = None;
        self.tilting = None;
        self.start = self.commanded;
        self.tare_since_tick = tick;
        self.started = true;
        self.assessor.due = true;
        self.phases.take(Event::TaresAnew);
    }

    /// Whether all that a start rests on is there.
    pub(crate) fn ready(&self, tick: i64, state: &RobotState) -> Result<(), Refusal> {
        let settings = &self.settings;
        let evidence = Evidence {
            state,
            state_age_s: self.robot_silent_s(tick),
            sensor_age_s: self.sensor_silent_s(tick),
            saturated: self.sensing.saturated()
                || self.motion.as_ref().is_some_and(|motion| motion.saturated()),
            lead_m: distance_m(
                &settings.kinematics.forward(&state.axis_position[0]),
                &settings.kinematics.forward(&self.commanded),
            ),
            tare: self.sensing.zero(),
            r_from_s: settings.kinematics.forward(&self.start),
            object_known: self.expectation.ready(),
            away: self.homing.away(),
        };
        readiness::check(settings, &evidence)
    }
}

fn latched() -> Refusal {
    Refusal {
        answer: ParameterAnswer::FaultLatched,
        limit: 0.0,
    }
}

fn distance_m(a: &Pose, b: &Pose) -> f64 {
    (a.translation.vector - b.translation.vector).norm()
}
