//! The numerical solution of (14): a check of the closed form, and the way to draw an impact.

use super::kick::KicksLaw;
use super::strike::{Striker, Surface};

/// One instant of an impact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// Time since the first contact, s.
    pub time_s: f64,
    /// Indentation, m.
    pub depth_m: f64,
    /// Its rate, m/s.
    pub speed_m_per_s: f64,
}

/// The step over the time that has passed since the first contact.
const GROWTH: f64 = 1.0 / 256.0;
/// When the integration starts, in units of the impact's own time; before it, the force has changed nothing.
const START: f64 = 1e-13;
/// Steps after which an integration is given up; it takes about 8000.
const MOST_STEPS: usize = 100_000;

/// Paper (14): `M h'' + c_in h^n = 0` from `h = 0`, `h' = v_0` until the mass stands still, by the classical
/// Runge-Kutta method. `see` gets every point; the last one, at rest, is returned too.
///
/// For n below 1 the force has a vertical tangent at h = 0, and for any broken n its higher derivatives are infinite
/// there. So steps grow with the time passed: each is as small against the distance from h = 0 as any other. The
/// last step ends exactly at rest, since the speed takes the place of the time as the independent variable.
pub fn indentation(law: &KicksLaw, striker: &Striker, mut see: impl FnMut(Point)) -> Point {
    let (mass, speed) = (striker.mass_kg(), striker.speed_m_per_s());
    let rate = |_: f64, [h, v]: [f64; 2]| [v, -law.force_n(h) / mass];
    // The solution is of order 1 in these units, whatever n, c_in, M and v_0 are.
    let scale = law.depth_of_energy_m(2.0 * striker.energy_j()) / speed;
    let mut time = START * scale;
    let mut state = [speed * time, speed];
    see(Point {
        time_s: 0.0,
        depth_m: 0.0,
        speed_m_per_s: speed,
    });
    for _ in 0..MOST_STEPS {
        see(point(time, state));
        let step = GROWTH * time.min(scale);
        let next = runge_kutta(rate, time, state, step);
        if next[1] <= 0.0 {
            break;
        }
        time += step;
        state = next;
    }
    // dt/dv = 1 / v', dh/dv = v / v'.
    let by_speed = |v: f64, [_, h]: [f64; 2]| {
        let acceleration = -law.force_n(h) / mass;
        [1.0 / acceleration, v / acceleration]
    };
    let [time, depth] = runge_kutta(by_speed, state[1], [time, state[0]], -state[1]);
    let end = point(time, [depth, 0.0]);
    see(end);
    end
}

/// The whole impact of `striker` on `surface`, indentation and rebound, point by point.
///
/// The rebound, from rest at the maximum depth, is an indentation of the stiffer law c_re backwards in time, from
/// where the force vanishes.
pub fn impact(surface: &Surface, striker: &Striker) -> Vec<Point> {
    let mut points = Vec::new();
    let deepest = indentation(&surface.law, striker, |point| points.push(point));
    let n = surface.law.exponent();
    let remaining = deepest.depth_m * surface.rebound.remaining_share(n);
    let leaving = striker.speed_m_per_s() * surface.rebound.restitution(n);
    let Ok(outgoing) = Striker::new(striker.mass_kg(), leaving) else {
        // So slow that it stays where it is.
        return points;
    };
    let mut mirrored = Vec::new();
    let law = surface.law.stiffened(surface.rebound.ratio());
    let end = indentation(&law, &outgoing, |point| mirrored.push(point));
    points.extend(mirrored.into_iter().rev().skip(1).map(|point| Point {
        time_s: deepest.time_s + end.time_s - point.time_s,
        depth_m: remaining + point.depth_m,
        speed_m_per_s: -point.speed_m_per_s,
    }));
    points
}

fn point(time_s: f64, [depth_m, speed_m_per_s]: [f64; 2]) -> Point {
    Point {
        time_s,
        depth_m,
        speed_m_per_s,
    }
}

/// One step of the classical Runge-Kutta method of fourth order.
fn runge_kutta(rate: impl Fn(f64, [f64; 2]) -> [f64; 2], x: f64, y: [f64; 2], step: f64) -> [f64; 2] {
    let along = |k: [f64; 2], share: f64| [y[0] + k[0] * share * step, y[1] + k[1] * share * step];
    let k1 = rate(x, y);
    let k2 = rate(x + 0.5 * step, along(k1, 0.5));
    let k3 = rate(x + 0.5 * step, along(k2, 0.5));
    let k4 = rate(x + step, along(k3, 1.0));
    std::array::from_fn(|i| y[i] + step / 6.0 * (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]))
}
