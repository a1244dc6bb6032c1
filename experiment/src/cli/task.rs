//! `touchdown task`: ask the controller for something while it runs, and tell its answer.

use super::{FAILED, WrongUsage, print, print_json};
use anyhow::{Context, Result, bail};
use experiment::up::CellConfig;
use lcmtypes::{Group, Lcm, LcmBuilder, Subscription};
use node::authenticity::{Author, Gate};
use node::clock;
use node::key_file;
use rustix::rand::{GetRandomFlags, getrandom};
use serde::Serialize;
use spatial::ports::{
    ControllerStatus, ParameterAnswer, RobotState, Stamp, Task, TaskAction, TaskParameters,
};
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::{Duration, Instant};

/// Ask the running controller, from any host: start, stop, tare, reset, release, or a parameter's new value
#[derive(clap::Args)]
#[command(after_help = "\
Without --url and --cell: udpm://239.255.76.67:7667?ttl=0, this host alone.

After a fault: mend its cause, then `touchdown task reset` and `touchdown task start`. A reset is asked for again for
2 s: the controller refuses it until the robot, which hears the same request, has cleared its own fault. So is a start:
a robot that was released (it stops, holds and is idle) or joined is armed first.

Exit codes:
  0  accepted
  1  refused, with the controller's reason, or not answered
  2  wrong usage or cell")]
pub(crate) struct Args {
    /// What to do; with `set` only the parameters change, `set-force 12` is `set desired_force_n=12`
    #[arg(value_parser = ["start", "stop", "tare", "reset", "release", "set", "set-force"])]
    action: String,
    /// Parameters and their new values, such as desired_force_n=12
    #[arg(value_name = "PARAMETER=VALUE")]
    parameters: Vec<String>,
    #[command(flatten)]
    channels: Channels,
    /// Sign with the key of the cell; of several the first signs [default: what the cell's file names]
    #[arg(long, value_name = "FILE")]
    key: Vec<PathBuf>,
    /// Print one JSON object instead of a line
    #[arg(long)]
    json: bool,
}

/// Where a cell is heard.
#[derive(clap::Args)]
pub(crate) struct Channels {
    /// LCM URL of the device channels, the one that the nodes have; where a node runs on another host it ends with
    /// ?ttl=1
    #[arg(long)]
    url: Option<String>,
    /// The cell's file, which names that URL
    #[arg(long, value_name = "CELL.toml", conflicts_with = "url")]
    cell: Option<PathBuf>,
}

#[derive(Serialize)]
struct Report {
    command: &'static str,
    answer: String,
    parameter: Option<&'static str>,
    /// The limit that was left, or the value that the parameter will have, in its unit.
    value: f64,
}

/// The URL of the device channels where none is named.
pub(super) const DEFAULT_URL: &str = "udpm://239.255.76.67:7667?ttl=0";
/// As many senders are told apart; the counts of requests, which begin there, have room beyond.
const SENDERS: i64 = 8_000_000_000_000;
/// How long to wait for an answer, and for how long a reset is asked for again.
const PATIENCE: Duration = Duration::from_secs(2);
/// How long until the request is repeated.
const REPEAT: Duration = Duration::from_millis(50);

impl Channels {
    /// The URL that was named, by itself or by a cell's file.
    pub(super) fn named(&self) -> Result<Option<String>> {
        match &self.cell {
            Some(path) => Ok(Some(CellConfig::load(path)?.url)),
            None => Ok(self.url.clone()),
        }
    }
}

pub(crate) fn run(args: &Args) -> Result<ExitCode> {
    let mut task = request(args).map_err(|error| WrongUsage(error.to_string()))?;
    let url = args.channels.named()?.unwrap_or_else(|| DEFAULT_URL.to_owned());
    let mut link = LcmBuilder::open(&url)?;
    let statuses = link.subscribe::<ControllerStatus>(64);
    let signature = args.signature()?.map(|gate| Signature {
        gate,
        states: link.subscribe(16),
    });
    let mut asker = Asker {
        link: link.start()?,
        statuses,
        signature,
    };
    let give_up = clock::now() + PATIENCE;
    let mut answer = None;
    while let Some(status) = asker.ask(&task, give_up)? {
        answer = Some(status);
        // The robot hears the same request, but may clear its fault after the controller has looked; and one that was released
        // is armed first.
        let early = matches!(
            (task.action, status.task_answer),
            (TaskAction::Reset, ParameterAnswer::FaultLatched)
                | (TaskAction::Start, ParameterAnswer::RobotNotReady)
        );
        if !early || !asker.pause(give_up) {
            break;
        }
        task.stamp.step += 1;
    }
    match answer {
        Some(status) => tell(args, &status),
        None => bail!(
            "no controller has answered on {url} within {} s{}; start one, or name its URL with --url{}",
            PATIENCE.as_secs(),
            match &asker.signature {
                Some(signature) if signature.gate.session() == 0 =>
                    ", nor has a robot said anything that is signed with this key",
                Some(_) => "",
                None => " (without --key: one with a key does not answer)",
            },
            match Group::of(&url) {
                Ok(Some(Group { ttl: 0, address, .. })) =>
                    format!(" (on another host: --url \"udpm://{address}?ttl=1\")"),
                _ =>
                    "; `touchdown doctor --peer` on both hosts tells whether they hear each other".to_owned(),
            }
        ),
    }
}

impl Args {
    /// What to sign with, if anything.
    fn signature(&self) -> Result<Option<Gate>> {
        let files = match &self.channels.cell {
            Some(path) if self.key.is_empty() => CellConfig::load(path)?.keys,
            _ => self.key.clone(),
        };
        Ok(key_file::read_all(&files)?.map(|keyring| Gate::new(keyring, Author::Operator)))
    }
}

/// Whoever asks.
struct Asker {
    link: Lcm,
    statuses: Subscription<ControllerStatus>,
    signature: Option<Signature>,
}

/// What a request is signed with: the robot's states tell of which session it is.
struct Signature {
    gate: Gate,
    states: Subscription<RobotState>,
}

impl Asker {
    /// Ask until the answer comes; `None`: not before `give_up`.
    fn ask(&mut self, task: &Task, give_up: Instant) -> Result<Option<ControllerStatus>> {
        while clock::now() < give_up {
            self.send(task, give_up)?;
            let until = (clock::now() + REPEAT).min(give_up);
            while let Ok(received) = self.statuses.receiver().recv_deadline(until) {
                if received.message.task_step == task.stamp.step {
                    return Ok(Some(received.message));
                }
            }
        }
        Ok(None)
    }

    /// Send the request, perhaps again: a repeated one is the same to the controller, also signed anew.
    fn send(&mut self, task: &Task, give_up: Instant) -> Result<()> {
        let mut task = *task;
        if let Some(Signature { gate, states }) = &mut self.signature {
            while let Some(received) = states.take() {
                let _ = gate.admit(&received.message);
            }
            while gate.session() == 0 {
                let Ok(received) = states.receiver().recv_deadline(give_up) else {
                    return Ok(());
                };
                let _ = gate.admit(&received.message);
            }
            gate.sign(&mut task);
        }
        Ok(self.link.publish(&task)?)
    }

    /// Let a repeat's time pass; `false`: there is none left before `give_up`.
    fn pause(&self, give_up: Instant) -> bool {
        let until = clock::now() + REPEAT;
        while self.statuses.receiver().recv_deadline(until.min(give_up)).is_ok() {}
        until < give_up
    }
}

fn request(args: &Args) -> Result<Task> {
    let mut texts = args.parameters.clone();
    if args.action == "set-force" {
        let [force] = args.parameters.as_slice() else {
            bail!("set-force takes one value, the desired force in N; write `touchdown task set-force 12`");
        };
        texts = vec![format!("desired_force_n={force}")];
    }
    let mut values = [None; TaskParameters::COUNT];
    for text in &texts {
        let (name, value) = text
            .split_once('=')
            .with_context(|| format!("{text:?} is no change of a parameter; write parameter=value"))?;
        let bit = TaskParameters::NAMES.iter().position(|known| *known == name);
        let known = || TaskParameters::NAMES.join(", ");
        let bit = bit.with_context(|| {
            format!(
                "unknown parameter {name:?}; those that can change are {}",
                known()
            )
        })?;
        let value = value.parse().ok().filter(|value: &f64| value.is_finite());
        values[bit] =
            Some(value.with_context(|| format!("{text:?} gives no finite number; write {name}=1.5"))?);
    }
    let action = match args.action.as_str() {
        "start" => TaskAction::Start,
        "stop" => TaskAction::Stop,
        "tare" => TaskAction::Tare,
        "reset" => TaskAction::Reset,
        "release" => TaskAction::Release,
        _ => TaskAction::None,
    };
    // Each call is a sender of its own, on whichever host, whose answer is told from those to others by its count, too.
    let mut random = [0; 8];
    getrandom(&mut random, GetRandomFlags::empty())?;
    let sender = i64::from_le_bytes(random).rem_euclid(SENDERS) + 1;
    Ok(Task {
        stamp: Stamp {
            step: sender,
            utime: 0,
            boot_id: sender,
        },
        action,
        parameters: TaskParameters::from_values(values),
        ..Task::default()
    })
}

fn tell(args: &Args, status: &ControllerStatus) -> Result<ExitCode> {
    let parameter = usize::try_from(status.task_parameter)
        .ok()
        .and_then(|bit| TaskParameters::NAMES.get(bit).copied());
    let answer = experiment::program::words(status.task_answer.name());
    if args.json {
        print_json(&Report {
            command: "task",
            answer,
            parameter,
            value: status.task_limit,
        })?;
    } else {
        let about = parameter.map_or(String::new(), |name| format!(" {name}"));
        print(format_args!("{answer}:{about} {}\n", status.task_limit))?;
    }
    let accepted = status.task_answer == ParameterAnswer::Accepted;
    Ok(if accepted {
        ExitCode::SUCCESS
    } else {
        ExitCode::from(FAILED)
    })
}
