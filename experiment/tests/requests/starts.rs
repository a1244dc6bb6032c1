//! Starting, stopping, starting again; tare and reset.

use super::{Said, ask, change, scenario};
use spatial::ports::{ControllerPhase, Fault, ParameterAnswer, Task, TaskAction};

/// A task that does not begin by itself waits for its request; stopped in contact it keeps the object, and another start
/// finds it where it is.
#[test]
fn a_task_is_started_stopped_and_started_again() {
    let scenario = scenario("paper", &["task.starts_by_itself=false", "timing.duration_s=4.0"]);
    let tasks = [
        ask(1, 100, TaskAction::Start),
        ask(2, 500, TaskAction::Start),
        ask(3, 2200, TaskAction::Stop),
        ask(4, 2800, TaskAction::Start),
    ];
    let said = Said::of(&scenario, &tasks);
    let at = |tick| {
        let status = said.status_at(tick);
        (status.phase, status.task_step, status.task_answer)
    };
    // Before the tare there is nothing to start.
    assert_eq!(at(100), (ControllerPhase::Sync, 1, ParameterAnswer::WrongPhase));
    assert_eq!(at(400).0, ControllerPhase::Ready);
    assert_eq!(at(500), (ControllerPhase::Approach, 2, ParameterAnswer::Accepted));
    assert_eq!(at(2100).0, ControllerPhase::Settled);
    assert_eq!(at(2200), (ControllerPhase::Ready, 3, ParameterAnswer::Accepted));
    let pressed = |range: std::ops::Range<usize>| {
        said.force_n[range]
            .iter()
            .fold((f64::MAX, 0.0_f64), |(a, b), f| (a.min(*f), b.max(*f)))
    };
    let (least, most) = pressed(2200..2800);
    assert!(least > 9.0 && most < 11.0, "{least} to {most} N");
    assert_eq!(at(3500), (ControllerPhase::Settled, 4, ParameterAnswer::Accepted));
    let (least, most) = pressed(2800..4000);
    assert!(least > 7.0 && most < 13.0, "{least} to {most} N");
}

/// After a fault nothing moves until it is reset and started again, from where it is; and zero can be taken anew.
#[test]
fn a_fault_is_reset_and_the_task_started_again() {
    // Nothing is there until the object rises by 20 mm after 4 s.
    let scenario = scenario(
        "paper",
        &[
            "task.expected_height_m=0.015",
            "object.profile_time_s=[0.0,4.0,5.0]",
            "object.profile_height_m=[-0.02,-0.02,-0.008]",
            "timing.duration_s=9.0",
        ],
    );
    let tasks = [
        ask(1, 3000, TaskAction::Start),
        ask(2, 3100, TaskAction::Reset),
        ask(3, 3200, TaskAction::Tare),
        Task {
            action: TaskAction::Start,
            stamp: ask(4, 6000, TaskAction::Start).stamp,
            ..change(6000, 5, 0.0)
        },
    ];
    let said = Said::of(&scenario, &tasks);
    let at = |tick| {
        let status = said.status_at(tick);
        (status.phase, status.fault, status.task_answer)
    };
    assert_eq!(at(2900).1, Fault::NoContact);
    assert_eq!(
        at(3000),
        (
            ControllerPhase::Fault,
            Fault::NoContact,
            ParameterAnswer::FaultLatched
        )
    );
    assert_eq!(
        at(3100),
        (ControllerPhase::Ready, Fault::None, ParameterAnswer::Accepted)
    );
    assert_eq!(
        at(3200),
        (ControllerPhase::Sync, Fault::None, ParameterAnswer::Accepted)
    );
    assert_eq!(at(3600).0, ControllerPhase::Ready);
    assert_eq!(
        at(6000),
        (ControllerPhase::Approach, Fault::None, ParameterAnswer::Accepted)
    );
    assert_eq!(
        at(8900),
        (ControllerPhase::Settled, Fault::None, ParameterAnswer::Accepted)
    );
}
