//! Three nodes in real time on one port, an attacker beside them, and what came of it.

use crate::attack::{Attack, Ear};
pub use crate::faults::again;
use crate::faults::{self, BRAKING_TICKS, DESIRED_N};
use crate::site::{LONG, Setting, Site};
use crossbeam::channel::{RecvTimeoutError, Sender, bounded};
use node::clock;
use rand_core::SeedableRng;
use rand_pcg::Pcg64;
use spatial::ports::{Fault, HORIZON, LinkQuality, NodeStatus, RobotMode, Role};
use std::error::Error;
use std::fs;
use std::net::{Ipv4Addr, SocketAddrV4, UdpSocket};
use std::thread::JoinHandle;
use std::time::Duration;

/// Group of every run.
const GROUP: Ipv4Addr = Ipv4Addr::new(239, 255, 76, 67);
const ROLES: [Role; 3] = [Role::Robot, Role::Sensor, Role::Controller];
/// So much a node may grow by while it is attacked, KiB: what it uses for the first time.
const GROWTH_KIB: u64 = 2048;

/// Sends until it is dropped or told to stop.
pub struct Attacker {
    stop: Sender<()>,
    thread: Option<JoinHandle<u64>>,
}

impl Attacker {
    /// Begin `attack` on the device channels at `url` and `port`. The ports and the packets of one `seed` are the same ones, as
    /// far as what the nodes say is.
    pub fn start(attack: Attack, url: &str, port: u16, seed: u64) -> Result<Self, Box<dyn Error>> {
        let mut random = Pcg64::seed_from_u64(seed);
        let mut ear = Ear::open(url, &mut random)?;
        let socket = UdpSocket::bind((Ipv4Addr::UNSPECIFIED, 0))?;
        socket.set_multicast_ttl_v4(0)?;
        let to = SocketAddrV4::new(GROUP, port);
        let (stop, stopped) = bounded(1);
        let thread = std::thread::spawn(move || {
            let (mut sent, mut due) = (0, clock::now());
            loop {
                let pause = match attack.per_ms() {
                    Some(_) => stopped.recv_deadline(due),
                    None => stopped.try_recv().map_err(|_| RecvTimeoutError::Timeout),
                };
                if pause != Err(RecvTimeoutError::Timeout) {
                    return sent;
                }
                ear.listen(&mut random);
                for _ in 0..attack.per_ms().unwrap_or(100) {
                    if let Some(packet) = attack.packet(&ear, &mut random) {
                        // What does not fit into a buffer is not sent.
                        sent += u64::from(socket.send_to(&packet, to).is_ok());
                    }
                }
                // Never more than that, also after a pause.
                due = clock::now().max(due) + Duration::from_millis(1);
            }
        });
        let thread = Some(thread);
        Ok(Self { stop, thread })
    }

    /// Stop; how many packets have been sent.
    pub fn stop(mut self) -> u64 {
        self.end()
    }

    fn end(&mut self) -> u64 {
        let _ = self.stop.try_send(());
        self.thread
            .take()
            .and_then(|thread| thread.join().ok())
            .unwrap_or_default()
    }
}

impl Drop for Attacker {
    fn drop(&mut self) {
        self.end();
    }
}

/// What came of an attack.
#[derive(Clone, Debug)]
pub struct Endured {
    /// Packets sent.
    pub sent: u64,
    /// What the nodes' statuses count of them, all three together.
    pub counted: Counted,
    /// State and fault of the robot.
    pub robot: (RobotMode, Fault),
    /// Fault of the controller.
    pub controller: Fault,
    /// Ticks from the end of the last good command's horizon to the standstill, and how many there may be; `None`: it did
    /// not stop.
    pub stop_ticks: Option<[i64; 2]>,
    /// Largest contact force, and that of the first contact as it was expected, N.
    pub force_n: [f64; 2],
    /// Largest speed of an axis, and its limit, rad/s.
    pub speed_rad_per_s: [f64; 2],
    /// Resident memory before and after, by role, KiB.
    pub memory_kib: [[u64; 2]; 3],
    /// Open files before and after, by role.
    pub files: [[usize; 2]; 3],
    /// Nodes that have ended.
    pub gone: Vec<Role>,
    /// Mean contact force once the experiment has been made again, after a reset and a start, N; or how far it has come;
    /// `None`: that has not been tried.
    pub again_n: Option<Result<f64, String>>,
}

/// What statuses count.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counted {
    /// Of no use.
    pub unusable: i64,
    /// Not from whom they should be, or not executed.
    pub refused: i64,
    /// Dropped by queues and by the kernel.
    pub dropped: i64,
}

impl Endured {
    /// What was promised and not kept.
    pub fn broken(&self) -> Option<String> {
        let [force_n, first_n] = self.force_n;
        let [fastest, limit] = self.speed_rad_per_s;
        let grown = self
            .memory_kib
            .iter()
            .find(|[before, after]| *after > before + GROWTH_KIB);
        let opened = self.files.iter().find(|[before, after]| after > before);
        let late = self.stop_ticks.filter(|[took, may]| took > may);
        match (&self.again_n, late, grown, opened) {
            _ if !self.gone.is_empty() => Some(format!("{:?} ended", self.gone)),
            (_, _, Some([before, after]), _) => Some(format!("from {before} to {after} KiB")),
            (_, _, _, Some([before, after])) => Some(format!("from {before} to {after} open files")),
            (_, Some([took, may]), ..) => Some(format!("it stood after {took} instead of {may} ms")),
            _ if force_n > 1.2 * first_n.max(DESIRED_N) => {
                Some(format!("{force_n:.0} N instead of {first_n:.0} N"))
            }
            _ if fastest > limit => Some(format!("{fastest:.2} rad/s instead of {limit:.2}")),
            (Some(Err(state)), ..) => Some(format!("it does not work again: {state}")),
            (Some(Ok(again_n)), ..) if libm::fabs(again_n - DESIRED_N) > 0.05 * DESIRED_N => {
                Some(format!("{again_n:.1} N when it works again"))
            }
            _ => None,
        }
    }
}

/// `setting` with all nodes on one port.
fn exposed<'a>(setting: &Setting<'a>) -> Setting<'a> {
    Setting {
        shared: true,
        ..*setting
    }
}

/// Attack from the approach on, through the contact, for `time`; `seed` of the packets.
pub fn endure(
    setting: &Setting<'_>,
    attack: Attack,
    time: Duration,
    seed: u64,
) -> Result<Endured, Box<dyn Error>> {
    let mut site = faults::reach(&exposed(setting), faults::Moment::Approach)?;
    let mut endured = under_attack(&mut site, attack, time, seed)?;
    endured.again_n = Some(faults::again(&mut site));
    endured.gone = gone(&site);
    Ok(endured)
}

/// A site whose nodes share a port, pressing.
pub fn pressing(setting: &Setting<'_>) -> Result<Site, Box<dyn Error>> {
    faults::reach(&exposed(setting), faults::Moment::Settled)
}

/// What `attack` does to `site` within `time`, as far as can be seen before the experiment is made again.
pub fn under_attack(
    site: &mut Site,
    attack: Attack,
    time: Duration,
    seed: u64,
) -> Result<Endured, Box<dyn Error>> {
    let expected_n = site
        .heard
        .controller
        .map_or(0.0, |status| status.impact.peak_force_n);
    let before = (counted(site), memory_kib(site), files(site));
    site.heard.mark();
    let attacker = Attacker::start(attack, &site.bench.plan.wiring.watch, site.bench.port(), seed)?;
    site.listen(time);
    let sent = attacker.stop();
    // By then everything has been taken; it is in each node's next status.
    site.listen(Duration::from_millis(20));
    site.heard.nodes = [None; 3];
    site.until(LONG, |heard| heard.nodes.iter().all(Option::is_some));
    let after = (counted(site), memory_kib(site), files(site));
    let (heard, scenario) = (&site.heard, &site.bench.scenario);
    let robot = heard.robot.ok_or("no state has been heard")?;
    let timing = &scenario.timing;
    let gap = libm::rint(1e3 * scenario.robot.command_gap_s) as i64;
    let stop = |[command, stopped]: [i64; 2]| {
        let horizon =
            command + (scenario.robot.command_delay_periods + HORIZON as i64) * timing.command_period_ticks;
        [
            stopped - horizon,
            gap + 2 * timing.command_period_ticks + BRAKING_TICKS,
        ]
    };
    Ok(Endured {
        sent,
        counted: Counted {
            unusable: after.0.unusable - before.0.unusable,
            refused: after.0.refused - before.0.refused,
            dropped: after.0.dropped - before.0.dropped,
        },
        robot: (robot.mode, robot.fault),
        controller: heard.controller.map_or(Fault::None, |status| status.fault),
        stop_ticks: heard.stopped.map(stop),
        force_n: [heard.peak_n, expected_n],
        speed_rad_per_s: [
            heard.speed_rad_per_s,
            scenario.robot.drives().velocity_limit_rad_per_s.amax(),
        ],
        memory_kib: std::array::from_fn(|i| [before.1[i], after.1[i]]),
        files: std::array::from_fn(|i| [before.2[i], after.2[i]]),
        gone: gone(site),
        again_n: None,
    })
}

fn counted(site: &Site) -> Counted {
    let all: Vec<LinkQuality> = site
        .heard
        .nodes
        .iter()
        .flatten()
        .map(|node: &NodeStatus| node.link)
        .collect();
    let sum = |count: fn(&LinkQuality) -> i64| all.iter().map(count).sum();
    Counted {
        unusable: sum(|link| link.undecodable),
        refused: sum(|link| link.refused),
        dropped: sum(|link| link.dropped + link.kernel_dropped.max(0)),
    }
}

/// Nodes that are not there any more, or dead and not yet waited for.
fn gone(site: &Site) -> Vec<Role> {
    ROLES
        .into_iter()
        .filter(|role| site.cell.process_id(*role).and_then(resident_kib).is_none())
        .collect()
}

/// Resident memory by role, KiB.
pub fn memory_kib(site: &Site) -> [u64; 3] {
    ROLES.map(|role| {
        site.cell
            .process_id(role)
            .and_then(resident_kib)
            .unwrap_or_default()
    })
}

/// Resident memory of a process, KiB.
pub fn resident_kib(id: u32) -> Option<u64> {
    let status = fs::read_to_string(format!("/proc/{id}/status")).ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"))?;
    line.trim().trim_end_matches(" kB").parse().ok()
}

/// Open files by role.
pub fn files(site: &Site) -> [usize; 3] {
    ROLES.map(|role| {
        let id = site.cell.process_id(role).unwrap_or_default();
        fs::read_dir(format!("/proc/{id}/fd")).map_or(0, |files| files.count())
    })
}
