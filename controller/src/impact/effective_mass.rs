//! Which mass strikes: M of (14) for a tool that may turn.

use super::quantity::{COORDINATE, INERTIA, ImpactError, MASS};
use nalgebra::Vector3;

/// The rigid tool behind the tcp, as far as an impact feels it. Vectors in s, the frame of the sensor.
///
/// (17) needs the mass that the contact feels, not the tool's: off the normal through the centre of mass the tool
/// gives way by turning. For the reference tool 1.798 of 4 kg, 107 instead of 160 N.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ToolInertia {
    mass: f64,
    inertia: Vector3<f64>,
    centre_of_mass: Vector3<f64>,
}

impl ToolInertia {
    /// With the mass (kg), the principal moments of inertia about the centre of mass along the axes of s (kg m^2),
    /// and the centre of mass in s (m).
    pub fn new(
        mass_kg: f64,
        inertia_kg_m2: [f64; 3],
        centre_of_mass_in_s_m: [f64; 3],
    ) -> Result<Self, ImpactError> {
        for moment in inertia_kg_m2 {
            INERTIA.check(moment)?;
        }
        for coordinate in centre_of_mass_in_s_m {
            COORDINATE.check(coordinate)?;
        }
        Ok(Self {
            mass: MASS.check(mass_kg)?,
            inertia: inertia_kg_m2.into(),
            centre_of_mass: centre_of_mass_in_s_m.into(),
        })
    }

    /// The effective mass (kg) at the tcp `tcp_in_s` (m) along the unit vector `normal` (in s): a force along it
    /// accelerates the tcp along it by the force over that mass.
    ///
    /// `1/m = 1/M + (r x n) . J^-1 (r x n)` with r from the centre of mass to the tcp. Validity: the sensor holds
    /// the tool so softly that the robot is not felt within the characteristic impact time.
    pub fn at_tcp_kg(&self, tcp_in_s: Vector3<f64>, normal: Vector3<f64>) -> f64 {
        let moment = (tcp_in_s - self.centre_of_mass).cross(&normal);
        1.0 / (1.0 / self.mass + moment.dot(&moment.component_div(&self.inertia)))
    }
}

/// The mass (kg) that strikes where the tool of `tool_mass` kg is bolted to the robot without compliance: the robot
/// keeps it from turning and adds its own `reflected_mass` kg along the normal.
///
/// An upper bound: what yields between the two, a compliant sensor above all, decouples the robot from the impact.
pub fn with_robot_kg(tool_mass: f64, reflected_mass: f64) -> Result<f64, ImpactError> {
    Ok(MASS.check(tool_mass)? + MASS.check(reflected_mass)?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Matrix3, Rotation3};
    use proptest::prelude::*;

    const TCP: Vector3<f64> = Vector3::new(0.10, 0.0, -0.15);

    fn reference(centre_of_mass: [f64; 3]) -> ToolInertia {
        ToolInertia::new(4.0, [0.012, 0.016, 0.010], centre_of_mass).unwrap()
    }

    /// PLANT.md section 5: 1.798 kg.
    #[test]
    fn the_reference_tool_gives_way() {
        let mass = reference([0.03, 0.0, -0.06]).at_tcp_kg(TCP, Vector3::z());
        assert!((mass - 1.798).abs() < 0.0005, "{mass}");
    }

    #[test]
    fn on_the_normal_through_its_centre_all_of_it_strikes() {
        let mass = reference([0.10, 0.0, -0.06]).at_tcp_kg(TCP, Vector3::z());
        assert!((mass - 4.0).abs() < 1e-15);
    }

    proptest! {
        /// What Newton and Euler say: a unit force along n at the tcp accelerates it along n by 1/m.
        #[test]
        fn it_is_what_the_tcp_resists_with(
            turn in [-3.0..3.0, -3.0..3.0, -3.0..3.0], com in [-0.2..0.2, -0.2..0.2, -0.2..0.2f64]
        ) {
            let normal = Rotation3::new(Vector3::from(turn)) * Vector3::z();
            let r = TCP - Vector3::from(com);
            let inertia = Matrix3::from_diagonal(&Vector3::new(0.012, 0.016, 0.010));
            let angular = inertia.try_inverse().unwrap() * r.cross(&normal);
            let at_tcp = normal / 4.0 + angular.cross(&r);
            let mass = reference(com).at_tcp_kg(TCP, normal);
            prop_assert!((normal.dot(&at_tcp) * mass - 1.0).abs() < 1e-12);
            prop_assert!(mass > 0.0 && mass <= 4.0 + 1e-12);
        }
    }

    #[test]
    fn what_is_no_tool_is_refused() {
        assert!(ToolInertia::new(-4.0, [0.01; 3], [0.0; 3]).is_err());
        assert!(ToolInertia::new(4.0, [0.01, 0.0, 0.01], [0.0; 3]).is_err());
        assert!(ToolInertia::new(4.0, [0.01; 3], [f64::NAN, 0.0, 0.0]).is_err());
    }

    #[test]
    fn a_bolted_tool_strikes_with_the_robot() {
        assert_eq!(with_robot_kg(4.0, 44.0), Ok(48.0));
        assert!(with_robot_kg(4.0, -1.0).is_err());
    }
}
