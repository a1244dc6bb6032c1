//! A law in the whole controller: what it commands is what its equation says.

use super::*;
use spatial::ports::Law;

/// Paper (2): `x_d(k) = x_a(k) + C (f(k) - f_d)` of the newest sample, on a robot that moves and under a force that
/// changes. x_a is the tcp at the sample's instant, and 1 / (2 pi f) earlier for the sensor's low pass; paired by
/// arrival, the newest reading. C is that of the tcp, 1/K_p + d_x^2 / K_phi (PLANT.md section 5: 28.267 um/N).
#[test]
fn the_literal_law_commands_equation_2_of_the_newest_sample() {
    let compliance = 28.266_64e-6;
    let delay = 5;
    for pairing in [Pairing::Sampling, Pairing::Arrival] {
        let mut scenario = weightless();
        scenario.controller.law = Law::Literal;
        scenario.controller.transform = scenario::Transform::Twist;
        scenario.controller.pairing = pairing;
        let kinematics = scenario.robot.kinematics();
        let d: Vector3<f64> = scenario.controller.tcp_in_s_m.into();
        let tcp =
            |axes: &Axes| (kinematics.forward(axes) * spatial::Pose::translation(d.x, d.y, d.z)).translation;
        let start = scenario.start_axes().unwrap();
        let moved = |ms: f64| start - Axes::ith(2, 20e-6 * (ms - 300.0).max(0.0));
        let force = |tick: i64| match tick - 400 {
            i64::MIN..0 => 0.0,
            after => 3.0 + 0.05 * after as f64 + (after % 3) as f64,
        };
        let mut controller = Controller::new(&scenario);
        let mut commands = 0;
        for tick in (0..=600).step_by(4) {
            let shown = |sampled: i64| lifted(compliance * force(sampled));
            let outputs = controller.cycle(&Heard::complete(
                &state(tick, moved(tick as f64)),
                &sensed(tick, delay, shown),
                None,
            ));
            let newest = tick - delay;
            if newest < 400 {
                continue;
            }
            commands += 1;
            let actual = match pairing {
                Pairing::Sampling => moved(newest as f64 - 1e3 / (TAU * 200.0)),
                Pairing::Arrival => moved(tick as f64),
            };
            let expected = tcp(&actual).z + compliance * (force(newest) - 10.0);
            for axes in &outputs.command.axis_position {
                let commanded = tcp(axes).z;
                assert!(
                    (commanded - expected).abs() < 1e-9,
                    "{pairing:?}, tick {tick}: {commanded} m, not {expected} m"
                );
            }
            assert!((outputs.status.force_error_n - (force(newest) - 10.0)).abs() < 1e-4);
        }
        assert_eq!(commands, 49);
    }
}
