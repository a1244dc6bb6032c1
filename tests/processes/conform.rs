//! Drivers that are none of the three programs: the skeleton of a robot's driver and the sensor in Python, by the contract alone.

use crate::python;
use lcmtypes::LcmBuilder;
use node::{clock, key_file};
use serde_json::Value;
use spatial::ports::{ControllerPhase, ControllerStatus};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use tests::site::LONG;
use tests::{Bench, programs, touchdown};

/// A machine that is busy may hold the check's commands up; the gap that the robot bridges, s.
const GAP_S: &str = "0.25";

/// A process; dropping it ends it.
struct Process(Child);

impl Process {
    fn start(command: &mut Command) -> Self {
        Self(command.stderr(Stdio::null()).spawn().unwrap())
    }

    /// One that reads the scenario of `bench`.
    fn node(bench: &Bench, program: &str, arguments: &[&str]) -> Self {
        let mut command = Command::new(programs().join(program));
        command
            .arg("--scenario")
            .arg(&bench.plan.scenario)
            .args(["--url", &bench.plan.wiring.watch])
            .args(["--with-parent", &std::process::id().to_string()]);
        for change in &bench.plan.overrides {
            command.args(["--set", change]);
        }
        command.args(arguments);
        Self::start(&mut command)
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

fn bench() -> Bench {
    let gap = format!("robot.command_gap_s={GAP_S}");
    Bench::of(
        "paper",
        &["timing.mode=realtime", "task.starts_by_itself=false", &gap],
    )
    .unwrap()
}

fn conform(bench: &Bench, arguments: &[&str]) -> Output {
    let mut command = touchdown();
    command.arg("conform").args(arguments);
    command
        .args(["--url", &bench.plan.wiring.watch])
        .output()
        .unwrap()
}

/// All rules are kept, and nothing is left that was not seen.
fn all_kept(output: &Output) {
    let text = String::from_utf8_lossy(&output.stdout);
    let error = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{text}{error}");
    let report: Value = serde_json::from_str(&text).unwrap();
    assert_eq!(
        (&report["broken"], &report["not_seen"]),
        (&0.into(), &0.into()),
        "{text}"
    );
    assert!(report["kept"].as_u64() > Some(12), "{text}");
}

fn repository() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../lcmtypes")
}

pub(crate) fn lcm_gen() -> PathBuf {
    match std::env::var_os("LCM_PREFIX").filter(|prefix| !prefix.is_empty()) {
        Some(prefix) => Path::new(&prefix).join("bin/lcm-gen"),
        None => PathBuf::from("lcm-gen"),
    }
}

#[test]
fn the_skeleton_of_a_robots_driver_keeps_the_contract() {
    let bench = bench();
    let _driver = Process::node(&bench, "examples/robot_driver", &[]);
    let arguments = ["robot", "--move", "--command-gap-s", GAP_S, "--json"];
    all_kept(&conform(&bench, &arguments));
}

/// Both drivers with the key of a cell.
#[test]
fn under_a_key_both_drivers_sign_and_take_what_is_signed() {
    let bench = bench();
    let Some(python) = python_with_types(&bench) else {
        return;
    };
    let path = bench.directory.path().join("cell.key");
    key_file::create(&path).unwrap();
    let key = ["--key", path.to_str().unwrap()];
    {
        let _sensor = sensor(&bench, &python, &key);
        let arguments = ["sensor", "--listen-s", "1.5", "--json"];
        all_kept(&conform(&bench, &[&arguments[..], &key].concat()));
    }
    let _driver = Process::node(&bench, "examples/robot_driver", &key);
    let arguments = ["robot", "--move", "--command-gap-s", GAP_S, "--json"];
    all_kept(&conform(&bench, &[&arguments[..], &key].concat()));
}

/// A Python that has LCM, and the types in the directory of `bench`; `None`, said loudly: there is none.
pub(super) fn python_with_types(bench: &Bench) -> Option<PathBuf> {
    let python = python::python()
        .inspect_err(|error| eprintln!("SKIPPED: no Python with LCM: {error}"))
        .ok()?;
    python::generate(&lcm_gen(), &repository().join("types"), bench.directory.path()).unwrap();
    Some(python)
}

/// The skeleton in Python, whose types are generated in the directory of `bench`.
fn sensor(bench: &Bench, python: &Path, arguments: &[&str]) -> Process {
    let mut command = Command::new(python);
    command.arg("-B").arg(repository().join("examples/sensor.py"));
    command.args(["--url", &bench.plan.wiring.watch, "--types"]);
    command.arg(bench.directory.path()).args(arguments);
    Process::start(&mut command)
}

/// With a controller and the skeleton as robot: clocks are known, the tare is done, and every rule is kept.
#[test]
fn a_sensor_in_python_keeps_the_contract_and_is_worked_with() {
    let bench = bench();
    let Some(python) = python_with_types(&bench) else {
        return;
    };
    let mut link = LcmBuilder::open(&bench.plan.wiring.watch).unwrap();
    let statuses = link.subscribe::<ControllerStatus>(64);
    let _link = link.start().unwrap();
    let _sensor = sensor(&bench, &python, &[]);
    let _driver = Process::node(&bench, "examples/robot_driver", &[]);
    let _controller = Process::node(&bench, "controller", &[]);
    let give_up = clock::now() + LONG;
    let ready = std::iter::from_fn(|| statuses.receiver().recv_deadline(give_up).ok())
        .any(|received| received.message.phase == ControllerPhase::Ready);
    assert!(ready, "the controller is not ready");
    all_kept(&conform(&bench, &["sensor", "--json"]));

    let refused = conform(&bench, &["robot"]);
    let message = String::from_utf8_lossy(&refused.stderr);
    assert_eq!(refused.status.code(), Some(1), "{message}");
    assert!(
        message.contains("a controller (boot id") && message.contains("stop it first"),
        "{message}"
    );
}

#[test]
fn nobody_keeps_no_contract() {
    let bench = bench();
    let output = conform(&bench, &["robot", "--listen-s", "0.2"]);
    let text = String::from_utf8_lossy(&output.stdout);
    assert_eq!(output.status.code(), Some(1), "{text}");
    assert!(
        text.contains("BROKEN    ROBOT_STATE every T") && text.contains("remedy: publish ROBOT_STATE"),
        "{text}"
    );
}
