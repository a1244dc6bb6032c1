//! The task once the tare is known: approach, contact, and the way from heights to axes.

use crate::Settings;
use crate::approach::{Approach, PathPoint, spread};
use crate::command_dynamics::CommandDynamics;
use crate::contact::{Aim, ContactSample};
use crate::detection::Detector;
use crate::law::NormalLaw;
use crate::posture::Posture;
use crate::transform::compliance_along;
use nalgebra::Vector3;
use spatial::kinematics::{Axes, Unreachable};
use spatial::ports::{DeflectionSample, HORIZON};
use spatial::{Deflection, Pose, TICK_S, TICK_US};

/// Everything that exists only once the tare is known.
#[derive(Clone, Debug)]
pub(crate) struct Motion {
    posture: Posture,
    /// Compliance of the tcp along the contact's normal, m/N.
    compliance_m_per_n: f64,
    /// Height of the hanging tcp at the start, m.
    start_height_m: f64,
    path: Approach,
    /// Tick at which the approach began.
    start_tick: Option<i64>,
    dynamics: CommandDynamics,
    detector: Detector,
    law: NormalLaw,
    contact: Option<Contact>,
    newest: ContactSample,
    deflection: Deflection,
    saturated: bool,
    /// Axes at the instant of the newest sample.
    axes: Axes,
    settled_cycles: i64,
}

#[derive(Clone, Copy, Debug)]
struct Contact {
    /// Tick of the sample that detected it.
    sample_tick: i64,
    /// Tick of the cycle that learned of it.
    cycle_tick: i64,
}

impl Motion {
    /// At rest at the axes `start`, with the deflection `tare` there.
    pub(crate) fn new(settings: &Settings, tare: &Deflection, start: &Axes) -> Self {
        let r_from_s = settings.kinematics.forward(start);
        let posture = Posture::new(
            &settings.compliance,
            settings.d,
            *tare,
            &r_from_s,
            &settings.desired,
        );
        let start_height_m = posture.hanging_tcp(&r_from_s).translation.vector.z;
        let (controller, task) = (&settings.controller, &settings.task);
        let length = start_height_m - (task.expected_height_m - task.search_depth_m);
        let compliance_m_per_n = compliance_along(&settings.compliance, posture.lever(), Vector3::z());
        let aim = Aim {
            desired_force_n: task.desired_force_n,
            compliance_m_per_n,
        };
        Self {
            posture,
            compliance_m_per_n,
            start_height_m,
            path: Approach::new(length, task.approach_speed_m_per_s),
            start_tick: None,
            dynamics: CommandDynamics::new(
                controller.filter_frequency_hz,
                controller.filter_damping,
                controller.acceleration_limit_rad_per_s2[2],
                settings.period_ticks,
                start_height_m,
            ),
            detector: Detector::new(
                controller.detection_threshold_n,
                controller.apparent_mass_kg,
                controller.detection_fading_s,
            ),
            law: NormalLaw::new(controller, aim),
            contact: None,
            newest: ContactSample::default(),
            deflection: *tare,
            saturated: false,
            axes: *start,
            settled_cycles: 0,
        }
    }

    /// Take one sample: the `deflection` that it stands for, at `axes`.
    pub(crate) fn take(
        &mut self,
        settings: &Settings,
        sample: &DeflectionSample,
        deflection: &Deflection,
        axes: &Axes,
        approaching: bool,
        tick: i64,
    ) {
        self.axes = *axes;
        self.deflection = *deflection;
        self.saturated = sample.flags.saturated;
        let r_from_s = settings.kinematics.forward(axes);
        let object_m = self
            .posture
            .deflected_tcp(&r_from_s, deflection)
            .translation
            .vector
            .z;
        let actual_m = self.posture.hanging_tcp(&r_from_s).translation.vector.z;
        let force_n = (object_m - actual_m) / self.compliance_m_per_n;
        self.newest = ContactSample {
            object_m,
            actual_m,
            force_n,
        };
        if approaching && self.contact.is_none() && force_n > self.detector.threshold_n() {
            self.contact = Some(Contact {
                sample_tick: sample.utime / TICK_US,
                cycle_tick: tick,
            });
        }
        if self.contact.is_some() {
            self.law.take(&self.newest);
        }
    }

    /// How long the approach has lasted at `tick`, which begins with the first question, s.
    pub(crate) fn approached_for(&mut self, tick: i64) -> f64 {
        (tick - *self.start_tick.get_or_insert(tick)) as f64 * TICK_S
    }

    /// How long the approach lasts at most, s.
    pub(crate) fn approach_duration(&self) -> f64 {
        self.path.duration()
    }

    /// Count this cycle as one with the force `inside` its band; how many there were in a row.
    pub(crate) fn count_settled(&mut self, inside: bool) -> i64 {
        self.settled_cycles = if inside { self.settled_cycles + 1 } else { 0 };
        self.settled_cycles
    }

    /// The next set-points of the axes, one period apart, each on the branch of its predecessor (the first one
    /// `near` the set-point before), and whether the bound of command minus actual binds.
    pub(crate) fn set_points(
        &mut self,
        settings: &Settings,
        tick: i64,
        actual: &Axes,
        near: &Axes,
    ) -> Result<([Axes; HORIZON], bool), Unreachable> {
        let kinematics = &settings.kinematics;
        let actual_m = self
            .posture
            .hanging_tcp(&kinematics.forward(actual))
            .translation
            .vector
            .z;
        let bound = settings.controller.max_lead_m;
        // The first set-point is reached n_d + 1 periods from now.
        let reached = |i: usize| tick + (settings.lead() + i as i64) * settings.period_ticks;
        let wanted = match self.contact {
            Some(_) => self.law.set_points(&self.dynamics),
            None => std::array::from_fn(|i| self.approach_height(settings, reached(i))),
        };
        let heights = wanted.map(|height| height.clamp(actual_m - bound, actual_m + bound));
        self.dynamics.advance(heights[0]);
        self.detector.follow(
            self.path_point(settings, reached(0)).acceleration,
            settings.period_ticks,
        );
        let mut axes = [*near; HORIZON];
        let mut near = *near;
        for (i, slot) in axes.iter_mut().enumerate() {
            let tilt = self.tilt(settings, reached(i));
            near = kinematics.inverse(&self.posture.sensor_pose(heights[i], tilt), &near)?;
            *slot = near;
        }
        Ok((axes, heights[0] != wanted[0]))
    }

    /// The set-point of the approach that is reached at `tick`; with the feed-forward the robot is on the path
    /// then, without it, it lags behind.
    fn approach_height(&self, settings: &Settings, tick: i64) -> f64 {
        let point = self.path_point(settings, tick);
        if self.law.feeds_forward() {
            self.start_height_m
                - self
                    .dynamics
                    .inverse(point.distance, point.speed, point.acceleration)
        } else {
            self.start_height_m - point.distance
        }
    }

    /// The point of the approach whose set-point is reached at `tick`.
    fn path_point(&self, settings: &Settings, tick: i64) -> PathPoint {
        match (self.start_tick, self.contact) {
            (Some(start), None) => self.path.at(since(settings, start, tick)),
            _ => PathPoint::default(),
        }
    }

    /// The share of the posture that is taken at `tick`, spread over the tilt time from the contact on.
    fn tilt(&self, settings: &Settings, tick: i64) -> f64 {
        let Some(contact) = self.contact else {
            return 0.0;
        };
        let share = spread(
            since(settings, contact.cycle_tick, tick),
            settings.controller.tilt_time_s,
        );
        self.dynamics
            .inverse(share.distance, share.speed, share.acceleration)
    }
}

/// Time (s) at `tick` since the first set-point of the cycle at `start` is reached.
fn since(settings: &Settings, start: i64, tick: i64) -> f64 {
    (tick - start - settings.lead() * settings.period_ticks) as f64 * TICK_S
}

/// What the status tells.
impl Motion {
    /// `r_from_ta1`: the deflected tcp at the newest sample.
    pub(crate) fn tcp_pose(&self, settings: &Settings) -> Pose {
        self.posture
            .deflected_tcp(&settings.kinematics.forward(&self.axes), &self.deflection)
    }

    pub(crate) fn deflection(&self) -> &Deflection {
        &self.deflection
    }

    /// Contact force along the normal at the newest sample, N.
    pub(crate) fn force_n(&self) -> f64 {
        self.newest.force_n
    }

    pub(crate) fn threshold_n(&self) -> f64 {
        self.detector.threshold_n()
    }

    pub(crate) fn saturated(&self) -> bool {
        self.saturated
    }

    pub(crate) fn in_contact(&self) -> bool {
        self.contact.is_some()
    }

    /// Tick of the sample that detected the contact.
    pub(crate) fn contact_tick(&self) -> Option<i64> {
        self.contact.map(|contact| contact.sample_tick)
    }

    pub(crate) fn object_height_m(&self) -> Option<f64> {
        self.law.object_height_m()
    }
}
