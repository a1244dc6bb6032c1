//! What an attacker who holds no key can do, and faults, as a table: `make hostile`. An argument names the attacks that are
//! tried by a part of their names.

use node::key_file;
use spatial::ports::Fault;
use std::error::Error;
use std::process::ExitCode;
use std::time::Duration;
use tests::Attack;
use tests::faults::{Injury, Moment, inflict};
use tests::hostile::{Endured, endure};
use tests::site::Setting;

const HEAD: &str = "\
Three programs in real time on one port of one host, and an attacker beside them that holds no key: 10 packets per ms on the
device channels at most, a flood of as many as can be sent, for 10 s from the approach on (`tests/attack.rs`). First on
programs without a key, then on programs with one, which also endure what others would believe.
unusable, refused, dropped: what the nodes' statuses count, all three together; stop: from the end of the last good
command's horizon to the standstill, and what is promised; force: the largest, and that of the first contact as it was
expected; memory: of the node that has grown most, before and after; again: once the attack is over, after `touchdown task
reset` and `start`. In lines of faults: once the injured program is started anew; at all moments: docs/faults.txt.";
const SCENARIO: &str = "arm";
const TIME: Duration = Duration::from_secs(10);
const SEED: u64 = 12;

fn main() -> ExitCode {
    let only = std::env::args().nth(1).unwrap_or_default();
    println!("{HEAD}\n\nScenario {SCENARIO}");
    match run(&only) {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(error) => {
            println!("{error}");
            ExitCode::FAILURE
        }
    }
}

/// The attacks whose names contain `only`, and faults if that is all of them; whether all that was promised was kept.
fn run(only: &str) -> Result<bool, Box<dyn Error>> {
    let setting = Setting {
        scenario: SCENARIO,
        ..Setting::default()
    };
    let directory = tempfile::tempdir()?;
    let key = directory.path().join("cell.key");
    key_file::create(&key)?;
    let chosen = |of: &[Attack]| -> Vec<Attack> {
        let named = of.iter().filter(|attack| attack.to_string().contains(only));
        named.copied().collect()
    };
    let without = attacks("without a key", &setting, &chosen(&Attack::ALL));
    let with = Setting {
        key: Some(&key),
        ..setting
    };
    let all = [Attack::ALL.as_slice(), &Attack::FORGERIES].concat();
    let with = attacks("with a key", &with, &chosen(&all));
    let faults = only.is_empty().then(|| faults(&setting));
    println!(
        "\n{:30} {:>8} {:>6} {:>14} {:>5} {:>16} {:>16} {:>20}",
        "",
        "packets",
        "tried",
        "nodes survived",
        "kept",
        "largest force N",
        "slowest stop ms",
        "memory at the end MiB"
    );
    without.print("attacks without a key");
    with.print("attacks with a key");
    if let Some(faults) = &faults {
        faults.print("faults at the contact");
    }
    let mut all = [Some(without), Some(with), faults].into_iter().flatten();
    Ok(all.all(|it| it.kept == it.tried))
}

/// A table of what `attacks` do to nodes as `setting` says.
fn attacks(title: &str, setting: &Setting<'_>, attacks: &[Attack]) -> Summary {
    println!();
    row([
        title,
        "packets",
        "unusable",
        "refused",
        "dropped",
        "robot",
        "controller",
        "stop ms",
        "force N",
        "memory MiB",
        "again N",
        "kept",
    ]
    .map(str::to_owned));
    let mut all = Vec::new();
    for &attack in attacks {
        match endure(setting, attack, TIME, SEED) {
            Ok(endured) => {
                row(cells(attack, &endured));
                all.push(endured);
            }
            Err(error) => println!("{attack}: {error}"),
        }
    }
    Summary {
        tried: attacks.len(),
        sent: Some(all.iter().map(|it| it.sent).sum()),
        survived: all.iter().filter(|it| it.gone.is_empty()).count(),
        kept: all.iter().filter(|it| it.broken().is_none()).count(),
        force_n: all.iter().map(|it| it.force_n[0]).fold(0.0, f64::max),
        stop_ms: all
            .iter()
            .filter_map(|it| it.stop_ticks)
            .map(|[took, _]| took)
            .max(),
        memory_kib: all
            .iter()
            .flat_map(|it| it.memory_kib)
            .map(|[_, after]| after)
            .max(),
    }
}

/// What came of many.
#[derive(Default)]
struct Summary {
    tried: usize,
    /// Packets; `None`: none.
    sent: Option<u64>,
    survived: usize,
    kept: usize,
    force_n: f64,
    stop_ms: Option<i64>,
    /// Of the largest node; `None`: not measured.
    memory_kib: Option<u64>,
}

impl Summary {
    fn print(&self, what: &str) {
        let Self {
            tried,
            survived,
            kept,
            force_n,
            ..
        } = self;
        let sent = self.sent.map_or("-".to_owned(), |sent| sent.to_string());
        let stop = self.stop_ms.map_or("-".to_owned(), |ms| ms.to_string());
        let memory = self
            .memory_kib
            .map_or("-".to_owned(), |kib| format!("{:.1}", kib as f64 / 1024.0));
        println!(
            "{what:30} {sent:>8} {tried:>6} {survived:>14} {kept:>5} {force_n:>16.0} {stop:>16} {memory:>20}"
        );
    }
}

/// Every fault at the moment at which most force is there; at all moments: `make faults`.
fn faults(setting: &Setting<'_>) -> Summary {
    let mut summary = Summary::default();
    for injury in Injury::all() {
        summary.tried += 1;
        match inflict(setting, injury, Moment::Contact) {
            Ok(outcome) => {
                let lost = outcome.broken();
                if let Some(lost) = &lost {
                    println!("{injury}: NO: {lost}");
                }
                summary.kept += usize::from(lost.is_none());
                // Whoever works again is there.
                summary.survived += usize::from(outcome.again_n.is_ok());
                summary.force_n = summary.force_n.max(outcome.force_n[0]);
                summary.stop_ms = summary.stop_ms.max(outcome.stop_ticks.map(|[took, _]| took));
            }
            Err(error) => println!("{injury}: {error}"),
        }
    }
    summary
}

fn cells(attack: Attack, endured: &Endured) -> [String; 12] {
    let state = |mode: &str, fault: Fault| match fault {
        Fault::None => mode.to_owned(),
        fault => fault.name().to_owned(),
    };
    let mib = |kib: u64| kib as f64 / 1024.0;
    let grown = endured
        .memory_kib
        .iter()
        .max_by_key(|[before, after]| after.saturating_sub(*before));
    let (counted, (mode, fault)) = (endured.counted, endured.robot);
    [
        attack.to_string(),
        endured.sent.to_string(),
        counted.unusable.to_string(),
        counted.refused.to_string(),
        counted.dropped.to_string(),
        state(mode.name(), fault),
        state("works", endured.controller),
        endured
            .stop_ticks
            .map_or("-".to_owned(), |[took, may]| format!("{took} ({may})")),
        format!("{:.0} ({:.0})", endured.force_n[0], endured.force_n[1]),
        grown.map_or("-".to_owned(), |[before, after]| {
            format!("{:.1} -> {:.1}", mib(*before), mib(*after))
        }),
        match &endured.again_n {
            Some(Ok(force_n)) => format!("{force_n:.1}"),
            _ => "-".to_owned(),
        },
        endured
            .broken()
            .map_or("yes".to_owned(), |what| format!("NO: {what}")),
    ]
}

fn row(cells: [String; 12]) {
    let [
        attack,
        packets,
        unusable,
        refused,
        dropped,
        robot,
        controller,
        stop,
        force,
        memory,
        again,
        kept,
    ] = cells;
    println!(
        "{attack:27} {packets:>8} {unusable:>8} {refused:>8} {dropped:>8}  {robot:11} {controller:12} {stop:>10} {force:>10} \
         {memory:>14} {again:>8}  {kept}"
    );
}
