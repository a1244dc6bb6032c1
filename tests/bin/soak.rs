//! A cell that presses for a long time, as a table: `make soak`, hours simulated in one process and then minutes in real time. An
//! argument says for how many minutes (20).

use experiment::in_process;
use experiment::scenarios::Source;
use lcmtypes::{LcmBuilder, Received, Subscription};
use libm::rint;
use node::clock;
use spatial::ports::{Command, ControllerPhase, Fault, RobotState};
use std::error::Error;
use std::process::ExitCode;
use std::time::{Duration, Instant};
use tests::hostile::{files, memory_kib, pressing, resident_kib};
use tests::site::{Setting, Site};

/// Scenarios, and for how many hours each.
const SIMULATED_H: [(&str, u32); 2] = [("paper", 6), ("elastic_arm", 2)];
const HEAD: &str = "
Three programs in real time that press with 10 N, minute by minute. memory: resident, KiB; files: open ones; answer: from the instant at
which the robot is sampled to that at which the command leaves that answers it (one host, one clock); lost: states without one.

minute  memory robot  sensor  controller   files  answer p50 us   p99 us  max us  lost  faults";
/// So much may become more from the first to the last hour or minute: KiB, and as a ratio of the time it takes.
const GROWTH_KIB: u64 = 256;
const GROWTH: f64 = 2.0;
/// Of the desired force, once it has settled; noise alone makes it 0.09 within hours.
const MOST_ERROR: f64 = 0.2;

fn main() -> ExitCode {
    let minutes = std::env::args()
        .nth(1)
        .and_then(|text| text.parse().ok())
        .unwrap_or(20);
    let outcome = SIMULATED_H
        .into_iter()
        .map(|(name, hours)| simulated(name, hours))
        .chain(std::iter::once_with(|| soak(minutes)))
        .find_map(|it| it.transpose());
    match outcome {
        None => ExitCode::SUCCESS,
        Some(Ok(what)) => {
            println!("\nNO: {what}");
            ExitCode::FAILURE
        }
        Some(Err(error)) => {
            println!("{error}");
            ExitCode::FAILURE
        }
    }
}

/// What has grown, or has not been kept to, within so many hours of a scenario in one process.
fn simulated(name: &str, hours: u32) -> Result<Option<String>, Box<dyn Error>> {
    let duration = format!("timing.duration_s={}", 3600 * hours);
    let scenario = Source::find(name)?.scenario(&[duration])?;
    let (own, hour) = (std::process::id(), rint(3600.0 / spatial::TICK_S) as i64);
    let (mut memory_kib, mut took_s, mut began) = (Vec::new(), Vec::new(), clock::now());
    let mut worst_n: f64 = 0.0;
    in_process::run(&scenario, |tick| {
        let (now, status) = (tick.link_motion.stamp.step, tick.controller.map(|it| it.status));
        if let Some(status) = status.filter(|_| now > hour) {
            worst_n = match status.phase {
                // Noise leads out of the band in which it is settled now and then.
                ControllerPhase::Contact | ControllerPhase::Settled => {
                    worst_n.max(status.force_error_n.abs())
                }
                _ => f64::INFINITY,
            };
        }
        if now > 0 && now % hour == 0 {
            memory_kib.push(resident_kib(own).unwrap_or_default());
            took_s.push((clock::now() - began).as_secs_f64());
            began = clock::now();
        }
    });
    let (Some((&first, &last)), Some((&quick, &late))) = (
        memory_kib.first().zip(memory_kib.last()),
        took_s.first().zip(took_s.last()),
    ) else {
        return Ok(None);
    };
    println!(
        "{name}, {hours} h simulated in one process: memory after the first hour {first} KiB, at the end {last} KiB; the first \
         hour took {quick:.1} s, the last {late:.1} s; largest error of the force after the first {worst_n:.2} N"
    );
    let kept = worst_n <= MOST_ERROR * scenario.task.desired_force_n;
    Ok(match (last > first + GROWTH_KIB, late > GROWTH * quick, kept) {
        (true, ..) => Some("memory has grown".to_owned()),
        (_, true, _) => Some("it has become slower".to_owned()),
        (.., false) => Some("the force has not been kept".to_owned()),
        _ => None,
    })
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
        let at = rint(share * last as f64) as usize;
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
