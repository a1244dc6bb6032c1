//! Programs and requests in processes over LCM: the same bits as in one process, watched on `CONTROLLER_STATUS`.

use experiment::program::{results, succeeded};
use experiment::transcript::{self, Entry};
use experiment::{launch, scenarios};
use lcmtypes::LcmBuilder;
use node::clock;
use spatial::ports::{
    ControllerPhase, ControllerStatus, NodeStatus, ParameterAnswer, Role, Stamp, Task, TaskAction,
    TaskParameters,
};
use std::collections::BTreeSet;
use std::fs;
use std::time::Duration;
use tests::{Bench, touchdown};

const LIMIT: Duration = Duration::from_secs(10);

/// A whole example in processes; its statuses are heard on the network, too.
fn example(name: &str) -> (Vec<Entry>, Vec<ControllerStatus>) {
    let bench = Bench::of(name, &[]).unwrap();
    let mut link = LcmBuilder::open(&bench.plan.wiring.watch).unwrap();
    let heard = link.subscribe::<ControllerStatus>(100_000);
    let _link = link.start().unwrap();
    let said = launch::run(&bench.plan, &crossbeam::channel::never(), |_| ()).unwrap();
    let expected = transcript::in_process(&bench.scenario).unwrap();
    assert_eq!(transcript::first_difference(&said, &expected), None);
    let steps = results(&bench.scenario, transcript::messages::<ControllerStatus>(&said));
    assert!(succeeded(&steps), "{}", experiment::program::Steps(&steps));
    let heard = heard.receiver().try_iter().map(|received| received.message);
    (said, heard.collect())
}

/// All steps of the `count` that a program has are seen by whoever watches.
fn assert_watched(statuses: &[ControllerStatus], count: i32, phases: &[ControllerPhase]) {
    let steps: BTreeSet<i32> = statuses.iter().map(|status| status.program_step).collect();
    assert_eq!(steps, (-1..count).collect());
    for phase in phases {
        assert!(statuses.iter().any(|status| status.phase == *phase), "{phase:?}");
    }
}

#[test]
fn a_row_of_screws() {
    use ControllerPhase::{Approach, Contact, Move, Retract, Settled};
    let (_, heard) = example("screws");
    assert_watched(&heard, 4, &[Move, Approach, Contact, Settled, Retract]);
}

#[test]
fn a_peg_in_a_chamfered_hole() {
    use ControllerPhase::{Approach, Contact, Retract, Search, Settled};
    let (_, heard) = example("peg");
    assert_watched(&heard, 6, &[Approach, Contact, Settled, Search, Retract]);
}

fn task(step: i64, tick: i64, action: TaskAction, parameters: TaskParameters) -> Task {
    Task {
        stamp: Stamp {
            step,
            utime: tick * spatial::TICK_US,
            boot_id: 77,
        },
        action,
        parameters,
        ..Task::default()
    }
}

/// Requests that are there in time take effect at their ticks, as in one process: a start, another force and filter gain in
/// contact, one that is refused, a stop. The loop's margins are known before the start, and anew in the cycle after.
#[test]
fn requests_take_effect_at_their_ticks() {
    let force = |force_n| TaskParameters {
        desired_force_n: Some(force_n),
        ..TaskParameters::default()
    };
    let slower = TaskParameters {
        object_filter_gain: Some(0.005),
        ..force(14.0)
    };
    let tasks = [
        task(1, 300, TaskAction::Start, TaskParameters::default()),
        task(2, 700, TaskAction::None, slower),
        task(3, 720, TaskAction::None, force(1e5)),
        task(4, 850, TaskAction::Stop, TaskParameters::default()),
    ];
    let changes = [
        "task.starts_by_itself=false",
        "task.start_position_m=[0, 0, 0.0115]",
    ];
    let bench = Bench::new(&changes).unwrap();
    let never = crossbeam::channel::never();

    // The robot is stopped until the controller has the requests: it answers whoever greets it as the robot does.
    let mut link = LcmBuilder::open(&bench.plan.wiring.watch).unwrap();
    let peers = link.subscribe::<NodeStatus>(64);
    let link = link.start().unwrap();
    let mut cell = launch::Cell::start_with(&bench.plan, || {
        let greeting = node::health::Health::new(
            Role::Robot,
            node::health::hello(&bench.scenario, bench.plan.run_id),
        );
        let give_up = clock::now() + LIMIT;
        while clock::now() < give_up {
            link.publish(&greeting.status()).unwrap();
            let answer = peers.receiver().recv_timeout(Duration::from_millis(50));
            if answer.is_ok_and(|it| it.message.role == Role::Controller) {
                tasks.iter().for_each(|task| link.publish(task).unwrap());
                return;
            }
        }
    })
    .unwrap();
    cell.watch(&never, |_| ()).unwrap();
    cell.stop().unwrap();
    let said = transcript::from_logs(&bench.plan.records()).unwrap();
    let expected = transcript::in_process_with(&bench.scenario, &tasks).unwrap();
    assert_eq!(transcript::first_difference(&said, &expected), None);

    let at = |tick: i64| {
        transcript::messages::<ControllerStatus>(&said)
            .find(|it| it.stamp.step == tick)
            .unwrap()
    };
    assert_eq!(
        (at(296).phase, at(300).phase),
        (ControllerPhase::Ready, ControllerPhase::Approach)
    );
    let answer = |tick| (at(tick).task_step, at(tick).task_answer);
    assert_eq!(answer(700), (2, ParameterAnswer::Accepted));
    assert_eq!(answer(720), (3, ParameterAnswer::OutOfRange));
    assert!(at(720).task_limit > 100.0 && at(720).task_limit < 200.0);
    assert_eq!(
        (answer(852), at(852).phase),
        ((4, ParameterAnswer::Accepted), ControllerPhase::Ready)
    );
    assert!(at(848).desired_wrench.force.z > 12.0);
    let margin = |tick| at(tick).gain_margin;
    assert!(margin(0) == 0.0 && margin(296) > 8.0, "{}", margin(296));
    assert!(
        margin(700) == margin(296) && margin(704) > 1.5 * margin(296),
        "{}",
        margin(704)
    );
}

/// `touchdown run` of a program prints a result per step; a failed one is exit code 1.
#[test]
fn the_command_tells_a_result_per_step() {
    let directory = tempfile::tempdir().unwrap();
    let run = |settings: &[&str]| {
        let mut command = touchdown();
        command
            .args(["run", "screws", "--json", "--out"])
            .arg(directory.path());
        settings.iter().for_each(|setting| {
            command.args(["--set", setting]);
        });
        let output = command.output().unwrap();
        let report: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        let steps = report["programs"][0]["steps"].as_array().unwrap().clone();
        (output.status.code(), steps)
    };
    let (code, steps) = run(&[]);
    assert_eq!((code, steps.len()), (Some(0), 16));
    assert!(steps.iter().all(|step| step["result"] == "done"));
    assert!(
        (steps[2]["end_force_n"].as_f64().unwrap() - 15.0).abs() < 0.3,
        "{}",
        steps[2]
    );
    assert!(fs::exists(directory.path().join("proposed.csv")).unwrap());

    // The plate is gone: each screw is missing, and each is left out.
    let (code, steps) = run(&["object.height_m=-0.02", "timing.duration_s=7.0"]);
    assert_eq!(code, Some(1));
    let missing = steps
        .iter()
        .filter(|step| step["kind"] == "approach" && step["result"] == "search");
    assert!(missing.count() >= 3, "{steps:?}");
    assert!(scenarios::names().any(|name| name == "screws"));
}
