//! What goes into an assessment, and between which limits it makes sense.

/// Why there is no assessment.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ImpactError {
    /// A value outside its limits.
    #[error("{} is {}, outside {} to {}; {}", quantity.name, quantity.text(*value), decimal(quantity.low),
        quantity.text(quantity.high), quantity.remedy)]
    OutOfRange {
        /// What it is.
        quantity: &'static Quantity,
        /// Its value.
        value: f64,
    },
    /// How fast something may be that leaves no mark at any speed.
    #[error(
        "no indentation remains with a rebound ratio of 1 (elastic), at any speed; give a rebound ratio above 1, or a \
         force that is allowed"
    )]
    NothingRemains,
    /// The answer has no room in a number.
    #[error("{0} is too large or too small to be told; choose values closer to those of a real contact")]
    Unrepresentable(&'static str),
}

/// A quantity with its limits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quantity {
    name: &'static str,
    unit: &'static str,
    low: f64,
    high: f64,
    remedy: &'static str,
}

impl Quantity {
    const fn new(name: &'static str, unit: &'static str, low: f64, high: f64, remedy: &'static str) -> Self {
        Self {
            name,
            unit,
            low,
            high,
            remedy,
        }
    }

    /// `value` if it lies within the limits; NaN lies nowhere.
    pub fn check(&'static self, value: f64) -> Result<f64, ImpactError> {
        if (self.low..=self.high).contains(&value) {
            return Ok(value);
        }
        Err(ImpactError::OutOfRange {
            quantity: self,
            value,
        })
    }

    /// `value` with the unit.
    fn text(&self, value: f64) -> String {
        let gap = if self.unit.is_empty() { "" } else { " " };
        format!("{}{gap}{}", decimal(value), self.unit)
    }
}

/// n of (13): `0 < n <= 2`. Below 1e-6 the force is the same at any depth that has a meaning.
pub static EXPONENT: Quantity = Quantity::new(
    "exponent n",
    "",
    1e-6,
    2.0,
    "1 is a flat punch, 1.5 a sphere, 2 a cone",
);
/// c_in of (13).
pub static COEFFICIENT: Quantity = Quantity::new(
    "indentation coefficient c_in",
    "N/m^n",
    1e-3,
    1e15,
    "for a flat punch it is 2 R E*",
);
/// c_re over c_in.
pub static REBOUND_RATIO: Quantity = Quantity::new(
    "rebound ratio c_re / c_in",
    "",
    1.0,
    1e3,
    "1 is elastic, more leaves an indentation",
);
/// M.
pub static MASS: Quantity = Quantity::new(
    "mass",
    "kg",
    1e-6,
    1e6,
    "give the mass that strikes, such as 4 kg for a tool",
);
/// The mass that a contact feels: far less than the tool's where that gives way by turning.
pub static EFFECTIVE_MASS: Quantity = Quantity::new(
    "effective mass",
    "kg",
    1e-12,
    1e6,
    "check the tool's moments of inertia and levers",
);
/// A moment of inertia.
pub static INERTIA: Quantity = Quantity::new(
    "moment of inertia",
    "kg m^2",
    1e-9,
    1e6,
    "give the principal moments about the centre of mass",
);
/// A coordinate of a lever.
pub static COORDINATE: Quantity = Quantity::new("coordinate", "m", -100.0, 100.0, "give it in metres");
/// v_0.
pub static SPEED: Quantity = Quantity::new(
    "speed",
    "m/s",
    1e-9,
    100.0,
    "give the speed towards the object, positive",
);
/// E.
pub static YOUNGS_MODULUS: Quantity =
    Quantity::new("Young's modulus", "Pa", 1e3, 1e13, "steel has 2.1e11 Pa");
/// E*.
pub static EFFECTIVE_MODULUS: Quantity = Quantity::new(
    "effective Young's modulus E*",
    "Pa",
    1e3,
    1e13,
    "steel on steel has about 1e11 Pa",
);
/// nu.
pub static POISSON_RATIO: Quantity = Quantity::new(
    "Poisson's ratio",
    "",
    0.0,
    0.5,
    "most solids have 0.2 to 0.4, rubber 0.5",
);
/// A radius or another length of an indenter.
pub static LENGTH: Quantity = Quantity::new(
    "length of the shape",
    "m",
    1e-9,
    100.0,
    "give its radius or side in metres",
);
/// Half the angle of a cone.
pub static HALF_ANGLE: Quantity = Quantity::new(
    "half angle",
    "rad",
    1e-3,
    1.57,
    "measure from the axis to the flank; a right angle would be a plane",
);
/// A shape's numerical factor.
pub static FACTOR: Quantity = Quantity::new(
    "factor of the shape",
    "",
    1e-6,
    1e6,
    "2 is a flat punch, 4/3 a sphere",
);
/// A force that is allowed.
pub static FORCE: Quantity = Quantity::new(
    "allowed force",
    "N",
    1e-6,
    1e9,
    "give the largest force that the object or the tool stands",
);
/// An indentation that may remain.
pub static REMAINING_DEPTH: Quantity = Quantity::new(
    "allowed remaining indentation",
    "m",
    1e-12,
    1.0,
    "give the deepest mark that may stay",
);
/// Stiffness of a contact with a person.
pub static BODY_STIFFNESS: Quantity = Quantity::new(
    "contact stiffness k of the body region",
    "N/m",
    1.0,
    1e9,
    "take it from the table of the standard that applies",
);
/// Sampling time of the force control.
pub static SAMPLING_TIME: Quantity = Quantity::new(
    "sampling time",
    "s",
    1e-6,
    10.0,
    "the command period T, such as 0.004 s",
);

/// A number as short as possible, with a power of ten where that is shorter to read.
pub(crate) fn decimal(value: f64) -> String {
    if value == 0.0 || (1e-4..1e6).contains(&value.abs()) {
        value.to_string()
    } else {
        format!("{value:e}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_refusal_names_value_limits_and_remedy() {
        assert_eq!(
            MASS.check(-4.0).unwrap_err().to_string(),
            "mass is -4 kg, outside 1e-6 to 1e6 kg; give the mass that strikes, such as 4 kg for a tool"
        );
        assert_eq!(
            REBOUND_RATIO.check(0.5).unwrap_err().to_string(),
            "rebound ratio c_re / c_in is 0.5, outside 1 to 1000; 1 is elastic, more leaves an indentation"
        );
    }

    #[test]
    fn what_is_no_number_is_refused() {
        assert!(EXPONENT.check(0.0).is_err() && EXPONENT.check(2.0).is_ok());
        assert!(EXPONENT.check(1e-6).is_ok() && EXPONENT.check(2.0000001).is_err());
        for quantity in [&EXPONENT, &MASS, &SPEED, &POISSON_RATIO, &REBOUND_RATIO] {
            assert!(quantity.check(f64::NAN).is_err() && quantity.check(f64::INFINITY).is_err());
        }
    }
}
