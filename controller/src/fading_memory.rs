//! Where something is, how fast and how much faster, from noisy samples of where it was.

/// Longest gap between two samples that is bridged, s: beyond it the filter starts anew.
const LONGEST_GAP_S: f64 = 0.1;

/// How long a motion is predicted beyond its newest sample, s.
pub const LONGEST_PREDICTION_S: f64 = 0.2;

/// How often the memory is to be filled before the degree grows.
const MEMORIES_PER_DEGREE: f64 = 5.0;

/// A polynomial through the recent samples in the sense of least squares, each weighted by `theta` less than the
/// next: the fading-memory filters of degree 0, 1 and 2 (e.g. Brookner, Tracking and Kalman Filtering Made Easy,
/// table 7.2-2). All their poles lie at theta.
///
/// With the residual r of a sample against the prediction, dt s after the one before:
/// degree 0: `x += (1 - theta) r`; degree 1: `x += (1 - theta^2) r`, `v += (1 - theta)^2 r / dt`; degree 2:
/// `x += (1 - theta^3) r`, `v += 1.5 (1 - theta)^2 (1 + theta) r / dt`, `a += (1 - theta)^3 r / dt^2`.
///
/// The memory grows: with the n-th sample `1 - theta` falls as 1 / n, as in a mean over all samples, from `first` down
/// to `last`. So does the degree, by one each time that the memory, `1 / (1 - theta)` samples, has been filled five
/// times: bounces after an impact must not become a velocity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FadingMemory {
    degree: usize,
    first: f64,
    last: f64,
    /// Velocity at the first sample.
    expected_velocity: f64,
    state: Option<State>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct State {
    /// Samples taken.
    count: f64,
    time_s: f64,
    /// Position, velocity and acceleration.
    position: f64,
    velocity: f64,
    acceleration: f64,
}

impl State {
    fn at(&self, time_s: f64) -> Self {
        let dt = time_s - self.time_s;
        Self {
            count: self.count,
            time_s,
            position: self.position + dt * (self.velocity + 0.5 * dt * self.acceleration),
            velocity: self.velocity + dt * self.acceleration,
            acceleration: self.acceleration,
        }
    }
}

impl FadingMemory {
    /// Nothing known yet. `degree` is that of the polynomial, 0 to 2; `1 - theta`, the weight of a new sample at degree
    /// 0, goes from `first` to `last`.
    pub fn new(degree: usize, first: f64, last: f64) -> Self {
        Self {
            degree,
            first,
            last: last.min(first),
            expected_velocity: 0.0,
            state: None,
        }
    }

    /// Expect the first sample to move with `velocity` instead of resting.
    pub fn expect(&mut self, velocity: f64) {
        self.expected_velocity = if self.degree > 0 { velocity } else { 0.0 };
    }

    /// Take the sample `position` of the instant `time_s`. The first one is believed fully.
    pub fn take(&mut self, time_s: f64, position: f64) {
        let Some(state) = self.state.filter(|state| {
            let gap = time_s - state.time_s;
            (0.0..=LONGEST_GAP_S).contains(&gap)
        }) else {
            self.restart(time_s, position, self.expected_velocity);
            return;
        };
        let count = state.count + 1.0;
        let fresh = (1.0 / count).clamp(self.last, self.first);
        let filled = (count * fresh / MEMORIES_PER_DEGREE) as usize;
        let [g, h, k] = gains(self.degree.min(filled), fresh);
        let dt = time_s - state.time_s;
        let predicted = state.at(time_s);
        let residual = position - predicted.position;
        // Two samples of one instant tell nothing of the velocity.
        let rate = if dt > 0.0 { 1.0 / dt } else { 0.0 };
        self.state = Some(State {
            count,
            time_s,
            position: predicted.position + g * residual,
            velocity: predicted.velocity + h * residual * rate,
            acceleration: predicted.acceleration + k * residual * (rate * rate),
        });
    }

    /// Forget all samples; at `time_s` it is at `position` and moves with `velocity`.
    pub fn restart(&mut self, time_s: f64, position: f64, velocity: f64) {
        self.state = Some(State {
            count: 1.0,
            time_s,
            position,
            velocity,
            acceleration: 0.0,
        });
    }

    /// Position and velocity at `time_s`; `None` before the first sample. What is not heard of for longer than
    /// [`LONGEST_PREDICTION_S`] is taken to stop where it was predicted to be then.
    pub fn at(&self, time_s: f64) -> Option<(f64, f64)> {
        self.state.map(|state| {
            let last_s = state.time_s + LONGEST_PREDICTION_S;
            let State {
                position, velocity, ..
            } = state.at(time_s.min(last_s));
            (position, if time_s > last_s { 0.0 } else { velocity })
        })
    }

    /// Whether the memory has been filled often enough for the polynomial's full degree.
    pub fn is_settled(&self) -> bool {
        self.state
            .is_some_and(|state| state.count * self.last >= MEMORIES_PER_DEGREE * self.degree as f64)
    }

    /// Position and velocity at the newest sample.
    pub fn newest(&self) -> Option<(f64, f64)> {
        self.state.map(
            |State {
                 position, velocity, ..
             }| (position, velocity),
        )
    }
}

/// Of position, velocity and acceleration, for `fresh` = 1 - theta.
fn gains(degree: usize, fresh: f64) -> [f64; 3] {
    let theta = 1.0 - fresh;
    match degree {
        0 => [fresh, 0.0, 0.0],
        1 => [1.0 - theta * theta, fresh * fresh, 0.0],
        _ => [
            1.0 - theta * theta * theta,
            1.5 * fresh * fresh * (1.0 + theta),
            fresh * fresh * fresh,
        ],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const DT: f64 = 1e-3;

    /// The residual after n steps is that of a pole of multiplicity degree + 1 at theta: against a polynomial of its
    /// own degree the filter errs by a polynomial in n times theta^n.
    #[test]
    fn a_polynomial_of_its_degree_is_followed_without_lag() {
        for (degree, v, a) in [(0, 0.0, 0.0), (1, 0.05, 0.0), (2, 0.05, 0.4)] {
            let mut filter = FadingMemory::new(degree, 0.1, 0.1);
            let truth = |t: f64| 0.01 + v * t + 0.5 * a * t * t;
            for n in 0..400 {
                let t = f64::from(n) * DT;
                filter.take(t, truth(t));
            }
            let (position, velocity) = filter.at(0.42).unwrap();
            assert!((position - truth(0.42)).abs() < 1e-12, "degree {degree}");
            assert!(
                (velocity - (v + a * 0.42)).abs() < 1e-9,
                "degree {degree}: {velocity}"
            );
        }
    }

    /// All poles at theta: the answer of the residual to a single wrong sample dies out as n^degree theta^n, so that
    /// the filter's own recursion (x_n+3 - 3 theta x_n+2 + 3 theta^2 x_n+1 - theta^3 x_n = 0 for degree 2) holds.
    #[test]
    fn all_poles_lie_at_theta() {
        let theta = 0.8;
        for degree in 0..=2 {
            let mut filter = FadingMemory::new(degree, 1.0 - theta, 1.0 - theta);
            // Until the degree is full.
            let before = 60;
            for n in 0..before {
                filter.take(f64::from(n) * DT, 0.0);
            }
            filter.take(f64::from(before) * DT, 1.0);
            let x: Vec<f64> = (before + 1..before + 11)
                .map(|n| {
                    filter.take(f64::from(n) * DT, 0.0);
                    filter.newest().unwrap().0
                })
                .collect();
            let polynomial: &[f64] = match degree {
                0 => &[1.0, -theta],
                1 => &[1.0, -2.0 * theta, theta * theta],
                _ => &[1.0, -3.0 * theta, 3.0 * theta * theta, -theta * theta * theta],
            };
            for window in x.windows(polynomial.len()) {
                let sum: f64 = window.iter().rev().zip(polynomial).map(|(x, c)| x * c).sum();
                assert!(sum.abs() < 1e-12, "degree {degree}: {sum}");
            }
        }
    }

    #[test]
    fn samples_of_one_instant_are_averaged_and_long_silence_is_rest() {
        let mut filter = FadingMemory::new(0, 0.5, 0.5);
        for position in [0.0, 1.0] {
            filter.take(0.1, position);
        }
        assert_eq!(filter.newest(), Some((0.5, 0.0)));
        let mut moving = FadingMemory::new(1, 0.1, 0.1);
        for n in 0..400 {
            moving.take(f64::from(n) * DT, 0.05 * f64::from(n) * DT);
        }
        let (position, velocity) = moving.at(9.0).unwrap();
        assert!((position - 0.05 * (0.399 + LONGEST_PREDICTION_S)).abs() < 1e-9);
        assert_eq!(velocity, 0.0);
    }

    #[test]
    fn a_memory_that_grows_is_a_mean() {
        let mut filter = FadingMemory::new(0, 1.0, 0.0);
        for n in 1..=100 {
            filter.take(f64::from(n) * DT, f64::from(n % 7));
        }
        let mean = (1..=100).map(|n| f64::from(n % 7)).sum::<f64>() / 100.0;
        assert!((filter.newest().unwrap().0 - mean).abs() < 1e-12);
    }

    #[test]
    fn a_long_gap_or_a_step_back_in_time_starts_anew() {
        for time in [0.5, 0.0] {
            let mut filter = FadingMemory::new(1, 0.1, 0.1);
            filter.take(0.1, 0.0);
            filter.take(0.101, 1.0);
            filter.take(time, 7.0);
            assert_eq!(filter.newest(), Some((7.0, 0.0)));
        }
    }
}
