//! The fault matrix as a table: `make faults`. An argument names the injuries that are tried by a part of their lines.

use spatial::ports::Role;
use std::process::ExitCode;
use tests::faults::{Injury, Moment, Outcome, inflict};
use tests::hosts::{Entered, Hosts, enter};
use tests::site::Setting;

const HEAD: &str = "\
What goes wrong with three programs in real time, when, and what comes of it.
stop: from the end of the last good command's horizon to the standstill, on the robot's clock, and what is promised;
force: the largest afterwards, and that of the first contact; again: once the injured program is started anew where it
was killed, after `touchdown task reset` and `start`.";
/// Rigid and elastic gears.
const SCENARIOS: [&str; 2] = ["arm", "elastic_arm"];

fn main() -> ExitCode {
    let only = std::env::args().nth(1).unwrap_or_default();
    let hosts = match enter(&[&only]) {
        Entered::Inside(hosts) => Some(hosts),
        Entered::Done(status) => return ExitCode::from(u8::from(!status.success())),
        Entered::Not(cause) => {
            eprintln!("all programs on one host, since {cause}");
            None
        }
    };
    let place = match hosts {
        Some(_) => "Three hosts: network namespaces, monotonic clocks days apart.",
        None => "One host.",
    };
    println!("{HEAD}\n{place}");
    let counts = SCENARIOS.map(|scenario| matrix(scenario, hosts.as_ref(), &only));
    let [tried, kept] = [0, 1].map(|i| counts.iter().map(|count| count[i]).sum::<usize>());
    println!("\n{tried} tried, what is promised was kept in {kept}");
    ExitCode::from(u8::from(kept < tried))
}

/// Every injury at every moment on `scenario`, as far as `only` is part of its line; how many, and in how many of them what
/// is promised was kept.
fn matrix(scenario: &str, hosts: Option<&Hosts>, only: &str) -> [usize; 2] {
    println!("\nScenario {scenario}");
    let titles = [
        "injury",
        "at",
        "robot",
        "controller",
        "stop ms",
        "force N",
        "again N",
        "kept",
    ];
    row(titles.map(str::to_owned));
    let (mut tried, mut kept) = (0, 0);
    let setting = Setting {
        scenario,
        hosts,
        ..Setting::default()
    };
    for injury in Injury::all() {
        for moment in Moment::ALL {
            if !format!("{injury} {moment:?}").contains(only) {
                continue;
            }
            tried += 1;
            match inflict(&setting, injury, moment) {
                Ok(outcome) => {
                    let lost = outcome.broken();
                    kept += usize::from(lost.is_none());
                    row(cells(injury, moment, &outcome, lost));
                }
                Err(error) => println!("{injury}, {moment:?}: {error}"),
            }
        }
    }
    [tried, kept]
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
