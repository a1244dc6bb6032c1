//! The fault matrix as a table: `make faults`.

use std::process::ExitCode;
use tests::faults::{Injury, Moment, inflict};
use tests::site::Setting;

fn main() -> ExitCode {
    let only = std::env::args().nth(1).unwrap_or_default();
    println!(
        "{:38} {:9} {:24} {:24} {:>12} {:>14} {:>7}",
        "injury", "at", "robot", "controller", "stop ms", "force N", "again N"
    );
    for injury in Injury::all() {
        for moment in Moment::ALL {
            if !format!("{injury} {moment:?}").contains(&only) {
                continue;
            }
            match inflict(&Setting::default(), injury, moment) {
                Ok(outcome) => println!(
                    "{:38} {:9} {:24} {:24} {:>12} {:>14} {:>7}",
                    injury.to_string(),
                    format!("{moment:?}"),
                    format!("{:?}, {:?}", outcome.robot.0, outcome.robot.1),
                    format!("{:?}", outcome.controller),
                    outcome
                        .stop_ticks
                        .map_or("-".to_owned(), |[took, may]| format!("{took} <= {may}")),
                    format!("{:.0} ({:.0})", outcome.force_n[0], outcome.force_n[1]),
                    outcome
                        .again_n
                        .map_or_else(|state| format!("no: {state}"), |force_n| format!("{force_n:.1}"))
                ),
                Err(error) => println!("{injury:38} {moment:?}: {error}"),
            }
        }
    }
    ExitCode::SUCCESS
}
