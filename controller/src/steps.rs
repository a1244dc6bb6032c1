//! The phases: what is done after the tare, step by step.

use crate::dofs::Selection;
use crate::parameters::FORCE;
use crate::phases::{Event, Phases};
use crate::{Controller, ControllerPhase};
use nalgebra::Vector3;
use node::scenario::{ForceControlled, Step, StepKind};
use spatial::TICK_S;
use spatial::ports::{Fault, LIMIT_STEP_SEARCH, LIMIT_STEP_TIME, LIMIT_STEP_TOLERANCE};

/// How long the force must stay in its band before the contact counts as settled, s.
const SETTLED_S: f64 = 0.05;

/// How a step stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Progress {
    Goes,
    Done,
    Failed(Fault, i32),
}

impl Controller {
    /// Begin the program's present step in the cycle at `tick`; without one all is done.
    pub(crate) fn begin_step(&mut self, tick: i64) {
        let (settings, program) = (&mut self.settings, &mut self.program);
        let Some(motion) = &mut self.motion else { return };
        let Some(step) = program.step().cloned() else {
            self.phases.take(Event::Rests);
            if motion.contact_tick().is_some() {
                motion.stop(settings, tick);
            }
            return;
        };
        program.began_tick = tick;
        if matches!(step.kind, StepKind::Approach | StepKind::Move) {
            self.collision.reset();
        }
        let selection = selection(&settings.task.force_controlled, &step, program.configured);
        let phase = match step.kind {
            StepKind::Approach => {
                settings.task = self.configured.clone();
                settings.task.approach_speed_m_per_s = step.speed_m_per_s;
                settings.task.search_depth_m = step.depth_m;
                settings.task.desired_force_n = step.force_n;
                settings.task.expected_height_m += program.offset.z;
                self.expectation.expect_at_height(settings.task.expected_height_m);
                if settings.desired.force.z != step.force_n {
                    // Nothing is touched that it could act on.
                    self.parameters.set(settings, FORCE, step.force_n);
                    motion.plan(settings, &self.sensing.compliance());
                }
                motion.begin_approach(settings, &self.expectation, selection, tick);
                ControllerPhase::Approach
            }
            StepKind::Press => {
                motion.begin_pressing();
                settings.task.desired_force_n = step.force_n;
                self.parameters.lead(settings, FORCE, step.force_n);
                ControllerPhase::Contact
            }
            StepKind::Hold if motion.presses() => {
                motion.begin_pressing();
                ControllerPhase::Contact
            }
            StepKind::Hold | StepKind::Next => ControllerPhase::Move,
            StepKind::Search => {
                settings.task.desired_force_n = step.force_n;
                self.parameters.lead(settings, FORCE, step.force_n);
                motion.begin_search(settings, selection, &step, tick);
                ControllerPhase::Search
            }
            StepKind::Insert => {
                let expected_m = settings.task.expected_height_m;
                settings.task.approach_speed_m_per_s = step.speed_m_per_s;
                settings.task.search_depth_m = step.depth_m;
                settings.task.tolerance_m = step.tolerance_m;
                settings.task.expected_height_m = motion.met_at_m().unwrap_or(expected_m);
                self.parameters.lead(settings, FORCE, 0.0);
                motion.begin_insertion(settings, &self.expectation, selection, tick);
                if motion.presses() {
                    ControllerPhase::Contact
                } else {
                    ControllerPhase::Approach
                }
            }
            StepKind::Retract => {
                motion.begin_retraction(settings, step.distance_m, step.speed_m_per_s, tick);
                ControllerPhase::Retract
            }
            StepKind::Move => {
                let position = Vector3::from(step.position_m) + program.offset;
                motion.begin_move(settings, position, step.speed_m_per_s, tick);
                ControllerPhase::Move
            }
        };
        self.phases.take(Event::Works(phase));
    }

    /// See how the present step stands in the cycle at `tick`, and go on to the next one where it has ended.
    pub(crate) fn follow_program(&mut self, tick: i64) {
        let Some(step) = self.program.step().cloned() else {
            return;
        };
        match self.progress(&step, tick) {
            Progress::Goes => {}
            Progress::Done => {
                if let (Some(motion), StepKind::Retract) = (&mut self.motion, step.kind) {
                    motion.end_retraction();
                }
                self.program.go_on();
                self.begin_step(tick);
            }
            Progress::Failed(fault, why) => {
                if self.program.fail(why) {
                    self.begin_step(tick);
                } else {
                    self.fail(fault);
                }
            }
        }
    }

    fn progress(&mut self, step: &Step, tick: i64) -> Progress {
        let settings = &self.settings;
        let Some(motion) = &mut self.motion else {
            return Progress::Goes;
        };
        let elapsed_s = (tick - self.program.began_tick) as f64 * TICK_S;
        let no_contact = Progress::Failed(Fault::NoContact, LIMIT_STEP_SEARCH);
        if elapsed_s > step.timeout_s {
            return Progress::Failed(Fault::StepTimeout, LIMIT_STEP_TIME);
        }
        let ended = motion.approached_for(tick) > motion.approach_duration(settings);
        match step.kind {
            StepKind::Approach if motion.in_contact() => Progress::Done,
            StepKind::Approach if ended => no_contact,
            StepKind::Press | StepKind::Hold if motion.lost_beyond_search() => no_contact,
            StepKind::Press => {
                let settled_s = settle(motion, settings, &mut self.phases);
                // The force is still led to where it is to be, by the step or by a request since.
                let arrived = settings.desired.force.z == settings.task.desired_force_n;
                if !arrived {
                    motion.begin_pressing();
                }
                if settled_s >= SETTLED_S + step.duration_s && arrived {
                    Progress::Done
                } else {
                    Progress::Goes
                }
            }
            StepKind::Hold => {
                if motion.presses() {
                    settle(motion, settings, &mut self.phases);
                }
                if elapsed_s >= step.duration_s {
                    Progress::Done
                } else {
                    Progress::Goes
                }
            }
            // A stiff tool sinks slowly: that nothing bears it for longer than a bounce tells of the hole before.
            StepKind::Search if motion.sunk_m() >= step.depth_m || motion.lost() => Progress::Done,
            StepKind::Search if motion.way_ended(tick) => no_contact,
            StepKind::Insert => self.insert(step, ended),
            StepKind::Move if motion.normal_force_n() > motion.threshold_n() => {
                Progress::Failed(Fault::Collision, LIMIT_STEP_TOLERANCE)
            }
            StepKind::Retract | StepKind::Move if motion.way_ended(tick) => Progress::Done,
            _ => Progress::Goes,
        }
    }

    /// An insertion: whose way has `ended` or not.
    fn insert(&mut self, step: &Step, ended: bool) -> Progress {
        let Some(motion) = &self.motion else {
            return Progress::Goes;
        };
        if self.phases.phase() == ControllerPhase::Approach && motion.in_contact() {
            self.phases.take(Event::Works(ControllerPhase::Contact));
        } else if motion.yields_by_m() > step.tolerance_m {
            return Progress::Failed(Fault::ToleranceExceeded, LIMIT_STEP_TOLERANCE);
        } else if motion.saturated() {
            return Progress::Failed(Fault::DeflectionSaturated, LIMIT_STEP_TOLERANCE);
        } else if ended && motion.arrived(step.tolerance_m) {
            self.phases.take(Event::Works(ControllerPhase::Settled));
            if self.program.configured {
                return Progress::Done;
            }
        }
        Progress::Goes
    }
}

/// Contact or settled, by the force's band; how long it has been inside, s.
fn settle(
    motion: &mut crate::motion::Motion,
    settings: &crate::settings::Settings,
    phases: &mut Phases,
) -> f64 {
    let error = motion.force_n() - settings.desired.force.z;
    let inside = libm::fabs(error) <= settings.controller.settled_band_n;
    let inside_s = motion.count_settled(inside) as f64 * settings.period_ticks as f64 * TICK_S;
    if inside_s >= SETTLED_S {
        phases.take(Event::Works(ControllerPhase::Settled));
    } else if !inside {
        phases.take(Event::Works(ControllerPhase::Contact));
    }
    inside_s
}

/// What follows the force law in a `step`: of the single task what is configured; of a program's steps the normal, and
/// on an insertion whatever is across it, besides the turns that are configured.
fn selection(configured: &ForceControlled, step: &Step, program: bool) -> Selection {
    let mut selected = configured.clone();
    if program {
        let inserts = step.kind == StepKind::Insert;
        (selected.x, selected.y, selected.z) = (inserts, inserts, !inserts);
    }
    Selection::new(&selected)
}
