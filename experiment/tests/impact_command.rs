//! `touchdown impact` as its users see it.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod common;

use common::touchdown;
use serde_json::Value;

const FLAT_PUNCH: &str = "--shape flat-punch --radius-m 0.008 --mass-kg 4 --speed-m-per-s 0.02";

/// The same of `touchdown impact`.
fn impact(arguments: &str) -> (i32, String, String) {
    touchdown(&format!("impact {arguments}"))
}

fn json(arguments: &str) -> Value {
    let (code, stdout, stderr) = impact(&format!("{arguments} --json"));
    assert_eq!((code, stderr.as_str()), (0, ""), "{arguments}");
    serde_json::from_str(&stdout).unwrap()
}

#[track_caller]
fn close(found: &Value, expected: f64) {
    let found = found.as_f64().unwrap();
    assert!(
        (found / expected - 1.0).abs() < 1e-9,
        "{found} instead of {expected}"
    );
}

#[test]
fn the_answer_is_one_object_with_units_in_its_keys() {
    let answer = json(&format!("{FLAT_PUNCH} --effective-modulus-pa 1e9"));
    assert_eq!(answer["command"], "impact");
    close(&answer["peak_force_n"], 160.0);
    close(&answer["maximum_depth_m"], 1e-5);
    close(&answer["characteristic_time_s"], std::f64::consts::PI / 2000.0);
    close(&answer["indentation_n_per_m"], 16e6);
    assert_eq!(answer["remaining_depth_m"], 0.0);
    assert_eq!(answer["controllable"], false);
}

/// Table I to four digits; the paper prints 0.7 ms and 9000 N, 1.5 ms and 160 N.
#[test]
fn table_1_of_the_paper_is_an_example() {
    let (code, stdout, _) = impact("--example table-1");
    assert_eq!(code, 0);
    let cells = |name: &str| -> Vec<String> {
        let line = stdout.lines().find(|line| line.starts_with(name)).unwrap();
        line.split_whitespace().rev().take(2).map(String::from).collect()
    };
    assert_eq!(cells("peak force, N"), ["160.0", "8944"]);
    assert_eq!(cells("characteristic impact time, ms"), ["1.571", "0.7025"]);
    assert_eq!(
        stdout
            .matches("no controller of this sampling time can change it")
            .count(),
        2
    );
    assert_eq!(json("--example table-1")["reports"].as_array().unwrap().len(), 2);
}

#[test]
fn materials_give_the_effective_modulus() {
    let answer = json(&format!("{FLAT_PUNCH} --tool steel --object wood-across-grain"));
    close(
        &answer["effective_modulus_pa"],
        1.0 / ((1.0 - 0.09) / 207e9 + (1.0 - 0.09) / 0.63e9),
    );
}

/// The tool's inertia makes 107.264 of 160 N (PLANT.md section 5), the robot's mass more.
#[test]
fn the_mass_that_strikes_is_the_effective_one() {
    let inertia = "--inertia-kg-m2 0.012,0.016,0.010 --centre-of-mass-m 0.03,0,-0.06 --tcp-m 0.10,0,-0.15";
    let answer = json(&format!("{FLAT_PUNCH} --effective-modulus-pa 1e9 {inertia}"));
    assert!(
        (answer["peak_force_n"].as_f64().unwrap() - 107.264).abs() < 0.001,
        "{answer}"
    );
    let bolted = json(&format!(
        "{FLAT_PUNCH} --effective-modulus-pa 1e9 --robot-mass-kg 96"
    ));
    close(&bolted["peak_force_n"], 800.0);
}

#[test]
fn the_highest_speeds_are_told() {
    let asked = "--rebound-ratio 4 --allowed-force-n 80 --allowed-remaining-m 3e-6";
    let answer = json(&format!("{FLAT_PUNCH} --effective-modulus-pa 1e9 {asked}"));
    close(&answer["speed_for_allowed_force_m_per_s"], 0.010);
    close(&answer["speed_for_allowed_remaining_depth_m_per_s"], 0.008);
    let (_, stdout, _) = impact(&format!("{FLAT_PUNCH} --effective-modulus-pa 1e9 {asked}"));
    assert!(
        stdout.contains("Approach at 8.000 mm/s at most: the 20.00 mm/s asked for is too fast."),
        "{stdout}"
    );
}

#[test]
fn which_limit_matters_is_said() {
    let with_peak = |peak: &str| {
        let arguments = format!("{FLAT_PUNCH} --effective-modulus-pa 1e9 --controlled-peak-n {peak}");
        (json(&arguments)["limit"].clone(), impact(&arguments).1)
    };
    let (limit, text) = with_peak("16");
    assert_eq!(limit, "impact");
    assert!(
        text.contains("The impact is the limit: its 160.0 N are 10.00 times the 16.00 N"),
        "{text}"
    );
    let (limit, text) = with_peak("200");
    assert_eq!(limit, "control");
    assert!(text.contains("Control is the limit: the 200.0 N"), "{text}");
    let slow = impact("--indentation-n-per-m 1000 --mass-kg 4 --speed-m-per-s 0.02").1;
    assert!(slow.contains("control can act on it before it is over"), "{slow}");
}

/// 10 kg (a moving mass of 12 kg, half of it, and the tool's 4) against 0.6 kg with 75 N/mm.
#[test]
fn the_transient_contact_is_no_certification() {
    let body = "--body-mass-kg 0.6 --body-stiffness-n-per-m 75e3 --body-force-n 280 --moving-mass-kg 12";
    let arguments = format!("{FLAT_PUNCH} --effective-modulus-pa 1e9 {body}");
    let contact = &json(&arguments)["transient_contact"];
    close(&contact["reduced_mass_kg"], 6.0 / 10.6);
    close(
        &contact["speed_for_allowed_force_m_per_s"],
        280.0 / (6.0 / 10.6 * 75e3_f64).sqrt(),
    );
    assert!(
        contact["notice"].as_str().unwrap().contains("no certification"),
        "{contact}"
    );
    assert!(impact(&arguments).1.contains("no certification"));
}

#[test]
fn a_scenario_is_assessed_and_simulated() {
    let directory = tempfile::tempdir().unwrap();
    let figure = directory.path().join("impact.svg");
    let answer = json(&format!(
        "--scenario paper --allowed-force-n 53.75 --figure {}",
        figure.display()
    ));
    let number = |value: &Value| value.as_f64().unwrap();
    // Hanging, the tool is turned by 2.9 mrad: 107.5 instead of 107.26 N.
    assert!((number(&answer["peak_force_n"]) - 107.5).abs() < 0.05, "{answer}");
    let simulated = &answer["simulated"];
    let deviation = number(&simulated["peak_force_n"]) / number(&simulated["predicted_peak_n"]) - 1.0;
    assert!(deviation.abs() < 0.005, "{deviation}");
    assert_eq!(answer["controlled_peak_n"], simulated["controlled_peak_n"]);
    assert_eq!(answer["limit"], "impact");
    assert!((number(&answer["speed_for_allowed_force_m_per_s"]) - 0.010).abs() < 1e-4);
    let svg = std::fs::read_to_string(figure).unwrap();
    assert!(svg.contains("simulated") && svg.trim_end().ends_with("</svg>"));
    let (_, stdout, _) = impact("--scenario car_body");
    assert!(
        stdout.contains("Not in the assessment: the object moves"),
        "{stdout}"
    );
}

#[test]
fn your_own_materials_and_shapes_count() {
    let directory = tempfile::tempdir().unwrap();
    let file = directory.path().join("own.toml");
    let text = "[materials.foam]\nyoungs_modulus_pa = 1e6\npoisson_ratio = 0.0\nsource = \"measured\"\n\
                [shapes.pin]\ndimension = \"radius_m\"\nexponent = 1.0\nfactor = 4.0\nsource = \"measured\"\n";
    std::fs::write(&file, text).unwrap();
    let own = format!("--materials {}", file.display());
    let answer = json(&format!(
        "{own} --shape pin --radius-m 0.001 --tool foam --object foam --mass-kg 1 --speed-m-per-s 1"
    ));
    close(&answer["effective_modulus_pa"], 0.5e6);
    close(&answer["indentation_n_per_m"], 2000.0);
    let list = impact(&format!("{own} --list")).1;
    assert!(
        list.contains("foam") && list.contains("steel") && list.contains("Hertz"),
        "{list}"
    );
}

#[test]
fn what_can_not_be_is_refused_with_value_and_range() {
    let modulus = "--effective-modulus-pa 1e9";
    for (arguments, error) in [
        (
            "--mass-kg -4 --indentation-n-per-m 16e6 --speed-m-per-s 0.02".to_owned(),
            "mass is -4 kg, outside 1e-6 to 1e6 kg; give the mass that strikes",
        ),
        (
            "--mass-kg 4 --indentation-n-per-m 16e6 --exponent 2.5 --speed-m-per-s 0.02".to_owned(),
            "exponent n is 2.5, outside 1e-6 to 2; 1 is a flat punch",
        ),
        (
            "--mass-kg 4 --indentation-n-per-m 16e6 --exponent 0 --speed-m-per-s 0.02".to_owned(),
            "exponent n is 0, outside 1e-6 to 2; ",
        ),
        (
            "--mass-kg 4 --indentation-n-per-m 16e6 --speed-m-per-s -0.02".to_owned(),
            "speed is -0.02 m/s, outside 1e-9 to 100 m/s; ",
        ),
        (
            format!("{FLAT_PUNCH} --tool stel --object glass"),
            "unknown material \"stel\"; known are acrylic-glass, aluminium, ",
        ),
        (
            "--shape ball --radius-m 1 --effective-modulus-pa 1e9 --mass-kg 1 --speed-m-per-s 1".to_owned(),
            "unknown shape \"ball\"; known are cone, flat-punch, sphere, square-punch; ",
        ),
        (
            "--shape cone --radius-m 1 --effective-modulus-pa 1e9 --mass-kg 1 --speed-m-per-s 1".to_owned(),
            "the shape cone has no --radius-m; give --half-angle-rad",
        ),
        (
            "--shape sphere --effective-modulus-pa 1e9 --mass-kg 1 --speed-m-per-s 1".to_owned(),
            "the dimension of the shape is missing; give --radius-m",
        ),
        (
            FLAT_PUNCH.to_owned(),
            "the stiffness is missing; give --tool and --object",
        ),
        (
            format!("{FLAT_PUNCH} {modulus} --rebound-ratio 0.5"),
            "rebound ratio c_re / c_in is 0.5, outside 1 to 1000; ",
        ),
        (
            format!("{FLAT_PUNCH} {modulus} --allowed-remaining-m 1e-6"),
            "no indentation remains with a rebound ratio of 1",
        ),
        (
            format!("{FLAT_PUNCH} {modulus} --inertia-kg-m2 1,2 --centre-of-mass-m 0,0,0 --tcp-m 0,0,0"),
            "give three numbers, separated by commas",
        ),
        (
            "--scenario paper --set object.exponent=3".to_owned(),
            "the impact in the scenario can't be assessed: exponent n is 3, outside 1e-6 to 2; ",
        ),
        (
            "--materials missing.toml --list".to_owned(),
            "the materials missing.toml can't be read: ",
        ),
    ] {
        let (code, stdout, stderr) = impact(&arguments);
        assert_eq!((code, stdout.as_str()), (2, ""), "{arguments}: {stderr}");
        assert!(
            stderr.starts_with("error: ") && stderr.contains(error),
            "{arguments}: {stderr}"
        );
    }
}
