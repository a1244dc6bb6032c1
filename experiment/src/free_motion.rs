//! Free motion from rest to rest, without an object: how far the tool swings afterwards, and how far it is off its path
//! meanwhile (PLANT.md section 7).

use crate::in_process;
use controller::approach::Approach;
use controller::shaping::Shape;
use controller::shaping::swing::Swing;
use nalgebra::Vector3;
use node::scenario::{Profile, Scenario, TaskKind};
use serde::Serialize;
use spatial::TICK_S;
use spatial::kinematics::Unreachable;
use spatial::ports::{ControllerPhase, Fault};
use std::fmt::{Display, Formatter};

/// A way to go.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Way {
    /// Downwards, m.
    pub length_m: f64,
    /// m/s.
    pub speed_m_per_s: f64,
}

/// How long it is watched after its end, s.
const WATCHED_S: f64 = 2.0;
/// The end of that, in which the tool counts as at rest, s.
const REST_S: f64 = 0.2;

/// What a free motion leaves. Positions of the deflected tcp, truth.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FreeMotion {
    /// How the speed changes: `smooth`, ...
    pub profile: String,
    /// Assumed frequencies of tool and gears as a multiple of the real ones.
    pub assumed_over_real: f64,
    /// From the first to the last set-point, s.
    pub duration_s: f64,
    /// What it takes more than a trapezoid of speed, s.
    pub extra_s: f64,
    /// Largest deviation of the tcp's deflection on the sensor from that at rest, after the motion, m.
    pub swing_m: f64,
    /// Largest deviation of the tcp from where it comes to rest, after the motion, m: gears and servos included.
    pub residual_m: f64,
    /// Largest deviation of the tcp from its path during the motion, m.
    pub off_path_m: f64,
}

/// Why there are no figures.
#[derive(Debug, thiserror::Error)]
pub enum FreeMotionError {
    /// The start can't be reached.
    #[error("the start of the way can't be reached: {0}; choose another task.start_position_m")]
    Start(#[from] Unreachable),
    /// A fault was latched.
    #[error("the free motion ends with the fault {fault:?} at {time_s} s; move less far, or more slowly")]
    Fault {
        /// Robot's or controller's.
        fault: Fault,
        /// s.
        time_s: f64,
    },
    /// The controller never began or ended it.
    #[error("the free motion does not end within {duration_s} s; move less far, or faster")]
    Endless {
        /// Length of the run, s.
        duration_s: f64,
    },
}

/// Along `way` as `profile` has it, by a controller that assumes `assumed_over_real` times the frequencies of tool and
/// gears that `scenario` says it assumes.
pub fn measure(
    scenario: &Scenario,
    way: Way,
    profile: Profile,
    assumed_over_real: f64,
) -> Result<FreeMotion, FreeMotionError> {
    let mut scenario = freed(scenario, way);
    assume(&mut scenario, assumed_over_real);
    scenario.controller.shaping.profile = profile;
    let duration_of = |shape| Approach::new(shape, way.length_m, way.speed_m_per_s).duration();
    let shaping = &scenario.controller.shaping;
    let swing = Swing::new(
        &scenario.controller,
        &scenario.robot.kinematics(),
        &scenario.start_axes()?,
    );
    let shape = Shape::new(shaping, &swing);
    let path = Approach::new(shape, way.length_m, way.speed_m_per_s);
    let trapezoid_s = duration_of(Shape::trapezoid(shaping.acceleration_m_per_s2));
    scenario.timing.duration_s = scenario.task.standstill_s + path.duration() + WATCHED_S + 0.1;
    let seen = Seen::of(&scenario)?;
    let end = seen.start_tick + libm::ceil(path.duration() / TICK_S) as usize;
    let swings = seen.after(end, |sample| sample.deflection);
    let residual_m = seen.after(end, |sample| sample.position);
    let from = seen.tcp[seen.start_tick].position;
    let off_path_m = (seen.start_tick..end.min(seen.tcp.len()))
        .map(|tick| {
            let distance = path.at((tick - seen.start_tick) as f64 * TICK_S).distance;
            (seen.tcp[tick].position - from + Vector3::z() * distance).norm()
        })
        .fold(0.0, f64::max);
    Ok(FreeMotion {
        profile: format!("{profile:?}").to_lowercase(),
        assumed_over_real,
        duration_s: path.duration(),
        extra_s: path.duration() - trapezoid_s,
        swing_m: swings,
        residual_m,
        off_path_m,
    })
}

/// `scenario` with nothing in the way, going along `way` and no further.
fn freed(scenario: &Scenario, way: Way) -> Scenario {
    let mut scenario = scenario.clone();
    // The way ends that far below the tcp, which hangs.
    let hanging = scenario.hanging_tcp_height_m();
    scenario.object = node::scenario::Object {
        height_m: -10.0,
        ..Default::default()
    };
    scenario.object_sensor.enabled = false;
    let (task, controller) = (&mut scenario.task, &mut scenario.controller);
    task.kind = TaskKind::Position;
    task.search_depth_m = 0.0;
    task.max_impact_force_n = 0.0;
    task.tolerance_m = f64::INFINITY;
    task.approach_speed_m_per_s = way.speed_m_per_s;
    task.expected_height_m = hanging - way.length_m;
    controller.expected.from = node::scenario::ExpectedFrom::Nothing;
    controller.detection_threshold_n = f64::INFINITY;
    controller.max_lead_m = f64::INFINITY;
    scenario
}

/// Multiply the frequencies that the controller assumes of tool and gears by `ratio`.
fn assume(scenario: &mut Scenario, ratio: f64) {
    let controller = &mut scenario.controller;
    controller.compliance_m_per_n /= ratio * ratio;
    controller.compliance_rad_per_nm /= ratio * ratio;
    for frequency in &mut controller.gears.frequency_hz {
        *frequency *= ratio;
    }
}

/// The tcp at a tick, in r and in the nominal tcp frame, m.
#[derive(Clone, Copy)]
struct Sample {
    position: Vector3<f64>,
    deflection: Vector3<f64>,
}

/// What was seen of a run.
struct Seen {
    tcp: Vec<Sample>,
    /// When the robot is at the start of its way.
    start_tick: usize,
}

impl Seen {
    fn of(scenario: &Scenario) -> Result<Self, FreeMotionError> {
        let (mut tcp, mut begun, mut fault) = (Vec::new(), None, None);
        in_process::run(scenario, |tick| {
            let truth = &tick.sensor.truth;
            tcp.push(Sample {
                position: truth.tcp_pose.translation.vector,
                deflection: truth.tcp_deflection.translation,
            });
            let robot = tick.robot_state.map_or(Fault::None, |state| state.fault);
            let Some(answer) = &tick.controller else { return };
            let (status, time_s) = (&answer.status, truth.stamp.step as f64 * TICK_S);
            for found in [robot, status.fault] {
                if found != Fault::None {
                    fault.get_or_insert((found, time_s));
                }
            }
            if status.phase == ControllerPhase::Approach {
                begun.get_or_insert(truth.stamp.step);
            }
        });
        if let Some((fault, time_s)) = fault {
            return Err(FreeMotionError::Fault { fault, time_s });
        }
        // The first set-point of the approach's first cycle is reached a lead later.
        let lead = (scenario.controller.command_delay_periods + 1) * scenario.timing.command_period_ticks;
        let start = begun.and_then(|tick| usize::try_from(tick + lead).ok());
        match start.filter(|&start| start < tcp.len()) {
            Some(start_tick) => Ok(Self { tcp, start_tick }),
            None => Err(FreeMotionError::Endless {
                duration_s: scenario.timing.duration_s,
            }),
        }
    }

    /// The largest deviation of `what` from its mean at rest, from the tick `end` on, m.
    fn after(&self, end: usize, what: impl Fn(&Sample) -> Vector3<f64>) -> f64 {
        let resting = libm::rint(REST_S / TICK_S) as usize;
        let rest = &self.tcp[self.tcp.len().saturating_sub(resting)..];
        let mean = rest.iter().map(&what).sum::<Vector3<f64>>() / rest.len() as f64;
        let after = self.tcp.get(end..).unwrap_or_default();
        after
            .iter()
            .map(|sample| (what(sample) - mean).norm())
            .fold(0.0, f64::max)
    }
}

/// Free motions as text: a table with units in its header.
#[derive(Clone, Copy, Debug)]
pub struct Table<'a>(pub &'a [FreeMotion]);

impl Display for Table<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        writeln!(
            f,
            "profile    assumed/real  duration ms  extra ms  swing um  residual um  off path um"
        )?;
        for row in self.0 {
            writeln!(
                f,
                "{:9}  {:12.2}  {:11.0}  {:8.0}  {:8.2}  {:11.2}  {:11.1}",
                row.profile,
                row.assumed_over_real,
                1e3 * row.duration_s,
                1e3 * row.extra_s,
                1e6 * row.swing_m,
                1e6 * row.residual_m,
                1e6 * row.off_path_m,
            )?;
        }
        Ok(())
    }
}
