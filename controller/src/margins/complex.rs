//! Functions of complex numbers by way of `libm`: the same bits on every CPU (DESIGN: invariant 4).

use nalgebra::Complex;

type C = Complex<f64>;

/// `e^x`.
pub(super) fn exp(x: C) -> C {
    let (sin, cos) = libm::sincos(x.im);
    C::new(cos, sin) * libm::exp(x.re)
}

/// `|x|`.
pub(super) fn modulus(x: C) -> f64 {
    libm::hypot(x.re, x.im)
}

/// The angle of x, -pi to pi, rad.
pub(super) fn angle(x: C) -> f64 {
    libm::atan2(x.im, x.re)
}
