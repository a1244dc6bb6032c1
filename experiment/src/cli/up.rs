//! `touchdown up`: this host's nodes of a cell, and what becomes of all of them.

use super::{FAILED, print};
use anyhow::{Context, Result};
use experiment::launch::{self, Cell};
use experiment::up::{CellConfig, Event, Watch, attend, same_host};
use node::clock;
use node::greeting::role_name;
use serde::Serialize;
use spatial::ports::Role;
use std::fmt::Write;
use std::path::PathBuf;
use std::process::ExitCode;

/// Start the nodes of a cell that belong to this host, say what to type on the others, and tell what becomes of all
/// nodes, until Ctrl-C or SIGTERM ends those that were started here
#[derive(clap::Args)]
#[command(after_help = "\
Nothing is restarted: a supervisor such as systemd does that, best node by node (--node, docs/lab.md).

Exit codes:
  0  a signal asked to end, and no node had died
  1  a node has died (the others go on until a signal comes), has ended with a fault, or can't be started
  2  wrong usage, cell or scenario")]
pub(crate) struct Args {
    /// The cell: a TOML file such as experiment/cells/two_hosts.toml, the same on all hosts
    #[arg(value_name = "CELL.toml")]
    cell: PathBuf,
    /// Name of this host in the file [default: what `uname -n` prints]
    #[arg(long, value_name = "NAME")]
    host: Option<String>,
    /// Start this one of the host's nodes alone: robot-sim, sensor-sim or controller
    #[arg(long, value_name = "NODE", value_parser = ["robot-sim", "sensor-sim", "controller"])]
    node: Option<String>,
    /// Print one JSON object a line instead of text
    #[arg(long)]
    json: bool,
}

/// What is told at the start.
#[derive(Serialize)]
struct Start<'a> {
    command: &'static str,
    scenario: &'a str,
    run_id: i64,
    url: &'a str,
    sim_url: &'a str,
    host: &'a str,
    nodes: Vec<&'static str>,
    others: Vec<Other<'a>>,
}

/// What is to be started elsewhere.
#[derive(Serialize)]
struct Other<'a> {
    host: &'a str,
    nodes: Vec<&'static str>,
    command: String,
}

/// The name of this host.
fn own_name() -> String {
    rustix::system::uname().nodename().to_string_lossy().into_owned()
}

fn names(roles: &[Role]) -> Vec<&'static str> {
    roles.iter().map(|role| role_name(*role)).collect()
}

pub(crate) fn run(args: &Args) -> Result<ExitCode> {
    let cell = CellConfig::load(&args.cell)?;
    let host = args.host.clone().unwrap_or_else(own_name);
    let only = [Role::Robot, Role::Sensor, Role::Controller]
        .into_iter()
        .find(|role| args.node.as_deref() == Some(role_name(*role)));
    let roles = cell.started_on(&host, only)?;

    let stop = node::shell::signals()?;
    let scratch = tempfile::tempdir().context("can't create a directory for the scenario")?;
    let scenario = match &cell.source.path {
        Some(path) => path.clone(),
        None => {
            let file = scratch.path().join(format!("{}.toml", cell.source.name));
            std::fs::write(&file, &cell.source.text)
                .with_context(|| format!("can't write {}", file.display()))?;
            file
        }
    };
    tell_start(args, &cell, &host, &roles)?;
    let commands = cell.commands(&roles, &launch::programs()?, &scenario);
    let nodes = Cell::of(&cell.url, cell.run_id, &commands)?;
    let watch = Watch::new(&cell, clock::now());
    // Without a reader of the lines the nodes go on.
    let well = attend(nodes, watch, &stop, |event| drop(tell(args, &event)))?;
    Ok(if well {
        ExitCode::SUCCESS
    } else {
        ExitCode::from(FAILED)
    })
}

fn tell_start(args: &Args, cell: &CellConfig, host: &str, roles: &[Role]) -> Result<()> {
    let others = cell
        .hosts()
        .into_iter()
        .filter(|other| !same_host(other, host))
        .map(|other| Other {
            host: other,
            nodes: names(&cell.on(other)),
            command: cell.command_on(other),
        });
    let start = Start {
        command: "up",
        scenario: &cell.source.name,
        run_id: cell.run_id,
        url: &cell.url,
        sim_url: &cell.sim_url,
        host,
        nodes: names(roles),
        others: others.collect(),
    };
    if args.json {
        return print(format_args!("{}\n", serde_json::to_string(&start)?));
    }
    let mut text = format!(
        "scenario {}, run {}, {}\nhere, on {host}: {}\n",
        start.scenario,
        start.run_id,
        start.url,
        start.nodes.join(", ")
    );
    for Other { host, nodes, command } in &start.others {
        writeln!(text, "on {host}, for {}: {command}", nodes.join(", "))?;
    }
    writeln!(
        text,
        "from any host: touchdown task start --cell {}",
        args.cell.display()
    )?;
    print(text)
}

fn tell(args: &Args, event: &Event) -> Result<()> {
    if args.json {
        return print(format_args!("{}\n", serde_json::to_string(event)?));
    }
    print(format_args!("{event}\n"))
}
