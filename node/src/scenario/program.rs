//! The section `[program]`: a list of steps, `[[program.step]]`, instead of the single task of `[task]`.

use super::check::{Conflicts, short};
use super::choice::Choice;
use super::error::{Place, Refusal};
use super::schema::Field;
use super::{OnFailure, Scenario, StepKind, TaskKind, names, schema};
use std::ops::Range;
use toml::{Spanned, de::DeTable};

schema::section! {
    /// What is done step by step; without steps it is the one task of `[task]`.
    Program at "program" with steps: Steps {
        /// What follows a step that fails: a fault, or the next retraction and what comes after it.
        on_failure: OnFailure = OnFailure::Fault;
    }
}

/// The steps of a program, in the order of the file: `[[program.step]]`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Steps(pub Vec<Step>);

impl Steps {
    /// A list has no keys of its own: they are its steps'.
    pub(in crate::scenario) fn fields(&mut self) -> impl Iterator<Item = Field<'_>> {
        std::iter::empty()
    }

    /// The section of its steps.
    pub(in crate::scenario) fn with_inner() -> impl Iterator<Item = schema::Section> {
        Step::with_inner()
    }
}

schema::section! {
    /// One step of a program. Every kind knows its own keys only; a key of another kind is refused.
    Step at "program.step" {
        /// What is done.
        kind: StepKind = StepKind::Move;
        /// How long the step may take before it counts as failed.
        timeout_s: f64 = 10.0, in 1e-3..=86400.0;
        /// Where a move leads the tcp, in r, as task.start_position_m; `next` adds its offsets.
        position_m: [f64; 3] = [0.0, 0.0, 0.030], in -10.0..=10.0;
        /// Speed on the way: of a search along its spiral.
        speed_m_per_s: f64 = 0.020, in 0.0005..=1.0;
        /// Normal force: that an approach presses with once it has met the object, that is pressed or searched with.
        force_n: f64 = 10.0, in 0.1..=1e5;
        /// How long to press with the force in its band, or to hold.
        duration_s: f64 = 0.5, in 0.0..=86400.0;
        /// How far an approach seeks below task.expected_height_m; how far the tool sinks where a search has found its
        /// hole, if it is not left without contact there before; how far an insertion leads below where the object was met, or below task.expected_height_m.
        depth_m: f64 = 0.005, in 1e-6..=1.0;
        /// How far a retraction leads up along the normal.
        distance_m: f64 = 0.010, in 1e-4..=1.0;
        /// Radius at which the spiral of a search ends.
        radius_m: f64 = 0.002, in 1e-5..=0.1;
        /// Distance of the spiral's turns.
        pitch_m: f64 = 0.0005, in 1e-5..=0.01;
        /// How far the tcp may yield on an insertion.
        tolerance_m: f64 = 0.001, in 1e-6..=0.1;
        /// From one workpiece to the next, in r: all that follows is shifted by it.
        offset_m: [f64; 3] = [0.0, 0.0, 0.0], in -10.0..=10.0;
        /// The step to which `next` goes back, counted from 0.
        first: i64 = 0, in 0..=1000;
        /// How many workpieces there are.
        count: i64 = 1, in 1..=10000;
    }
}

impl StepKind {
    /// The keys that mean something to this kind of step.
    fn keys(self) -> &'static [&'static str] {
        match self {
            Self::Move => &["kind", "timeout_s", "position_m", "speed_m_per_s"],
            Self::Approach => &["kind", "timeout_s", "speed_m_per_s", "force_n", "depth_m"],
            Self::Press => &["kind", "timeout_s", "force_n", "duration_s"],
            Self::Hold => &["kind", "timeout_s", "duration_s"],
            Self::Search => &[
                "kind",
                "timeout_s",
                "speed_m_per_s",
                "force_n",
                "depth_m",
                "radius_m",
                "pitch_m",
            ],
            Self::Insert => &["kind", "timeout_s", "speed_m_per_s", "depth_m", "tolerance_m"],
            Self::Retract => &["kind", "timeout_s", "speed_m_per_s", "distance_m"],
            Self::Next => &["kind", "offset_m", "first", "count"],
        }
    }
}

/// Where a key is that is refused, and why.
pub(super) type Refused = (Place, Refusal);

impl Step {
    /// Step `i` of a program as the `table` says.
    pub(super) fn read(
        i: usize,
        table: &DeTable<'_>,
        here: &Place,
        place: &impl Fn(Range<usize>) -> Place,
    ) -> Result<Self, Vec<Refused>> {
        let (mut step, mut refused) = (Self::default(), Vec::new());
        let mut given: Vec<(&str, Range<usize>)> = Vec::new();
        for (key, value) in table.iter() {
            let name: &str = key.get_ref();
            match step.put(i, name, value) {
                Ok(()) => given.push((name, key.span())),
                Err(misfits) => {
                    refused.extend(misfits.into_iter().map(|(span, refusal)| (place(span), refusal)));
                }
            }
        }
        if !table.iter().any(|(key, _)| *key.get_ref() == "kind") {
            let kinds = "move, approach, press, hold, search, insert, retract or next";
            let text = format!("program.step[{i}] does not say its kind; set it to {kinds}");
            refused.push((here.clone(), Refusal::Conflict(text)));
        } else if refused.is_empty() {
            let known = step.kind.keys();
            for (name, span) in given.into_iter().filter(|(name, _)| !known.contains(name)) {
                let (kind, known) = (super::choice::word(&step.kind), known.join(", "));
                let text = format!(
                    "program.step[{i}].{name} means nothing to the kind {kind:?}, which knows {known}"
                );
                refused.push((place(span), Refusal::Conflict(text)));
            }
        }
        if refused.is_empty() {
            Ok(step)
        } else {
            Err(refused)
        }
    }

    fn put(
        &mut self,
        i: usize,
        name: &str,
        value: &Spanned<toml::de::DeValue<'_>>,
    ) -> Result<(), Vec<super::value::Misfit>> {
        let path = format!("program.step[{i}].{name}");
        let field = self.fields().find(|field| schema::split(field.path).1 == name);
        match field {
            Some(Field { slot, .. }) => slot.put(&path, value),
            None => {
                let mut all = Self::default();
                let known: Vec<_> = all.fields().map(|field| schema::split(field.path).1).collect();
                let near = names::Near::to(name, known.iter().map(|known| (*known, (*known).to_owned())));
                let (section, known) = ("[program.step]".to_owned(), known.join(", "));
                Err(vec![(
                    value.span(),
                    Refusal::UnknownKey {
                        path,
                        section,
                        known,
                        near,
                    },
                )])
            }
        }
    }

    /// Names of the keys that mean something to this step.
    pub(super) fn known(&self) -> &'static [&'static str] {
        self.kind.keys()
    }

    /// Every key of a step, in the order of declaration.
    pub fn keys() -> Vec<schema::Key> {
        Self::default().fields().map(schema::describe).collect()
    }

    /// Every kind of step by its word, with the names of the keys that it knows.
    pub fn kinds() -> Vec<(&'static str, &'static [&'static str])> {
        let mut kind = StepKind::default();
        let words = kind.words().iter();
        words
            .map(|&word| {
                kind.choose(word);
                (word, kind.keys())
            })
            .collect()
    }
}

impl Program {
    /// The steps.
    pub fn steps(&self) -> &[Step] {
        &self.steps.0
    }

    /// The largest force that a step presses with, N; 0: none does.
    pub(super) fn largest_force_n(&self) -> f64 {
        let pressing = self
            .steps()
            .iter()
            .filter(|step| step.kind.keys().contains(&"force_n"));
        pressing.fold(0.0, |most, step| most.max(step.force_n))
    }
}

impl Scenario {
    /// What the steps of a program need of each other and of the axes.
    pub(super) fn check_program(&self, conflicts: &mut Conflicts) {
        const STEPS: &[&str] = &["program.step"];
        let steps = self.program.steps();
        conflicts.require(
            steps.is_empty() || self.task.kind == TaskKind::Press,
            &["task.kind", "program.step"],
            "task.kind is not \"press\", and there is a program, whose steps say what is done; remove one of them"
                .to_owned(),
        );
        let mut touching = false;
        for (i, step) in steps.iter().enumerate() {
            let (needs, leaves) = match step.kind {
                StepKind::Move | StepKind::Next => (Some(false), false),
                StepKind::Approach => (Some(false), true),
                StepKind::Press | StepKind::Search => (Some(true), true),
                StepKind::Hold => (None, touching),
                StepKind::Insert => (None, true),
                StepKind::Retract => (None, false),
            };
            let kind = super::choice::word(&step.kind);
            conflicts.require(
                needs != Some(true) || touching,
                STEPS,
                format!(
                    "program.step[{i}] is a {kind}, but nothing is touched before it; put an approach there"
                ),
            );
            conflicts.require(
                needs != Some(false) || !touching,
                STEPS,
                format!(
                    "program.step[{i}] is a {kind}, but the object is still touched before it; retract first"
                ),
            );
            let most = self.task.max_contact_force_n;
            conflicts.require(
                !step.kind.keys().contains(&"force_n") || step.force_n < most,
                &["task.max_contact_force_n", "program.step"],
                format!(
                    "program.step[{i}].force_n is {} N, not below task.max_contact_force_n, {} N; press less, or allow \
                     more",
                    short(step.force_n),
                    short(most)
                ),
            );
            touching = leaves;
            match step.kind {
                StepKind::Next => self.check_next(conflicts, i, step),
                StepKind::Move => self.check_move(conflicts, i, step, [0.0; 3]),
                _ => {}
            }
        }
    }

    /// Where `next`, step `i`, leads.
    fn check_next(&self, conflicts: &mut Conflicts, i: usize, step: &Step) {
        const STEPS: &[&str] = &["program.step"];
        let (steps, first) = (
            self.program.steps(),
            usize::try_from(step.first).unwrap_or(usize::MAX),
        );
        let starts_free = steps
            .get(first)
            .is_some_and(|it| !matches!(it.kind, StepKind::Press | StepKind::Search));
        conflicts.require(
            first < i && starts_free,
            STEPS,
            format!(
                "program.step[{i}].first is {first}, no step before it that can begin without contact; choose one, \
                 counted from 0"
            ),
        );
        let last = step.offset_m.map(|offset| offset * (step.count - 1) as f64);
        for (k, moved) in steps
            .iter()
            .enumerate()
            .filter(|(k, it)| *k < i && it.kind == StepKind::Move)
        {
            self.check_move(conflicts, k, moved, last);
        }
    }

    /// Whether the axes reach where step `k` moves to, shifted by `offset` (m).
    fn check_move(&self, conflicts: &mut Conflicts, k: usize, step: &Step, offset: [f64; 3]) {
        let at: [f64; 3] = std::array::from_fn(|axis| step.position_m[axis] + offset[axis]);
        conflicts.require(
            self.axes_at(at).is_ok_and(|axes| self.within_range(&axes)),
            &["program.step"],
            format!(
                "program.step[{k}] leads to ({}, {}, {}) m, which the axes can't reach; move elsewhere, or choose \
                 fewer or nearer workpieces",
                short(at[0]),
                short(at[1]),
                short(at[2]),
            ),
        );
    }
}
