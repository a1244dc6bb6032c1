//! `controller`: the control scheme as a node; in lockstep it follows the robot.

mod shell;

use clap::Parser;
use std::process::ExitCode;

/// Force controller. It answers each ROBOT_STATE, once what the sensors say at the same tick is there, with a command,
/// until SIGTERM, SIGINT or SIGHUP.
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
