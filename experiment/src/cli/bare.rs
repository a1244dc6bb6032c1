//! `touchdown bench bare`: a process that `bench network` starts, of which nobody else has use.

use anyhow::Result;
use clap::ValueEnum;
use experiment::wire_speed::bare::Bare;
use spatial::ports::Role;
use std::process::ExitCode;
use std::time::Duration;

/// Say as much as a program, and nothing
#[derive(clap::Args)]
pub(crate) struct Args {
    role: Program,
    #[arg(long)]
    port: u16,
    #[arg(long)]
    period_ticks: i64,
    #[arg(long)]
    spin_ns: u64,
    #[arg(long)]
    with_parent: i32,
}

#[derive(Clone, Copy, ValueEnum)]
enum Program {
    RobotSim,
    SensorSim,
    Controller,
}

pub(crate) fn run(args: &Args) -> Result<ExitCode> {
    node::shell::follow(args.with_parent)?;
    let role = match args.role {
        Program::RobotSim => Role::Robot,
        Program::SensorSim => Role::Sensor,
        Program::Controller => Role::Controller,
    };
    let bare = Bare {
        role,
        port: args.port,
        period_ticks: args.period_ticks.max(1),
        spin: Duration::from_nanos(args.spin_ns),
    };
    bare.run()?;
    Ok(ExitCode::SUCCESS)
}
