//! A cell that presses for a long time, as a table: `make soak`. An argument says for how many minutes (20).

use lcmtypes::{LcmBuilder, Received, Subscription};
use node::clock;
use spatial::ports::{Command, Fault, RobotState};
use std::error::Error;
use std::process::ExitCode;
use std::time::{Duration, Instant};
use tests::hostile::{files, memory_kib, pressing};
use tests::site::{Setting, Site};

const HEAD: &str = "\
Three programs in real time that press with 10 N, minute by minute. memory: resident, KiB; files: open ones; answer: from the instant at
which the robot is sampled to that at which the command leaves that answers it (one host, one clock); lost: states without one.

minute  memory robot  sensor  controller   files  answer p50 us   p99 us  max us  lost  faults";
/// So much may become more from the first to the last minute: KiB, and as a ratio of the median answer.
const GROWTH_KIB: u64 = 256;
const GROWTH: f64 = 2.0;

fn main() -> ExitCode {
    let minutes = std::env::args()
        .nth(1)
        .and_then(|text| text.parse().ok())
        .unwrap_or(20);
    match soak(minutes) {
        Ok(None) => ExitCode::SUCCESS,
        Ok(Some(what)) => {
            println!("\nNO: {what}");
            ExitCode::FAILURE
        }
        Err(error) => {
            println!("{error}");
            ExitCode::FAILURE
        }
    }
}

/// A minute.
struct Minute {
    memory_kib: [u64; 3],
    files: [usize; 3],
    answers_us: Vec<u64>,
    lost: usize,
}

impl Minute {
    fn answer_us(&self, share: f64) -> u64 {
        let last = self.answers_us.len().saturating_sub(1);
        let at = libm::rint(share * last as f64) as usize;
        self.answers_us.get(at).copied().unwrap_or_default()
    }
}

/// What has grown within so many minutes.
fn soak(minutes: usize) -> Result<Option<String>, Box<dyn Error>> {
    println!("{HEAD}");
    let setting = Setting {
        scenario: "arm",
        // As on any virtual machine that does other things, too.
        overrides: &["robot.command_gap_s=0.25", "controller.stale_fault_s=0.25"],
        ..Setting::default()
    };
    let mut site = pressing(&setting)?;
    let mut link = LcmBuilder::open(&site.bench.plan.wiring.watch)?;
    let (states, commands) = (link.subscribe(1024), link.subscribe(1024));
    let _link = link.start()?;
    let mut all = Vec::new();
    for number in 1..=minutes {
        let minute = measure(
            &mut site,
            &states,
            &commands,
            clock::now() + Duration::from_secs(60),
        );
        let [robot, sensor, controller] = minute.memory_kib;
        let faults = [
            site.heard.robot.map(|it| it.fault),
            site.heard.controller.map(|it| it.fault),
        ];
        let faults: Vec<_> = faults
            .into_iter()
            .flatten()
            .filter(|fault| *fault != Fault::None)
            .map(Fault::name)
            .collect();
        println!(
            "{number:6}  {robot:12}  {sensor:6}  {controller:10}   {:5}  {:13}  {:7}  {:6}  {:4}  {}",
            minute.files.iter().sum::<usize>(),
            minute.answer_us(0.5),
            minute.answer_us(0.99),
            minute.answer_us(1.0),
            minute.lost,
            faults.join(" ")
        );
        all.push(minute);
    }
    let (Some(first), Some(last)) = (all.first(), all.last()) else {
        return Ok(None);
    };
    let grown = (0..3).any(|i| last.memory_kib[i] > first.memory_kib[i] + GROWTH_KIB);
    let later = last.answer_us(0.5) as f64 > GROWTH * first.answer_us(0.5) as f64;
    println!(
        "\n{minutes} min: memory {:+} KiB, open files {:+}, median answer {:+} us from the first to the last",
        last.memory_kib.iter().sum::<u64>() as i64 - first.memory_kib.iter().sum::<u64>() as i64,
        last.files.iter().sum::<usize>() as i64 - first.files.iter().sum::<usize>() as i64,
        last.answer_us(0.5) as i64 - first.answer_us(0.5) as i64,
    );
    Ok(match (grown, last.files != first.files, later) {
        (true, ..) => Some("memory has grown".to_owned()),
        (_, true, _) => Some("there are other open files".to_owned()),
        (_, _, true) => Some("answers have become slower".to_owned()),
        _ => None,
    })
}

/// What can be seen until `end`.
fn measure(
    site: &mut Site,
    states: &Subscription<RobotState>,
    commands: &Subscription<Command>,
    end: Instant,
) -> Minute {
    let (mut answers_us, mut asked, mut lost) = (Vec::new(), Vec::<(i64, i64)>::new(), 0);
    while clock::now() < end {
        site.listen(Duration::from_millis(100));
        while let Some(Received { message, .. }) = states.take() {
            asked.push((message.stamp.step, message.stamp.utime));
        }
        while let Some(Received { message, .. }) = commands.take() {
            if let Some(i) = asked.iter().position(|(step, _)| *step == message.stamp.step) {
                let (_, at) = asked.remove(i);
                answers_us.push((message.send_utime - at).unsigned_abs());
            }
        }
        let newest = asked.last().map_or(0, |(step, _)| *step);
        let before = asked.len();
        asked.retain(|(step, _)| newest - step < 500);
        lost += before - asked.len();
    }
    answers_us.sort_unstable();
    Minute {
        memory_kib: memory_kib(site),
        files: files(site),
        answers_us,
        lost,
    }
}
