//! What a law sees of a contact, and what it is to reach.

/// One sample of the sensor in contact, paired with the pose at its instant. Heights along the normal, m.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ContactSample {
    /// Where the deflected tcp is: the object, (12).
    pub object_m: f64,
    /// Where the tcp would be without contact: the virtual pose x_a of Fig. 3.
    pub actual_m: f64,
    /// Contact force, N; positive when the environment pushes the tool back.
    pub force_n: f64,
}

/// What a law is to reach, and with what sensor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aim {
    /// f_d, N.
    pub desired_force_n: f64,
    /// Assumed compliance C of the tcp along the normal, m/N.
    pub compliance_m_per_n: f64,
}
