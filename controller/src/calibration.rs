//! What a sensor and its tool are, learnt from rests in tilted orientations under gravity alone.
//!
//! At rest only the weight M g acts, at the centre of mass c. Seen from the sensor it turns with the tilt, and what is
//! constant stays behind as a bias. With g in s and E = Exp(phi) the turn of the deflected tool:
//!
//! | Measured at s, in s | Model | Unknown, in which the model is linear |
//! |---|---|---|
//! | force | `f = M g + f_0` | M, f_0 |
//! | moment | `m = (E c) x M g + m_0` | M c, m_0 |
//! | translation, paper (3) | `p = C_p M g + p_0` | C_p M, p_0 |
//! | rotation, paper (4) | `phi = C_phi ((E c) x M g) + phi_0` | C_phi M c, phi_0 |
//!
//! So each row is a linear least-squares problem of its own, of one of two kinds (along and across gravity), and the
//! quotients give C_p, C_phi and c. E needs phi without its bias: the last row is repeated with the bias just found, a
//! contraction by the sag's angle.
//!
//! What can be learnt: turning about the vertical leaves g in s as it is, and with it every bias inseparable; tilting
//! about one axis alone leaves the part of c along that axis in the dark. The rests have to tilt about two axes.
//! Without a measured wrench M is inseparable from C_p, and M c from C_phi: both have to be known then.
//!
//! Model choice: the sensor is equally compliant along and about all its axes, so that p is parallel to f and the moment
//! about s is that about s'. A sensor that is not shows up in the residuals.

mod error;
mod estimate;
mod least_squares;

pub use error::CalibrationError;
pub use estimate::Estimate;
use estimate::{Moment, bias, positive, quotient, ratio};
use least_squares::{Fit, fit};
use nalgebra::{Matrix3, UnitQuaternion, Vector3};
use spatial::{Deflection, GRAVITY_M_PER_S2, Wrench, rotation};

/// What was measured, on average, while sensor and tool were at rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rest {
    /// Orientation of the nominal sensor frame: `r_from_s`'s rotation; r's z axis points up.
    pub r_from_s: UnitQuaternion<f64>,
    /// Deflection at s, in s.
    pub deflection: Deflection,
    /// Wrench at s, in s, if it is measured independently of the deflection.
    pub wrench: Option<Wrench>,
}

/// What is known of the tool beforehand; only needed where no wrench is measured.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct KnownTool {
    /// M, kg.
    pub mass_kg: Option<f64>,
    /// c in s, m.
    pub centre_of_mass_in_s_m: Option<Vector3<f64>>,
}

/// What the rests tell.
#[derive(Clone, Debug, PartialEq)]
pub struct Calibration {
    /// Tool and bias of the wrench; `None`: no wrench was measured.
    pub tool: Option<ToolEstimate>,
    /// C_p, m/N.
    pub compliance_m_per_n: Estimate<f64>,
    /// C_phi, rad/Nm, or what is missing for it.
    pub compliance_rad_per_nm: Result<Estimate<f64>, CalibrationError>,
    /// p_0, m: the translation without load.
    pub translation_bias_m: Estimate<Vector3<f64>>,
    /// phi_0, rad: the rotation without load.
    pub rotation_bias_rad: Estimate<Vector3<f64>>,
    /// rms of what the model leaves unexplained of a translation's component, m.
    pub translation_residual_m: f64,
    /// The same of a rotation's component, rad.
    pub rotation_residual_rad: f64,
}

/// What a measured wrench tells.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ToolEstimate {
    /// M, kg.
    pub mass_kg: Estimate<f64>,
    /// c in s, m.
    pub centre_of_mass_in_s_m: Estimate<Vector3<f64>>,
    /// f_0, N.
    pub force_bias_n: Estimate<Vector3<f64>>,
    /// m_0, Nm.
    pub moment_bias_nm: Estimate<Vector3<f64>>,
    /// rms of what the model leaves unexplained of a force's component, N.
    pub force_residual_n: f64,
    /// The same of a moment's component, Nm.
    pub moment_residual_nm: f64,
}

/// Fewest rests: below, the six unknowns of a moment are not overdetermined.
pub const MINIMUM_RESTS: usize = 3;

/// Least tilt of the rests, rad rms about the axis about which they tilt least: a twentieth of a radian changes the
/// forces by a twentieth of the weight.
pub const MINIMUM_TILT_RAD: f64 = 0.05;

/// How often the turn of the deflected tool is evaluated: a sag of 0.1 rad is exact to 1e-8 then.
const PASSES: usize = 8;

/// Learn what `rests` tell. Works offline: its cost grows with their number.
pub fn calibrate(rests: &[Rest], known: &KnownTool) -> Result<Calibration, CalibrationError> {
    check(rests)?;
    let translation = along_gravity(
        rests
            .iter()
            .map(|rest| (gravity(rest), rest.deflection.translation)),
    )?;
    let mut rotation_bias = Vector3::zeros();
    let mut rotation = across(rests, &rotation_bias, |rest| rest.deflection.rotation)?;
    for _ in 1..PASSES {
        rotation_bias = rotation.value.fixed_rows::<3>(3).into_owned();
        rotation = across(rests, &rotation_bias, |rest| rest.deflection.rotation)?;
    }
    let (_, rotation_bias_rad) = rotation.halves();

    let wrenches: Option<Vec<Wrench>> = rests.iter().map(|rest| rest.wrench).collect();
    let weighed = match wrenches {
        Some(wrenches) => Some(weigh(rests, &wrenches, &rotation_bias)?),
        None => None,
    };
    let mass = match (&weighed, known.mass_kg) {
        (Some(weighed), _) => weighed.tool.mass_kg,
        (None, Some(value)) => Estimate { value, sigma: 0.0 },
        (None, None) => return Err(CalibrationError::MassUnknown),
    };
    let first_moment = match (&weighed, known.centre_of_mass_in_s_m) {
        (Some(weighed), _) => Ok(weighed.first_moment),
        (None, Some(centre)) => Ok(Moment {
            value: centre * mass.value,
            covariance: Matrix3::zeros(),
        }),
        (None, None) => Err(CalibrationError::CentreUnknown),
    };
    let yielding = Estimate {
        value: translation.value[0],
        sigma: translation.sigma(0),
    };
    Ok(Calibration {
        tool: weighed.map(|weighed| weighed.tool),
        compliance_m_per_n: positive("the translational compliance, m/N", quotient(yielding, mass))?,
        compliance_rad_per_nm: first_moment.and_then(|moment| {
            positive(
                "the rotational compliance, rad/Nm",
                ratio(&Moment::of(&rotation), &moment),
            )
        }),
        translation_bias_m: bias(&translation),
        rotation_bias_rad,
        translation_residual_m: translation.residual_rms,
        rotation_residual_rad: rotation.residual_rms,
    })
}

/// What the wrenches tell.
struct Weighed {
    tool: ToolEstimate,
    /// M c, kg m.
    first_moment: Moment,
}

fn weigh(
    rests: &[Rest],
    wrenches: &[Wrench],
    rotation_bias: &Vector3<f64>,
) -> Result<Weighed, CalibrationError> {
    let measured = || rests.iter().zip(wrenches);
    let force = along_gravity(measured().map(|(rest, wrench)| (gravity(rest), wrench.force)))?;
    let moment = across_gravity(
        measured().map(|(rest, wrench)| (turn(rest, rotation_bias), gravity(rest), wrench.moment)),
    )?;
    let mass_kg = positive(
        "the tool's mass, kg,",
        Estimate {
            value: force.value[0],
            sigma: force.sigma(0),
        },
    )?;
    let (first_moment, moment_bias_nm) = moment.halves();
    let centre = std::array::from_fn::<_, 3, _>(|i| {
        let component = Estimate {
            value: first_moment.value[i],
            sigma: first_moment.sigma[i],
        };
        quotient(component, mass_kg)
    });
    Ok(Weighed {
        tool: ToolEstimate {
            mass_kg,
            centre_of_mass_in_s_m: Estimate {
                value: centre.map(|c| c.value).into(),
                sigma: centre.map(|c| c.sigma).into(),
            },
            force_bias_n: bias(&force),
            moment_bias_nm,
            force_residual_n: force.residual_rms,
            moment_residual_nm: moment.residual_rms,
        },
        first_moment: Moment::of(&moment),
    })
}

/// Enough rests, tilted enough.
fn check(rests: &[Rest]) -> Result<(), CalibrationError> {
    let found = rests.len();
    if found < MINIMUM_RESTS {
        return Err(CalibrationError::TooFewRests { found });
    }
    let tilt_rad = tilt(rests);
    // A value that is not a number is refused too.
    if tilt_rad >= MINIMUM_TILT_RAD {
        Ok(())
    } else {
        Err(CalibrationError::TooLittleTilt { tilt_rad })
    }
}

/// How far the rests tilt, rad rms about the axis about which they tilt least.
///
/// With the deviations D of the direction of gravity from its mean, `sum (D.D I - D D^T) / N` is the information of
/// the model `c x g` on c: its smallest eigenvalue is the mean square of the D across the worst direction of c.
fn tilt(rests: &[Rest]) -> f64 {
    let share = 1.0 / rests.len() as f64;
    let directions = || rests.iter().map(|rest| gravity(rest) / GRAVITY_M_PER_S2);
    let mean = directions().sum::<Vector3<f64>>() * share;
    let information = directions()
        .map(|direction| rotation::skew(direction - mean))
        .map(|k| k.transpose() * k)
        .sum::<Matrix3<f64>>()
        * share;
    information.symmetric_eigenvalues().min().max(0.0).sqrt()
}

/// g in s, m/s^2.
fn gravity(rest: &Rest) -> Vector3<f64> {
    rest.r_from_s.inverse() * Vector3::new(0.0, 0.0, -GRAVITY_M_PER_S2)
}

/// E: the turn of the deflected tool, s from s'.
fn turn(rest: &Rest, rotation_bias: &Vector3<f64>) -> UnitQuaternion<f64> {
    rotation::exp(rest.deflection.rotation - rotation_bias)
}

/// [`across_gravity`] for what `measured` takes from a rest.
fn across(
    rests: &[Rest],
    rotation_bias: &Vector3<f64>,
    measured: impl Fn(&Rest) -> Vector3<f64> + Clone,
) -> Result<Fit<6>, CalibrationError> {
    across_gravity(
        rests
            .iter()
            .map(move |rest| (turn(rest, rotation_bias), gravity(rest), measured(rest))),
    )
}

/// The fit of `y = a g + y_0` to pairs (g, y): unknowns a, y_0.
fn along_gravity(
    pairs: impl Iterator<Item = (Vector3<f64>, Vector3<f64>)> + Clone,
) -> Result<Fit<4>, CalibrationError> {
    fit(pairs.map(|(gravity, y)| {
        let mut rows = nalgebra::Matrix3x4::zeros();
        rows.set_column(0, &gravity);
        rows.fixed_view_mut::<3, 3>(0, 1).fill_with_identity();
        (rows, y)
    }))
}

/// The fit of `y = (E b) x g + y_0` to triples (E, g, y): unknowns b, y_0.
fn across_gravity(
    triples: impl Iterator<Item = (UnitQuaternion<f64>, Vector3<f64>, Vector3<f64>)> + Clone,
) -> Result<Fit<6>, CalibrationError> {
    fit(triples.map(|(turn, gravity, y)| {
        let mut rows = nalgebra::Matrix3x6::zeros();
        rows.fixed_view_mut::<3, 3>(0, 0)
            .copy_from(&(-rotation::skew(gravity) * turn.to_rotation_matrix().matrix()));
        rows.fixed_view_mut::<3, 3>(0, 3).fill_with_identity();
        (rows, y)
    }))
}

#[cfg(test)]
mod tests;
