//! What a law sees of a contact along one degree of freedom, and what it is to reach.

use spatial::ports::HORIZON;

/// How many of the coming set-points' instants a law looks ahead to: those of a command, and two more, from which
/// the last ones' velocity and acceleration follow.
pub const PREVIEW: usize = HORIZON + 2;

/// A motion along one degree of freedom at an instant: m, m/s, m/s^2, or rad, rad/s, rad/s^2.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Waypoint {
    /// x.
    pub position: f64,
    /// x'.
    pub rate: f64,
    /// x''.
    pub change: f64,
}

/// One sample of the sensor in contact, paired with the pose at its instant. Coordinates in m or rad, wrench in N or
/// Nm.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ContactSample {
    /// When it was true, s.
    pub time_s: f64,
    /// Where the deflected tcp is: the object, (12).
    pub object: f64,
    /// Where the tcp would be without contact: the virtual pose x_a of Fig. 3.
    pub actual: f64,
    /// Contact force or moment; positive when the environment pushes the tool back.
    pub wrench: f64,
    /// Whether the tool touches the object.
    pub touch: Touch,
}

/// Whether the tool touches the object, once it has met it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Touch {
    /// It does: the deflected tcp is where the object is.
    #[default]
    Contact,
    /// It has left the object for a moment, as after an impact.
    Bounce,
    /// It has left it for longer than any bounce, or has never met it.
    Lost,
}

/// What a law is to reach.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Aim {
    /// f_d, N or Nm.
    pub wrench: f64,
    /// The tcp's displacement under all of the desired wrench, `C f_d`, m or rad.
    pub displacement: f64,
    /// Compliance C along this degree of freedom alone, m/N or rad/Nm.
    pub compliance: f64,
}

/// Where the tcp was sent last, and when the coming set-points act.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Situation {
    /// The set-point last given, m or rad.
    pub commanded: f64,
    /// The desired coordinate last given, m or rad: where the robot will be when the next set-point begins to act.
    pub desired: f64,
    /// Its rate, m/s or rad/s.
    pub desired_rate: f64,
    /// Where the tcp would be without contact by the newest encoder values, m or rad.
    pub actual: f64,
    /// When the robot reaches the coming set-points, s; T apart.
    pub reached_s: [f64; PREVIEW],
    /// T, s.
    pub period_s: f64,
}

#[cfg(test)]
impl Situation {
    /// At rest at `position` since ever.
    pub(crate) fn at_rest(position: f64, period_s: f64) -> Self {
        Self {
            commanded: position,
            desired: position,
            desired_rate: 0.0,
            actual: position,
            reached_s: [0.0; PREVIEW],
            period_s,
        }
    }
}

#[cfg(test)]
impl Aim {
    /// 10 N with the tool of the paper's experiment.
    pub(crate) const PAPER: Self = Self {
        wrench: 10.0,
        displacement: 280e-6,
        compliance: 28e-6,
    };
}
