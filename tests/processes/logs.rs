//! Logs of ours for others, and theirs for us: lcm-logger, lcm-logplayer, Python's lcm.

use crate::python;
use experiment::launch;
use experiment::log::Log;
use experiment::run_port::RunPort;
use experiment::transcript;
use lcmtypes::{EventLogReader, LcmBuilder, Message};
use node::clock;
use rustix::process::Signal;
use serde_json::Value;
use spatial::ports::{ControllerStatus, RobotState};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::Duration;
use tests::{Bench, signal, touchdown};

const LIMIT: Duration = Duration::from_secs(20);

/// LCM's program `name`: of the LCM that this was built with, or the system's.
fn lcm_program(name: &str) -> PathBuf {
    let own = std::env::var_os("LCM_PREFIX").map(|prefix| Path::new(&prefix).join("bin").join(name));
    own.filter(|program| program.exists())
        .unwrap_or_else(|| name.into())
}

/// A program of LCM's that is ended when it is dropped.
struct Lcm(Child);

impl Lcm {
    fn start(command: &mut Command) -> Self {
        let child = command.stdout(Stdio::null()).stderr(Stdio::null()).spawn();
        Self(child.expect("apt-get install liblcm-bin"))
    }
}

impl Drop for Lcm {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// What `touchdown` answers as JSON, and its exit code.
fn answer(command: &str, log: &Path, arguments: &[&str]) -> (Value, i32, String) {
    let mut touchdown = touchdown();
    let output = touchdown
        .arg(command)
        .arg(log)
        .arg("--json")
        .args(arguments)
        .output()
        .unwrap();
    let told = String::from_utf8(output.stderr).unwrap();
    let json = serde_json::from_slice(&output.stdout).unwrap_or_else(|error| panic!("{error}: {told}"));
    (json, output.status.code().unwrap(), told)
}

fn missing(analysis: &Value) -> BTreeMap<String, i64> {
    let channels = analysis["channels"].as_array().unwrap().iter();
    channels
        .map(|it| {
            (
                it["channel"].as_str().unwrap().to_owned(),
                it["missing"].as_i64().unwrap(),
            )
        })
        .collect()
}

/// The device channels of a run as lcm-logger hears them, in a cell with a suffix: analysed without `SIM_*`, and replayed bit
/// for bit.
#[test]
fn what_lcm_logger_records_of_a_run_is_analysed_and_replayed() {
    let mut bench = Bench::new(&[]).unwrap();
    let log = bench.directory.path().join("logger.lcmlog");
    let url = &bench.plan.wiring.watch.clone();
    let wiring = &mut bench.plan.wiring;
    for url in wiring.device.iter_mut().chain([&mut wiring.watch]) {
        url.push_str("&suffix=_B");
    }
    let mut logger = Lcm::start(
        Command::new(lcm_program("lcm-logger"))
            .args(["--lcm-url", url, "--flush-interval", "10", "--force"])
            .arg(&log),
    );
    // It says nothing when it listens: it does once something is in its file.
    let link = LcmBuilder::open(url).unwrap().start().unwrap();
    let give_up = clock::now() + LIMIT;
    let heard = || std::fs::metadata(&log).is_ok_and(|about| about.len() > 0);
    let never = crossbeam::channel::never::<()>();
    while !heard() {
        assert!(clock::now() < give_up, "lcm-logger hears nothing");
        link.publish_raw("PROBE", b"!").unwrap();
        let _ = never.recv_timeout(Duration::from_millis(20));
    }
    let said = launch::run(&bench.plan, &crossbeam::channel::never(), |_| ()).unwrap();
    signal(logger.0.id(), Signal::INT);
    assert!(logger.0.wait().unwrap().success());

    let scenario = bench.directory.path().join("scenario.toml");
    let mut arguments = vec!["--scenario", scenario.to_str().unwrap()];
    for change in &bench.plan.overrides {
        arguments.extend(["--set", change]);
    }
    let output = touchdown()
        .arg("analyse")
        .arg(&log)
        .args(&arguments)
        .output()
        .unwrap();
    let told = String::from_utf8_lossy(&output.stderr);
    assert!(
        told.contains("those that end in _B are read with --suffix _B"),
        "{told}"
    );
    arguments.extend(["--suffix", "_B"]);
    let (analysis, code, told) = answer("analyse", &log, &arguments);
    assert_eq!(code, 0, "{told}");
    // LCM's own LCM_SELF_TEST may be another one.
    let foreign = analysis["foreign_channels"].as_array().unwrap();
    assert!(foreign.contains(&"PROBE".into()), "{foreign:?}");
    assert_eq!(analysis["force_from"], "controller");
    let missing = missing(&analysis);
    assert!(
        !missing.keys().any(|channel| channel.starts_with("SIM_")),
        "{missing:?}"
    );
    let (replay, code, told) = answer("replay", &log, &arguments);
    let states = transcript::messages::<RobotState>(&said).count();
    // The recorder may lose what the programs have repeated to each other.
    let whole = missing.values().all(|missing| *missing == 0);
    if whole {
        assert_eq!(code, 0, "{told}");
        assert_eq!(replay["equal_commands"].as_u64(), Some(states as u64), "{told}");
    }
    assert!(whole || replay["stopped"].is_string(), "{told}");
    assert_eq!(replay["difference"], Value::Null);
}

/// A log of a run, as `touchdown run --record` writes it.
fn recorded(directory: &Path) -> PathBuf {
    let mut command = touchdown();
    let output = command
        .args(["run", "paper", "--laws", "proposed", "--record", "--out"])
        .arg(directory)
        .args([
            "--set",
            "task.start_position_m=[0.0,0.0,0.0165]",
            "--set",
            "timing.duration_s=2.4",
        ])
        .output()
        .unwrap();
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    directory.join("proposed.lcmlog")
}

/// Played, read by Python, analysed, replayed, and what becomes of it when it is cut or of another version.
#[test]
fn what_is_recorded_is_played_read_and_replayed() {
    let directory = tempfile::tempdir().unwrap();
    let log = recorded(directory.path());
    let (analysis, code, told) = answer("analyse", &log, &[]);
    assert_eq!((code, told.as_str()), (0, ""));
    assert_eq!(analysis["force_from"], "truth");
    assert!(analysis["metrics"]["peak_n"].as_f64().unwrap() > 10.0);
    assert!(missing(&analysis).values().all(|missing| *missing == 0));
    let (replay, code, told) = answer("replay", &log, &[]);
    assert_eq!((code, told.as_str()), (0, ""));
    assert_eq!(replay["equal_commands"].as_u64(), Some(601));
    plays(&log);
    python_reads(directory.path(), &log);
    damaged(&log);
}

fn plays(log: &Path) {
    let port = RunPort::free(Duration::ZERO).unwrap();
    let url = port.device_url();
    let mut link = LcmBuilder::open(&url).unwrap();
    let statuses = link.subscribe::<ControllerStatus>(4096);
    let _link = link.start().unwrap();
    let mut player = Lcm::start(
        Command::new(lcm_program("lcm-logplayer"))
            .args(["--speed", "4", "--lcm-url", &url])
            .arg(log),
    );
    let give_up = clock::now() + LIMIT;
    let mut last = None;
    while let Ok(received) = statuses.receiver().recv_deadline(give_up) {
        last = Some(received.message);
        if received.message.stamp.step == 2400 {
            break;
        }
    }
    let said = Log::open(log).unwrap().said();
    assert_eq!(last, transcript::messages::<ControllerStatus>(&said).last());
    assert!(player.0.wait().unwrap().success());
}

fn python_reads(directory: &Path, log: &Path) {
    let types = Path::new(env!("CARGO_MANIFEST_DIR")).join("../lcmtypes/types");
    let program = "import sys; sys.path.insert(0, sys.argv[1]); import lcm, touchdown\n\
                   events = list(lcm.EventLog(sys.argv[2], 'r'))\n\
                   truths = [touchdown.sim_truth_t.decode(e.data) for e in events if e.channel == 'SIM_TRUTH']\n\
                   assert [t.step for t in truths] == list(range(2401))\n\
                   assert [e.timestamp for e in events] == sorted(e.timestamp for e in events)\n\
                   print(len(events), max(t.truth_contact_force_peak_n for t in truths))";
    let told = python::generate(&lcm_program("lcm-gen"), &types, directory).and_then(|()| {
        let output = Command::new(python::python()?)
            .args(["-c", program])
            .args([directory, log])
            .output()
            .map_err(|error| error.to_string())?;
        match output.status.success() {
            true => Ok(String::from_utf8_lossy(&output.stdout).into_owned()),
            false => Err(String::from_utf8_lossy(&output.stderr).into_owned()),
        }
    });
    let told = told.unwrap_or_else(|error| panic!("{error}"));
    let (events, peak_n) = told.trim().split_once(' ').unwrap();
    assert_eq!(events.parse(), Ok(EventLogReader::open(log).unwrap().count()));
    assert!(peak_n.parse::<f64>().unwrap() > 50.0, "{peak_n} N");
}

fn damaged(log: &Path) {
    let cut = log.with_extension("cut.lcmlog");
    let bytes = std::fs::read(log).unwrap();
    std::fs::write(&cut, &bytes[..bytes.len() / 2]).unwrap();
    let beside = log.with_extension("toml");
    let arguments = ["--scenario", beside.to_str().unwrap()];
    let (replay, code, told) = answer("replay", &cut, &arguments);
    assert_eq!(code, 1);
    assert!(told.contains("is damaged at byte"), "{told}");
    let equal = replay["equal_commands"].as_u64().unwrap();
    assert!((290..=301).contains(&equal), "{equal}");
    let old = log.with_extension("old.lcmlog");
    // Every status of the controller as one of another version has it.
    let mut changed = Log::open(log).unwrap().entries;
    for entry in &mut changed {
        if entry.channel == ControllerStatus::CHANNEL {
            entry.bytes[..8].copy_from_slice(&[7; 8]);
        }
    }
    transcript::write_log(&old, &changed).unwrap();
    let (replay, code, told) = answer("replay", &old, &arguments);
    assert_eq!((code, replay["equal_commands"].as_u64()), (1, Some(601)));
    let named = format!(
        "the type controller_status_t has changed, its fingerprint is 0x0707070707070707 in the log and {:#018x}",
        ControllerStatus::fingerprint()
    );
    assert!(told.contains(&named), "{told}");
}
