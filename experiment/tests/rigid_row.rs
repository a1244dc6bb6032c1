//! What the laws attain on the rigid gantry, worst case over contact phases and seeds (PLANT.md section 6).
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "tests")]

use experiment::compare::{Comparison, Matrix};
use experiment::scenarios::Source;
use experiment::tuning::{Gains, Tuned};
use node::scenario::Scenario;
use std::sync::atomic::{AtomicUsize, Ordering};

fn matrix(phases: usize, seeds: usize) -> Matrix {
    Matrix {
        robots: vec!["rigid".to_owned()],
        kinematics: vec!["gantry".to_owned()],
        laws: vec!["pd".to_owned(), "proposed".to_owned()],
        gains: vec![Gains::Default],
        phases,
        seeds,
    }
}

fn paper() -> Scenario {
    Source::find("paper").unwrap().scenario(&[]).unwrap()
}

#[test]
fn the_proposed_law_keeps_its_bounds_and_pd_is_tuned_fairly() {
    let comparison = matrix(8, 3).run(&paper(), &Tuned::default(), || ()).unwrap();
    assert_eq!(comparison.failures, []);
    let [pd, proposed] = comparison.rows.as_slice() else {
        panic!("{:?}", comparison.rows)
    };
    assert_eq!((pd.law.as_str(), pd.runs), ("pd", 24));
    assert_eq!((proposed.law.as_str(), proposed.runs), ("proposed", 24));
    let worst = proposed.worst;
    assert!(worst.peak_n <= 17.0, "{worst:?}");
    assert!(worst.settling_10_s <= 0.060, "{worst:?}");
    assert!(worst.iae_n_s <= 0.32, "{worst:?}");
    assert!((0.55..=0.70).contains(&pd.mean.iae_n_s), "{:?}", pd.mean);
}

#[test]
fn threads_do_not_change_a_bit() {
    let scenario = paper();
    let matrix = matrix(2, 1);
    let with_threads = |count| {
        let done = AtomicUsize::new(0);
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(count)
            .build()
            .unwrap();
        let comparison = pool.install(|| {
            matrix.run(&scenario, &Tuned::default(), || {
                done.fetch_add(1, Ordering::Relaxed);
            })
        });
        assert_eq!(done.into_inner(), matrix.runs());
        comparison.unwrap()
    };
    let bits = |comparison: &Comparison| -> Vec<_> {
        let figures = comparison.rows.iter().flat_map(|row| [row.mean, row.worst]);
        figures
            .map(|metrics| metrics.values().map(f64::to_bits))
            .collect()
    };
    let (one, two) = (with_threads(1), with_threads(2));
    assert_eq!(bits(&one).len(), 4);
    assert_eq!(bits(&one), bits(&two));
}
