//! What goes wrong at the start or in the middle ends with a clear message, and nothing is left running.

use experiment::launch::{self, Cell, LaunchError};
use lcmtypes::LcmBuilder;
use rustix::process::Signal;
use spatial::ports::{Fault, Role};
use tests::{Bench, processes_naming, signal};

/// An experiment that lasts until somebody ends it.
fn endless() -> Bench {
    Bench::new(&["timing.duration_s=86400"]).unwrap()
}

/// Watch a cell that is hurt once its robot has reached tick 250; the error it ends with.
fn hurt(bench: &Bench, mut injure: impl FnMut(&Cell)) -> LaunchError {
    let never = crossbeam::channel::never();
    let mut cell = Cell::start(&bench.plan).unwrap();
    let (sender, reached) = crossbeam::channel::bounded(1);
    // Interrupt the watch once, to be able to use the cell.
    let progress = |tick: i64| {
        if tick >= 250 {
            let _ = sender.try_send(());
        }
    };
    assert!(matches!(
        cell.watch(&reached, progress),
        Err(LaunchError::Interrupted)
    ));
    injure(&cell);
    let error = cell.watch(&never, |_| ()).unwrap_err();
    drop(cell);
    assert_eq!(
        processes_naming(bench.directory.path().to_str().unwrap()),
        Vec::<i32>::new()
    );
    error
}

#[test]
fn a_killed_node_names_itself() {
    for (role, name) in [
        (Role::Robot, "robot-sim"),
        (Role::Sensor, "sensor-sim"),
        (Role::Controller, "controller"),
    ] {
        let error = hurt(&endless(), |cell| {
            signal(cell.process_id(role).unwrap(), Signal::KILL)
        });
        let message = error.to_string();
        assert!(
            message.starts_with(&format!("{name} died (signal 9) at tick ")),
            "{message}"
        );
    }
}

#[test]
fn a_frozen_peer_is_named_by_the_robot() {
    for role in [Role::Sensor, Role::Controller] {
        let error = hurt(&endless(), |cell| {
            signal(cell.process_id(role).unwrap(), Signal::STOP)
        });
        assert!(
            matches!(error, LaunchError::Faulty { role: Role::Robot, fault: Fault::PeerSilent, peer, .. } if peer == role),
            "{error}"
        );
    }
}

/// Whoever hears the other first says so, or that its nodes refuse each other; nobody takes the other's end for its
/// own.
#[test]
fn two_runs_on_the_same_port_are_refused_by_run_id() {
    let first = endless();
    let mut second = Bench::new(&[]).unwrap();
    second.plan.wiring = first.plan.wiring.clone();
    let never = crossbeam::channel::never();
    let _running = Cell::start(&first.plan).unwrap();
    let error = Cell::start(&second.plan)
        .unwrap()
        .watch(&never, |_| ())
        .unwrap_err();
    assert!(
        matches!(
            error,
            LaunchError::Foreign { .. }
                | LaunchError::Faulty {
                    fault: Fault::HelloMismatch,
                    ..
                }
        ),
        "{error}"
    );
}

#[test]
fn the_end_of_another_run_is_not_taken_for_the_own() {
    let bench = endless();
    let others = LcmBuilder::open(&bench.plan.wiring.watch)
        .unwrap()
        .start()
        .unwrap();
    let hello = node::health::hello(&bench.scenario, bench.plan.run_id + 1);
    let mut finished = node::health::Health::new(Role::Robot, hello);
    finished.finish();
    let mut cell = Cell::start(&bench.plan).unwrap();
    others.publish(&finished.status()).unwrap();
    let error = cell.watch(&crossbeam::channel::never(), |_| ()).unwrap_err();
    assert_eq!(
        error.to_string(),
        format!(
            "another run's robot-sim (run id {}) is on this port; end it, or choose another --port",
            bench.plan.run_id + 1
        )
    );
}

#[test]
fn a_missing_program_is_named() {
    let mut bench = Bench::new(&[]).unwrap();
    let programs = tempfile::tempdir().unwrap();
    std::os::unix::fs::symlink(
        bench.plan.programs.join("sensor-sim"),
        programs.path().join("sensor-sim"),
    )
    .unwrap();
    bench.plan.programs = programs.path().to_owned();
    let error = launch::run(&bench.plan, &crossbeam::channel::never(), |_| ())
        .unwrap_err()
        .to_string();
    assert!(
        error.starts_with("can't start ") && error.contains("controller"),
        "{error}"
    );
    assert_eq!(
        processes_naming(bench.directory.path().to_str().unwrap()),
        Vec::<i32>::new()
    );
}
