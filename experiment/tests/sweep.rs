//! Sweeps and tuned gains: the same bytes whatever the threads, nothing run twice, and no grid that finds better gains.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "tests")]

use experiment::linear;
use experiment::scenarios::Source;
use experiment::sweep::{Cells, Definition, HEADER, Plan, cells_csv, map_figure, verdicts};
use experiment::tuning::{Entry, Gains, Set, Tuned, judge, parameters};
use node::scenario::Scenario;
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};

fn smoke() -> Plan {
    Plan::new(Definition::find("smoke").unwrap(), &Tuned::built_in().unwrap()).unwrap()
}

/// The runs file and all that follows from it.
fn with_threads(plan: &Plan, path: &Path, threads: usize) -> [String; 3] {
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .unwrap();
    pool.install(|| {
        let (outcomes, _) = plan.run(path, |_| ()).unwrap();
        let cells = Cells::new(plan, &outcomes);
        let runs = std::fs::read_to_string(path).unwrap();
        [
            runs,
            cells_csv(plan, &cells),
            map_figure(plan, &cells, 0).unwrap(),
        ]
    })
}

#[test]
fn one_thread_and_many_write_the_same_bytes_and_an_interrupted_sweep_goes_on() {
    let directory = tempfile::tempdir().unwrap();
    let plan = smoke();
    let path = directory.path().join("one.csv");
    let one = with_threads(&plan, &path, 1);
    assert!(one == with_threads(&plan, &directory.path().join("three.csv"), 3));
    assert_eq!(one[0].lines().count(), 1 + plan.runs.len());
    assert!(one[0].starts_with(&(HEADER() + "\n")));

    // Cut off in the middle of a line, somewhere in the header, and not at all.
    for (kept, whole) in [(one[0].len() * 2 / 3, 11), (10, 0), (one[0].len(), 18)] {
        std::fs::write(&path, &one[0][..kept]).unwrap();
        let told = AtomicUsize::new(0);
        let (outcomes, resumed) = plan
            .run(&path, |runs| {
                told.fetch_add(runs, Ordering::Relaxed);
            })
            .unwrap();
        assert_eq!((outcomes.len(), resumed, told.into_inner()), (18, whole, 18));
        assert_eq!(std::fs::read_to_string(&path).unwrap(), one[0]);
    }

    // Another sweep's runs are not taken for this one's.
    let mut other = Definition::find("smoke").unwrap();
    other.set.push("timing.seed=7".to_owned());
    let other = Plan::new(other, &Tuned::built_in().unwrap()).unwrap();
    let error = other.run(&path, |_| ()).unwrap_err().to_string();
    assert!(
        error.starts_with("line 2 of ") && error.contains("is no run of this sweep"),
        "{error}"
    );
}

/// Linear theory and simulation agree on all of the small sweep: PLANT.md's border of eq. (2) with force output lies
/// between ratios of 2 and 3.5.
#[test]
fn the_small_sweep_shows_the_border_that_theory_predicts() {
    let directory = tempfile::tempdir().unwrap();
    let plan = smoke();
    let (outcomes, _) = plan.run(&directory.path().join("runs.csv"), |_| ()).unwrap();
    let verdicts = verdicts(&plan, &Cells::new(&plan, &outcomes));
    let counts: Vec<_> = verdicts
        .iter()
        .map(|verdict| {
            (
                verdict.law.as_str(),
                verdict.cells,
                verdict.stable_cells,
                verdict.agreeing_cells,
            )
        })
        .collect();
    assert_eq!(counts, [("pd", 9, 9, Some(9)), ("literal", 9, 6, Some(9))]);
}

/// All points of a grid of `steps` per parameter, on the logarithmic scale.
fn grid(scenario: &Scenario, steps: usize) -> Vec<Vec<String>> {
    let mut points = vec![Vec::new()];
    for parameter in parameters(scenario.controller.law) {
        let value = |step: usize| {
            let share = (step as f64 + 0.5) / steps as f64;
            parameter.low * libm::pow(parameter.high / parameter.low, share)
        };
        points = points
            .into_iter()
            .flat_map(|point: Vec<String>| {
                (0..steps).map(move |step| {
                    let mut point = point.clone();
                    point.push(format!("{}={:?}", parameter.key, value(step)));
                    point
                })
            })
            .collect();
    }
    points
}

/// The peers' tuned rows are as good as an independent coarse grid finds them: on runs that neither has seen before, the
/// best of it is not better by more than 5 %.
#[test]
fn no_coarse_grid_finds_better_gains_for_the_peers() {
    let tuned = Tuned::built_in().unwrap();
    for (law, steps) in [("pd", 5), ("fzi", 5), ("ros2", 3)] {
        let overrides = [
            format!("controller.law={law}"),
            "timing.duration_s=2.1".to_owned(),
        ];
        let mut scenario = Source::find("paper").unwrap().scenario(&overrides).unwrap();
        scenario.task.start_position_m[2] = 0.0175;
        scenario.timing.duration_s = 2.4;
        // The grid chooses by runs of its own, too; then both are judged on more that neither has seen.
        let chosen = grid(&scenario, steps)
            .iter()
            .map(|point| scenario.with(point).unwrap())
            .map(|tried| (judge(&tried, Set::Training, 2), tried))
            .min_by(|a, b| a.0.total_cmp(&b.0))
            .unwrap()
            .1;
        let found = judge(
            &tuned.apply(Gains::Tuned, &scenario).unwrap().unwrap(),
            Set::HeldOut,
            12,
        );
        let best = judge(&chosen, Set::HeldOut, 12);
        println!("{law}: tuned {found}, grid {best}");
        assert!(found <= 1.05 * best, "{law}: tuned {found}, grid {best}");
    }
}

/// The margins that stand beside tuned gains are those of their loops: `make tune` writes the same.
#[test]
fn the_margins_of_tuned_gains_are_those_of_their_loops() {
    let round = |value: f64| format!("{value:.3}");
    let mut wrong = Vec::new();
    for entry in Tuned::built_in().unwrap().tuned {
        let overrides = [format!("controller.law={}", entry.law)];
        let scenario = Source::find(&entry.scenario)
            .unwrap()
            .scenario(&overrides)
            .unwrap();
        let scenario = Tuned::built_in()
            .unwrap()
            .apply(Gains::Tuned, &scenario)
            .unwrap()
            .unwrap();
        let margins = linear::closed(&scenario).unwrap().margins();
        let found = [margins.gain_margin, margins.phase_margin_rad].map(round);
        let told =
            [entry.gain_margin, entry.phase_margin_rad].map(|margin| margin.map_or("none".to_owned(), round));
        if found != told {
            let Entry {
                law,
                robot,
                kinematics,
                ..
            } = entry;
            wrong.push(format!("{law} on {robot} {kinematics}: {found:?}, not {told:?}"));
        }
    }
    assert_eq!(wrong, Vec::<String>::new());
}

/// What the README claims of the laws' order after tuning, and of the maps' size.
#[test]
fn what_the_readme_says_of_tuned_laws_and_maps() {
    let tuned = Tuned::built_in().unwrap();
    let cost = |law: &str| {
        let of = |entry: &&Entry| entry.law == law && entry.robot == "rigid" && entry.kinematics == "gantry";
        tuned.tuned.iter().find(of).unwrap().criterion_held_out
    };
    for law in ["pd", "pd-reset", "ros2", "fzi"] {
        assert!(
            cost(law) >= 2.0 * cost("proposed"),
            "{law}: {}, proposed: {}",
            cost(law),
            cost("proposed")
        );
    }
    // The file's figures are those of the search.
    let pd = Source::find("paper")
        .unwrap()
        .scenario(&["controller.law=pd".to_owned()])
        .unwrap();
    let entry = tuned
        .tuned
        .iter()
        .find(|entry| entry.law == "pd" && entry.robot == "rigid")
        .unwrap();
    let again = judge(
        &tuned.apply(Gains::Tuned, &pd).unwrap().unwrap(),
        Set::HeldOut,
        entry.runs,
    );
    let same = tuned
        .tuned
        .iter()
        .any(|entry| entry.law == "pd" && (entry.criterion_held_out - again).abs() < 5e-4);
    assert!(same, "{again}: run `make tune`");

    let plan = Plan::new(Definition::find("shootout").unwrap(), &tuned).unwrap();
    let thousands = format!("{},{:03}", plan.runs.len() / 1000, plan.runs.len() % 1000);
    let readme = concat!(env!("CARGO_MANIFEST_DIR"), "/../README.md");
    let readme = std::fs::read_to_string(readme).unwrap();
    assert!(
        readme.contains(&format!("in {thousands} simulated experiments")),
        "{thousands}"
    );
}
