//! What a cell is: a TOML file, the same on all its hosts.

use super::{ROLES, UpError};
use crate::scenarios::Source;
use lcmtypes::Group;
use node::greeting::role_name;
use node::scenario::{Scenario, TimingMode};
use serde::Deserialize;
use spatial::ports::Role;
use std::fs;
use std::path::{Path, PathBuf};

/// Highest priority under SCHED_FIFO.
const HIGHEST_PRIORITY: i64 = 99;
/// As many CPUs as a mask of them holds.
const HIGHEST_CPU: i64 = 1023;

/// The file as it is written.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    scenario: String,
    #[serde(default)]
    set: Vec<String>,
    run_id: i64,
    #[serde(default = "device_url")]
    url: String,
    #[serde(default = "world_url")]
    sim_url: String,
    #[serde(default)]
    keys: Vec<PathBuf>,
    #[serde(rename = "robot-sim")]
    robot: Option<Place>,
    #[serde(rename = "sensor-sim")]
    sensor: Option<Place>,
    controller: Option<Place>,
}

/// Where a node runs.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Place {
    /// The host's name, as `uname -n` prints it there.
    pub host: String,
    /// The CPU that the thread that controls stays on.
    pub cpu: Option<i64>,
    /// Its priority under SCHED_FIFO; 0: not asked for.
    pub priority: Option<i64>,
}

/// A cell: three nodes, where they run, and how they talk.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CellConfig {
    /// The file, as it was named.
    pub name: String,
    /// The scenario of all nodes.
    pub source: Source,
    /// What is changed of it, texts `section.key=value`.
    pub overrides: Vec<String>,
    /// Identity of the cell: nodes of another one are refused.
    pub run_id: i64,
    /// LCM URL of the device channels.
    pub url: String,
    /// LCM URL of the simulated world.
    pub sim_url: String,
    /// Key files, where they are on each host; the first one signs.
    pub keys: Vec<PathBuf>,
    /// By role; `None`: something else plays it, such as the driver of a real robot.
    places: [Option<Place>; 3],
}

fn device_url() -> String {
    "udpm://239.255.76.67:7667?ttl=0".to_owned()
}

fn world_url() -> String {
    "udpm://239.255.76.67:7668?ttl=0".to_owned()
}

/// Whether two names are of the same host: with or without its domain.
pub fn same_host(a: &str, b: &str) -> bool {
    let first = |name: &str| name.split('.').next().unwrap_or_default().to_ascii_lowercase();
    a.eq_ignore_ascii_case(b) || ((!a.contains('.') || !b.contains('.')) && first(a) == first(b))
}

impl CellConfig {
    /// The cell in the file at `path`; a scenario's path is meant relative to it.
    pub fn load(path: &Path) -> Result<Self, UpError> {
        let text = fs::read_to_string(path).map_err(|source| UpError::Unreadable {
            path: path.to_owned(),
            source,
        })?;
        let directory = path.parent().unwrap_or(Path::new("."));
        Self::parse(&path.display().to_string(), &text, directory)
    }

    /// The cell in `text`; `name` stands for the file, `directory` is where it is.
    pub fn parse(name: &str, text: &str, directory: &Path) -> Result<Self, UpError> {
        let file: File = toml::from_str(text).map_err(|error| UpError::Syntax {
            name: name.to_owned(),
            message: error.to_string().trim_end().to_owned(),
        })?;
        let is_path = file.scenario.contains('/') || file.scenario.ends_with(".toml");
        let source = match is_path {
            true => Source::find(&format!("{}", directory.join(&file.scenario).display())),
            false => Source::find(&file.scenario),
        }?;
        let scenario = source.scenario(&file.set)?;
        let cell = Self {
            name: name.to_owned(),
            source,
            overrides: file.set,
            run_id: file.run_id,
            url: file.url,
            sim_url: file.sim_url,
            keys: file.keys.iter().map(|key| directory.join(key)).collect(),
            places: [file.robot, file.sensor, file.controller],
        };
        let problems: Vec<_> = [cell.timing(&scenario), cell.urls(), cell.nodes()]
            .concat()
            .into_iter()
            .map(|problem| format!("{name}: {problem}"))
            .collect();
        if problems.is_empty() {
            Ok(cell)
        } else {
            Err(UpError::Problems { problems })
        }
    }

    /// Where the node in `role` runs.
    pub fn place(&self, role: Role) -> Option<&Place> {
        self.places[role as usize].as_ref()
    }

    /// All hosts, each once.
    pub fn hosts(&self) -> Vec<&str> {
        let mut hosts: Vec<&str> = Vec::new();
        for place in self.places.iter().flatten() {
            if !hosts.iter().any(|known| same_host(known, &place.host)) {
                hosts.push(&place.host);
            }
        }
        hosts
    }

    /// The nodes that run on `host`, in the order in which they are started.
    pub fn on(&self, host: &str) -> Vec<Role> {
        let here = |role: &Role| {
            self.place(*role)
                .is_some_and(|place| same_host(&place.host, host))
        };
        ROLES.into_iter().filter(here).collect()
    }

    /// What to type on `host`.
    pub fn command_on(&self, host: &str) -> String {
        format!("touchdown up {} --host {host}", self.name)
    }

    /// What is to be started on `host`: all that belongs there, or of that `only` one node.
    pub fn started_on(&self, host: &str, only: Option<Role>) -> Result<Vec<Role>, UpError> {
        let here = self.on(host);
        match only {
            None if here.is_empty() => Err(UpError::nothing_here(self, host)),
            None => Ok(here),
            Some(role) if here.contains(&role) => Ok(vec![role]),
            Some(role) => Err(UpError::Elsewhere {
                name: self.name.clone(),
                node: role_name(role),
                there: self.place(role).map_or(String::new(), |place| place.host.clone()),
                host: host.to_owned(),
            }),
        }
    }

    fn timing(&self, scenario: &Scenario) -> Vec<String> {
        let mut problems = Vec::new();
        if scenario.timing.mode != TimingMode::Realtime {
            problems.push(
                "timing.mode is lockstep, but the nodes of a cell start and end one by one; put \
                 \"timing.mode=realtime\" into set"
                    .to_owned(),
            );
        }
        let loss = scenario.network.loss_ratio;
        if loss != 0.0 {
            problems.push(format!(
                "network.loss_ratio is {loss}, but the network between processes loses what it does; put \
                 \"network.loss_ratio=0\" into set"
            ));
        }
        problems
    }

    fn urls(&self) -> Vec<String> {
        let mut problems = Vec::new();
        let mut group = |key: &str, url: &str| match Group::of(url) {
            Ok(Some(group)) => Some(group),
            Ok(None) => {
                problems.push(format!(
                    "{key} is {url:?}, which stays in one process; write {:?}",
                    device_url()
                ));
                None
            }
            Err(error) => {
                problems.push(format!("{key}: {error}"));
                None
            }
        };
        let (device, world) = (group("url", &self.url), group("sim_url", &self.sim_url));
        let (Some(device), Some(world)) = (device, world) else {
            return problems;
        };
        if device.address == world.address {
            problems.push(format!(
                "url and sim_url are both {}, but the simulated world needs a port of its own; give sim_url the next one",
                device.address
            ));
        }
        let hosts = self.hosts();
        let simulated = [Role::Robot, Role::Sensor].map(|role| self.place(role));
        let apart = matches!(simulated, [Some(a), Some(b)] if !same_host(&a.host, &b.host));
        let leaves = [
            ("url", device, hosts.len() > 1, hosts.join(", ")),
            (
                "sim_url",
                world,
                apart,
                "robot-sim and sensor-sim apart".to_owned(),
            ),
        ];
        for (key, Group { address, ttl, .. }, apart, hosts) in leaves {
            if apart && ttl == 0 {
                problems.push(format!(
                    "{key} has ttl=0, which keeps messages on one host, but the nodes are on several ({hosts}); \
                     write {key} = \"udpm://{address}?ttl=1\""
                ));
            }
        }
        problems
    }

    fn nodes(&self) -> Vec<String> {
        let mut problems = Vec::new();
        if self.hosts().is_empty() {
            problems.push(
                "no node has a host; write at least one of [robot-sim], [sensor-sim], [controller] with host = \"NAME\""
                    .to_owned(),
            );
        }
        for role in ROLES {
            let Some(place) = self.place(role) else { continue };
            let node = role_name(role);
            if place.host.trim().is_empty() || place.host.contains(char::is_whitespace) {
                problems.push(format!(
                    "[{node}] host is {:?}, which no host is called; write what `uname -n` prints there",
                    place.host
                ));
            }
            let numbers = [
                ("cpu", place.cpu, HIGHEST_CPU),
                ("priority", place.priority, HIGHEST_PRIORITY),
            ];
            for (key, value, highest) in numbers {
                if let Some(value) = value.filter(|value| !(0..=highest).contains(value)) {
                    let (side, limit) = if value < 0 {
                        ("below", 0)
                    } else {
                        ("above", highest)
                    };
                    problems.push(format!(
                        "[{node}] {key} is {value}, {side} the limit of {limit}; choose a number in 0..={highest}, or \
                         leave it out"
                    ));
                }
            }
        }
        problems
    }
}

#[cfg(test)]
mod tests;
