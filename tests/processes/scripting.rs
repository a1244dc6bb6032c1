//! The experiment in Python: a cell is started, changed, watched and stopped by the wire contract alone.

use super::conform::python_with_types;
use super::up::{LONG, WHOLE, cell, up};
use crate::python;
use lcmtypes::LcmBuilder;
use node::{clock, key_file};
use spatial::ports::{ControllerPhase, ControllerStatus};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use tests::{Bench, touchdown};

/// With a suffix, since other cells may be on the port.
const SUFFIXED: &str = "&suffix=_B";

/// `experiment.py` for the cell on the port of `bench`, whose types are generated in its directory.
struct Script {
    python: PathBuf,
    plain_url: String,
    url: String,
    types: PathBuf,
}

impl Script {
    /// `None`, which is said: there is no Python for it.
    fn of(bench: &Bench) -> Option<Self> {
        let python = python_with_types(bench)?;
        let types = bench.directory.path().to_owned();
        let plain_url = bench.plan.wiring.watch.clone();
        Some(Self {
            python,
            url: plain_url.clone() + SUFFIXED,
            plain_url,
            types,
        })
    }

    fn run(&self, forces: &str, arguments: &[&str]) -> Output {
        let mut command = Command::new(&self.python);
        command.arg("-B").arg(repository().join("examples/experiment.py"));
        command
            .args([
                "--url",
                &self.plain_url,
                "--suffix",
                "_B",
                "--force-n",
                forces,
                "--types",
            ])
            .arg(&self.types);
        command.args(arguments).output().unwrap()
    }
}

fn repository() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../lcmtypes")
}

/// A cell that waits to be asked, with `more` in its file.
fn waiting_cell(bench: &Bench, more: &str) -> PathBuf {
    let file = cell(bench, "cell.toml", 7);
    let text = fs::read_to_string(&file).unwrap();
    let waits = text
        .replace("set = [", "set = [\"task.starts_by_itself=false\", ")
        .replace("?ttl=0", &format!("?ttl=0{SUFFIXED}"));
    fs::write(&file, format!("{more}{waits}")).unwrap();
    file
}

#[test]
fn an_experiment_in_python_presses_with_one_force_after_the_other() {
    let bench = Bench::new(&[]).unwrap();
    let Some(script) = Script::of(&bench) else { return };
    let cell_up = up(&waiting_cell(&bench, ""), &[]);
    cell_up.until(WHOLE);

    let output = script.run("8,12", &[]);
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{said}");
    let text = String::from_utf8(output.stdout).unwrap();
    let rows: Vec<Vec<f64>> = text
        .lines()
        .skip(1)
        .map(|line| line.split(',').map(|field| field.parse().unwrap()).collect())
        .collect();
    assert_eq!(rows.len(), 2, "{text}");
    for (row, force_n) in rows.iter().zip([8.0, 12.0]) {
        assert!(row[0] == force_n && (row[1] - force_n).abs() < 0.5, "{text}");
    }
    // A force that the scenario does not allow is refused, with the limit.
    let refused = script.run("1e4", &[]);
    let said = String::from_utf8_lossy(&refused.stderr);
    assert_eq!(refused.status.code(), Some(1), "{said}");
    assert!(said.contains("refused: out of range, "), "{said}");
    assert_eq!(cell_up.end(), 0);
}

/// Who has the key is followed, in Python and by `touchdown task`; who has none, or another one, is not even answered.
#[test]
fn under_a_key_those_who_sign_are_followed() {
    let bench = Bench::new(&[]).unwrap();
    let Some(script) = Script::of(&bench) else { return };
    let directory = bench.directory.path();
    let key = |name: &str| {
        let path = directory.join(name);
        key_file::create(&path).unwrap();
        path.to_str().unwrap().to_owned()
    };
    let (own, other) = (key("cell.key"), key("other.key"));
    let file = waiting_cell(&bench, "keys = [\"cell.key\"]\n");
    let cell_up = up(&file, &[]);
    cell_up.until(WHOLE);
    let mut link = LcmBuilder::open(&script.url).unwrap();
    let statuses = link.subscribe::<ControllerStatus>(64);
    let link = link.start().unwrap();
    let give_up = clock::now() + LONG;
    let ready = std::iter::from_fn(|| statuses.receiver().recv_deadline(give_up).ok())
        .any(|received| received.message.phase == ControllerPhase::Ready);
    assert!(ready);
    drop(link);

    let output = script.run("8", &[]);
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(
        !output.status.success() && said.contains("no controller has answered"),
        "{said}"
    );
    let mut command = touchdown();
    command.args(["task", "start", "--url", &script.url, "--key", &other]);
    let output = command.output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(
        !output.status.success() && said.contains("signed with this key"),
        "{said}"
    );
    let output = script.run("8", &["--key", &own]);
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    assert_eq!(text.lines().count(), 2, "{text}");
    let output = touchdown()
        .args(["task", "set-force", "9", "--cell"])
        .arg(&file)
        .output()
        .unwrap();
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    assert_eq!(cell_up.end(), 0);
}

/// The contract once more, in another language.
#[test]
fn python_signs_as_the_contract_says() {
    let Ok(python) = python::python() else {
        return eprintln!("SKIPPED: no Python with LCM");
    };
    let check = "
import sys
sys.path.insert(0, sys.argv[1])
import authenticity
key = authenticity.Key(bytes(range(32)))
for line in open(sys.argv[2]):
    channel, text = line.split()
    if channel == 'key_id':
        assert key.id == int(text)
    else:
        encoding = bytes.fromhex(text)
        assert key.tag(channel, encoding) == encoding[-16:], channel
        assert key.tag(channel, bytes([encoding[0] ^ 1]) + encoding[1:]) != encoding[-16:]
        print(channel)
";
    let mut command = Command::new(python);
    command.args(["-B", "-c", check]);
    command.args([
        repository().join("examples"),
        repository().join("tests/golden/tags"),
    ]);
    let output = command.output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{said}");
    assert_eq!(
        String::from_utf8_lossy(&output.stdout),
        "ROBOT_STATE\nSENSOR_DEFLECTION\nROBOT_COMMAND\nTASK\n"
    );
}
