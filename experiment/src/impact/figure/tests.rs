//! The drawn assessment.

use super::*;
use crate::impact::scenario::question;
use node::scenario::Scenario;

fn report(allowed_force_n: Option<f64>) -> Report {
    let mut question = question(&Scenario::default(), "paper").unwrap();
    question.allowed_force_n = allowed_force_n;
    question.controlled_peak_n = Some(14.0);
    question.sampling_time_s = 0.002;
    question.answer().unwrap()
}

/// The curves are those of the assessment: they end where the force vanishes, and peak where it says.
#[test]
fn the_panels_show_the_assessment() {
    let report = report(Some(150.0));
    let panels = panels(&report);
    let [force, depth, peak] = panels.as_slice() else {
        unreachable!()
    };
    let highest = |panel: &Panel<'_>| panel.points.iter().map(|point| point.1).fold(0.0, f64::max);
    assert!((highest(force) / report.peak_force_n - 1.0).abs() < 1e-3);
    assert!((highest(depth) / (1e6 * report.maximum_depth_m) - 1.0).abs() < 1e-3);
    let end = |panel: &Panel<'_>| panel.points[panel.points.len() - 1];
    assert!(
        (end(force).0 / (1e3 * report.characteristic_time_s) - 1.0).abs() < 1e-9 && end(force).1.abs() < 1e-6
    );
    assert!((end(depth).1 / (1e6 * report.remaining_depth_m) - 1.0).abs() < 1e-9);
    // The speed for the allowed force is on the axis, and the peak is reached there.
    assert!(highest(peak) > 150.0);
}

#[test]
fn it_is_drawn_without_a_value_that_is_no_number() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("impact.svg");
    draw(&[report(None), report(Some(50.0))], &path).unwrap();
    let svg = std::fs::read_to_string(&path).unwrap();
    assert!(svg.starts_with("<svg width=\"960\" height=\"600\" viewBox") && !svg.contains("NaN"));
    for text in [
        "force, N",
        "peak force, N",
        "allowed",
        "controlled peak",
        "one sampling time",
    ] {
        assert!(svg.contains(text), "{text}");
    }
    let error = draw(&[report(None)], &directory.path().join("no such/impact.svg"))
        .unwrap_err()
        .to_string();
    assert!(error.contains("impact.svg can't be written"), "{error}");
}
