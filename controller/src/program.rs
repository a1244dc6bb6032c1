//! The steps of a program, and which of them is done now.

use nalgebra::Vector3;
use node::scenario::{OnFailure, Program as Configured, Scenario, Step, StepKind, Task, TaskKind};

/// A list of steps, and where in it the controller is. Without a program in the scenario its one task is the list.
#[derive(Clone, Debug)]
pub(crate) struct Program {
    steps: Vec<Step>,
    /// The way back to the start, while that is what is done.
    home: Option<[Step; 2]>,
    /// Whether the scenario has a program, whose steps are published.
    pub(crate) configured: bool,
    on_failure: OnFailure,
    /// `None`: none is done.
    index: Option<usize>,
    /// How often each `next` has led on.
    repeated: Vec<i64>,
    /// From the first workpiece to the present one, m in r.
    pub(crate) offset: Vector3<f64>,
    /// Tick at which the present step began.
    pub(crate) began_tick: i64,
    /// The bits that say why the step before failed.
    pub(crate) failed: i32,
}

/// Steps of the single task that a scenario without a program has, at most.
const SINGLE: usize = 2;

impl Program {
    /// The steps of a scenario, none of them begun.
    pub(crate) fn new(scenario: &Scenario) -> Self {
        let Configured { on_failure, .. } = scenario.program;
        let configured = !scenario.program.steps().is_empty();
        let steps = if configured {
            scenario.program.steps().to_vec()
        } else {
            Vec::with_capacity(SINGLE)
        };
        Self {
            repeated: vec![0; steps.len()],
            steps,
            home: None,
            configured,
            on_failure,
            index: None,
            offset: Vector3::zeros(),
            began_tick: 0,
            failed: 0,
        }
    }

    /// Begin anew with the first step; the single task is taken as it is configured now.
    pub(crate) fn start(&mut self, task: &Task) {
        if !self.configured {
            self.steps.clear();
            self.steps.extend(single(task).into_iter().flatten());
        }
        self.repeated.fill(0);
        self.offset = Vector3::zeros();
        self.failed = 0;
        self.index = Some(0);
        self.home = None;
    }

    /// Begin the way back to the start instead.
    pub(crate) fn go_home(&mut self, way: [Step; 2]) {
        self.failed = 0;
        self.offset = Vector3::zeros();
        self.index = Some(0);
        self.home = Some(way);
    }

    /// What is done, step by step.
    fn list(&self) -> &[Step] {
        self.home.as_ref().map_or(&self.steps, |home| home)
    }

    /// Nothing is done any more.
    pub(crate) fn end(&mut self) {
        self.index = None;
    }

    /// The step that is done now.
    pub(crate) fn step(&self) -> Option<&Step> {
        self.list().get(self.index?)
    }

    /// The kind of the step that is done now.
    pub(crate) fn kind(&self) -> Option<StepKind> {
        self.step().map(|step| step.kind)
    }

    /// Index of the step as it is published.
    pub(crate) fn published(&self) -> Option<i32> {
        self.index
            .filter(|_| self.configured && self.home.is_none())
            .and_then(|index| i32::try_from(index).ok())
    }

    /// The present step has come to its end: go on to what follows, back to an earlier one where `next` says so.
    pub(crate) fn go_on(&mut self) {
        self.failed = 0;
        let mut index = self.index.map_or(0, |index| index + 1);
        if let Some(home) = &self.home {
            self.index = Some(index).filter(|&index| index < home.len());
            return;
        }
        while let Some(step) = self.steps.get(index).filter(|step| step.kind == StepKind::Next) {
            let first = usize::try_from(step.first).unwrap_or(0);
            self.repeated[index] += 1;
            if self.repeated[index] < step.count {
                self.offset += Vector3::from(step.offset_m);
                // Loops within this one begin anew.
                self.repeated[first..index].fill(0);
                index = first;
                break;
            }
            self.offset -= Vector3::from(step.offset_m) * (step.count - 1) as f64;
            index += 1;
        }
        self.index = (index < self.steps.len()).then_some(index);
    }

    /// The present step has failed for what the bit `why` says: go on to the next retraction, if there is one and the
    /// program is to; `false`: it is not.
    pub(crate) fn fail(&mut self, why: i32) -> bool {
        let after = self.index.map_or(0, |index| index + 1);
        let retraction = (after..self.steps.len()).find(|&i| self.steps[i].kind == StepKind::Retract);
        if self.on_failure == OnFailure::Fault || retraction.is_none() || self.home.is_some() {
            return false;
        }
        self.index = retraction;
        self.failed = why;
        true
    }
}

/// The steps that a single task is made of; they last until they are stopped.
fn single(task: &Task) -> [Option<Step>; SINGLE] {
    let endless = Step {
        timeout_s: f64::INFINITY,
        speed_m_per_s: task.approach_speed_m_per_s,
        force_n: task.desired_force_n,
        duration_s: f64::INFINITY,
        depth_m: task.search_depth_m,
        tolerance_m: task.tolerance_m,
        ..Step::default()
    };
    let step = |kind| {
        Some(Step {
            kind,
            ..endless.clone()
        })
    };
    match task.kind {
        TaskKind::Press => [step(StepKind::Approach), step(StepKind::Press)],
        TaskKind::Position => [step(StepKind::Insert), None],
        TaskKind::Calibrate => [None, None],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Kinds and offsets (mm along x) of all steps that are done.
    fn done(text: &str) -> Vec<(StepKind, f64)> {
        let scenario = Scenario::parse("a.toml", text, &[]).unwrap();
        let mut program = Program::new(&scenario);
        program.start(&scenario.task);
        let mut seen = Vec::new();
        while let Some(kind) = program.kind() {
            seen.push((kind, (program.offset.x * 1e3).round()));
            program.go_on();
            assert!(seen.len() < 100);
        }
        seen
    }

    #[test]
    fn a_row_is_gone_along_and_another_one_from_its_beginning() {
        use StepKind::{Approach, Move, Retract};
        let text = "program.step = [{kind = 'move'}, {kind = 'approach'}, {kind = 'retract'},
            {kind = 'next', first = 1, count = 2, offset_m = [0.01, 0.0, 0.0]},
            {kind = 'next', first = 0, count = 2, offset_m = [0.1, 0.0, 0.0]}, {kind = 'move'}]";
        assert_eq!(
            done(text),
            [
                (Move, 0.0),
                (Approach, 0.0),
                (Retract, 0.0),
                (Approach, 10.0),
                (Retract, 10.0),
                (Move, 100.0),
                (Approach, 100.0),
                (Retract, 100.0),
                (Approach, 110.0),
                (Retract, 110.0),
                (Move, 0.0),
            ]
        );
    }

    #[test]
    fn a_failure_leads_to_the_next_retraction_or_to_a_fault() {
        for (on_failure, goes_on) in [("retract", true), ("fault", false)] {
            let text = format!(
                "program.on_failure = '{on_failure}'
                program.step = [{{kind = 'approach'}}, {{kind = 'press'}}, {{kind = 'retract'}}]"
            );
            let scenario = Scenario::parse("a.toml", &text, &[]).unwrap();
            let mut program = Program::new(&scenario);
            program.start(&scenario.task);
            assert_eq!(program.fail(4), goes_on);
            assert_eq!(
                (program.kind(), program.failed),
                if goes_on {
                    (Some(StepKind::Retract), 4)
                } else {
                    (Some(StepKind::Approach), 0)
                }
            );
            assert!(!(goes_on && program.fail(4)), "nothing to retract to is left");
        }
    }

    #[test]
    fn a_task_is_a_program_of_its_own() {
        let mut program = Program::new(&Scenario::default());
        assert_eq!((program.kind(), program.published()), (None, None));
        program.start(&Task::default());
        assert_eq!(
            (program.kind(), program.published()),
            (Some(StepKind::Approach), None)
        );
        program.go_on();
        assert_eq!(
            program.step().map(|step| (step.kind, step.force_n)),
            Some((StepKind::Press, 10.0))
        );
        program.go_on();
        assert_eq!(program.kind(), None);
    }
}
