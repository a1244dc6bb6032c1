//! A place for one run: ports of its own, a directory of its own, a short scenario.

use experiment::launch::{Plan, Wiring};
use experiment::run_port::RunPort;
use node::scenario::Scenario;
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::process::{Pid, PidfdFlags, Signal, kill_process, pidfd_open};
use std::error::Error;
use std::fs;
use std::path::PathBuf;
use std::time::Duration;
use tempfile::TempDir;

/// Overrides of the paper's scenario that bring the contact early: 0.9 simulated seconds tell all.
const SHORT: [&str; 2] = [
    "task.start_position_m=[0.0, 0.0, 0.0165]",
    "timing.duration_s=0.9",
];

/// Everything that one run needs of its own; removed when dropped.
pub struct Bench {
    /// Directory of scenario and records.
    pub directory: TempDir,
    /// The configuration.
    pub scenario: Scenario,
    /// What to launch.
    pub plan: Plan,
    ports: Vec<RunPort>,
}

impl Bench {
    /// The short experiment with further `overrides`, all nodes on the same two ports.
    pub fn new(overrides: &[&str]) -> Result<Self, Box<dyn Error>> {
        let overrides: Vec<_> = SHORT.iter().chain(overrides).copied().collect();
        Self::of("paper", &overrides)
    }

    /// The built-in scenario `name` with `overrides`, all nodes on the same two ports.
    pub fn of(name: &str, overrides: &[&str]) -> Result<Self, Box<dyn Error>> {
        let directory = tempfile::tempdir()?;
        let port = RunPort::free(Duration::ZERO)?;
        let file = directory.path().join("scenario.toml");
        fs::write(&file, experiment::scenarios::Source::find(name)?.text)?;
        let overrides: Vec<String> = overrides.iter().map(|&text| text.to_owned()).collect();
        let plan = Plan {
            programs: crate::programs(),
            scenario: file.clone(),
            overrides: overrides.clone(),
            wiring: Wiring::shared(&port.device_url(), &port.simulation_url()),
            run_id: i64::from(port.port()),
            directory: directory.path().to_owned(),
            flags: Default::default(),
            through: Default::default(),
        };
        Ok(Self {
            scenario: Scenario::load(&file, &overrides)?,
            directory,
            plan,
            ports: vec![port],
        })
    }

    /// Give each process ports of its own, to be joined by a relay: by role robot, sensor, controller, then the
    /// watching launcher. Returns the device ports and the ports of the simulated world that belong together.
    pub fn separate(&mut self) -> Result<[Vec<u16>; 2], Box<dyn Error>> {
        for _ in 0..3 {
            self.ports.push(RunPort::free(Duration::ZERO)?);
        }
        let url = |i: usize| (self.ports[i].device_url(), self.ports[i].simulation_url());
        self.plan.wiring = Wiring {
            device: [0, 1, 2].map(|i| url(i).0),
            world: [0, 1, 2].map(|i| url(i).1),
            watch: url(3).0,
        };
        let device: Vec<u16> = self.ports.iter().map(RunPort::port).collect();
        let world = device[..2].iter().map(|port| port + 1).collect();
        Ok([device, world])
    }

    /// The port of the run.
    pub fn port(&self) -> u16 {
        self.ports[0].port()
    }

    /// Give the locks of the ports back, so that a launcher under test can take them.
    pub fn release_ports(&mut self) {
        self.ports.clear();
    }
}

/// Ids of the processes that have `text` in their command line.
pub fn processes_naming(text: &str) -> Vec<i32> {
    let Ok(entries) = fs::read_dir("/proc") else {
        return Vec::new();
    };
    let ids = entries
        .flatten()
        .filter_map(|entry| entry.file_name().to_str()?.parse().ok());
    ids.filter(|id| {
        let line = fs::read(PathBuf::from(format!("/proc/{id}/cmdline"))).unwrap_or_default();
        String::from_utf8_lossy(&line).contains(text)
    })
    .collect()
}

/// Send `signal` to the process `id`, if it is still there.
pub fn signal(id: u32, signal: Signal) {
    if let Some(id) = i32::try_from(id).ok().and_then(Pid::from_raw) {
        let _ = kill_process(id, signal);
    }
}

/// Wait until the process `id`, which need not be a child, has ended; `false`: it has not within `limit`.
pub fn wait_for_end(id: i32, limit: Duration) -> bool {
    let Some(process) = Pid::from_raw(id) else {
        return true;
    };
    let Ok(handle) = pidfd_open(process, PidfdFlags::empty()) else {
        return true;
    };
    let limit = Timespec {
        tv_sec: limit.as_secs() as i64,
        tv_nsec: i64::from(limit.subsec_nanos()),
    };
    let mut descriptors = [PollFd::new(&handle, PollFlags::IN)];
    matches!(poll(&mut descriptors, Some(&limit)), Ok(1))
}
