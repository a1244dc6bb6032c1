//! `sensor-sim`: the simulated sensor, tool and contact as a node; in lockstep it follows the robot.

mod shell;

use clap::Parser;
use std::process::ExitCode;

/// Simulated compliant sensor, tool and contact. It answers robot-sim tick by tick until SIGTERM, SIGINT or SIGHUP.
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
