//! A stop at any instant is smooth, and force control is left without snapping back.

use super::{Said, ask, scenario};
use node::scenario::Scenario;
use rayon::prelude::*;
use spatial::ports::{ControllerPhase, Fault, TaskAction};
use std::collections::BTreeSet;

/// What a stop at some ticks looks like, at worst, and in which phases it came.
#[derive(Debug, Default)]
struct Worst {
    phases: BTreeSet<i32>,
    /// Largest acceleration of the motors from the stop on, m/s^2 and rad/s^2, and in the same run without a stop.
    acceleration: [f64; 2],
    without: [f64; 2],
    /// How far the tcp went after the stop, m.
    way_m: f64,
    /// How far it turned back up after it, beyond what it had gone up before, m.
    back_m: f64,
    /// How much the set-points still move 0.5 s after the stop, rad.
    moves_rad: f64,
}

fn stop_at(scenario: &Scenario, ticks: &[i64]) -> Worst {
    let period_s = scenario.timing.command_period_ticks as f64 * 1e-3;
    let without = Said::of(scenario, &[]).acceleration_from(0, period_s);
    let each = |&tick: &i64| {
        let said = Said::of(scenario, &[ask(1, tick, TaskAction::Stop)]);
        let before = said.status_at(tick - 8).phase;
        let end = said.statuses.last().unwrap();
        assert_eq!(
            (end.phase, end.fault),
            (ControllerPhase::Ready, Fault::None),
            "stop at {tick}"
        );
        let at = said.tcp_m[tick as usize];
        let after = &said.tcp_m[tick as usize..];
        let up = |points: &[nalgebra::Vector3<f64>]| points.iter().map(|p| p.z - at.z).fold(0.0, f64::max);
        let rising = (at.z - said.tcp_m[tick as usize - 20].z).max(0.0);
        let moved = said
            .set_points
            .iter()
            .filter(|(n, _)| *n > tick + 500)
            .map(|(_, it)| *it);
        let last = said.set_points.last().unwrap().1;
        Worst {
            phases: [before.code()].into(),
            acceleration: said.acceleration_from(tick, period_s),
            without,
            way_m: after.iter().map(|p| (p - at).norm()).fold(0.0, f64::max),
            back_m: if rising > 0.1e-3 { 0.0 } else { up(after) },
            moves_rad: moved.map(|it| (it - last).amax()).fold(0.0, f64::max),
        }
    };
    let all: Vec<Worst> = ticks.par_iter().map(each).collect();
    all.into_iter().fold(Worst::default(), |a, b| Worst {
        phases: a.phases.union(&b.phases).copied().collect(),
        acceleration: [0, 1].map(|i| a.acceleration[i].max(b.acceleration[i])),
        without,
        way_m: a.way_m.max(b.way_m),
        back_m: a.back_m.max(b.back_m),
        moves_rad: a.moves_rad.max(b.moves_rad),
    })
}

/// No harder than what the run does anyway (or, about axes, 1 rad/s^2: a posture that is taken slowly comes to rest as fast
/// as all else), and at rest after half a second.
fn assert_smooth(name: &str, worst: &Worst) {
    for ((stopped, without), gentle) in worst.acceleration.iter().zip(worst.without).zip([0.0, 1.0]) {
        assert!(*stopped <= (without * 1.001).max(gentle), "{name}: {worst:?}");
    }
    assert!(worst.moves_rad < 1e-9, "{name}: {worst:?}");
}

/// Approach, impact, contact and settled contact, with every law, rigid and elastic: from 20 mm/s the robot rests after
/// hardly more than the 1 mm of the fade and what it lags behind, and keeps the object.
#[test]
fn each_law_stops_smoothly_in_every_phase_of_a_task() {
    for (law, gears) in [
        ("pd", "rigid"),
        ("pd-reset", "rigid"),
        ("literal", "rigid"),
        ("proposed", "rigid"),
        ("impedance", "rigid"),
        ("proposed", "elastic"),
        ("pd", "elastic"),
        ("elastic", "elastic"),
    ] {
        let law_ = format!("controller.law={law}");
        let base = if gears == "rigid" { "paper" } else { "elastic" };
        let scenario = scenario(base, &[&law_, "timing.duration_s=2.6"]);
        let ticks: Vec<i64> = (0..24)
            .map(|i| 260 + 73 * i)
            .chain((1296..1360).step_by(9))
            .collect();
        let worst = stop_at(&scenario, &ticks);
        assert!(worst.phases.len() >= 2, "{law}: {worst:?}");
        assert_smooth(law, &worst);
        // What moves up at that instant by the law itself comes to rest, too: pd-reset does so at 60 mm/s, and what is
        // told to the motors of elastic gears runs ahead of the tcp.
        let back_m = match law {
            "proposed" | "impedance" => 0.4e-3,
            "elastic" => 1.6e-3,
            _ => 0.8e-3,
        };
        assert!(
            worst.way_m < 2e-3 && worst.back_m < back_m,
            "{law}, {gears}: {worst:?}"
        );
    }
}

#[test]
fn a_program_and_a_calibration_stop_smoothly() {
    let screws = scenario("screws", &["timing.duration_s=4.5"]);
    let worst = stop_at(&screws, &(0..40).map(|i| 260 + 83 * i).collect::<Vec<_>>());
    assert_smooth("screws", &worst);
    assert!(worst.way_m < 8e-3 && worst.back_m < 1.2e-3, "{worst:?}");
    let calibration = scenario(
        "paper",
        &[
            "task.kind=calibrate",
            "task.calibration_rest_s=0.2",
            "timing.duration_s=8",
        ],
    );
    let worst = stop_at(&calibration, &(0..20).map(|i| 300 + 331 * i).collect::<Vec<_>>());
    // Slower than the ramps of any approach.
    assert!(
        worst.acceleration[0] < 0.15 && worst.moves_rad < 1e-9,
        "{worst:?}"
    );
}
