//! Rests computed from a tool that hangs in balance: what was put in comes out.

use super::*;
use proptest::prelude::*;

/// What is put in.
#[derive(Clone, Copy, Debug)]
struct Cell {
    mass_kg: f64,
    centre: Vector3<f64>,
    compliance: [f64; 2],
    deflection_bias: Deflection,
    wrench_bias: Wrench,
}

impl Cell {
    /// The balance of spring and weight at `r_from_s`, found by iterating the spring's deflection.
    fn rest(&self, r_from_s: UnitQuaternion<f64>) -> Rest {
        let weight = r_from_s.inverse() * Vector3::new(0.0, 0.0, -9.80665 * self.mass_kg);
        let mut phi = Vector3::zeros();
        for _ in 0..100 {
            phi = (rotation::exp(phi) * self.centre).cross(&weight) * self.compliance[1];
        }
        let moment = phi / self.compliance[1];
        Rest {
            r_from_s,
            deflection: Deflection {
                translation: weight * self.compliance[0] + self.deflection_bias.translation,
                rotation: phi + self.deflection_bias.rotation,
            },
            wrench: Some(Wrench {
                force: weight + self.wrench_bias.force,
                moment: moment + self.wrench_bias.moment,
            }),
        }
    }

    fn rests(&self, tilt: f64) -> Vec<Rest> {
        let across = tilt * std::f64::consts::FRAC_1_SQRT_2;
        [
            (0.0, 0.0),
            (tilt, 0.0),
            (-tilt, 0.0),
            (0.0, tilt),
            (0.0, -tilt),
            (across, across),
            (-across, -across),
        ]
        .iter()
        .map(|&(x, y)| self.rest(rotation::exp(Vector3::new(x, y, 0.0))))
        .collect()
    }
}

fn vector(limit: f64) -> impl Strategy<Value = Vector3<f64>> {
    [-limit..limit, -limit..limit, -limit..limit].prop_map(Vector3::from)
}

/// From a screwdriver to the 100 kg of the paper's Fig. 1, sags of up to 5 deg included.
fn cell() -> impl Strategy<Value = Cell> {
    (
        0.3..100.0,
        vector(1.0).prop_filter("a lever", |c| c.norm() > 0.3),
        (0.01..0.08, 1e-5..3e-3),
        vector(1e-4),
        vector(5e-3),
        vector(5.0),
        vector(0.5),
    )
        .prop_map(|(mass_kg, direction, (sag_rad, sag_m), p, phi, f, m)| {
            let centre = direction * 0.1;
            Cell {
                mass_kg,
                centre,
                compliance: [
                    sag_m / (9.81 * mass_kg),
                    sag_rad / (9.81 * mass_kg * centre.norm()),
                ],
                deflection_bias: Deflection {
                    translation: p,
                    rotation: phi,
                },
                wrench_bias: Wrench { force: f, moment: m },
            }
        })
}

/// The cell of PLANT.md section 1, with a bias.
fn reference() -> Cell {
    Cell {
        mass_kg: 4.0,
        centre: Vector3::new(0.03, 0.0, -0.06),
        compliance: [1.0 / 300e3, 1.0 / 401.07],
        deflection_bias: Deflection {
            translation: Vector3::new(20e-6, -10e-6, 5e-6),
            rotation: Vector3::new(1e-3, 0.0, -1e-3),
        },
        wrench_bias: Wrench {
            force: Vector3::new(1.0, -2.0, 3.0),
            moment: Vector3::new(0.1, 0.2, -0.1),
        },
    }
}

fn close(found: f64, expected: f64, relative: f64) -> bool {
    (found - expected).abs() <= relative * expected.abs()
}

proptest! {
    /// Without noise, all comes out exactly, however far the tool sags.
    #[test]
    fn what_was_put_in_comes_out(cell in cell(), tilt in 0.12..0.8) {
        let found = calibrate(&cell.rests(tilt), &KnownTool::default()).unwrap();
        let tool = found.tool.unwrap();
        prop_assert!(close(tool.mass_kg.value, cell.mass_kg, 1e-9));
        prop_assert!((tool.centre_of_mass_in_s_m.value - cell.centre).norm() < 1e-9);
        prop_assert!((tool.force_bias_n.value - cell.wrench_bias.force).norm() < 1e-8);
        prop_assert!((tool.moment_bias_nm.value - cell.wrench_bias.moment).norm() < 1e-8);
        prop_assert!(close(found.compliance_m_per_n.value, cell.compliance[0], 1e-7));
        prop_assert!(close(found.compliance_rad_per_nm.unwrap().value, cell.compliance[1], 1e-7));
        prop_assert!((found.translation_bias_m.value - cell.deflection_bias.translation).norm() < 1e-10);
        prop_assert!((found.rotation_bias_rad.value - cell.deflection_bias.rotation).norm() < 1e-8);
    }

    /// Without a wrench, mass and centre of mass as known give the same compliance.
    #[test]
    fn a_known_tool_takes_the_place_of_the_wrench(cell in cell(), tilt in 0.12..0.8) {
        let mut rests = cell.rests(tilt);
        rests[3].wrench = None;
        let known = KnownTool { mass_kg: Some(cell.mass_kg), centre_of_mass_in_s_m: Some(cell.centre) };
        let found = calibrate(&rests, &known).unwrap();
        prop_assert_eq!(found.tool, None);
        prop_assert!(close(found.compliance_m_per_n.value, cell.compliance[0], 1e-7));
        prop_assert!(close(found.compliance_rad_per_nm.unwrap().value, cell.compliance[1], 1e-7));
    }

    /// Noise: the deviations found are those foretold.
    #[test]
    fn the_standard_deviations_are_honest(seed in vector(1.0)) {
        let cell = reference();
        let (mut squares, mut count) = ([0.0; 3], 0.0);
        for round in 0..60 {
            let mut rests = cell.rests(0.3);
            let mut phase = seed.sum() + f64::from(round);
            // Equidistributed, uncorrelated: sigma 1.
            let mut noise = || Vector3::from_fn(|_, _| {
                phase += 0.618_033_988_749_894_9 + 0.1 * libm::sin(1e3 * phase);
                3f64.sqrt() * (2.0 * (phase - libm::floor(phase)) - 1.0)
            });
            for rest in &mut rests {
                rest.deflection.translation += noise() * 0.2e-6;
                rest.deflection.rotation += noise() * 4e-6;
                let wrench = rest.wrench.as_mut().unwrap();
                wrench.force += noise() * 0.02;
                wrench.moment += noise() * 5e-4;
            }
            let found = calibrate(&rests, &KnownTool::default()).unwrap();
            let pairs = [
                (found.tool.unwrap().mass_kg, cell.mass_kg),
                (found.compliance_m_per_n, cell.compliance[0]),
                (found.compliance_rad_per_nm.unwrap(), cell.compliance[1]),
            ];
            for (square, (estimate, truth)) in squares.iter_mut().zip(pairs) {
                let deviation = (estimate.value - truth) / estimate.sigma;
                *square += deviation * deviation;
            }
            count += 1.0;
        }
        for square in squares {
            let ratio = (square / count).sqrt();
            prop_assert!((0.5..2.0).contains(&ratio), "{ratio}");
        }
    }
}

#[test]
fn without_mass_or_centre_the_error_names_what_is_missing() {
    let mut rests = reference().rests(0.3);
    rests.iter_mut().for_each(|rest| rest.wrench = None);
    let mut known = KnownTool::default();
    let error = calibrate(&rests, &known).unwrap_err();
    assert_eq!(error, CalibrationError::MassUnknown);
    assert!(error.to_string().ends_with("set controller.tool_mass_kg"));
    known.mass_kg = Some(4.0);
    let found = calibrate(&rests, &known).unwrap();
    assert!(close(found.compliance_m_per_n.value, 1.0 / 300e3, 1e-9));
    let error = found.compliance_rad_per_nm.unwrap_err();
    assert_eq!(error, CalibrationError::CentreUnknown);
    assert!(
        error
            .to_string()
            .ends_with("set controller.tool_centre_of_mass_in_s_m")
    );
}

/// Turns about the vertical, and tilts about one axis, leave something in the dark; so do small tilts and few rests.
#[test]
fn what_is_not_identifiable_is_refused() {
    let cell = reference();
    let refused = |turns: &[Vector3<f64>]| {
        let rests: Vec<_> = turns.iter().map(|&turn| cell.rest(rotation::exp(turn))).collect();
        calibrate(&rests, &KnownTool::default()).unwrap_err()
    };
    let about = |axis: Vector3<f64>| [0.0, 0.3, -0.3, 0.2].map(|angle| axis * angle);
    assert_eq!(
        refused(&[Vector3::zeros(), Vector3::x()]),
        CalibrationError::TooFewRests { found: 2 }
    );
    assert!(matches!(
        refused(&about(Vector3::z())),
        CalibrationError::TooLittleTilt { tilt_rad } if tilt_rad < 1e-7
    ));
    assert!(matches!(
        refused(&about(Vector3::x())),
        CalibrationError::TooLittleTilt { tilt_rad } if tilt_rad < 0.03
    ));
    let small = calibrate(&cell.rests(0.05), &KnownTool::default()).unwrap_err();
    assert_eq!(
        small.to_string(),
        "the rests tilt by 0.027 rad rms about the axis about which they tilt least, below 0.05 rad; tilt further \
         about two horizontal axes (a turn about the vertical tells nothing)"
    );
}

/// A sensor that says what the tool exerts on the environment.
#[test]
fn a_wrong_sign_is_refused() {
    let mut rests = reference().rests(0.3);
    for rest in &mut rests {
        let wrench = rest.wrench.as_mut().unwrap();
        wrench.force = -wrench.force;
    }
    let error = calibrate(&rests, &KnownTool::default()).unwrap_err();
    assert!(
        matches!(error, CalibrationError::NotPositive { value, .. } if (value + 4.0).abs() < 1e-9),
        "{error}"
    );
}
