//! Table and figure of the README come from a run: `make demo` prints and draws the same.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use experiment::figure::{LabelledCurve, force_figure};
use experiment::metrics::Recording;
use experiment::table::{Row, Table};
use experiment::transcript;
use node::scenario::Scenario;

const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/..");

#[test]
fn the_readme_shows_what_make_demo_shows() {
    let text = experiment::scenarios::Source::find("elastic_arm").unwrap().text;
    let (mut rows, mut curves) = (Vec::new(), Vec::new());
    for law in ["elastic", "pd"] {
        let scenario = Scenario::parse("elastic_arm", &text, &[format!("controller.law={law}")]).unwrap();
        let entries = transcript::in_process(&scenario).unwrap();
        let (recording, measured) = Recording::from_transcript(&scenario, &entries);
        let metrics = recording.metrics().unwrap();
        rows.push(Row::single("elastic", "arm", law, metrics));
        curves.push(LabelledCurve::new(law, &scenario, &recording, measured).unwrap());
    }
    let table = Table(&rows).to_string();
    let readme = std::fs::read_to_string(format!("{ROOT}/README.md")).unwrap();
    assert!(
        readme.contains(&table),
        "README.md does not show this table:\n{table}"
    );

    let drawn = std::env::temp_dir().join(format!("touchdown-readme-{}.svg", std::process::id()));
    force_figure(&curves, &drawn).unwrap();
    let (drawn_bytes, shown) = (
        std::fs::read(&drawn).unwrap(),
        std::fs::read(format!("{ROOT}/docs/force.svg")).unwrap(),
    );
    std::fs::remove_file(&drawn).unwrap();
    assert!(
        drawn_bytes == shown,
        "docs/force.svg is not what `make demo` draws: copy target/demo/force.svg there"
    );
}
