//! The experiment in Python: a cell is started, changed, watched and stopped by the wire contract alone.

use super::conform::lcm_gen;
use super::up::{WHOLE, cell, up};
use crate::python;
use std::fs;
use std::path::Path;
use std::process::Command;
use tests::Bench;

#[test]
fn an_experiment_in_python_presses_with_one_force_after_the_other() {
    let bench = Bench::new(&[]).unwrap();
    let python = match python::python() {
        Ok(python) => python,
        Err(error) => return eprintln!("SKIPPED: no Python with LCM: {error}"),
    };
    let repository = Path::new(env!("CARGO_MANIFEST_DIR")).join("../lcmtypes");
    let types = bench.directory.path();
    python::generate(&lcm_gen(), &repository.join("types"), types).unwrap();
    let file = cell(&bench, "cell.toml", 7);
    let text = fs::read_to_string(&file).unwrap();
    // With a suffix, since other cells may be on the port.
    let waits = text
        .replace("set = [", "set = [\"task.starts_by_itself=false\", ")
        .replace("?ttl=0", "?ttl=0&suffix=_B");
    fs::write(&file, waits).unwrap();
    let cell_up = up(&file, &[]);
    cell_up.until(WHOLE);

    let url = &bench.plan.wiring.watch;
    let script = |forces: &str| {
        let mut command = Command::new(&python);
        command.arg(repository.join("examples/experiment.py"));
        command
            .args(["--url", url, "--suffix", "_B", "--force-n", forces, "--types"])
            .arg(types);
        command.output().unwrap()
    };
    let output = script("8,12");
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
    let refused = script("1e4");
    let said = String::from_utf8_lossy(&refused.stderr);
    assert_eq!(refused.status.code(), Some(1), "{said}");
    assert!(said.contains("refused: out of range, "), "{said}");
    assert_eq!(cell_up.end(), 0);
}
