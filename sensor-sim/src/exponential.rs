//! Exponential integration of `y' = L y + N(y, t)`: exact for the linear part, explicit for the rest.
//!
//! The functions `phi_0(z) = e^z`, `phi_k(z) = (phi_(k-1)(z) - 1/(k-1)!) / z` carry a force that grows with the
//! (k-1)-th power of time through a linear system (Hochbruck and Ostermann, Exponential integrators, Acta Numerica
//! 2010, eqs. (2.10), (2.11)).

use nalgebra::{SMatrix, SVector};

/// Number of components of y.
pub const SIZE: usize = 14;
/// y, or its rate of change.
pub type Vector = SVector<f64, SIZE>;
/// L, or a function of it.
pub type Operator = SMatrix<f64, SIZE, SIZE>;

/// Terms of the series of phi_3: for |z| < 1 the first one left out, z^15 / 18!, is below rounding.
const TERMS: u32 = 15;

/// The functions phi of `h L` for steps of one length h, each times h.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Phi {
    one: Operator,
    two: Operator,
    three: Operator,
}

/// `e^(h L)` with [`Phi`], which is all that doubling h takes.
struct Flow {
    exponential: Operator,
    phi: Phi,
}

impl Phi {
    /// Of no step at all.
    pub fn zero() -> Self {
        Self {
            one: Operator::zeros(),
            two: Operator::zeros(),
            three: Operator::zeros(),
        }
    }

    /// Into `levels`, those for steps of `longest` s, of half of that, of a quarter, ...: the stages of scaling and
    /// squaring, from the shortest step's series on, where `|h L| < 1`.
    pub fn fill(levels: &mut [Self], linear: &Operator, longest: f64) {
        let shortest = levels.iter().skip(1).fold(longest, |step, _| 0.5 * step);
        let mut flow = Flow::short(linear, shortest);
        for (i, level) in levels.iter_mut().rev().enumerate() {
            if i > 0 {
                flow = flow.doubled();
            }
            *level = flow.phi;
        }
    }
}

impl Flow {
    fn short(linear: &Operator, step: f64) -> Self {
        let z = linear * step;
        let one = Operator::identity();
        // phi_3 = 1/3! + z/4! + z^2/5! + ... by Horner's rule, in which 1/6 is taken out: 1 + z/4 (1 + z/5 (...)).
        let series = (4..4 + TERMS)
            .rev()
            .fold(one, |sum, k| one + z * sum * (1.0 / f64::from(k)));
        let three = series * (1.0 / 6.0);
        let two = one * 0.5 + z * three;
        let first = one + z * two;
        Self {
            exponential: one + z * first,
            phi: Phi {
                one: first * step,
                two: two * step,
                three: three * step,
            },
        }
    }

    /// `phi_k(2 z) = 2^-k (e^z phi_k(z) + sum over j of phi_j(z) / (k - j)!)`, j from 1 to k.
    fn doubled(&self) -> Self {
        let Self { exponential: e, phi } = self;
        Self {
            exponential: e * e,
            phi: Phi {
                one: e * phi.one + phi.one,
                two: (e * phi.two + phi.one + phi.two) * 0.5,
                three: (e * phi.three + phi.one * 0.5 + phi.two + phi.three) * 0.25,
            },
        }
    }
}

/// Where in a step a stage stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// At half of its time.
    Middle,
    /// At its end.
    End,
}

/// The change of y over a step: Krogstad's method of fourth order (Generalized integrating factor methods for stiff
/// PDEs, J. Comput. Phys. 203, 2005: ETDRK4-B), in the form that starts from the rate of change at the step's start.
///
/// `whole` and `half` are of the step and of half of it. `rate` gives y' where y has changed so much since the start.
/// As in the classical method, which this one is for L = 0, of the two stages at the middle one falls short by as much
/// as the other goes too far: their mean is what the solution does there.
pub fn step(
    linear: &Operator,
    [whole, half]: [&Phi; 2],
    start: &Vector,
    mut rate: impl FnMut(&Vector, Place) -> Vector,
) -> Vector {
    // How much of the rate's change since the start is not linear.
    let mut rest = |change: &Vector, place: Place| rate(change, place) - start - linear * change;
    let straight = half.one * start;
    let guess = rest(&straight, Place::Middle);
    let middle = rest(&(straight + half.two * guess * 2.0), Place::Middle);
    let straight = whole.one * start;
    let end = rest(&(straight + whole.two * middle * 2.0), Place::End);
    let both = guess + middle;
    straight + whole.two * (both * 2.0 - end) + whole.three * ((end - both) * 4.0)
}

#[cfg(test)]
mod tests;
