//! The standard law of industrial robots: pd or admittance control.

use node::scenario;

/// Paper (1): `x_c(k) = x_c(k-1) + K (f(k) - f_d) + D (f(k) - f(k-1))`, on the contact's normal.
///
/// The distant-sensor extension (the posture of section III-B) acts on the other degrees of freedom; see
/// [`crate::posture`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pd {
    proportional_m_per_n: f64,
    derivative_m_per_n: f64,
    setpoint_m: f64,
    previous_force_n: f64,
}

impl Pd {
    /// The law taking over at the commanded position `setpoint_m`, with the force `force_n` felt then.
    pub fn new(parameters: &scenario::Pd, setpoint_m: f64, force_n: f64) -> Self {
        Self {
            proportional_m_per_n: parameters.proportional_m_per_n,
            derivative_m_per_n: parameters.derivative_m_per_n,
            setpoint_m,
            previous_force_n: force_n,
        }
    }

    /// The next set-point x_c (m) along the normal. `force_n` is positive when the environment pushes the tool
    /// back, along which direction the set-point then retreats.
    pub fn setpoint(&mut self, force_n: f64, desired_force_n: f64) -> f64 {
        self.setpoint_m += self.proportional_m_per_n * (force_n - desired_force_n)
            + self.derivative_m_per_n * (force_n - self.previous_force_n);
        self.previous_force_n = force_n;
        self.setpoint_m
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_term_of_equation_1() {
        let gains = scenario::Pd {
            proportional_m_per_n: 2e-6,
            derivative_m_per_n: 30e-6,
        };
        let mut pd = Pd::new(&gains, 0.5, 1.0);
        let first = pd.setpoint(4.0, 10.0);
        assert!((first - (0.5 + 2e-6 * -6.0 + 30e-6 * 3.0)).abs() < 1e-15);
        let second = pd.setpoint(4.0, 10.0);
        assert!((second - (first + 2e-6 * -6.0)).abs() < 1e-15);
    }
}
