//! The second impact of a tool that bounces off the object while the robot behind the sensor still moves on.

use super::rebound::Rebound;
use std::f64::consts::PI;

/// Bisections that find the flight's end: as many as a double has bits.
const BISECTIONS: usize = 60;

/// The speed of the second impact over that of the first.
///
/// The tool leaves the object with e v, while the link comes on with v: against the link it moves with (1 + e) v on
/// the sensor's spring, of whatever frequency w. Seen from the object it is at `(1 + e) v / w sin(w t) - v t`, and
/// back at the object when `(1 + e) sin(theta) = theta`, theta = w t, with the speed `v (1 - (1 + e) cos(theta))`.
/// Off an elastic object (e = 1) it comes back 1.64 times as fast, and only below e = pi/2 - 1 slower than it came.
///
/// Model choice: the paper has one impact. Validity: one mode of the tool on the sensor, no damping, and a robot that has
/// not reacted before the tool is back (half a period of that mode at most): one that has makes it slower.
pub fn second_impact_speed_ratio(rebound: &Rebound, exponent: f64) -> f64 {
    let leaving = 1.0 + rebound.restitution(exponent);
    // The sine is above the line until the flight's end, and below it from there on to pi.
    let (mut flying, mut back) = (0.0, PI);
    for _ in 0..BISECTIONS {
        let theta = 0.5 * (flying + back);
        if leaving * libm::sin(theta) > theta {
            flying = theta;
        } else {
            back = theta;
        }
    }
    1.0 - leaving * libm::cos(back)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ratio(restitution: f64) -> f64 {
        // n = 1: e = sqrt(c_in / c_re).
        second_impact_speed_ratio(&Rebound::new(1.0 / (restitution * restitution)).unwrap(), 1.0)
    }

    /// The flight integrated: a mass on a spring whose other end moves on.
    #[test]
    fn the_flight_ends_with_that_speed() {
        for restitution in [0.2, 0.5, 0.571, 0.8, 1.0] {
            for frequency in [50.0, 140.0] {
                let step = 1e-7;
                let (mut height, mut speed, mut time) = (0.0, restitution, 0.0_f64);
                loop {
                    speed += -frequency * frequency * (height + time) * step;
                    height += speed * step;
                    time += step;
                    if height <= 0.0 {
                        break;
                    }
                }
                let found = ratio(restitution);
                assert!(
                    (found + speed).abs() < 2e-4,
                    "e = {restitution}: {found}, {speed}"
                );
            }
        }
    }

    #[test]
    fn an_elastic_object_gives_back_more_and_a_soft_one_less() {
        assert!((ratio(1.0) - 1.638).abs() < 0.001);
        assert!((ratio(PI / 2.0 - 1.0) - 1.0).abs() < 1e-9);
        assert!(ratio(0.5) < 1.0 && ratio(0.05) < 0.2);
    }
}
