//! What was heard of a node under test, and what was said to it.

use spatial::ports::{ClockEcho, Command, Deflections, NodeStatus, RobotMode, RobotState, Role, Stamp};
use std::collections::BTreeMap;

/// A message and when it came or went.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct At<M> {
    /// On the checker's clock, us.
    pub us: i64,
    /// The message.
    pub message: M,
}

/// Messages that can't be used.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Refused {
    /// Their channel.
    pub channel: &'static str,
    /// How many.
    pub count: u64,
    /// Why the last one was refused.
    pub why: String,
}

/// What became of the tags of the node under test.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Signed {
    /// Messages that were signed and new.
    pub taken: u64,
    /// Others.
    pub refused: u64,
    /// Why the first of these was refused.
    pub why: Option<String>,
}

/// What the checker, as a controller, says in answer to each state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Saying {
    /// Nothing.
    Silence,
    /// A good command without enable.
    Released,
    /// The same, of a tick that is to come.
    Future,
    /// The same, of a tick that is long over.
    Old,
    /// The same, and one of another process with other set-points.
    Foreign,
    /// Without enable, set-points that no axis reaches.
    OutOfRange,
    /// An enabled command that stays and is not signed, by whoever has a key.
    Unsigned,
    /// An enabled command that stays.
    Stay,
    /// The same, and an enabled one of another process with other set-points.
    Intruder,
    /// An enabled command that stays, and a request to reset.
    ResetWhileEnabled,
    /// A good command without enable, and a request to reset.
    Reset,
}

/// A time in which one thing was said.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Phase {
    /// What was said.
    pub saying: Saying,
    /// From when on, us.
    pub from_us: i64,
    /// Until when, us.
    pub until_us: i64,
}

/// What state and deflection have in common.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Head {
    /// When it came, us.
    pub us: i64,
    /// Tick, sampling instant, sender.
    pub stamp: Stamp,
    /// What it echoes.
    pub echo: ClockEcho,
}

/// What was heard and said, each in its order.
#[derive(Clone, Debug, PartialEq)]
pub struct Record {
    /// The role under test.
    pub role: Role,
    /// Statuses of that role.
    pub statuses: Vec<At<NodeStatus>>,
    /// Statuses of the other roles that are not the checker's own.
    pub peers: Vec<At<NodeStatus>>,
    /// States of the robot.
    pub states: Vec<At<RobotState>>,
    /// Deflections of the sensor.
    pub deflections: Vec<At<Deflections>>,
    /// The commands of the controller that the node under test should work with, the checker's or another's.
    pub commands: Vec<At<Command>>,
    /// The checker's commands that no robot should act upon, whose stamps may be echoed all the same.
    pub odd_commands: Vec<At<Command>>,
    /// When it asked for a reset, us.
    pub resets_us: Vec<i64>,
    /// What the checker said, when.
    pub phases: Vec<Phase>,
    /// What could not be used, by channel.
    pub refused: Vec<Refused>,
    /// With a key.
    pub signed: Option<Signed>,
    /// How long it listened, us.
    pub listened_us: i64,
}

impl Record {
    /// Nothing of a node in `role` yet.
    pub fn new(role: Role) -> Self {
        Self {
            role,
            statuses: Vec::new(),
            peers: Vec::new(),
            states: Vec::new(),
            deflections: Vec::new(),
            commands: Vec::new(),
            odd_commands: Vec::new(),
            resets_us: Vec::new(),
            phases: Vec::new(),
            refused: Vec::new(),
            signed: None,
            listened_us: 0,
        }
    }

    /// Name of the channel under test.
    pub fn channel(&self) -> &'static str {
        match self.role {
            Role::Robot => "ROBOT_STATE",
            Role::Sensor => "SENSOR_DEFLECTION",
            Role::Controller => "ROBOT_COMMAND",
        }
    }

    /// The heads of the messages under test.
    pub fn heads(&self) -> Vec<Head> {
        let head = |us, stamp, echo| Head { us, stamp, echo };
        match self.role {
            Role::Robot => {
                let all = self.states.iter();
                all.map(|it| head(it.us, it.message.stamp, it.message.echo))
                    .collect()
            }
            Role::Sensor => {
                let all = self.deflections.iter();
                all.map(|it| head(it.us, it.message.stamp, it.message.echo))
                    .collect()
            }
            Role::Controller => Vec::new(),
        }
    }

    /// When each command went, us, by its `send_utime`.
    pub fn sent(&self) -> BTreeMap<i64, i64> {
        let all = self.commands.iter().chain(&self.odd_commands);
        all.map(|it| (it.message.send_utime, it.us)).collect()
    }

    /// The first phase in which `saying` was said.
    pub fn phase(&self, saying: Saying) -> Option<Phase> {
        self.phases.iter().find(|phase| phase.saying == saying).copied()
    }

    /// The states that came in `phase`.
    pub fn states_in(&self, phase: Phase) -> &[At<RobotState>] {
        let begin = self.states.partition_point(|it| it.us < phase.from_us);
        let end = self.states.partition_point(|it| it.us < phase.until_us);
        &self.states[begin..end.max(begin)]
    }

    /// Ticks per command period as the node under test says; 0: it has not said any that can be.
    pub fn period_ticks(&self) -> i64 {
        let said = self
            .statuses
            .last()
            .map(|it| i64::from(it.message.hello.ticks_per_cycle));
        said.filter(|ticks| (1..=12).contains(ticks)).unwrap_or(0)
    }
}

/// The modes of `states`, each run of the same one once.
pub fn course(states: &[At<RobotState>]) -> Vec<RobotMode> {
    let mut modes: Vec<_> = states.iter().map(|it| it.message.mode).collect();
    modes.dedup();
    modes
}

/// The names of `modes` in their order.
pub fn names(modes: &[RobotMode]) -> String {
    let names: Vec<_> = modes.iter().map(|mode| mode.name()).collect();
    match names.as_slice() {
        [] => "no state".to_owned(),
        names => names.join(", "),
    }
}

/// The value that the share `ratio` of `values` does not exceed; `None` of none.
pub fn quantile(values: &[f64], ratio: f64) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let last = sorted.len().checked_sub(1)?;
    let i = libm::rint(ratio * last as f64) as usize;
    sorted.get(i.min(last)).copied()
}

/// Every two neighbours.
pub fn pairs<T>(values: &[T]) -> impl Iterator<Item = (&T, &T)> {
    values.iter().zip(values.iter().skip(1))
}
