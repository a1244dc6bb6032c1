//! What is measured of a run: peak, settling, IAE, steady error, orientation (PLANT.md section 6).

mod no_figures;
mod recording;

pub use no_figures::NoFigures;
pub use recording::{ForceCurve, Recording};

use serde::Serialize;

/// How long after the first contact is judged, s.
pub const WINDOW_S: f64 = 1.5;
/// The end of that window, over which steady values are averaged, s.
const STEADY_S: f64 = 0.3;

/// The figures of one run. A settling time that is not a number (`null` in JSON, `-` in a table): outside the band at
/// the end of the window, never settled.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Metrics {
    /// Largest contact force as the tcp's deflection shows it, N.
    pub peak_n: f64,
    /// Last exit from desired force +- 10 %, s after the first contact.
    pub settling_10_s: f64,
    /// Last exit from desired force +- 2 %, s after the first contact.
    pub settling_2_s: f64,
    /// Integral of the force error's magnitude, N s.
    pub iae_n_s: f64,
    /// Mean of the true contact force minus the desired one at the end, N.
    pub steady_error_n: f64,
    /// Largest deviation of the tool's orientation from that before contact, rad.
    pub orientation_max_rad: f64,
    /// The same at the end, rad.
    pub orientation_end_rad: f64,
}

impl Metrics {
    /// Names of the figures, in the order of [`Metrics::values`].
    pub const NAMES: [&'static str; 7] = [
        "peak_n",
        "settling_10_s",
        "settling_2_s",
        "iae_n_s",
        "steady_error_n",
        "orientation_max_rad",
        "orientation_end_rad",
    ];

    /// The figures in the order of [`Metrics::NAMES`].
    pub fn values(&self) -> [f64; 7] {
        [
            self.peak_n,
            self.settling_10_s,
            self.settling_2_s,
            self.iae_n_s,
            self.steady_error_n,
            self.orientation_max_rad,
            self.orientation_end_rad,
        ]
    }

    /// The figures in the order of [`Metrics::NAMES`].
    pub fn from_values(values: [f64; 7]) -> Self {
        let [
            peak_n,
            settling_10_s,
            settling_2_s,
            iae_n_s,
            steady_error_n,
            orientation_max_rad,
            orientation_end_rad,
        ] = values;
        Self {
            peak_n,
            settling_10_s,
            settling_2_s,
            iae_n_s,
            steady_error_n,
            orientation_max_rad,
            orientation_end_rad,
        }
    }
}
