//! The schema and its messages as a user meets them.

mod conflicts;
mod messages;
mod properties;

use super::Scenario;

const PAPER: &str = include_str!("../../../experiment/scenarios/paper.toml");

/// What is wrong with `text` and `overrides`, as printed.
fn refusal(text: &str, overrides: &[&str]) -> String {
    Scenario::parse("a.toml", text, &strings(overrides))
        .unwrap_err()
        .to_string()
}

fn strings(texts: &[&str]) -> Vec<String> {
    texts.iter().map(|text| text.to_string()).collect()
}

#[test]
fn the_defaults_are_the_experiment_of_the_paper() {
    assert_eq!(Scenario::parse("paper.toml", PAPER, &[]), Ok(Scenario::default()));
    assert_eq!(Scenario::parse("empty.toml", "", &[]), Ok(Scenario::default()));
}

#[test]
fn what_is_written_is_the_same_scenario() {
    let program =
        "[[program.step]]\nkind = \"approach\"\n[[program.step]]\nkind = \"press\"\nforce_n = 12.5\n";
    let overrides = strings(&[
        "timing.seed=7",
        "controller.law=pd-reset",
        "sensor.noise_force_n=0.1",
    ]);
    for text in [PAPER, program] {
        let scenario = Scenario::parse("a.toml", text, &overrides).unwrap();
        let written = scenario.to_toml();
        let again = Scenario::parse("written.toml", &written, &[])
            .unwrap_or_else(|error| panic!("{error}\n{written}"));
        assert_eq!((again.hash(), &again), (scenario.hash(), &scenario));
    }
}

#[test]
fn the_paper_names_every_key() {
    let document = toml::de::DeTable::parse(PAPER).unwrap();
    for key in Scenario::keys() {
        let mut parts = key.path.split('.');
        let section = document.get_ref().get(parts.next().unwrap()).unwrap();
        parts.fold(section.get_ref(), |table, part| {
            table
                .get(part)
                .unwrap_or_else(|| panic!("{} is missing", key.path))
                .get_ref()
        });
    }
}

#[test]
fn overrides_count_more_than_the_file_and_later_ones_more_than_earlier_ones() {
    let text = "controller.law = 'proposed'\ntiming.seed = 2";
    let overrides = strings(&[
        "controller.law=pd",
        "task.start_position_m=[0, 0, 0.04]",
        "timing.seed=3",
        "timing.seed = 4",
    ]);
    let scenario = Scenario::parse("a.toml", text, &overrides).unwrap();
    assert_eq!(scenario.controller.law, spatial::ports::Law::Pd);
    assert_eq!(scenario.task.start_position_m, [0.0, 0.0, 0.04]);
    assert_eq!(scenario.timing.seed, 4);
    assert_eq!(Scenario::default().with(&overrides), Ok(scenario));
}

#[test]
fn a_file_is_loaded_by_its_path() {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../experiment/scenarios/paper.toml");
    assert_eq!(Scenario::load(&path, &[]), Ok(Scenario::default()));
}
