//! Elastic gears between motors and links.

use node::scenario;
use spatial::kinematics::Axes;
use std::f64::consts::TAU;

/// A linear spring and damper in each axis (PLANT.md section 2): `F = k (x_m - x_l) + d (v_m - v_l)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gears {
    /// k, Nm/rad.
    pub stiffness: Axes,
    /// d, Nms/rad.
    pub damping: Axes,
}

impl Gears {
    /// The gears of a scenario's robot, whose links have `link_inertia` (kg m^2) about their axes; `None`: rigid.
    ///
    /// `k = m_l (2 pi f)^2`, `d = 2 zeta sqrt(k m_l)`: with the motor locked the link swings with f.
    pub fn new(robot: &scenario::Robot, link_inertia: &Axes) -> Option<Self> {
        match robot.gears {
            scenario::Gears::Rigid => None,
            scenario::Gears::Elastic => {
                let frequency = robot.drives().gear_frequency_hz * TAU;
                let stiffness = link_inertia.component_mul(&frequency.component_mul(&frequency));
                let critical = link_inertia.component_mul(&frequency);
                Some(Self {
                    stiffness,
                    damping: critical * (2.0 * robot.gear_damping),
                })
            }
        }
    }

    /// The torque (Nm) on the links from the motors' lead, `wind_up` (rad) and its rate, `slip` (rad/s).
    pub fn torque(&self, wind_up: &Axes, slip: &Axes) -> Axes {
        self.stiffness.component_mul(wind_up) + self.damping.component_mul(slip)
    }

    /// Elastic energy, J.
    pub fn energy(&self, wind_up: &Axes) -> f64 {
        0.5 * self.stiffness.dot(&wind_up.component_mul(wind_up))
    }

    /// Power that the dampers dissipate, W.
    pub fn dissipation(&self, slip: &Axes) -> f64 {
        self.damping.dot(&slip.component_mul(slip))
    }
}
