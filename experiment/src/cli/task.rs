//! `touchdown task`: ask the controller for something while it runs, and tell its answer.

use super::{FAILED, print, print_json};
use anyhow::{Context, Result, bail};
use lcmtypes::LcmBuilder;
use node::clock;
use serde::Serialize;
use spatial::ports::{ControllerStatus, ParameterAnswer, Stamp, Task, TaskAction, TaskParameters};
use std::process::ExitCode;
use std::time::Duration;

/// Ask the running controller: start, stop, tare, reset, or a parameter's new value
#[derive(clap::Args)]
pub(crate) struct Args {
    /// What to do; with `set` only the parameters change
    #[arg(value_parser = ["start", "stop", "tare", "reset", "set"])]
    action: String,
    /// Parameters and their new values, such as desired_force_n=12
    #[arg(value_name = "PARAMETER=VALUE")]
    parameters: Vec<String>,
    /// LCM URL of the device channels
    #[arg(long, default_value = "udpm://239.255.76.67:7667?ttl=0")]
    url: String,
    /// Print one JSON object instead of a line
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct Report {
    command: &'static str,
    answer: String,
    parameter: Option<&'static str>,
    /// The limit that was left, or the value that the parameter will have, in its unit.
    value: f64,
}

/// How long to wait for an answer.
const PATIENCE: Duration = Duration::from_secs(2);
/// How long until the request is repeated.
const REPEAT: Duration = Duration::from_millis(50);

pub(crate) fn run(args: &Args) -> Result<ExitCode> {
    let task = request(args)?;
    let mut link = LcmBuilder::open(&args.url)?;
    let statuses = link.subscribe::<ControllerStatus>(64);
    let link = link.start()?;
    let give_up = clock::now() + PATIENCE;
    while clock::now() < give_up {
        // A repeated request is the same one to the controller.
        link.publish(&task)?;
        let until = clock::now() + REPEAT;
        while let Ok(received) = statuses.receiver().recv_deadline(until) {
            if received.message.task_step == task.stamp.step {
                return tell(args, &received.message);
            }
        }
    }
    bail!(
        "no controller has answered on {} within {} s; start one, or name its URL with --url",
        args.url,
        PATIENCE.as_secs()
    )
}

fn request(args: &Args) -> Result<Task> {
    let mut values = [None; TaskParameters::COUNT];
    for text in &args.parameters {
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
        _ => TaskAction::None,
    };
    // Each call is a sender of its own, whose answer is told from those to others by its count, too.
    let sender = i64::from(std::process::id());
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
