//! `touchdown bench bare`: a process that `bench network` starts, of which nobody else has use.

use anyhow::{Context, Result};
use clap::ValueEnum;
use experiment::wire_speed::bare::Bare;
use rustix::process::{Pid, Signal, getppid, set_parent_process_death_signal};
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
    set_parent_process_death_signal(Some(Signal::TERM)).context("can't follow the parent process")?;
    // It may have ended before the line above.
    if getppid().map(Pid::as_raw_pid) != Some(args.with_parent) {
        return Ok(ExitCode::SUCCESS);
    }
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
