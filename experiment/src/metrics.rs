//! What is measured of a run: peak, settling, IAE, steady state, orientation, impact (PLANT.md section 6).

mod from_log;
mod no_figures;
mod recording;

pub use from_log::ForceFrom;
pub use no_figures::NoFigures;
pub use recording::{ForceCurve, Recording};

use serde::Serialize;

/// How long after the first contact is judged, s.
pub const WINDOW_S: f64 = 1.5;
/// The end of that window, over which steady values are averaged, s.
const STEADY_S: f64 = 0.3;
/// Where as long a time begins whose ringing that at the end is held against, s after the first contact.
const EARLY_S: f64 = 0.6;
/// Shorter separations are the vibration of the contact itself, s.
const REBOUND_S: f64 = 0.003;

/// Declares the figures once: struct, names, and the way to an array and back.
macro_rules! figures {
    ($count:literal: $($(#[doc = $doc:literal])+ $name:ident,)+) => {
        /// The figures of one run. A settling time that is not a number (`null` in JSON, `-` in a table): outside the
        /// band at the end of the window, never settled.
        #[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
        pub struct Metrics {
            $($(#[doc = $doc])+ pub $name: f64,)+
        }

        impl Metrics {
            /// How many figures there are.
            pub const COUNT: usize = $count;

            /// Names of the figures, in the order of [`Metrics::values`].
            pub const NAMES: [&'static str; $count] = [$(stringify!($name)),+];

            /// The figures in the order of [`Metrics::NAMES`].
            pub fn values(&self) -> [f64; $count] {
                [$(self.$name),+]
            }

            /// The figures in the order of [`Metrics::NAMES`].
            pub fn from_values([$($name),+]: [f64; $count]) -> Self {
                Self { $($name),+ }
            }
        }
    };
}

figures! { 16:
    /// Largest contact force as the tcp's deflection shows it, N.
    peak_n,
    /// That above the desired force, as a share of it.
    overshoot_ratio,
    /// Last exit from desired force +- 10 %, s after the first contact.
    settling_10_s,
    /// Last exit from desired force +- 5 %, s after the first contact.
    settling_5_s,
    /// Last exit from desired force +- 2 %, s after the first contact.
    settling_2_s,
    /// Integral of the force error's magnitude, N s.
    iae_n_s,
    /// Integral of the force above the desired one, N s.
    impulse_above_n_s,
    /// Mean of the true contact force minus the desired one at the end, N.
    steady_error_n,
    /// Standard deviation of the true contact force at the end, N.
    steady_sigma_n,
    /// That over the same from 0.6 to 0.9 s after the first contact: below 1, what rings dies out.
    ringing_ratio,
    /// How often the tool has left the object for more than 3 ms and met it again.
    rebounds,
    /// Largest deviation of the tool's orientation from that before contact, rad.
    orientation_max_rad,
    /// The same at the end, rad.
    orientation_end_rad,
    /// From the first contact to the sample that the controller has detected it in, s; not a number: not detected.
    detection_delay_s,
    /// Largest true contact force, the impact's peak included, N.
    impact_peak_n,
    /// Energy that the tool has put into the object, J.
    energy_j,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_survive_the_way_to_an_array_and_back() {
        let values = std::array::from_fn(|i| i as f64);
        let metrics = Metrics::from_values(values);
        assert_eq!(metrics.values(), values);
        assert_eq!((metrics.peak_n, metrics.energy_j), (0.0, 15.0));
        assert_eq!(Metrics::NAMES[5], "iae_n_s");
    }
}
