//! Real-time rights of the thread that controls: asked for where the system grants them, reported where not.

use rustix::mm::{MlockAllFlags, mlockall};
use rustix::thread::{CpuSet, sched_setaffinity, set_current_timer_slack};
use std::num::NonZeroU64;
use thread_priority::{
    NormalThreadSchedulePolicy, RealtimeThreadSchedulePolicy, ThreadPriority, ThreadPriorityValue,
    ThreadSchedulePolicy, set_thread_priority_and_policy, thread_native_id,
};

/// Just below the kernel's threaded interrupts, which bring the messages.
const PRIORITY: u8 = 49;
/// What gives the rights to a program.
pub const REMEDY: &str = "sudo setcap cap_sys_nice,cap_ipc_lock+ep PROGRAM";

/// What a host may give to the thread that controls.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::Args)]
pub struct Wanted {
    /// Real time: priority of the thread that controls under SCHED_FIFO, 0 to 99; 0: not asked for
    #[arg(long, default_value_t = PRIORITY, value_name = "N", value_parser = clap::value_parser!(u8).range(0..=99))]
    pub priority: u8,
    /// Real time: the CPU that the thread that controls stays on [default: any]
    #[arg(long, value_name = "N")]
    pub cpu: Option<u16>,
}

impl Default for Wanted {
    fn default() -> Self {
        Self {
            priority: PRIORITY,
            cpu: None,
        }
    }
}

impl Wanted {
    /// Ask for the rights for the calling thread, say which are not had and how to get them; whether all are.
    ///
    /// Never fatal: what runs without them is late more often, and publishes how late.
    pub fn ask(&self) -> bool {
        let missing = self.missing();
        if !missing.is_empty() {
            tracing::warn!(
                "without real-time rights: {}; deadlines may be missed. `{REMEDY}` gives them, --priority 0 does without",
                missing.join(", ")
            );
        }
        missing.is_empty()
    }

    /// Ask for the rights for the calling thread; those that are not had, and why.
    pub fn missing(&self) -> Vec<String> {
        let cause = |error: rustix::io::Errno| error.to_string();
        let locked = mlockall(MlockAllFlags::CURRENT | MlockAllFlags::FUTURE);
        let mut asked = vec![
            (
                "timer slack of 1 ns".to_owned(),
                set_current_timer_slack(NonZeroU64::new(1)).map_err(cause),
            ),
            ("memory locked against paging".to_owned(), locked.map_err(cause)),
        ];
        if let Some(cpu) = self.cpu {
            asked.push((format!("CPU {cpu}"), stay_on(cpu)));
        }
        if self.priority > 0 {
            asked.push((format!("SCHED_FIFO {}", self.priority), schedule(self.priority)));
        }
        let refused = |(what, outcome): (String, Result<(), String>)| {
            outcome.err().map(|cause| format!("{what} ({cause})"))
        };
        asked.into_iter().filter_map(refused).collect()
    }
}

/// For a thread that the controlling one has started, and that has time.
pub fn give_up() {
    let policy = ThreadSchedulePolicy::Normal(NormalThreadSchedulePolicy::Other);
    // Whoever has no rights has none to give up.
    let _ = set_thread_priority_and_policy(thread_native_id(), ThreadPriority::Min, policy);
}

fn stay_on(cpu: u16) -> Result<(), String> {
    if usize::from(cpu) >= CpuSet::MAX_CPU {
        return Err(format!("there is none beyond {}", CpuSet::MAX_CPU - 1));
    }
    let mut set = CpuSet::new();
    set.set(usize::from(cpu));
    sched_setaffinity(None, &set).map_err(|error| error.to_string())
}

fn schedule(priority: u8) -> Result<(), String> {
    let value = ThreadPriorityValue::try_from(priority).map_err(|cause| cause.to_owned())?;
    let policy = ThreadSchedulePolicy::Realtime(RealtimeThreadSchedulePolicy::Fifo);
    set_thread_priority_and_policy(thread_native_id(), ThreadPriority::Crossplatform(value), policy).map_err(
        |error| match error {
            thread_priority::Error::OS(code) => std::io::Error::from_raw_os_error(code).to_string(),
            error => format!("{error:?}"),
        },
    )
}
