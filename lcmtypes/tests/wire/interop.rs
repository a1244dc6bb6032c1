//! Python's LCM 1.5.3 reads what Rust writes and the other way round, through a log and over multicast.

use crate::draw::Counting;
use crate::link::next;
use crate::python::{self, REMEDY};
use crate::samples::{Sample, for_all_messages};
use crate::{expect, golden, udpm_url};
use lcmtypes::{EventLogReader, EventLogWriter, LcmBuilder, Message};
use spatial::ports::*;
use std::env;
use std::fmt::Debug;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Command as Process, Stdio};
use std::sync::LazyLock;

static PYTHON: LazyLock<PathBuf> = LazyLock::new(|| good(python::python()));

fn good<T>(result: Result<T, String>) -> T {
    result.unwrap_or_else(|error| panic!("{error}"))
}

fn run(command: &mut Process) {
    good(python::run(command));
}

/// The golden values, written anew by Python if `UPDATE_GOLDEN` is set.
static GOLDEN: LazyLock<PathBuf> = LazyLock::new(|| {
    if env::var_os("UPDATE_GOLDEN").is_some() {
        let directory = tempfile::TempDir::new().unwrap();
        let log = write_samples(directory.path());
        run(script("describe", directory.path(), &golden::directory()).arg(log));
    }
    golden::directory()
});

/// The script, with types that lcm-gen generates into `directory`.
fn script(command: &str, directory: &Path, golden: &Path) -> Process {
    let types = Path::new(env!("CARGO_MANIFEST_DIR")).join("types");
    good(python::generate(Path::new(env!("LCM_GEN")), &types, directory));
    let mut script = Process::new(&*PYTHON);
    script
        .arg(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/interop.py"))
        .arg(command);
    script.arg(directory).arg(golden);
    script
}

/// A log of all samples, in `directory`.
fn write_samples(directory: &Path) -> PathBuf {
    fn write<M: Message + Sample>(log: &mut EventLogWriter) {
        let encoded = M::sample(&mut Counting::default()).encode().unwrap();
        log.write(0, encoded.channel(), encoded.as_bytes()).unwrap();
    }
    let path = directory.join("rust.lcmlog");
    let mut log = EventLogWriter::create(&path).unwrap();
    macro_rules! write_all { ($($message:ty),*) => { $(write::<$message>(&mut log);)* } }
    for_all_messages!(write_all);
    log.close().unwrap();
    path
}

fn read<M: Message + Sample + Debug + PartialEq>(log: &mut EventLogReader) {
    let event = log.next().expect("an event of every channel").unwrap();
    assert_eq!(event.channel, M::CHANNEL);
    let sample = M::sample(&mut Counting::default());
    assert_eq!(M::decode(&event.bytes).unwrap(), sample);
    assert_eq!(event.bytes, sample.encode().unwrap().as_bytes());
}

#[test]
fn python_and_rust_mean_the_same_by_the_same_bytes() {
    let directory = tempfile::TempDir::new().unwrap();
    let (ours, theirs) = (
        write_samples(directory.path()),
        directory.path().join("python.lcmlog"),
    );
    run(script("log", directory.path(), &GOLDEN).args([&ours, &theirs]));

    let mut log = EventLogReader::open(&theirs).unwrap();
    macro_rules! read_all { ($($message:ty),*) => { $(read::<$message>(&mut log);)* } }
    for_all_messages!(read_all);
    assert!(log.next().is_none());
}

#[test]
fn python_and_rust_hear_each_other() {
    let directory = tempfile::TempDir::new().unwrap();
    let (there, back) = (udpm_url(), udpm_url());
    let mut command = script("link", directory.path(), &GOLDEN);
    let mut python = command
        .args([&there, &back])
        .stdout(Stdio::piped())
        .spawn()
        .expect(REMEDY);
    let mut ready = String::new();
    BufReader::new(python.stdout.take().unwrap())
        .read_line(&mut ready)
        .unwrap();
    assert_eq!(ready, "ready\n", "the script says why on standard error");

    let mut builder = expect(LcmBuilder::open(&back));
    let lcm = expect(expect(LcmBuilder::open(&there)).start());
    macro_rules! subscribe { ($($message:ty),*) => { ($(builder.subscribe::<$message>(1)),*) } }
    let subscriptions = for_all_messages!(subscribe);
    let _receiving = expect(builder.start());

    macro_rules! publish { ($($message:ty),*) => { $(
        expect(lcm.publish(&<$message>::sample(&mut Counting::default())));
    )* } }
    for_all_messages!(publish);
    macro_rules! receive { ($($index:tt)*) => { $(
        assert_eq!(next(&subscriptions.$index), Sample::sample(&mut Counting::default()));
    )* } }
    receive!(0 1 2 3 4 5 6 7 8 9);
    assert!(python.wait().unwrap().success());
}
