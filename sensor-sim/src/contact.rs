//! The contact of the tcp with the object's surface: loading and a stiffer rebound.

use node::scenario;

/// Contact of a point with a plane, with the memory of its deepest indentation.
///
/// Loading (h >= h_max): `f = c_in h^n`. Otherwise `f = c_re (h - h_rem)^n` above the remaining indentation
/// `h_rem = h_max (1 - (c_in / c_re)^(1/n))` and zero below it. The memory is cleared once h < 0, and is frozen
/// inside an integration step, so that the force is a smooth function of h there (PLANT.md section 3).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    indentation_n_per_m: f64,
    rebound_n_per_m: f64,
    exponent: f64,
    /// `1 - (c_in / c_re)^(1/n)`.
    remaining_fraction: f64,
    deepest_m: f64,
}

/// A piece of the contact's law in which its force is a smooth function of the indentation.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Piece {
    /// No force.
    #[default]
    Off,
    /// The stiffer line on the way out and back in.
    Rebound,
    /// Deeper than ever before: a kink as soon as the motion turns.
    Loading,
}

impl Contact {
    /// An untouched surface, of whose stiffness this contact has the `share` (1: all).
    pub fn new(object: &scenario::Object, share: f64) -> Self {
        let fraction = libm::pow(1.0 / object.rebound_ratio, 1.0 / object.exponent);
        Self {
            indentation_n_per_m: object.indentation_n_per_m * share,
            rebound_n_per_m: object.indentation_n_per_m * object.rebound_ratio * share,
            exponent: object.exponent,
            remaining_fraction: 1.0 - fraction,
            deepest_m: 0.0,
        }
    }

    /// The normal force (N) on the tool at indentation `h` (m), the memory left as it is.
    pub fn force(&self, h: f64) -> f64 {
        self.force_on(self.piece(h).0, h)
    }

    /// The force (N) that a `piece` of the law gives at `h` (m): the piece's own formula, also beyond its ends.
    pub fn force_on(&self, piece: Piece, h: f64) -> f64 {
        match piece {
            Piece::Off => 0.0,
            Piece::Rebound => self.rebound_n_per_m * self.power(h - self.remaining_m()),
            Piece::Loading => self.indentation_n_per_m * self.power(h),
        }
    }

    /// Slope of a `piece` of the law with exponent 1, N/m.
    pub fn stiffness_on(&self, piece: Piece) -> f64 {
        match piece {
            Piece::Off => 0.0,
            Piece::Rebound => self.rebound_n_per_m,
            Piece::Loading => self.indentation_n_per_m,
        }
    }

    /// The piece of the law that holds at indentation `h` (m), and how far, m, it is to a kink between two pieces.
    pub fn piece(&self, h: f64) -> (Piece, f64) {
        let remaining = self.remaining_m();
        if h <= remaining {
            (Piece::Off, remaining - h)
        } else if h < self.deepest_m {
            (Piece::Rebound, (h - remaining).min(self.deepest_m - h))
        } else {
            (Piece::Loading, 0.0)
        }
    }

    /// The deepest indentation reached, m: the force of the rebound meets that of the loading there.
    pub fn deepest_m(&self) -> f64 {
        self.deepest_m
    }

    /// Remember the indentation `h` (m) reached at the end of an integration step.
    pub fn remember(&mut self, h: f64) {
        self.deepest_m = if h < 0.0 { 0.0 } else { self.deepest_m.max(h) };
    }

    /// The indentation (m) at which the force vanishes on the way out.
    pub fn remaining_m(&self) -> f64 {
        self.deepest_m * self.remaining_fraction
    }

    fn power(&self, h: f64) -> f64 {
        // The flat punch needs no transcendental function.
        if self.exponent == 1.0 {
            h
        } else {
            libm::pow(h, self.exponent)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn contact(rebound_ratio: f64, exponent: f64) -> Contact {
        let object = scenario::Object {
            rebound_ratio,
            exponent,
            ..Default::default()
        };
        Contact::new(&object, 1.0)
    }

    proptest! {
        #[test]
        fn loading_and_unloading_meet_at_the_deepest_point(
            ratio in 1.0..20.0, exponent in 0.5..2.0, depth in 1e-7..1e-4
        ) {
            let mut contact = contact(ratio, exponent);
            let loading = contact.force(depth);
            contact.remember(depth);
            let unloading = contact.force(depth * (1.0 - 1e-12));
            prop_assert!((loading - unloading).abs() < 1e-6 * loading);
            prop_assert_eq!(contact.force(contact.remaining_m()), 0.0);
        }
    }

    #[test]
    fn leaving_the_surface_clears_the_memory() {
        let mut contact = contact(4.0, 1.0);
        contact.remember(1e-5);
        assert!((contact.remaining_m() - 0.75e-5).abs() < 1e-20);
        assert_eq!(contact.force(0.5e-5), 0.0);
        contact.remember(-1e-9);
        assert_eq!(contact.remaining_m(), 0.0);
        assert_eq!(contact.force(0.5e-5), 16e6 * 0.5e-5);
    }
}
