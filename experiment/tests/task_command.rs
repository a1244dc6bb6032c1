//! `touchdown task` against a controller that answers as it is told to.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "tests")]

mod common;

use common::touchdown;
use crossbeam::channel::{Sender, bounded};
use crossbeam::select;
use experiment::in_process;
use experiment::run_port::RunPort;
use lcmtypes::LcmBuilder;
use node::scenario::Scenario;
use spatial::ports::{ControllerStatus, ParameterAnswer, Task, TaskAction};
use std::thread::JoinHandle;
use std::time::Duration;

/// A controller on a port of its own: refuses the first `refusals` requests, repeats apart, because of a latched fault.
struct Controller {
    url: String,
    end: Sender<()>,
    /// The requests that it has heard.
    heard: JoinHandle<Vec<Task>>,
    _port: RunPort,
}

/// What a controller says first.
fn first_status() -> ControllerStatus {
    let scenario = Scenario::parse("short", "", &["timing.duration_s=0.1".to_owned()]).unwrap();
    let mut first = None;
    in_process::run(&scenario, |tick| {
        first = first.or(tick.controller.as_ref().map(|outputs| outputs.status));
    });
    first.unwrap()
}

impl Controller {
    fn start(refusals: usize) -> Self {
        let port = RunPort::free(Duration::ZERO).unwrap();
        let url = port.device_url();
        let mut builder = LcmBuilder::open(&url).unwrap();
        let tasks = builder.subscribe::<Task>(64);
        let link = builder.start().unwrap();
        let (end, ended) = bounded(0);
        let blank = first_status();
        let heard = std::thread::spawn(move || {
            let mut heard: Vec<Task> = Vec::new();
            loop {
                select! {
                    recv(tasks.receiver()) -> received => {
                        let task = received.unwrap().message;
                        if heard.last() != Some(&task) {
                            heard.push(task);
                        }
                        let answer = match heard.len() > refusals {
                            true => ParameterAnswer::Accepted,
                            false => ParameterAnswer::FaultLatched,
                        };
                        link.publish(&ControllerStatus {
                            task_step: task.stamp.step,
                            task_answer: answer,
                            task_parameter: -1,
                            ..blank
                        })
                        .unwrap();
                    }
                    recv(ended) -> _ => return heard,
                }
            }
        });
        Self {
            url,
            end,
            heard,
            _port: port,
        }
    }

    /// Ask it; exit code, what was said, and the requests.
    fn ask(self, arguments: &str) -> (i32, String, Vec<Task>) {
        let (code, stdout, stderr) = touchdown(&format!("task {arguments} --url {}", self.url));
        drop(self.end);
        (code, stdout + &stderr, self.heard.join().unwrap())
    }
}

#[test]
fn a_reset_is_asked_for_again_until_the_robot_has_cleared_its_fault() {
    let (code, said, heard) = Controller::start(3).ask("reset");
    assert_eq!((code, said.as_str()), (0, "accepted: 0\n"));
    assert_eq!(heard.len(), 4);
    assert!(heard.iter().all(|task| task.action == TaskAction::Reset));
    let steps: Vec<_> = heard.iter().map(|task| task.stamp.step).collect();
    assert!(steps.is_sorted_by(|a, b| a < b), "{steps:?}");
    assert!(
        heard
            .iter()
            .all(|task| task.stamp.boot_id == heard[0].stamp.boot_id)
    );
}

#[test]
fn a_reset_that_stays_refused_is_told_and_a_start_is_not_asked_for_again() {
    let (code, said, heard) = Controller::start(usize::MAX).ask("reset");
    assert_eq!((code, said.as_str()), (1, "fault latched: 0\n"));
    assert!(heard.len() > 1, "{heard:?}");
    let (code, said, heard) = Controller::start(usize::MAX).ask("start");
    assert_eq!((code, said.as_str(), heard.len()), (1, "fault latched: 0\n", 1));
}

#[test]
fn a_force_is_set_by_one_value() {
    let (code, said, heard) = Controller::start(0).ask("set-force 12");
    assert_eq!(code, 0, "{said}");
    let name = spatial::ports::TaskParameters::NAMES
        .iter()
        .position(|name| *name == "desired_force_n")
        .unwrap();
    assert_eq!(heard[0].parameters.values()[name], Some(12.0));
}

#[test]
fn nobody_s_answer_names_the_remedies() {
    let port = RunPort::free(Duration::ZERO).unwrap();
    let (code, _, stderr) = touchdown(&format!("task stop --url {}", port.device_url()));
    assert_eq!(code, 1, "{stderr}");
    assert!(
        stderr.contains(
            "within 2 s (without --key: one with a key does not answer); start one, or name its URL with --url (on another \
             host:"
        ),
        "{stderr}"
    );
}

#[test]
fn what_makes_no_sense_is_wrong_usage() {
    for (arguments, error) in [
        (
            "doctor --url udpm://x",
            "LCM URL \"udpm://x\": address \"x\" is no IPv4 address",
        ),
        ("doctor --cell none.toml", "the cell none.toml can't be read"),
        ("task stop --cell none.toml", "the cell none.toml can't be read"),
        ("task stop --url udpm://x", "address \"x\" is no IPv4 address"),
        (
            "task set-force",
            "set-force takes one value, the desired force in N; write",
        ),
        ("task set-force a", "\"desired_force_n=a\" gives no finite number"),
        ("task set force=3", "unknown parameter \"force\""),
        ("up none.toml", "the cell none.toml can't be read"),
        ("doctor --wait-s 3", "--peer"),
    ] {
        let (code, stdout, stderr) = touchdown(arguments);
        assert_eq!((code, stdout.as_str()), (2, ""), "{arguments}: {stderr}");
        assert!(stderr.contains(error), "{arguments}: {stderr}");
    }
}
