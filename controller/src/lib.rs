//! The outer loop of the paper's Fig. 2: from encoder and sensor values to the commanded pose.
//!
//! Pure: a [`Controller`] takes the robot's state and the sensor's samples of a cycle and answers with a command
//! and its status. It sees only what a real one would. The only home of eqs. (1)-(12); each file is one idea:
//!
//! | Idea | File | Paper |
//! |---|---|---|
//! | actual pose and deflection at the same instant | [`pairing`] | below (2) |
//! | contact or not | [`detection`] | V |
//! | between sensor and tcp | [`transform`] | (3)-(12) |
//! | standard law | [`pd`] | (1) |
//! | object measured once, then refined | [`object_model`] | (2), (12) |
//! | feed-forward of the position control | [`command_dynamics`] | Fig. 2, II-B |
//! | posture that keeps the tool's orientation | [`posture`] | (9)-(11), Fig. 5 |

pub mod approach;
pub mod command_dynamics;
pub mod detection;
pub mod object_model;
pub mod pairing;
pub mod pd;
pub mod posture;
pub mod tare;
pub mod transform;

mod status;

use approach::{Approach, PathPoint, spread};
use command_dynamics::CommandDynamics;
use detection::Detector;
use nalgebra::Vector3;
use node::scenario::{self, Scenario};
use object_model::ObjectModel;
use pairing::EncoderHistory;
use pd::Pd;
use posture::Posture;
use spatial::kinematics::{Axes, Kinematics, Unreachable};
use spatial::ports::{
    Command, ControllerPhase, ControllerStatus, DeflectionSample, Deflections, Fault, HORIZON, Law,
    RobotState,
};
use spatial::{Compliance, TICK_S, Wrench};
use std::f64::consts::TAU;
use tare::Tare;

/// What one cycle brings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outputs {
    /// For the robot.
    pub command: Command,
    /// For people.
    pub status: ControllerStatus,
}

/// The control scheme, one cycle of T after the other.
#[derive(Clone, Debug)]
pub struct Controller {
    settings: Settings,
    phase: ControllerPhase,
    fault: Fault,
    encoders: EncoderHistory,
    newest_sample_utime: i64,
    tare: Tare,
    start: Axes,
    /// The set-point that the axes are to reach next.
    commanded: Axes,
    motion: Option<Motion>,
    limits: i32,
}

/// What the scenario says, in the controller's terms.
#[derive(Clone, Debug)]
struct Settings {
    seed: i64,
    period_ticks: i64,
    task: scenario::Task,
    controller: scenario::Controller,
    kinematics: Kinematics,
    compliance: Compliance,
    d: Vector3<f64>,
    desired: Wrench,
}

/// Everything that exists only once the tare is known.
#[derive(Clone, Debug)]
struct Motion {
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
    object: ObjectModel,
    pd: Option<Pd>,
    /// Contact force along the normal from the newest sample, N.
    force_n: f64,
    contact: Option<Contact>,
    newest: DeflectionSample,
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

/// How long the force must stay in its band before the contact counts as settled, s.
const SETTLED_S: f64 = 0.05;

impl Controller {
    /// The scenario's controller, knowing nothing yet.
    pub fn new(scenario: &Scenario) -> Self {
        let controller = &scenario.controller;
        Self {
            settings: Settings {
                seed: scenario.timing.seed,
                period_ticks: scenario.timing.command_period_ticks,
                task: scenario.task.clone(),
                controller: controller.clone(),
                kinematics: scenario.robot.kinematics(),
                compliance: Compliance::isotropic(
                    controller.compliance_m_per_n,
                    controller.compliance_rad_per_nm,
                ),
                d: controller.tcp_in_s_m.into(),
                desired: Wrench {
                    force: Vector3::new(0.0, 0.0, scenario.task.desired_force_n),
                    moment: Vector3::zeros(),
                },
            },
            phase: ControllerPhase::Init,
            fault: Fault::None,
            encoders: EncoderHistory::default(),
            newest_sample_utime: i64::MIN,
            tare: Tare::default(),
            start: Axes::zeros(),
            commanded: Axes::zeros(),
            motion: None,
            limits: 0,
        }
    }

    /// One cycle at the tick of `state`: the command that answers it, and the status.
    ///
    /// Both messages have been checked by whoever received them.
    pub fn cycle(&mut self, state: &RobotState, deflections: &Deflections) -> Outputs {
        let tick = state.stamp.step;
        self.encoders.update(state);
        if self.phase == ControllerPhase::Init {
            self.start = state.axis_position[0];
            self.commanded = self.start;
            self.phase = ControllerPhase::Sync;
        }
        for sample in deflections.samples.iter().rev() {
            if sample.flags.valid && sample.utime > self.newest_sample_utime {
                self.newest_sample_utime = sample.utime;
                self.take(sample, tick);
            }
        }
        self.change_phase(tick);
        let axis_position = match self.set_points(tick, &state.axis_position[0]) {
            Ok(set_points) => set_points,
            Err(_) => self.hold(Fault::Unreachable),
        };
        self.commanded = axis_position[0];
        Outputs {
            command: self.command(tick, axis_position),
            status: self.status(tick),
        }
    }

    /// One sample of the sensor, paired with the axes at its instant.
    fn take(&mut self, sample: &DeflectionSample, tick: i64) {
        let settings = &self.settings;
        let Some(motion) = &mut self.motion else {
            self.tare.add(&sample.deflection);
            return;
        };
        // The low pass shows the deflection of 1 / (2 pi f) ago.
        let lag_us = 1e6 / (TAU * settings.controller.sensor_bandwidth_hz);
        motion.axes = self.encoders.at(sample.utime as f64 - lag_us);
        motion.newest = *sample;
        let r_from_s = settings.kinematics.forward(&motion.axes);
        let real = motion
            .posture
            .deflected_tcp(&r_from_s, &sample.deflection)
            .translation
            .vector
            .z;
        let hanging = motion.posture.hanging_tcp(&r_from_s).translation.vector.z;
        motion.force_n = (real - hanging) / motion.compliance_m_per_n;
        if self.phase == ControllerPhase::Approach
            && motion.contact.is_none()
            && motion.force_n > motion.detector.threshold_n()
        {
            motion.contact = Some(Contact {
                sample_tick: sample.utime / spatial::TICK_US,
                cycle_tick: tick,
            });
        }
        if motion.contact.is_some() {
            motion.object.update(real);
        }
    }

    fn change_phase(&mut self, tick: i64) {
        let settings = &self.settings;
        let time = tick as f64 * TICK_S;
        match self.phase {
            ControllerPhase::Sync if time >= settings.controller.tare_s && self.tare.count() > 0 => {
                self.motion = Some(Motion::new(settings, &self.tare, &self.start));
                self.phase = ControllerPhase::Ready;
            }
            ControllerPhase::Ready if time >= settings.task.standstill_s => {
                self.phase = ControllerPhase::Approach;
            }
            _ => {}
        }
        let Some(motion) = &mut self.motion else { return };
        match self.phase {
            ControllerPhase::Approach => {
                let start = *motion.start_tick.get_or_insert(tick);
                if motion.contact.is_some() {
                    self.phase = ControllerPhase::Contact;
                    motion.pd = Some(Pd::new(
                        &settings.controller.pd,
                        motion.dynamics.setpoint(),
                        motion.force_n,
                    ));
                } else if (tick - start) as f64 * TICK_S > motion.path.duration() {
                    self.phase = ControllerPhase::Fault;
                    self.fault = Fault::NoContact;
                }
            }
            ControllerPhase::Contact | ControllerPhase::Settled => {
                let error = motion.force_n - settings.task.desired_force_n;
                let inside = libm::fabs(error) <= settings.controller.settled_band_n;
                motion.settled_cycles = if inside { motion.settled_cycles + 1 } else { 0 };
                let needed = SETTLED_S / (settings.period_ticks as f64 * TICK_S);
                if motion.settled_cycles as f64 >= needed {
                    self.phase = ControllerPhase::Settled;
                } else if !inside {
                    self.phase = ControllerPhase::Contact;
                }
            }
            _ => {}
        }
    }

    /// Stay at the set-point last given; the first cause is latched.
    fn hold(&mut self, fault: Fault) -> [Axes; HORIZON] {
        self.phase = ControllerPhase::Fault;
        if self.fault == Fault::None {
            self.fault = fault;
        }
        [self.commanded; HORIZON]
    }

    /// The next set-points of the axes, one period apart, each on the branch of its predecessor.
    fn set_points(&mut self, tick: i64, actual: &Axes) -> Result<[Axes; HORIZON], Unreachable> {
        let settings = &self.settings;
        self.limits = 0;
        let Some(motion) = &mut self.motion else {
            return Ok([self.start; HORIZON]);
        };
        if self.fault == Fault::Unreachable {
            return Ok([self.commanded; HORIZON]);
        }
        let proposed = settings.controller.law == Law::Proposed;
        let actual_height = motion
            .posture
            .hanging_tcp(&settings.kinematics.forward(actual))
            .translation
            .vector
            .z;
        // The first set-point takes effect n_d + 1 periods from now.
        let lead = settings.controller.command_delay_periods + 1;
        let mut pd_setpoint = motion
            .pd
            .as_mut()
            .map(|pd| pd.setpoint(motion.force_n, settings.task.desired_force_n));
        let mut ahead = motion.dynamics;
        let mut committed = motion.dynamics;
        let bandwidth = TAU * settings.controller.proposed.reference_bandwidth_hz;
        let target = motion
            .object
            .desired_height(motion.compliance_m_per_n, settings.task.desired_force_n);
        let mut near = self.commanded;
        let mut axes = [near; HORIZON];
        for (i, slot) in axes.iter_mut().enumerate() {
            let at_tick = tick + (lead + i as i64) * settings.period_ticks;
            let wanted = match (motion.contact, proposed) {
                (Some(_), true) => ahead.towards(target.unwrap_or(ahead.setpoint()), bandwidth),
                (Some(_), false) => *pd_setpoint.get_or_insert(ahead.setpoint()),
                (None, feed_forward) => motion.approach_height(settings, at_tick, lead, feed_forward),
            };
            let bound = settings.controller.max_lead_m;
            let height = wanted.clamp(actual_height - bound, actual_height + bound);
            if height != wanted && i == 0 {
                self.limits |= status::LIMIT_LEAD;
            }
            ahead.advance(height);
            if i == 0 {
                committed = ahead;
            }
            let pose = motion
                .posture
                .sensor_pose(height, motion.tilt(settings, at_tick, lead));
            near = settings.kinematics.inverse(&pose, &near)?;
            *slot = near;
        }
        motion.dynamics = committed;
        motion.detector.follow(
            motion
                .path_point(settings, tick + lead * settings.period_ticks, lead)
                .acceleration,
            settings.period_ticks,
        );
        Ok(axes)
    }
}

impl Motion {
    fn new(settings: &Settings, tare: &Tare, start: &Axes) -> Self {
        let r_from_s = settings.kinematics.forward(start);
        let posture = Posture::new(
            &settings.compliance,
            settings.d,
            tare.mean(),
            &r_from_s,
            &settings.desired,
        );
        let start_height_m = posture.hanging_tcp(&r_from_s).translation.vector.z;
        let controller = &settings.controller;
        let task = &settings.task;
        let length = start_height_m - (task.expected_height_m - task.search_depth_m);
        Self {
            posture,
            compliance_m_per_n: transform::compliance_along(
                &settings.compliance,
                posture.lever(),
                Vector3::z(),
            ),
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
            detector: Detector::new(controller.detection_threshold_n, controller.apparent_mass_kg),
            object: ObjectModel::new(&controller.proposed),
            pd: None,
            force_n: 0.0,
            contact: None,
            newest: DeflectionSample::default(),
            axes: *start,
            settled_cycles: 0,
        }
    }

    /// The set-point of the approach that takes effect at `tick`; with the feed-forward, the robot is on the
    /// path then, without it, it lags behind.
    fn approach_height(&self, settings: &Settings, tick: i64, lead: i64, feed_forward: bool) -> f64 {
        let point = self.path_point(settings, tick, lead);
        if feed_forward {
            self.start_height_m
                - self
                    .dynamics
                    .inverse(point.distance, point.speed, point.acceleration)
        } else {
            self.start_height_m - point.distance
        }
    }

    /// The point of the approach whose set-point takes effect at `tick`.
    fn path_point(&self, settings: &Settings, tick: i64, lead: i64) -> PathPoint {
        match (self.start_tick, self.contact) {
            (Some(start), None) => self
                .path
                .at((tick - start - lead * settings.period_ticks) as f64 * TICK_S),
            _ => PathPoint::default(),
        }
    }

    /// The share of the posture that is taken at `tick`, spread over the tilt time from the contact on.
    fn tilt(&self, settings: &Settings, tick: i64, lead: i64) -> f64 {
        let Some(contact) = self.contact else {
            return 0.0;
        };
        let time = (tick - contact.cycle_tick - lead * settings.period_ticks) as f64 * TICK_S;
        let share = spread(time, settings.controller.tilt_time_s);
        self.dynamics
            .inverse(share.distance, share.speed, share.acceleration)
    }
}

#[cfg(test)]
mod tests;
