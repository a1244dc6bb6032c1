//! The search itself: deterministic, without derivatives, the same whatever the number of threads.

use rayon::prelude::*;

/// In the unit cube: half of the evaluations on points that fill it evenly (additive recurrence with the roots of
/// `x^(d + 1) = x + 1`, Roberts 2018) and on the start; the rest on a compass search from the best two of them, whose
/// steps are halved where none of the neighbours is better.
pub(super) struct Search {
    pub(super) evaluations: usize,
    pub(super) seed: u64,
}

/// Share of the cube's edge that a compass begins with and ends with.
const FIRST_STEP: f64 = 0.08;
const LAST_STEP: f64 = 0.005;

#[derive(Clone)]
struct Judged {
    point: Vec<f64>,
    cost: f64,
}

impl Search {
    /// The best point found for `cost`, from `start` on.
    pub(super) fn run(&self, start: &[f64], cost: impl Fn(&[f64]) -> f64 + Sync) -> Vec<f64> {
        let judge = |points: Vec<Vec<f64>>| -> Vec<Judged> {
            let judged = |point: Vec<f64>| Judged {
                cost: cost(&point),
                point,
            };
            points.into_par_iter().map(judged).collect()
        };
        let spread = (self.evaluations / 2).max(1);
        let mut points = vec![start.to_vec()];
        points.extend((1..spread).map(|n| self.spread(n, start.len())));
        let mut judged = judge(points);
        // Of equally good ones the earlier counts: the sort is stable.
        judged.sort_by(|a, b| a.cost.total_cmp(&b.cost));
        judged.truncate(2);
        let each = (self.evaluations - spread) / judged.len();
        let ends = judged.into_iter().map(|from| compass(from, each, judge));
        ends.min_by(|a, b| a.cost.total_cmp(&b.cost))
            .map_or_else(|| start.to_vec(), |best| best.point)
    }

    fn spread(&self, n: usize, dimensions: usize) -> Vec<f64> {
        let mut root = 1.5;
        for _ in 0..64 {
            root = libm::pow(1.0 + root, 1.0 / (dimensions as f64 + 1.0));
        }
        let offset = 0.5 + self.seed as f64 * 0.381_966_011_250_105;
        let along = |i: usize| offset + n as f64 * libm::pow(root, -(i as f64 + 1.0));
        (0..dimensions)
            .map(|i| along(i) - libm::floor(along(i)))
            .collect()
    }
}

fn compass(from: Judged, evaluations: usize, judge: impl Fn(Vec<Vec<f64>>) -> Vec<Judged>) -> Judged {
    let (mut best, mut step, mut left) = (from, FIRST_STEP, evaluations);
    while step >= LAST_STEP {
        let neighbours: Vec<_> = (0..best.point.len())
            .flat_map(|i| [step, -step].map(|change| (i, change)))
            .map(|(i, change)| {
                let mut point = best.point.clone();
                point[i] = f64::clamp(point[i] + change, 0.0, 1.0);
                point
            })
            .filter(|point| *point != best.point)
            .collect();
        if neighbours.len() > left {
            break;
        }
        left -= neighbours.len();
        let better = judge(neighbours)
            .into_iter()
            .min_by(|a, b| a.cost.total_cmp(&b.cost))
            .filter(|found| found.cost < best.cost);
        match better {
            Some(found) => best = found,
            None => step *= 0.5,
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicUsize, Ordering};

    #[test]
    fn a_valley_is_found_within_the_budget() {
        let count = AtomicUsize::new(0);
        let cost = |point: &[f64]| {
            count.fetch_add(1, Ordering::Relaxed);
            let (x, y) = (point[0] - 0.83, point[1] - 0.12);
            x * x + 10.0 * (y - 0.5 * x) * (y - 0.5 * x)
        };
        let search = Search {
            evaluations: 120,
            seed: 0,
        };
        let best = search.run(&[0.1, 0.9], cost);
        assert!(
            (best[0] - 0.83).abs() < 0.02 && (best[1] - 0.12).abs() < 0.02,
            "{best:?}"
        );
        assert!(count.load(Ordering::Relaxed) <= 120);
    }
}
