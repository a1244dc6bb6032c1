//! The fault matrix as a table: `make faults`. An argument names the injuries that are tried by a part of their lines.

use spatial::ports::Role;
use std::process::ExitCode;
use tests::faults::{Injury, Moment, Outcome, inflict};
use tests::site::Setting;

fn main() -> ExitCode {
    let only = std::env::args().nth(1).unwrap_or_default();
    println!(
        "What goes wrong with three programs in real time (scenario paper), when, and what comes of it."
    );
    println!(
        "stop: from the end of the last good command's horizon to the standstill, on the robot's clock, and what is"
    );
    println!(
        "promised; force: the largest afterwards, and that of the first contact; again: once the injured program is"
    );
    println!("started anew where it was killed, after `touchdown task reset` and `start`.");
    println!();
    row([
        "injury",
        "at",
        "robot",
        "controller",
        "stop ms",
        "force N",
        "again N",
        "kept",
    ]
    .map(str::to_owned));
    let (mut tried, mut broken) = (0, 0);
    for injury in Injury::all() {
        for moment in Moment::ALL {
            if !format!("{injury} {moment:?}").contains(&only) {
                continue;
            }
            tried += 1;
            match inflict(&Setting::default(), injury, moment) {
                Ok(outcome) => {
                    let lost = outcome.broken();
                    broken += usize::from(lost.is_some());
                    row(cells(injury, moment, &outcome, lost));
                }
                Err(error) => {
                    broken += 1;
                    println!("{injury}, {moment:?}: {error}");
                }
            }
        }
    }
    println!("\n{tried} tried, what is promised was kept in {}", tried - broken);
    ExitCode::from(u8::from(broken > 0))
}

fn cells(injury: Injury, moment: Moment, outcome: &Outcome, lost: Option<String>) -> [String; 8] {
    let stop = |[took, may]: [i64; 2]| format!("{took} ({may})");
    let state = |mode: &str, fault: &str| match fault {
        "None" => mode.to_owned(),
        _ => fault.to_owned(),
    };
    let (mode, fault) = outcome.robot;
    let gone = |role, said: String| {
        if injury == Injury::Kill(role) {
            "gone".to_owned()
        } else {
            said
        }
    };
    [
        injury.to_string(),
        format!("{moment:?}"),
        gone(Role::Robot, state(mode.name(), fault.name())),
        gone(Role::Controller, state("works", outcome.controller.name())),
        outcome.stop_ticks.map_or("-".to_owned(), stop),
        format!("{:.0} ({:.0})", outcome.force_n[0], outcome.force_n[1]),
        outcome
            .again_n
            .as_ref()
            .map_or("-".to_owned(), |force_n| format!("{force_n:.1}")),
        lost.map_or("yes".to_owned(), |what| format!("NO: {what}")),
    ]
}

fn row([injury, at, robot, controller, stop, force, again, kept]: [String; 8]) {
    println!("{injury:35} {at:9} {robot:11} {controller:12} {stop:>10} {force:>10} {again:>8}  {kept}");
}
