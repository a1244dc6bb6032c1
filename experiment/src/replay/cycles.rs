//! The cycles of a log: what each has heard, and what it has answered.

use super::Unreplayable;
use crate::log::{Log, said_on, stamp};
use crate::transcript::Entry;
use controller::agenda::Agenda;
use lcmtypes::Message;
use node::record::HEARD;
use node::scenario::Scenario;
use spatial::TICK_US;
use spatial::ports::{
    Command, ControllerStatus, Deflections, NodeStatus, ObjectPose, RobotState, Stamp, Task,
};
use std::collections::BTreeMap;

/// One cycle of the controller.
#[derive(Debug, Default)]
pub(super) struct Cycle<'a> {
    pub(super) tick: i64,
    /// The controller begins anew before it.
    pub(super) anew: bool,
    pub(super) task: Option<Task>,
    pub(super) state: Option<RobotState>,
    pub(super) deflections: Option<Deflections>,
    pub(super) object: Option<ObjectPose>,
    /// The recorded answer.
    pub(super) command: Option<&'a Entry>,
    pub(super) status: Option<&'a Entry>,
}

/// The cycles of `log`, why there are no more of them, and whether they are those of real time.
pub(super) fn of<'a>(
    scenario: &Scenario,
    log: &'a Log,
) -> Result<(Vec<Cycle<'a>>, Option<String>, bool), Unreplayable> {
    let on = |channel: &str| log.entries.iter().any(|entry| entry.channel == channel);
    if on(&format!("{HEARD}{}", Deflections::CHANNEL)) {
        return Ok((live(log), None, true));
    }
    let mut states = log
        .entries
        .iter()
        .filter(|entry| entry.channel == RobotState::CHANNEL);
    if states.any(|entry| stamp(&entry.bytes).is_some_and(|stamp: Stamp| !stamp.is_lockstep())) {
        return Err(Unreplayable::NotHeard);
    }
    let (cycles, stopped) = lockstep(scenario, log)?;
    Ok((cycles, stopped, false))
}

/// In real time, as the controller has recorded them: an answer, then what it answers.
fn live(log: &Log) -> Vec<Cycle<'_>> {
    let mut cycles: Vec<Cycle<'_>> = Vec::new();
    let mut anew = false;
    for entry in &log.entries {
        if entry.channel == Command::CHANNEL {
            cycles.push(Cycle {
                tick: stamp(&entry.bytes).map_or(-1, |stamp| stamp.step),
                anew: std::mem::take(&mut anew),
                command: Some(entry),
                ..Cycle::default()
            });
            continue;
        }
        anew |= entry.channel == format!("{HEARD}{}", NodeStatus::CHANNEL);
        let Some(cycle) = cycles.last_mut() else { continue };
        if entry.channel == ControllerStatus::CHANNEL {
            cycle.status = Some(entry);
        } else if entry.channel.starts_with(HEARD) && entry.utime == cycle.tick * TICK_US {
            let bytes = &entry.bytes;
            match said_on(&entry.channel) {
                Task::CHANNEL => cycle.task = Task::decode(bytes).ok(),
                RobotState::CHANNEL => cycle.state = RobotState::decode(bytes).ok(),
                Deflections::CHANNEL => cycle.deflections = Deflections::decode(bytes).ok(),
                ObjectPose::CHANNEL => cycle.object = ObjectPose::decode(bytes).ok(),
                _ => {}
            }
        }
    }
    cycles
}

/// The messages of a channel by step, the first of each.
fn by_step<M: Message>(log: &Log) -> BTreeMap<i64, (&Entry, M)> {
    let mut all = BTreeMap::new();
    for entry in log.entries.iter().filter(|entry| entry.channel == M::CHANNEL) {
        if let Ok(message) = M::decode(&entry.bytes) {
            all.entry(message.stamp().step).or_insert((entry, message));
        }
    }
    all
}

/// In lockstep, where the tick says what belongs together.
fn lockstep<'a>(scenario: &Scenario, log: &'a Log) -> Result<(Vec<Cycle<'a>>, Option<String>), Unreplayable> {
    let states = by_step::<RobotState>(log);
    let deflections = by_step::<Deflections>(log);
    let objects = by_step::<ObjectPose>(log);
    let (commands, statuses) = (by_step::<Command>(log), by_step::<ControllerStatus>(log));
    let mut tasks = Tasks::of(log);
    match states.keys().next() {
        None => return Err(Unreplayable::Nothing),
        Some(0) => {}
        Some(first) => return Err(Unreplayable::Middle(*first)),
    }
    let period = scenario.timing.command_period_ticks;
    let mut cycles = Vec::new();
    for (expected, (tick, (_, state))) in (0..).step_by(period as usize).zip(&states) {
        let missing = |channel| {
            let why = format!("the log lacks {channel} of step {expected}: what follows can't be repeated");
            Some(why)
        };
        if *tick != expected {
            return Ok((cycles, missing(RobotState::CHANNEL)));
        }
        let Some((_, heard)) = deflections.get(tick) else {
            return Ok((cycles, missing(Deflections::CHANNEL)));
        };
        let object = objects.get(tick).map(|(_, pose)| *pose);
        if object.is_none() && scenario.object_sensor.due(*tick) {
            return Ok((cycles, missing(ObjectPose::CHANNEL)));
        }
        cycles.push(Cycle {
            tick: *tick,
            anew: false,
            task: tasks.due(*tick),
            state: Some(*state),
            deflections: Some(*heard),
            object,
            command: commands.get(tick).map(|(entry, _)| *entry),
            status: statuses.get(tick).map(|(entry, _)| *entry),
        });
    }
    Ok((cycles, None))
}

/// Requests: as the controller has recorded that it follows them, else by their own time.
enum Tasks {
    Followed(BTreeMap<i64, Task>),
    Asked(Agenda),
}

impl Tasks {
    fn of(log: &Log) -> Self {
        let heard = format!("{HEARD}{}", Task::CHANNEL);
        let on = |channel: &str| -> Vec<(i64, Task)> {
            let of = log.entries.iter().filter(|entry| entry.channel == channel);
            of.filter_map(|entry| Some((entry.utime / TICK_US, Task::decode(&entry.bytes).ok()?)))
                .collect()
        };
        let followed = on(&heard);
        if !followed.is_empty() {
            return Self::Followed(followed.into_iter().collect());
        }
        let mut agenda = Agenda::default();
        for (_, task) in on(Task::CHANNEL) {
            agenda.add(&task);
        }
        Self::Asked(agenda)
    }

    fn due(&mut self, tick: i64) -> Option<Task> {
        match self {
            Self::Followed(tasks) => tasks.get(&tick).copied(),
            Self::Asked(agenda) => agenda.due(tick),
        }
    }
}
