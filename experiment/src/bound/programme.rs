//! The linear programmes, solved by an interior-point method (clarabel).

use clarabel::algebra::CscMatrix;
use clarabel::solver::{DefaultSettings, DefaultSolver, IPSolver, SolverStatus, SupportedConeT};

/// Forces over time, linear in the accelerations at the knots.
#[derive(Clone, Debug, PartialEq)]
pub struct Programme {
    /// The force at each instant with no acceleration at any knot, N.
    pub free: Vec<f64>,
    /// What each knot adds at each instant for an acceleration at its limit, N: a column for each knot.
    pub reach: Vec<Vec<f64>>,
    /// The force to regulate, N.
    pub desired: f64,
}

impl Programme {
    /// The forces (N) with accelerations (share of the limit) at the knots.
    pub fn forces(&self, accelerations: &[f64]) -> Vec<f64> {
        let mut forces = self.free.clone();
        for (column, share) in self.reach.iter().zip(accelerations) {
            for (force, reach) in forces.iter_mut().zip(column) {
                *force += reach * share;
            }
        }
        forces
    }

    /// The accelerations (share of the limit) with the least sum of `|f - f_d|`.
    pub fn least_sum(&self) -> Result<Vec<f64>, SolverStatus> {
        let instants = self.free.len();
        let rows: Vec<Row> = (0..instants)
            .flat_map(|i| [1.0, -1.0].map(|sign| self.row(i, sign, i)))
            .collect();
        Ok(solve(&rows, self.reach.len(), instants)?.0)
    }

    /// The least possible largest `|f - f_d|` from the instant `from` on, N.
    pub fn least_error(&self, from: usize) -> Result<f64, SolverStatus> {
        let rows: Vec<Row> = (from..self.free.len())
            .flat_map(|i| [1.0, -1.0].map(|sign| self.row(i, sign, 0)))
            .collect();
        Ok(solve(&rows, self.reach.len(), 1)?.1)
    }

    /// The least possible largest force, N, at least the desired one.
    pub fn least_peak(&self) -> Result<f64, SolverStatus> {
        let rows: Vec<Row> = (0..self.free.len()).map(|i| self.row(i, 1.0, 0)).collect();
        Ok(self.desired + solve(&rows, self.reach.len(), 1)?.1)
    }

    /// `sign (f - f_d) <= slack` at the instant `i`.
    fn row(&self, i: usize, sign: f64, slack: usize) -> Row {
        Row {
            reach: self.reach.iter().map(|column| sign * column[i]).collect(),
            slack,
            limit: sign * (self.desired - self.free[i]),
        }
    }
}

/// `reach . a - slack <= limit`.
struct Row {
    reach: Vec<f64>,
    slack: usize,
    limit: f64,
}

/// Minimise the sum of `slacks` slacks, none of them negative, within `rows`, with the accelerations a at `knots` between
/// -1 and 1. The accelerations, and the sum of the slacks.
fn solve(rows: &[Row], knots: usize, slacks: usize) -> Result<(Vec<f64>, f64), SolverStatus> {
    let variables = knots + slacks;
    let mut limits: Vec<f64> = rows.iter().map(|row| row.limit).collect();
    limits.extend(std::iter::repeat_n(1.0, 2 * knots));
    limits.extend(std::iter::repeat_n(0.0, slacks));

    // The unknowns are not the accelerations, whose effects are ways that grow for ever, but the ways' coefficients c of
    // cubic B-splines, whose effects are local: a_k = c_k - 2 c_(k-1) + c_(k-2).
    let local = |reach: &[f64], knot: usize| {
        let at = |i: usize| reach.get(i).copied().unwrap_or(0.0);
        at(knot) - 2.0 * at(knot + 1) + at(knot + 2)
    };
    // By columns, as the solver takes it: rows, upper and lower limits, signs of the slacks.
    let (mut starts, mut places, mut values) = (vec![0], Vec::new(), Vec::new());
    for knot in 0..knots {
        for (place, row) in rows.iter().enumerate() {
            let value = local(&row.reach, knot);
            if value != 0.0 {
                places.push(place);
                values.push(value);
            }
        }
        for (offset, sign) in [(rows.len(), 1.0), (rows.len() + knots, -1.0)] {
            let bands = [1.0, -2.0, 1.0].into_iter().enumerate();
            for (behind, band) in bands.take(knots - knot) {
                places.push(offset + knot + behind);
                values.push(sign * band);
            }
        }
        starts.push(places.len());
    }
    for slack in 0..slacks {
        for (place, _) in rows.iter().enumerate().filter(|(_, row)| row.slack == slack) {
            places.push(place);
            values.push(-1.0);
        }
        places.push(rows.len() + 2 * knots + slack);
        values.push(-1.0);
        starts.push(places.len());
    }
    let constraints = CscMatrix::new(limits.len(), variables, starts, places, values);
    let mut cost = vec![0.0; knots];
    cost.extend(std::iter::repeat_n(1.0, slacks));
    // Forces are wanted to a millinewton.
    let settings = DefaultSettings {
        verbose: false,
        tol_gap_abs: 1e-5,
        tol_gap_rel: 1e-6,
        tol_feas: 1e-6,
        ..DefaultSettings::default()
    };
    let cones = [SupportedConeT::NonnegativeConeT(limits.len())];
    let curvature = CscMatrix::zeros((variables, variables));
    let solver = DefaultSolver::new(&curvature, &cost, &constraints, &limits, &cones, settings);
    let mut solver = solver.map_err(|_| SolverStatus::Unsolved)?;
    solver.solve();
    let found = &solver.solution.x;
    match solver.solution.status {
        SolverStatus::Solved | SolverStatus::AlmostSolved => {
            let before = |knot: usize, back: usize| knot.checked_sub(back).map_or(0.0, |i| found[i]);
            let accelerations = (0..knots).map(|knot| found[knot] - 2.0 * before(knot, 1) + before(knot, 2));
            Ok((accelerations.collect(), found[knots..].iter().sum()))
        }
        status => Err(status),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two instants, one knot that trades one for the other: the sum and the largest error in closed form.
    #[test]
    fn a_trade_in_closed_form() {
        let programme = Programme {
            free: vec![4.0, 1.0],
            reach: vec![vec![-1.0, 2.0]],
            desired: 2.0,
        };
        let best = programme.least_sum().unwrap();
        assert!((best[0] - 0.5).abs() < 1e-6, "{best:?}");
        // 2 - a = 2 a - 1 at a = 1: one newton too much at both.
        assert!((programme.least_error(0).unwrap() - 1.0).abs() < 1e-6);
        assert!((programme.least_error(1).unwrap()).abs() < 1e-6);
        assert!((programme.least_peak().unwrap() - 3.0).abs() < 1e-6);
    }
}
