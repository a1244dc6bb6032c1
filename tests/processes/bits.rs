//! Three processes in lockstep say bit for bit what the loop in one process says (DESIGN.md, invariant 4).

use experiment::{launch, transcript};
use tests::{Bench, Impairment, Relay};

fn assert_same_bits(bench: &Bench) {
    let never = crossbeam::channel::never();
    let said = launch::run(&bench.plan, &never, |_| ()).unwrap();
    let expected = transcript::in_process(&bench.scenario).unwrap();
    assert!(expected.len() > 3 * 900);
    assert_eq!(transcript::first_difference(&said, &expected), None);
}

#[test]
fn the_proposed_law() {
    assert_same_bits(&Bench::new(&[]).unwrap());
}

#[test]
fn the_pd_law_with_another_period_and_seed() {
    let changes = [
        "controller.law=pd",
        "timing.command_period_ticks=3",
        "timing.seed=42",
    ];
    assert_same_bits(&Bench::new(&changes).unwrap());
}

#[test]
fn with_five_percent_of_all_datagrams_lost_and_five_doubled() {
    for seed in 1..=4 {
        let mut bench = Bench::new(&[&format!("timing.seed={seed}")]).unwrap();
        let ports = bench.separate().unwrap();
        let relay = Relay::start(
            &ports,
            Impairment {
                loss: 0.05,
                duplication: 0.05,
                seed,
            },
        )
        .unwrap();
        assert_same_bits(&bench);
        assert!(relay.lost() > 100, "the relay has lost only {}", relay.lost());
    }
}
