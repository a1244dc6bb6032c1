//! The closed form against the numerical solution of (14), against what is published, and against itself.

use super::numerical::{Point, impact, indentation};
use super::strike::time_factor;
use super::*;
use proptest::prelude::*;

fn surface(coefficient: f64, exponent: f64, ratio: f64) -> Surface {
    Surface {
        law: KicksLaw::new(coefficient, exponent).unwrap(),
        rebound: Rebound::new(ratio).unwrap(),
    }
}

/// Over decades: 10 to the power of what is drawn.
fn decades(low: f64, high: f64) -> impl Strategy<Value = f64> {
    (low..high).prop_map(|exponent| libm::pow(10.0, exponent))
}

/// 0 < n <= 2, its ends and the shapes' included.
fn exponents() -> impl Strategy<Value = f64> {
    prop_oneof![
        4 => 0.0..2.0f64,
        1 => decades(-6.0, 0.0),
        1 => prop::sample::select(vec![1e-6, 0.5, 1.0, 1.5, 2.0]),
    ]
    .prop_map(|n| n.max(1e-6))
}

fn close(found: f64, expected: f64, what: &str) -> Result<(), TestCaseError> {
    prop_assert!(
        (found / expected - 1.0).abs() < 1e-9,
        "{what}: {found} instead of {expected}"
    );
    Ok(())
}

proptest! {
    /// Maximum depth, peak force and time of the indentation, to 1e-9 over the whole range of n, c, M and v.
    #[test]
    fn the_closed_form_solves_the_equation_of_motion(
        n in exponents(), c in decades(-3.0, 15.0), mass in decades(-6.0, 6.0), speed in decades(-9.0, 2.0)
    ) {
        let (surface, striker) = (surface(c, n, 1.0), Striker::new(mass, speed).unwrap());
        let closed = surface.struck_by(&striker);
        let end = indentation(&surface.law, &striker, |_| ());
        close(closed.maximum_depth_m, end.depth_m, "depth")?;
        close(closed.peak_force_n, surface.law.force_n(end.depth_m), "force")?;
        close(closed.indentation_time_s, end.time_s, "time")?;
    }

    /// The rebound as it is drawn: its time, its speed at the end, what remains where the force vanishes, and on all
    /// of the way out the energy of `M h'' = -c_re (h - h_rem)^n`.
    #[test]
    fn the_rebound_solves_its_equation_of_motion(
        n in 0.2..2.0f64, ratio in 1.0..30.0f64, mass in decades(-2.0, 3.0), speed in decades(-3.0, 0.5)
    ) {
        let (surface, striker) = (surface(16e6, n, ratio), Striker::new(mass, speed).unwrap());
        let closed = surface.struck_by(&striker);
        let points = impact(&surface, &striker);
        let end = points[points.len() - 1];
        close(end.time_s, closed.characteristic_time_s(), "time")?;
        close(-end.speed_m_per_s / speed, closed.restitution, "restitution")?;
        prop_assert!((end.depth_m - closed.remaining_depth_m).abs() < 1e-9 * closed.maximum_depth_m);
        let turn = points.iter().position(|point| point.speed_m_per_s <= 0.0).unwrap();
        for point in &points[turn..] {
            let above = (point.depth_m - closed.remaining_depth_m).max(0.0);
            let elastic = ratio * 16e6 * libm::pow(above, n + 1.0) / (n + 1.0);
            let kinetic = 0.5 * mass * point.speed_m_per_s * point.speed_m_per_s;
            let returned = striker.energy_j() - closed.lost_energy_j;
            prop_assert!((elastic + kinetic - returned).abs() < 1e-8 * striker.energy_j(), "{point:?}");
        }
    }

    /// The speed that is allowed is the one at which the limit is reached.
    #[test]
    fn the_inverse_questions_are_inverse(
        n in 0.1..2.0f64, ratio in 1.01..30.0f64, mass in decades(-2.0, 3.0), speed in decades(-3.0, 0.5)
    ) {
        let surface = surface(16e6, n, ratio);
        let closed = surface.struck_by(&Striker::new(mass, speed).unwrap());
        let for_force = surface.speed_for_force_m_per_s(mass, closed.peak_force_n);
        prop_assert!((for_force.unwrap() / speed - 1.0).abs() < 1e-10);
        if closed.remaining_depth_m > 1e-12 {
            let for_mark = surface.speed_for_remaining_depth_m_per_s(mass, closed.remaining_depth_m);
            prop_assert!((for_mark.unwrap() / speed - 1.0).abs() < 1e-10);
        }
    }

    /// n = 1 is (15)-(18), whatever the rest.
    #[test]
    fn the_general_form_contains_the_papers_example(
        radius in decades(-4.0, 0.0), modulus in decades(6.0, 11.5), mass in decades(-2.0, 3.0),
        speed in decades(-3.0, 0.5), share in 0.0..1.0f64
    ) {
        let (punch, striker) = (FlatPunch::new(radius, modulus).unwrap(), Striker::new(mass, speed).unwrap());
        let general = Surface { law: punch.law().unwrap(), rebound: Rebound::ELASTIC }.struck_by(&striker);
        close(general.maximum_depth_m, punch.maximum_depth_m(&striker), "(16)")?;
        close(general.peak_force_n, punch.peak_force_n(&striker), "(17)")?;
        close(general.characteristic_time_s(), punch.characteristic_time_s(mass), "(18)")?;
        let near = |at: f64, point: &Point| (point.time_s - at).abs();
        let at = share * general.indentation_time_s;
        let mut best = None::<Point>;
        indentation(&punch.law().unwrap(), &striker, |point| {
            if best.is_none_or(|known| near(at, &point) < near(at, &known)) {
                best = Some(point);
            }
        });
        let best = best.unwrap();
        let sine = punch.depth_m(&striker, best.time_s);
        prop_assert!((best.depth_m - sine).abs() < 1e-9 * general.maximum_depth_m, "(15)");
    }

    /// Momentum and energy balance: what goes in comes out or stays.
    #[test]
    fn momentum_and_energy_are_accounted_for(n in 0.2..2.0f64, ratio in 1.0..30.0f64, speed in decades(-3.0, 0.5)) {
        let (surface, striker) = (surface(16e6, n, ratio), Striker::new(2.0, speed).unwrap());
        let closed = surface.struck_by(&striker);
        let points = impact(&surface, &striker);
        let force = |point: &Point, loading: bool| if loading {
            surface.law.force_n(point.depth_m)
        } else {
            ratio * 16e6 * libm::pow((point.depth_m - closed.remaining_depth_m).max(0.0), n)
        };
        let (mut impulse, mut work) = (0.0, 0.0);
        for pair in points.windows(2) {
            let loading = pair[1].speed_m_per_s >= 0.0;
            let mean = 0.5 * (force(&pair[0], loading) + force(&pair[1], loading));
            impulse += mean * (pair[1].time_s - pair[0].time_s);
            work += mean * (pair[1].depth_m - pair[0].depth_m);
        }
        prop_assert!((impulse / closed.impulse_ns - 1.0).abs() < 1e-4, "{impulse} {}", closed.impulse_ns);
        prop_assert!((work - closed.lost_energy_j).abs() < 1e-4 * striker.energy_j(), "{work}");
    }
}

/// K. L. Johnson, Contact Mechanics (1985), eq. (11.24): a Hertzian impact lasts 2.94 times the maximum compression
/// over the speed. For n = 2 the integral is Gamma(1/3) sqrt(pi) / (3 Gamma(5/6)) = 1.402182; towards n = 0, a
/// constant force, it is 2.
#[test]
fn the_time_factor_is_the_published_one() {
    assert_eq!(time_factor(1.0), std::f64::consts::FRAC_PI_2);
    assert!((2.0 * time_factor(1.5) - 2.94).abs() < 0.005);
    assert!((time_factor(2.0) - 1.402_182).abs() < 5e-7);
    assert!((time_factor(1e-6) - 2.0).abs() < 2e-6);
    // Next to n = 1 the Gamma function says what the closed form does.
    assert!((time_factor(1.0 + 1e-9) - time_factor(1.0)).abs() < 1e-8);
}

/// PLANT.md section 5: 107.264 N with the effective mass, 160 N with the whole tool; duration and restitution with
/// `c_re = 4 c_in`.
#[test]
fn the_reference_impact() {
    let tool = ToolInertia::new(4.0, [0.012, 0.016, 0.010], [0.03, 0.0, -0.06]).unwrap();
    let mass = tool.at_tcp_kg([0.10, 0.0, -0.15].into(), nalgebra::Vector3::z());
    let impact = surface(16e6, 1.0, 4.0).struck_by(&Striker::new(mass, 0.02).unwrap());
    assert!((impact.peak_force_n - 107.264).abs() < 0.001, "{impact:?}");
    assert_eq!(
        (impact.restitution, impact.remaining_depth_m),
        (0.5, 0.75 * impact.maximum_depth_m)
    );
    assert!((impact.characteristic_time_s() / impact.indentation_time_s - 1.5).abs() < 1e-15);
}

#[test]
fn what_leaves_no_mark_has_no_speed_for_one() {
    let elastic = surface(16e6, 1.0, 1.0);
    assert_eq!(
        elastic.speed_for_remaining_depth_m_per_s(2.0, 1e-6),
        Err(ImpactError::NothingRemains)
    );
    assert!(matches!(
        elastic.speed_for_force_m_per_s(2.0, -1.0),
        Err(ImpactError::OutOfRange { .. })
    ));
    assert!(matches!(
        surface(1e15, 1e-6, 1.0).speed_for_force_m_per_s(2.0, 1.0),
        Err(ImpactError::Unrepresentable(_))
    ));
}
