//! The paper's own example: a flat faced cylinder on a flat surface.

use super::kick::KicksLaw;
use super::quantity::{EFFECTIVE_MODULUS, ImpactError, LENGTH};
use super::strike::Striker;
use std::f64::consts::PI;

/// Paper IV-B: a rigid cylinder of radius R that hits a half space of the effective modulus E* normally, n = 1.
///
/// All of it is [`super::strike`] with `c_in = 2 R E*`; here it stands in the paper's closed form.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FlatPunch {
    radius: f64,
    modulus: f64,
}

impl FlatPunch {
    /// With R in m and E* in Pa.
    pub fn new(radius_m: f64, effective_modulus_pa: f64) -> Result<Self, ImpactError> {
        Ok(Self {
            radius: LENGTH.check(radius_m)?,
            modulus: EFFECTIVE_MODULUS.check(effective_modulus_pa)?,
        })
    }

    /// `c_in = 2 R E*`, N/m.
    pub fn coefficient_n_per_m(&self) -> f64 {
        2.0 * self.radius * self.modulus
    }

    /// Paper (13) with `n = 1` and `c_in = 2 R E*`.
    pub fn law(&self) -> Result<KicksLaw, ImpactError> {
        KicksLaw::new(self.coefficient_n_per_m(), 1.0)
    }

    /// `omega_in = sqrt(2 R E* / M)`, rad/s.
    pub fn frequency_rad_per_s(&self, mass_kg: f64) -> f64 {
        (self.coefficient_n_per_m() / mass_kg).sqrt()
    }

    /// Paper (15): the indentation (m) at `time` (s), `h(t) = h_max sin(omega_in t)`, for `0 <= t <= tau_in`.
    pub fn depth_m(&self, striker: &Striker, time: f64) -> f64 {
        self.maximum_depth_m(striker) * libm::sin(self.frequency_rad_per_s(striker.mass_kg()) * time)
    }

    /// Paper (16): `h_max = v_0 / omega_in`, m.
    pub fn maximum_depth_m(&self, striker: &Striker) -> f64 {
        striker.speed_m_per_s() / self.frequency_rad_per_s(striker.mass_kg())
    }

    /// Paper, below (16): `tau_in = pi / (2 omega_in)`, s.
    pub fn indentation_time_s(&self, mass_kg: f64) -> f64 {
        0.5 * PI / self.frequency_rad_per_s(mass_kg)
    }

    /// Paper (17): the peak force `v_0 sqrt(2 R E* M)`, N.
    pub fn peak_force_n(&self, striker: &Striker) -> f64 {
        striker.speed_m_per_s() * (self.coefficient_n_per_m() * striker.mass_kg()).sqrt()
    }

    /// Paper (18): the characteristic impact time `tau_cit = 2 tau_in = pi / omega_in` (s) where c_re is unknown,
    /// whatever the speed. The paper's "tau_out" below (18) is its tau_re.
    pub fn characteristic_time_s(&self, mass_kg: f64) -> f64 {
        2.0 * self.indentation_time_s(mass_kg)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Table I, to four digits. The paper prints 0.7 ms, 1.5 ms, 9000 N and 160 N.
    #[test]
    fn table_1_of_the_paper() {
        for (radius, mass, modulus, time, peak) in [
            (0.010, 100.0, 100e9, "7.025e-4 s", "8.944e3 N"),
            (0.008, 4.0, 1e9, "1.571e-3 s", "1.600e2 N"),
        ] {
            let punch = FlatPunch::new(radius, modulus).unwrap();
            let striker = Striker::new(mass, 0.020).unwrap();
            assert_eq!(format!("{:.3e} s", punch.characteristic_time_s(mass)), time);
            assert_eq!(format!("{:.3e} N", punch.peak_force_n(&striker)), peak);
        }
    }

    /// (15) starts at v_0 and ends at rest, at (16).
    #[test]
    fn the_sine_begins_with_the_speed_and_ends_in_the_depth() {
        let punch = FlatPunch::new(0.008, 1e9).unwrap();
        let striker = Striker::new(4.0, 0.02).unwrap();
        let end = punch.indentation_time_s(4.0);
        let d = 1e-9;
        assert!((punch.depth_m(&striker, d) / d - 0.02).abs() < 1e-9);
        assert!((punch.depth_m(&striker, end) - 10e-6).abs() < 1e-18);
        let speed = (punch.depth_m(&striker, end + d) - punch.depth_m(&striker, end - d)) / (2.0 * d);
        assert!(speed.abs() < 1e-7, "{speed}");
    }
}
