//! The functions phi against closed forms, the step against exact solutions and its order.

use super::*;

/// An oscillator of `w` rad/s in components 0 and 1, a decay of 50 /s in component 2; the others stay.
fn linear(w: f64) -> Operator {
    let mut linear = Operator::zeros();
    linear[(0, 1)] = 1.0;
    linear[(1, 0)] = -w * w;
    linear[(2, 2)] = -50.0;
    linear
}

fn levels(linear: &Operator, longest: f64) -> Vec<Phi> {
    let mut levels = vec![Phi::zero(); 8];
    Phi::fill(&mut levels, linear, longest);
    levels
}

#[test]
fn the_functions_are_their_closed_forms_at_every_level() {
    let longest = 1e-3;
    for (i, phi) in levels(&linear(6000.0), longest).iter().enumerate() {
        let h = longest / f64::from(1 << i);
        let z = -50.0 * h;
        let one = libm::expm1(z) / z;
        let two = (one - 1.0) / z;
        let three = (two - 0.5) / z;
        let found = [phi.one, phi.two, phi.three].map(|phi| phi[(2, 2)] / h);
        for (found, (expected, within)) in found.iter().zip([(one, 1e-14), (two, 1e-12), (three, 1e-8)]) {
            assert!((found - expected).abs() < within, "level {i}: {found} {expected}");
        }
        // The oscillator, 6 rad away on the longest level: phi_1 is the integral of the flow.
        let angle = 6000.0 * h;
        let (sine, cosine) = libm::sincos(angle);
        assert!((phi.one[(0, 0)] / h - sine / angle).abs() < 1e-13);
        assert!((phi.one[(0, 1)] / h - (1.0 - cosine) / (angle * 6000.0)).abs() < 1e-16);
        // What does not change by itself: phi_k = 1 / k!.
        assert!((phi.one[(5, 5)] / h - 1.0).abs() < 1e-15);
        assert!((phi.two[(5, 5)] / h - 0.5).abs() < 1e-15);
        assert!((phi.three[(5, 5)] / h - 1.0 / 6.0).abs() < 1e-15);
    }
}

/// A force that grows with the square of time is carried through the stiffest system without any error.
#[test]
fn a_parabolic_force_is_exact_over_a_whole_period() {
    let (w, h) = (6000.0, 1e-3);
    let linear = linear(w);
    let levels = levels(&linear, h);
    let force = |t: f64| 3.0 + 5e3 * t + 7e6 * t * t;
    // x'' = -w^2 x + a + b t + c t^2 from rest at zero.
    let (a, b, c) = (3.0, 5e3, 7e6);
    let exact = |t: f64| {
        let (sine, cosine) = libm::sincos(w * t);
        let constant = a / (w * w) - 2.0 * c / (w * w * w * w);
        constant * (1.0 - cosine) + b / (w * w) * (t - sine / w) + c / (w * w) * t * t
    };
    let mut start = Vector::zeros();
    start[1] = force(0.0);
    let change = step(&linear, [&levels[0], &levels[1]], &start, |y, place| {
        let mut rate = linear * y;
        rate[1] += force(if place == Place::Middle { 0.5 * h } else { h });
        rate
    });
    assert!(
        (change[0] / exact(h) - 1.0).abs() < 1e-11,
        "{} {}",
        change[0],
        exact(h)
    );
}

/// An oscillator whose spring hardens by a tenth: the error goes with the fourth power of the step, also where the
/// linear part alone turns by radians.
#[test]
fn the_method_is_of_fourth_order() {
    let (w, end) = (100.0, 0.064);
    let linear = linear(w);
    let run = |steps: usize| {
        let h = end / steps as f64;
        let levels = levels(&linear, h);
        let rate = |y: &Vector| {
            let mut rate = linear * y;
            rate[1] -= w * w * 0.1 * y[0] * y[0] * y[0];
            rate
        };
        let mut y = Vector::zeros();
        y[0] = 1.0;
        for _ in 0..steps {
            y += step(&linear, [&levels[0], &levels[1]], &rate(&y), |change, _| {
                rate(&(y + change))
            });
        }
        y[0]
    };
    let exact = run(2048);
    let error = |steps: usize| (run(steps) - exact).abs();
    let order = libm::log2(error(16) / error(32));
    assert!((3.7..4.4).contains(&order), "order {order}");
    assert!(error(32) < 1e-5, "{}", error(32));
}
