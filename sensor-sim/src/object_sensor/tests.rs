//! Schedule, delay, noise and sight.

use super::*;
use spatial::ports::Role;
use spatial::rotation;

fn quiet() -> scenario::ObjectSensor {
    scenario::ObjectSensor {
        enabled: true,
        noise_m: 0.0,
        quantum_m: 0.0,
        ..Default::default()
    }
}

/// At each tick from 0 on, what is published of an object that is at `at(tick)` while the tcp is `distance` m above it.
fn publish(
    settings: &scenario::ObjectSensor,
    ticks: i64,
    at: impl Fn(i64) -> Pose,
    distance: impl Fn(i64) -> f64,
) -> Vec<(i64, ObjectPose)> {
    let mut sensor = ObjectSensor::new(settings, 7);
    let publish = |tick| {
        let pose = at(tick);
        let tcp = pose * nalgebra::Point3::new(0.3, -0.2, distance(tick));
        let published = sensor.sample(Stamp::lockstep(tick, 7, Role::Sensor), &pose, &tcp.coords);
        published.map(|published| (tick, published))
    };
    (0..ticks).filter_map(publish).collect()
}

/// Moving along x by 1 mm per tick.
fn moving(tick: i64) -> Pose {
    spatial::pose(
        Vector3::new(1e-3 * tick as f64, 0.0, 0.0),
        Vector3::new(0.1, 0.0, 0.0),
    )
}

#[test]
fn poses_come_at_multiples_of_the_period_and_are_as_old_as_the_delay() {
    for (period_ticks, delay_ticks) in [(1, 0), (8, 0), (8, 8), (12, 5), (4, 30)] {
        let settings = scenario::ObjectSensor {
            period_ticks,
            delay_ticks,
            ..quiet()
        };
        let published = publish(&settings, 100, moving, |_| 0.1);
        let ticks: Vec<_> = published.iter().map(|(tick, _)| *tick).collect();
        assert_eq!(ticks, (0..100).step_by(period_ticks as usize).collect::<Vec<_>>());
        for (tick, pose) in published {
            let sampled = tick - delay_ticks;
            assert_eq!((pose.stamp.step, pose.stamp.utime), (tick, sampled * TICK_US));
            assert_eq!(pose.visible, sampled >= 0);
            let expected = if sampled >= 0 {
                moving(sampled)
            } else {
                Pose::identity()
            };
            assert_eq!(pose.pose, expected);
            assert_eq!((pose.velocity, pose.angular_velocity), Default::default());
        }
    }
}

#[test]
fn noise_has_the_configured_rms_per_axis_about_the_bias() {
    let settings = scenario::ObjectSensor {
        period_ticks: 1,
        delay_ticks: 0,
        noise_m: 50e-6,
        bias_m: [1e-3, 0.0, -2e-3],
        ..quiet()
    };
    let published = publish(&settings, 20_000, |_| Pose::identity(), |_| 0.1);
    let count = published.len() as f64;
    for (axis, bias) in [1e-3, 0.0, -2e-3].into_iter().enumerate() {
        let errors = published
            .iter()
            .map(|(_, pose)| pose.pose.translation.vector[axis] - bias);
        let (sum, squares) = errors.fold((0.0, 0.0), |(sum, squares), e| (sum + e, squares + e * e));
        assert!((sum / count).abs() < 4.0 * 50e-6 / count.sqrt());
        assert!(((squares / count).sqrt() / 50e-6 - 1.0).abs() < 0.02);
    }
    assert!(published.iter().all(|(_, pose)| pose.position_sigma_m == 50e-6));
}

#[test]
fn positions_are_quantised() {
    let settings = scenario::ObjectSensor {
        quantum_m: 1e-4,
        delay_ticks: 0,
        ..quiet()
    };
    let at = |_| Pose::translation(0.12347, -0.00018, 0.01004);
    for (_, pose) in publish(&settings, 20, at, |_| 0.1) {
        let expected = Vector3::new(0.1235, -0.0002, 0.0100);
        assert!((pose.pose.translation.vector - expected).norm() < 1e-15);
    }
}

#[test]
fn an_object_is_seen_within_range_along_its_normal_also_from_below_the_surface() {
    let settings = scenario::ObjectSensor {
        period_ticks: 1,
        delay_ticks: 0,
        range_m: 0.2,
        ..quiet()
    };
    let tilted = |_| {
        Pose::from_parts(
            Vector3::new(0.0, 0.0, 0.5).into(),
            rotation::exp(Vector3::new(0.4, 0.0, 0.0)),
        )
    };
    let distance = |tick: i64| 0.3015 - 1e-3 * tick as f64;
    for (tick, pose) in publish(&settings, 310, tilted, distance) {
        assert_eq!(pose.visible, distance(tick) <= 0.2, "{tick}");
    }
}

#[test]
fn samples_of_a_drop_out_see_nothing_and_the_noise_goes_on() {
    let noisy = scenario::ObjectSensor {
        enabled: true,
        period_ticks: 4,
        delay_ticks: 3,
        ..Default::default()
    };
    let broken = scenario::ObjectSensor {
        dropout_start_s: 0.020,
        dropout_duration_s: 0.010,
        ..noisy.clone()
    };
    let [whole, broken] = [noisy, broken].map(|settings| publish(&settings, 80, moving, |_| 0.1));
    for ((_, whole), (_, broken)) in whole.iter().zip(&broken) {
        assert_eq!(whole.stamp, broken.stamp);
        if (20_000..30_000).contains(&broken.stamp.utime) {
            assert!(whole.visible && !broken.visible && broken.pose == Pose::identity());
        } else {
            assert_eq!(whole, broken);
        }
    }
}
