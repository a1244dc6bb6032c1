use super::*;
use crate::scenarios::Source;
use crate::tuning::{Gains, Tuned};
use nalgebra::Complex;

fn margins(name: &str, overrides: &[&str]) -> Margins {
    let overrides: Vec<String> = overrides.iter().map(|&text| text.to_owned()).collect();
    let scenario = Source::find(name).unwrap().scenario(&overrides).unwrap();
    closed(&scenario).unwrap().margins()
}

/// PLANT.md section 7: with force output, eq. (2) becomes unstable where the assumed compliance is 2.64 times the real
/// one at a delay of 4 ms, 2.96 times at 0, 2.28 times at 16 ms.
#[test]
fn the_borders_of_equation_2_are_those_of_the_plan() {
    for (delay, border) in [(4, 2.64), (0, 2.96), (16, 2.28)] {
        let delay = format!("sensor.delay_ticks={delay}");
        let found = margins("paper", &["controller.law=literal", &delay]).gain_margin;
        assert!(
            (found / border - 1.0).abs() < 0.06,
            "{delay}: {found}, not {border}"
        );
    }
}

/// As `experiment/tests/borders.rs` finds them in simulations.
#[test]
fn what_the_simulations_find_unstable_is_predicted_so() {
    let literal = "controller.law=literal";
    let stable = |overrides: &[&str]| margins("paper", overrides).stable;
    let elastic = "robot.gears=elastic";
    assert!(!stable(&[literal, elastic]));
    assert!(!stable(&[literal, elastic, "robot.gear_damping=0.10"]));
    assert!(stable(&[literal, elastic, "robot.gear_damping=0.25"]));
    assert!(stable(&[
        literal,
        elastic,
        "robot.gantry.gear_frequency_hz=[30, 30, 30, 30, 30, 30]"
    ]));
    let arrival = "controller.pairing=arrival";
    assert!(stable(&[literal, arrival, "sensor.delay_ticks=16"]));
    assert!(!stable(&[literal, arrival, "sensor.delay_ticks=36"]));
    assert!(stable(&[literal, "sensor.delay_ticks=36"]));
}

/// The law behind elastic gears, tuned, is stable with the gears that it assumes, with gears 15 % off, and with longer
/// periods; with gears more than twice as stiff and a period of 1 or 2 ms it is not, as the map `gears` shows.
#[test]
fn the_law_behind_elastic_gears_has_a_border_too() {
    let tuned = Tuned::built_in().unwrap();
    let found = |ticks: i64, mode_hz: f64| {
        let modes = [14.0, 14.0, 14.0, 20.0, 20.0, 20.0].map(|hz| hz * mode_hz / 14.0);
        let overrides = [
            format!("timing.command_period_ticks={ticks}"),
            format!("robot.gantry.gear_frequency_hz={modes:?}"),
            "robot.integration_step_s=5e-4".to_owned(),
        ];
        let scenario = Source::find("elastic").unwrap().scenario(&overrides).unwrap();
        let scenario = tuned.apply(Gains::Tuned, &scenario).unwrap().unwrap();
        closed(&scenario).unwrap().margins()
    };
    for (ticks, mode_hz) in [(4, 14.0), (4, 11.9), (4, 16.1), (8, 14.0), (1, 14.0), (2, 20.0)] {
        let margins = found(ticks, mode_hz);
        assert!(
            margins.stable && margins.phase_margin_rad > 0.5,
            "{ticks} ms, {mode_hz} Hz: {margins:?}"
        );
    }
    for (ticks, mode_hz) in [(1, 30.0), (1, 40.0), (2, 40.0)] {
        assert!(!found(ticks, mode_hz).stable, "{ticks} ms, {mode_hz} Hz");
    }
}

/// A set-point that stays is reached, whatever robot and gears are.
#[test]
fn at_rest_the_robot_is_where_it_is_sent() {
    for name in ["paper", "arm", "elastic"] {
        let scenario = Source::find(name).unwrap().scenario(&[]).unwrap();
        let plant = plant(&scenario).unwrap();
        let seen = plant.seen(Complex::new(0.0, 0.01)).unwrap();
        assert!(
            (seen.actual - Complex::from(1.0)).norm() < 1e-3,
            "{name}: {seen:?}"
        );
        // Against a stiff object all of it is deflection.
        assert!((seen.deflection.re + 1.0).abs() < 0.12, "{name}: {seen:?}");
    }
}
