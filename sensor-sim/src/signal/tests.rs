//! Each link of the chain alone.

use super::*;

fn chain(sensor: scenario::Sensor) -> SignalChain {
    SignalChain::new(&sensor, 7, &Reading::default())
}

fn quiet() -> scenario::Sensor {
    scenario::Sensor {
        noise_translation_m: 0.0,
        noise_rotation_rad: 0.0,
        quantum_translation_m: 0.0,
        quantum_rotation_rad: 0.0,
        ..Default::default()
    }
}

fn deflected(translation: [f64; 3]) -> Reading {
    let mut reading = Reading::default();
    reading.deflection.translation = translation.into();
    reading
}

#[test]
fn a_step_passes_the_low_pass_and_the_delay() {
    let mut chain = chain(scenario::Sensor {
        delay_ticks: 4,
        bandwidth_hz: 200.0,
        ..quiet()
    });
    let step = deflected([1e-3, 0.0, 0.0]);
    chain.sample(0);
    chain.felt = components(&step);
    let weights = chain.weights(1e-3);
    for tick in 1..=20 {
        chain.follow(None, &step, &weights);
        let samples = chain.sample(tick);
        assert_eq!(samples[0].utime, (tick - 4) * 1000);
        assert_eq!(samples[0].flags.valid, tick >= 4);
        let after = (tick - 4).max(0) as f64 * 1e-3;
        let expected = 1e-3 * (1.0 - libm::exp(-std::f64::consts::TAU * 200.0 * after));
        assert!((samples[0].deflection.translation.x - expected).abs() < 1e-12);
    }
}

#[test]
fn a_ramp_passes_the_low_pass_exactly_in_steps_of_any_length() {
    let through = |steps: u32| {
        let mut chain = chain(quiet());
        let weights = chain.weights(1e-3 / f64::from(steps));
        for i in 1..=steps {
            chain.follow(
                None,
                &deflected([1e-3 * f64::from(i) / f64::from(steps), 0.0, 0.0]),
                &weights,
            );
        }
        chain.filtered[0]
    };
    let tau = 1.0 / (std::f64::consts::TAU * 200.0);
    let exact = 1.0 - tau / 1e-3 * (1.0 - libm::exp(-1e-3 / tau));
    for steps in [1, 5, 50] {
        assert!((through(steps) / 1e-3 / exact - 1.0).abs() < 1e-12);
    }
}

#[test]
fn noise_has_the_configured_rms_and_no_mean() {
    let mut chain = chain(scenario::Sensor {
        noise_translation_m: 2e-6,
        noise_rotation_rad: 40e-6,
        ..quiet()
    });
    let count = 20_000;
    let (mut sum, mut squares) = ([0.0; 6], [0.0; 6]);
    for tick in 0..count {
        let DeflectionSample {
            deflection, wrench, ..
        } = chain.sample(tick)[0];
        let newest = components(&Reading { deflection, wrench });
        for i in 0..6 {
            sum[i] += newest[i];
            squares[i] += newest[i] * newest[i];
        }
    }
    for i in 0..6 {
        let rms = if i < 3 { 2e-6 } else { 40e-6 };
        assert!((sum[i] / count as f64).abs() < 4.0 * rms / (count as f64).sqrt());
        assert!(((squares[i] / count as f64).sqrt() / rms - 1.0).abs() < 0.02);
    }
}

#[test]
fn samples_are_quantised_and_saturate_at_the_range() {
    let mut chain = chain(scenario::Sensor {
        quantum_translation_m: 1e-6,
        range_translation_m: 1.5e-3,
        delay_ticks: 0,
        ..quiet()
    });
    let far = deflected([0.1234567e-3, -2e-3, 0.0]);
    let weights = chain.weights(1.0);
    chain.follow(None, &far, &weights);
    chain.follow(None, &far, &weights);
    let sample = chain.sample(0)[0];
    assert!((sample.deflection.translation.x - 0.123e-3).abs() < 1e-12);
    assert_eq!(sample.deflection.translation.y, -1.5e-3);
    assert!(sample.flags.saturated);
}

#[test]
fn a_bias_drifts() {
    let mut chain = chain(scenario::Sensor {
        drift_translation_m_per_s: [1e-6, 0.0, -2e-6],
        drift_rotation_rad_per_s: [0.0, 3e-5, 0.0],
        delay_ticks: 0,
        ..quiet()
    });
    let drifted = chain.sample(2000)[0].deflection;
    assert!((drifted.translation - nalgebra::Vector3::new(2e-6, 0.0, -4e-6)).norm() < 1e-18);
    assert!((drifted.rotation.y - 6e-5).abs() < 1e-18);
}

#[test]
fn samples_of_a_drop_out_are_invalid_and_the_noise_goes_on() {
    let noisy = scenario::Sensor {
        delay_ticks: 2,
        ..Default::default()
    };
    let mut whole = chain(noisy.clone());
    let mut broken = chain(scenario::Sensor {
        dropout_start_s: 0.005,
        dropout_duration_s: 0.003,
        ..noisy
    });
    for tick in 0..20 {
        let (whole, broken) = (whole.sample(tick), broken.sample(tick));
        for (whole, broken) in whole.iter().zip(&broken) {
            assert_eq!(whole.utime, broken.utime);
            if (5000..8000).contains(&broken.utime) {
                assert!(!broken.flags.valid && broken.deflection == Deflection::default());
            } else {
                assert_eq!(whole, broken);
            }
        }
    }
}

#[test]
fn a_measured_wrench_is_flagged_and_leaves_the_deflection_its_bits_at_the_first_tick() {
    let measuring = scenario::Sensor {
        delay_ticks: 0,
        wrench_measured: true,
        noise_force_n: 0.0,
        noise_moment_nm: 0.0,
        ..Default::default()
    };
    let mut reading = Reading::default();
    reading.wrench.force.z = 10.0;
    reading.wrench.moment.x = -0.3;
    let sample = SignalChain::new(&measuring, 7, &reading).sample(0)[0];
    assert!(sample.flags.wrench_measured);
    assert_eq!(sample.wrench, reading.wrench);
    let plain = chain(scenario::Sensor {
        wrench_measured: false,
        ..measuring
    })
    .sample(0)[0];
    assert!(!plain.flags.wrench_measured && plain.wrench == Wrench::default());
    assert_eq!(sample.deflection, plain.deflection);
}
