//! Figures of what was measured in turns.

/// What is measured of one of several things in turns: a list of values for each of its turns.
#[derive(Clone, Debug, Default)]
pub(super) struct Turns(Vec<Vec<f64>>);

/// A ratio of all values, and its least and largest of one turn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Ratio {
    pub(super) all: f64,
    pub(super) least: f64,
    pub(super) largest: f64,
}

impl Turns {
    /// Add a turn, with at least one value.
    pub(super) fn push(&mut self, mut turn: Vec<f64>) {
        turn.sort_by(f64::total_cmp);
        self.0.push(turn);
    }

    /// All values, from the lowest to the highest.
    pub(super) fn sorted(&self) -> Vec<f64> {
        let mut all = self.0.concat();
        all.sort_by(f64::total_cmp);
        all
    }

    /// How the `q` quantile compares with that of `other`, turn by turn with the one at the same time.
    pub(super) fn ratio(&self, other: &Self, q: f64) -> Ratio {
        let pairs = self.0.iter().zip(&other.0);
        let ratios = pairs.map(|(own, other)| quantile(own, q) / quantile(other, q));
        let (least, largest) = ratios.fold((f64::INFINITY, 0.0), |(least, largest): (f64, f64), ratio| {
            (least.min(ratio), largest.max(ratio))
        });
        Ratio {
            all: quantile(&self.sorted(), q) / quantile(&other.sorted(), q),
            least,
            largest,
        }
    }
}

/// The value of `sorted` that is no less than the share `q` of all; NaN: there is none.
pub(super) fn quantile(sorted: &[f64], q: f64) -> f64 {
    let rank = libm::ceil(q * sorted.len() as f64).max(1.0) as usize;
    sorted.get(rank - 1).copied().unwrap_or(f64::NAN)
}

/// In which order `count` things have their turn number `turn`: each is first as often as any other.
pub(super) fn order(turn: usize, count: usize) -> impl Iterator<Item = usize> {
    (0..count).map(move |place| (turn + place) % count)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quantile_is_one_of_the_values() {
        let values: Vec<f64> = (1..=1000).map(f64::from).collect();
        assert_eq!(
            [0.5, 0.999, 1.0].map(|q| quantile(&values, q)),
            [500.0, 999.0, 1000.0]
        );
        assert_eq!([0.0, 0.5, 0.999].map(|q| quantile(&values[..1], q)), [1.0; 3]);
        assert!(quantile(&[], 0.5).is_nan());
    }

    #[test]
    fn a_ratio_is_of_all_and_of_each_turn() {
        let (mut own, mut other) = (Turns::default(), Turns::default());
        for (factor, base) in [(1.0, 10.0), (2.0, 20.0), (1.5, 30.0)] {
            own.push(vec![3.0 * factor * base, factor * base, 2.0 * factor * base]);
            other.push(vec![base, 2.0 * base, 3.0 * base]);
        }
        let ratio = own.ratio(&other, 0.5);
        assert_eq!((ratio.least, ratio.largest), (1.0, 2.0));
        // 10 20 30, 40 80 120, 45 90 135 against 10 20 30, 20 40 60, 30 60 90.
        assert_eq!(ratio.all, 45.0 / 30.0);
    }

    #[test]
    fn everyone_is_first_in_turn() {
        let orders: Vec<Vec<usize>> = (0..3).map(|turn| order(turn, 3).collect()).collect();
        assert_eq!(orders, [[0, 1, 2], [1, 2, 0], [2, 0, 1]]);
    }
}
