//! What may go wrong with a cell in real time, when, and what came of it: the fault matrix.

use crate::site::{Heard, LONG, Setting, Site};
use rustix::process::Signal;
use spatial::ports::{ControllerPhase, Fault, HORIZON, RobotMode, Role, TaskAction};
use std::error::Error;
use std::fmt;
use std::time::Duration;

/// What goes wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Injury {
    /// A process is killed.
    Kill(Role),
    /// A process stands still for so many ms.
    Freeze(Role, u64),
    /// A process is cut off from the others' device channels for so many ms.
    Cut(Role, u64),
    /// A process's clock steps by so many s.
    ClockStep(Role, i64),
    /// For 200 ms each command is sent once more, later, and as one of the future, and each state as one of another process.
    Replay,
    /// Another controller is started beside the one that works.
    SecondController,
    /// The controller is replaced by one with another scenario.
    Mismatch,
}

/// When it goes wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Moment {
    /// On the way down, at full speed.
    Approach,
    /// Right after the contact.
    Contact,
    /// Pressing, once the force has settled.
    Settled,
}

/// What came of it.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// State and fault of the robot.
    pub robot: (RobotMode, Fault),
    /// Fault of the controller.
    pub controller: Fault,
    /// Ticks from the end of the last good command's horizon to the standstill, and how many there may be; `None`: the
    /// robot has no fault.
    pub stop_ticks: Option<[i64; 2]>,
    /// Largest contact force afterwards, and of the first contact, N: before it that which is expected.
    pub force_n: [f64; 2],
    /// Largest speed of an axis afterwards, and its limit, rad/s.
    pub speed_rad_per_s: [f64; 2],
    /// Mean contact force once the experiment has been made again, after the injured node's restart, a reset and a start, N;
    /// or how far it has come.
    pub again_n: Result<f64, String>,
}

/// Ticks that braking takes at the approach's speed: the command filter comes to rest.
pub(crate) const BRAKING_TICKS: i64 = 150;

impl Outcome {
    /// What was promised and not kept.
    pub fn broken(&self) -> Option<String> {
        let [after_n, before_n] = self.force_n;
        let [fastest, limit] = self.speed_rad_per_s;
        let late = self.stop_ticks.filter(|[took, may]| took > may);
        match (&self.again_n, late) {
            (_, Some([took, may])) => Some(format!("it stood after {took} instead of {may} ms")),
            _ if after_n > 1.2 * before_n.max(DESIRED_N) => {
                Some(format!("{after_n:.0} N after {before_n:.0} N"))
            }
            _ if fastest > limit => Some(format!("{fastest:.2} rad/s instead of {limit:.2}")),
            (Err(state), _) => Some(format!("it does not work again: {state}")),
            (Ok(again_n), _) if libm::fabs(again_n - DESIRED_N) > 0.05 * DESIRED_N => {
                Some(format!("{again_n:.1} N when it works again"))
            }
            _ => None,
        }
    }
}

/// What the scenario presses with, N.
pub(crate) const DESIRED_N: f64 = 10.0;

/// Send what has been sent once more, and what has not been yet.
fn replay(site: &mut Site) {
    for _ in 0..50 {
        site.listen(Duration::from_millis(4));
        let (Some(command), Some(state)) = (site.heard.command, site.heard.robot) else {
            continue;
        };
        let mut future = command;
        future.stamp.step += 1000;
        let mut foreign = state;
        (foreign.stamp.boot_id, foreign.stamp.step) = (1, foreign.stamp.step + 4);
        // A full buffer is one more loss.
        let _ = site.link().publish(&command);
        let _ = site.link().publish(&future);
        let _ = site.link().publish(&foreign);
    }
}

impl Injury {
    /// Every one.
    pub fn all() -> Vec<Self> {
        let roles = [Role::Robot, Role::Sensor, Role::Controller];
        let times = [50, 200, 1000];
        let mut all: Vec<_> = roles.map(Self::Kill).to_vec();
        all.extend(
            roles
                .iter()
                .flat_map(|&role| times.map(|ms| Self::Freeze(role, ms))),
        );
        all.extend(roles.iter().flat_map(|&role| times.map(|ms| Self::Cut(role, ms))));
        all.extend(
            roles
                .iter()
                .flat_map(|&role| [1, -1].map(|s| Self::ClockStep(role, s))),
        );
        all.extend([Self::Replay, Self::SecondController, Self::Mismatch]);
        all
    }

    fn inflict(self, site: &mut Site) -> Result<(), Box<dyn Error>> {
        match self {
            Self::Kill(role) => site.cell.kill(role),
            Self::Freeze(role, ms) => {
                site.signal(role, Signal::STOP);
                site.listen(Duration::from_millis(ms));
                site.signal(role, Signal::CONT);
            }
            Self::Cut(role, ms) => {
                site.cut(role, true);
                site.listen(Duration::from_millis(ms));
                site.cut(role, false);
            }
            Self::ClockStep(role, _) => site.signal(role, Signal::USR1),
            Self::Replay => replay(site),
            Self::SecondController => site.cell.start_another(&site.bench.plan, Role::Controller)?,
            Self::Mismatch => {
                site.cell.kill(Role::Controller);
                let mut plan = site.bench.plan.clone();
                plan.overrides.push("task.desired_force_n=11".to_owned());
                site.cell.start_another(&plan, Role::Controller)?;
            }
        }
        Ok(())
    }

    /// What a person does about it.
    fn mend(self, site: &mut Site) -> Result<(), Box<dyn Error>> {
        match self {
            Self::Kill(role) => site.cell.start_another(&site.bench.plan, role)?,
            Self::SecondController => site.cell.kill(Role::Controller),
            Self::Mismatch => {
                site.cell.kill(Role::Controller);
                site.cell.start_another(&site.bench.plan, Role::Controller)?;
            }
            Self::Freeze(..) | Self::Cut(..) | Self::ClockStep(..) | Self::Replay => {}
        }
        Ok(())
    }
}

impl fmt::Display for Injury {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = node::greeting::role_name;
        match *self {
            Self::Kill(role) => write!(f, "{} killed", name(role)),
            Self::Freeze(role, ms) => write!(f, "{} frozen for {ms} ms", name(role)),
            Self::Cut(role, ms) => write!(f, "{} cut off for {ms} ms", name(role)),
            Self::ClockStep(role, s) => write!(f, "clock of {} steps by {s:+} s", name(role)),
            Self::Replay => write!(f, "stale and future messages"),
            Self::SecondController => write!(f, "a second controller"),
            Self::Mismatch => write!(f, "a controller with another scenario"),
        }
    }
}

impl Moment {
    /// Every one.
    pub const ALL: [Self; 3] = [Self::Approach, Self::Contact, Self::Settled];

    fn wait(self, site: &mut Site) -> bool {
        site.until(LONG, |heard| {
            self.is(heard) || heard.phase() == Some(ControllerPhase::Fault)
        });
        self.is(&site.heard)
    }

    fn is(self, heard: &Heard) -> bool {
        match self {
            Self::Approach => {
                heard.phase() == Some(ControllerPhase::Approach)
                    && heard.truth.is_some_and(|truth| truth.tcp_velocity.z < -0.0195)
            }
            Self::Contact => heard.phase() == Some(ControllerPhase::Contact),
            Self::Settled => heard.phase() == Some(ControllerPhase::Settled),
        }
    }
}

/// Inflict `injury` at `moment`.
pub fn inflict(setting: &Setting<'_>, injury: Injury, moment: Moment) -> Result<Outcome, Box<dyn Error>> {
    let mut setting = *setting;
    if let Injury::ClockStep(role, s) = injury {
        setting.flags[role as usize] = if s > 0 {
            &["--clock-step-s=1"]
        } else {
            &["--clock-step-s=-1"]
        };
    }
    let mut site = reach(&setting, moment)?;
    // Before the contact: what it is going to be, as the controller publishes it.
    let expected_n = site
        .heard
        .controller
        .map_or(0.0, |status| status.impact.peak_force_n);
    let before_n = if site.heard.peak_n > 0.0 {
        site.heard.peak_n
    } else {
        expected_n
    };
    site.heard.mark();
    injury.inflict(&mut site)?;
    site.listen(Duration::from_millis(800));
    let heard = &site.heard;
    let robot = heard.robot.ok_or("no state has been heard")?;
    let (drives, timing) = (site.bench.scenario.robot.drives(), &site.bench.scenario.timing);
    let period = timing.command_period_ticks;
    let delay = site.bench.scenario.robot.command_delay_periods;
    let gap = libm::rint(1e3 * site.bench.scenario.robot.command_gap_s) as i64;
    let stop = |[command, stopped]: [i64; 2]| {
        let horizon = command + (delay + HORIZON as i64) * period;
        [stopped - horizon, gap + 2 * period + BRAKING_TICKS]
    };
    let mut outcome = Outcome {
        robot: (robot.mode, robot.fault),
        controller: heard.controller.map_or(Fault::None, |status| status.fault),
        stop_ticks: heard.stopped.map(stop),
        force_n: [heard.peak_n, before_n],
        speed_rad_per_s: [heard.speed_rad_per_s, drives.velocity_limit_rad_per_s.amax()],
        again_n: Err(String::new()),
    };
    injury.mend(&mut site)?;
    outcome.again_n = again(&mut site);
    Ok(outcome)
}

/// A site at `moment`. A machine that is busy with other things may hold a process up for longer than the robot waits:
/// that is another fault than the one that is to be seen.
pub(crate) fn reach(setting: &Setting<'_>, moment: Moment) -> Result<Site, Box<dyn Error>> {
    let mut phase = None;
    for _ in 0..3 {
        let mut site = Site::start(setting)?;
        if moment.wait(&mut site) {
            return Ok(site);
        }
        phase = site.heard.phase();
    }
    Err(format!("it is not reached: {phase:?}").into())
}

/// Reset, start, and the force once it has settled.
pub fn again(site: &mut Site) -> Result<f64, String> {
    let works = |heard: &Heard| {
        heard
            .controller
            .is_some_and(|status| status.fault == Fault::None && status.phase != ControllerPhase::Fault)
            && heard.robot.is_some_and(|robot| {
                robot.fault == Fault::None && matches!(robot.mode, RobotMode::Following | RobotMode::Bridging)
            })
    };
    let goes = |heard: &Heard| {
        matches!(
            heard.phase(),
            Some(ControllerPhase::Approach | ControllerPhase::Contact | ControllerPhase::Settled)
        )
    };
    site.heard.controller = None;
    site.heard.robot = None;
    let settles = site.ask(TaskAction::Reset, works)
        && (site.until(Duration::from_millis(300), goes) || site.ask(TaskAction::Start, goes))
        && site.until(LONG, |heard| heard.phase() == Some(ControllerPhase::Settled));
    site.listen(Duration::from_millis(200));
    // The mean of half a second: the contact rings, and elastic gears swing.
    let mut forces_n = Vec::new();
    for _ in 0..50 {
        site.listen(Duration::from_millis(10));
        forces_n.extend(site.heard.truth.map(|truth| truth.contact_force.z));
    }
    let mean_n = (!forces_n.is_empty()).then(|| forces_n.iter().sum::<f64>() / forces_n.len() as f64);
    mean_n.filter(|_| settles).ok_or_else(|| {
        let robot = site.heard.robot.map(|robot| (robot.mode, robot.fault));
        let controller = site.heard.controller;
        let controller = controller.map(|status| (status.phase, status.fault, status.task_answer));
        format!("robot {robot:?}, controller {controller:?}")
    })
}
