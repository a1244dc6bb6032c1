//! `robot-sim`: the simulated robot as a node; in lockstep the clock master.

mod shell;

use clap::Parser;
use std::process::ExitCode;

/// Simulated position controlled robot. It waits for sensor-sim and controller, runs the scenario in lockstep with
/// them, and goes on publishing its status until SIGTERM, SIGINT or SIGHUP.
#[derive(Parser)]
#[command(version)]
struct Arguments {
    #[command(flatten)]
    node: node::shell::Flags,
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    node::shell::run(|| shell::run(&arguments.node))
}
