//! What free motion leaves swinging (PLANT.md section 7): the claims of docs/free-motion.txt.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use experiment::free_motion::{FreeMotion, Way, measure};
use experiment::in_process;
use experiment::scenarios::{Source, names};
use node::scenario::{Profile, Scenario};
use rayon::prelude::*;
use spatial::ports::Fault;

const ELASTIC_ARM: [&str; 2] = ["robot.gears=elastic", "controller.gears.kind=elastic"];

fn scenario(name: &str, overrides: &[&str]) -> Scenario {
    let overrides: Vec<_> = overrides.iter().map(|&text| text.to_owned()).collect();
    Source::find(name).unwrap().scenario(&overrides).unwrap()
}

/// The worst of several ways at several speeds, by the swing.
fn worst(scenario: &Scenario, profile: Profile, ratio: f64) -> FreeMotion {
    let ways: Vec<_> = [0.05, 0.1, 0.12, 0.15, 0.21]
        .into_iter()
        .flat_map(|length_m| {
            [0.02, 0.06, 0.15, 0.25].map(|speed_m_per_s| Way {
                length_m,
                speed_m_per_s,
            })
        })
        .collect();
    let swings = ways
        .par_iter()
        .map(|way| measure(scenario, *way, profile, ratio).unwrap());
    swings.max_by(|a, b| a.swing_m.total_cmp(&b.swing_m)).unwrap()
}

/// The gantry, with its modes as assumed or 10 % beside: at most the 1 um that is asked for.
#[test]
fn the_gantry_leaves_a_micrometre_whatever_the_way() {
    for (name, trapezoid_m, extra_s) in [("paper", 200e-6, 0.113), ("elastic", 350e-6, 0.180)] {
        let scenario = scenario(name, &[]);
        let bare = worst(&scenario, Profile::Trapezoid, 1.0);
        assert!(bare.swing_m > trapezoid_m, "{name}: {bare:?}");
        for ratio in [0.9, 1.0, 1.1] {
            let shaped = worst(&scenario, Profile::Smooth, ratio);
            assert!(shaped.swing_m < 1e-6, "{name}: {shaped:?}");
        }
        let way = Way {
            length_m: 0.15,
            speed_m_per_s: 0.25,
        };
        let [bare, shaped] = [Profile::Trapezoid, Profile::Smooth]
            .map(|profile| measure(&scenario, way, profile, 1.0).unwrap());
        assert!(shaped.extra_s < extra_s, "{name}: {shaped:?}");
        // The deflected tcp is what keeps to the path.
        assert!(
            shaped.off_path_m < 0.06 * bare.off_path_m,
            "{name}: {shaped:?} {bare:?}"
        );
    }
}

/// The arm's servos know nothing of its coupled links, and its modes are not those of decoupled ones: some micrometres.
#[test]
fn the_arm_leaves_a_hundredth_of_a_trapezoid() {
    for overrides in [&[] as &[&str], &ELASTIC_ARM] {
        let scenario = scenario("arm", overrides);
        let bare = worst(&scenario, Profile::Trapezoid, 1.0).swing_m;
        for (ratio, share) in [(0.9, 0.01), (1.0, 0.015), (1.1, 0.02)] {
            let shaped = worst(&scenario, Profile::Smooth, ratio);
            assert!(
                shaped.swing_m < share * bare,
                "{overrides:?}: {shaped:?} of {bare} m"
            );
        }
    }
}

/// In every scenario the approach is not taken for contact, on rigid and on elastic gears, assumed or not.
#[test]
fn no_scenario_gives_a_false_alarm() {
    let runs: Vec<_> = names()
        .flat_map(|name| [&[] as &[&str], &ELASTIC_ARM, &ELASTIC_ARM[..1]].map(|overrides| (name, overrides)))
        .flat_map(|(name, overrides)| [1, 2].map(|seed| (name, overrides, seed)))
        .collect();
    runs.par_iter().for_each(|(name, overrides, seed)| {
        let mut scenario = scenario(name, overrides);
        scenario.timing.seed = *seed;
        // Nothing is met before that.
        scenario.timing.duration_s = 1.0;
        let mut touched = false;
        in_process::run(&scenario, |tick| {
            touched |= tick.sensor.truth.first_contact_time_s >= 0.0;
            let Some(answer) = &tick.controller else { return };
            assert_eq!(
                answer.status.fault,
                Fault::None,
                "{name}, {overrides:?}, seed {seed}"
            );
            let detected = answer.status.detection.contact_step >= 0;
            assert!(
                touched || !detected,
                "{name}, {overrides:?}, seed {seed}: false alarm"
            );
        });
    });
}
