//! The report: whole, self-contained, the same on any number of threads, and nothing in it that a command does not compute.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "tests")]

mod common;

use common::touchdown;
use serde_json::Value;
use std::path::Path;

const SMALL: &str = "report --scenarios paper,soft --phases 2 --seeds 1 --sweep smoke --sweep-phases 1";

fn written(out: &Path, more: &str) -> String {
    let (code, stdout, stderr) = touchdown(&format!("{SMALL} --out {} {more}", out.display()));
    assert_eq!((code, stderr.as_str()), (0, ""));
    assert_eq!(stdout, format!("{}\n", out.join("report.html").display()));
    std::fs::read_to_string(out.join("report.html")).unwrap()
}

#[test]
fn a_small_report_is_whole_and_shows_what_its_commands_compute() {
    let directory = tempfile::tempdir().unwrap();
    let page = written(directory.path(), "--threads 1");
    well_formed(&page);
    self_contained(&page);
    // The maps are resumed, and nothing depends on the threads.
    assert!(page == written(directory.path(), "--threads 3"));
    assert!(page == written(directory.path(), "--threads 2 --fresh"));

    let origins = origins(&page);
    assert!(origins.len() > 10, "{origins:?}");
    let mut compared = 0;
    for (command, hash) in &origins {
        let Some(arguments) = command.strip_prefix("touchdown ") else {
            panic!("{command}");
        };
        // `run` needs a network; its commands are parsed in `cli/report.rs`.
        if !arguments.starts_with("compare ") {
            continue;
        }
        let (code, stdout, stderr) = touchdown(&format!("{arguments} --json"));
        assert_eq!((code, stderr.as_str()), (0, ""), "{command}");
        let found: Value = serde_json::from_str(&stdout).unwrap();
        assert_eq!(found["configuration_hash"], hash.as_str(), "{command}");
        for row in found["rows"].as_array().unwrap() {
            for (name, mean) in row["mean"].as_object().unwrap() {
                let digits = |value: &Value| value.as_f64().map_or("NaN".to_owned(), |v| format!("{v:?}"));
                let (worst, half) = (&row["worst"][name], &row["confidence"][name]);
                let cell = format!(
                    "data-v=\"{}\" data-worst=\"{}\" data-ci=\"{}\"",
                    digits(mean),
                    digits(worst),
                    digits(half)
                );
                assert!(page.contains(&cell), "{command}: {name}: {cell}");
                compared += 1;
            }
        }
    }
    // Both scenarios, the first one twice: beside its figures and its table.
    assert_eq!(compared, 16 * (13 + 13 + 2));

    let (_, stdout, _) = touchdown(&format!(
        "sweep smoke --phases 1 --json --out {}",
        directory.path().join("sweep").display()
    ));
    let found: Value = serde_json::from_str(&stdout).unwrap();
    let sweep = (
        "touchdown sweep smoke --phases 1",
        found["configuration_hash"].as_str().unwrap(),
    );
    assert!(
        origins
            .iter()
            .any(|(command, hash)| (command.as_str(), hash.as_str()) == sweep)
    );
    let map = std::fs::read_to_string(directory.path().join("sweep/delay.svg")).unwrap();
    let inside = map.split_once("viewBox").unwrap().1.split_once('>').unwrap().1;
    assert!(page.contains(inside), "the map is not the sweep's");
}

#[test]
fn what_cannot_be_reported_is_refused_before_anything_runs() {
    let directory = tempfile::tempdir().unwrap();
    let out = directory.path().join("out");
    for (arguments, error) in [
        (
            "--scenarios papre",
            "unknown scenario \"papre\"; the built-in ones are: paper",
        ),
        (
            "--scenarios paper,paper",
            "--scenarios names \"paper\" twice; name each once",
        ),
        (
            "--sweep somke",
            "unknown sweep \"somke\"; the built-in ones are: smoke",
        ),
        (
            "--phases 0",
            "invalid value '0' for '--phases <N>': 0 is not in 1..=1000",
        ),
    ] {
        let (code, stdout, stderr) = touchdown(&format!("report {arguments} --out {}", out.display()));
        assert_eq!((code, stdout.as_str()), (2, ""), "{arguments}: {stderr}");
        assert!(stderr.contains(error), "{arguments}: {stderr}");
    }
    assert!(!out.exists());
}

/// Commands and hashes, in their order.
fn origins(page: &str) -> Vec<(String, String)> {
    let command = page.split("<code class=\"command\">").skip(1);
    let text = |part: &str| part.split_once('<').unwrap().0.to_owned();
    command
        .filter_map(|part| {
            // The last one makes the whole page, of many configurations.
            let hash = part
                .split("</p>")
                .next()
                .unwrap()
                .split_once("<code class=\"hash\">")?
                .1;
            Some((text(part), text(hash)))
        })
        .collect()
}

/// Nothing is loaded from anywhere, and nothing of the machine is told.
fn self_contained(page: &str) {
    for foreign in [
        "http",
        "src=",
        "@import",
        "url(",
        "<link",
        "file:",
        "//cdn",
        "NaN m",
        env!("CARGO_MANIFEST_DIR"),
    ] {
        assert!(!page.contains(foreign), "{foreign}");
    }
    for link in page.split("href=\"").skip(1) {
        let anchor = link
            .split('"')
            .next()
            .unwrap()
            .strip_prefix('#')
            .expect("inside the page");
        assert!(page.contains(&format!("id=\"{anchor}\"")), "{anchor}");
    }
}

/// Every element that is opened is closed, in order; the text has no stray brackets.
fn well_formed(page: &str) {
    assert!(page.starts_with("<!DOCTYPE html><html lang=\"en\">") && page.ends_with("</html>"));
    // What a style or script says is no markup.
    let mut rest = page.strip_prefix("<!DOCTYPE html>").unwrap();
    let mut open: Vec<&str> = Vec::new();
    let mut figures = 0;
    while let Some((text, after)) = rest.split_once('<') {
        let raw = open.last().is_some_and(|last| ["style", "script"].contains(last));
        if raw && !after.starts_with(&format!("/{}", open.last().unwrap())) {
            rest = after;
            continue;
        }
        assert!(raw || !text.contains('>'), "{text}");
        let (tag, after) = after.split_once('>').unwrap();
        assert_eq!(tag.matches('"').count() % 2, 0, "{tag}");
        let name = tag
            .trim_start_matches('/')
            .split([' ', '\n', '/'])
            .next()
            .unwrap();
        if tag.starts_with('/') {
            assert_eq!(open.pop(), Some(name), "</{name}>");
        } else if !tag.ends_with('/') && name != "meta" {
            figures += usize::from(name == "svg");
            open.push(name);
        }
        rest = after;
    }
    assert_eq!(open, Vec::<&str>::new());
    // Two rankings, seven laws, two laws of the other scenario, a map.
    assert_eq!(figures, 2 + 7 + 2 + 1);
}
