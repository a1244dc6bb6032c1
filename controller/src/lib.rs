//! The outer loop of the paper's Fig. 2: from encoder and sensor values to the commanded pose.
//!
//! Pure: a [`Controller`] takes the robot's state and the sensors' samples of a cycle and answers with a command
//! and its status. It sees only what a real one would. The only home of eqs. (1)-(18); each file is one idea:
//!
//! | Idea | File | Paper |
//! |---|---|---|
//! | actual pose and deflection at the same instant | [`pairing`] | below (2) |
//! | object expected before the contact | [`expectation`], [`approach`] | II-B, IV-C, footnote 3 |
//! | free motion that leaves nothing swinging | [`shaping`], [`approach`] | VI |
//! | contact or not; collision | [`detection`], [`collision`] | V |
//! | limits of the command | [`limits`] | |
//! | commands that are lost | [`delivery`] | |
//! | between sensor and tcp | [`transform`] | (3)-(12) |
//! | force controlled or not, per degree of freedom | [`dofs`] | III |
//! | the laws behind one interface | [`law`] | |
//! | standard law | [`pd`] | (1) |
//! | task description, sample by sample | [`literal`] | (2) |
//! | object measured once, then refined and extrapolated | [`object_model`], [`fading_memory`] | (2), (12) |
//! | impedance as the task | [`impedance`] | II |
//! | the object behind elastic gears | [`elastic`] | VI |
//! | peers' laws, for comparison | [`ros2`], [`fzi`] | |
//! | feed-forward of the position control | [`command_dynamics`] | Fig. 2, II-B |
//! | desired force as a disturbance of the position control | [`disturbance`] | II-B |
//! | posture that keeps the tool's orientation | [`posture`] | (9)-(11), Fig. 5 |
//! | zero force, and whether it drifts | [`tare`], [`drift`] | |
//! | compliance adapted in contact | [`adaptation`] | V |
//! | tool and sensor learnt from tilted rests, and the way through them | [`calibration`], [`tilting`] | (3), (4) |
//! | assessment of the impact | [`impact`] | (13)-(18), footnote 9 |
//! | stability and margins of the loop by what is assumed | [`margins`] | |
//! | a contact force that swings up, and the gain lowered for it | [`oscillation`] | |
//! | whether a start can be answered for | `readiness` | |
//! | what is asked for at run time, when, and changed smoothly | [`agenda`], `requests`, `parameters` | |
//! | programs: steps, their order, how each begins and ends | `program`, `steps`, `motion/begin.rs` | |

pub mod adaptation;
pub mod agenda;
pub mod approach;
pub mod calibration;
pub mod collision;
pub mod command_dynamics;
pub mod contact;
pub mod delivery;
pub mod detection;
pub mod disturbance;
pub mod dofs;
pub mod drift;
pub mod elastic;
pub mod expectation;
pub mod fading_memory;
pub mod fzi;
pub mod impact;
pub mod impedance;
pub mod law;
pub mod limits;
pub mod literal;
pub mod margins;
pub mod object_model;
pub mod oscillation;
pub mod pairing;
pub mod pd;
pub mod posture;
pub mod ros2;
pub mod shaping;
pub mod structure;
pub mod tare;
pub mod tilting;
pub mod transform;

mod motion;
mod parameters;
mod program;
mod protection;
mod readiness;
mod requests;
mod sensing;
mod settings;
mod status;
mod steps;

use collision::CollisionWatch;
use delivery::Delivery;
use expectation::Expectation;
use limits::Limits;
use margins::Assessor;
use motion::{Motion, Sample};
use nalgebra::Vector3;
use node::scenario::{self, Pairing, Scenario};
use pairing::EncoderHistory;
use parameters::Parameters;
use program::Program;
use requests::Requests;
use sensing::Sensing;
use settings::Settings;
use spatial::kinematics::Axes;
use spatial::ports::{
    Command, ControllerPhase, ControllerStatus, DeflectionSample, Deflections, Fault, ObjectPose, RobotState,
};
use spatial::{TICK_S, TICK_US};
use std::f64::consts::TAU;
use tilting::Tilting;
use transform::deflection_at_tcp;

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
    /// The task as it is configured now; what the present step makes of it is in force.
    configured: scenario::Task,
    parameters: Parameters,
    program: Program,
    requests: Requests,
    phase: ControllerPhase,
    fault: Fault,
    encoders: EncoderHistory,
    newest_state_utime: i64,
    /// Tick at which that state came.
    state_tick: i64,
    newest_sample_utime: i64,
    /// Tick at which that sample came.
    heard_tick: i64,
    /// How old that sample was then, ticks.
    delay_ticks: i64,
    /// Tick since which the tare is taken.
    tare_since_tick: i64,
    /// The task has begun, or was kept from it: it does not begin by itself any more.
    started: bool,
    expectation: Expectation,
    sensing: Sensing,
    start: Axes,
    /// The set-point that the axes are to reach next.
    commanded: Axes,
    motion: Option<Motion>,
    /// The way of a calibration, until it is done.
    tilting: Option<Tilting>,
    collision: CollisionWatch,
    delivery: Delivery,
    /// The last stage before a command leaves.
    bounds: Limits,
    /// Bits of the limits that bind.
    limits: i32,
    assessor: Assessor,
}

impl Controller {
    /// The scenario's controller, knowing nothing yet.
    pub fn new(scenario: &Scenario) -> Self {
        let settings = Settings::new(scenario);
        Self {
            sensing: Sensing::new(&settings.controller, settings.compliance),
            configured: scenario.task.clone(),
            parameters: Parameters::new(scenario),
            program: Program::new(scenario),
            requests: Requests::default(),
            settings,
            phase: ControllerPhase::Init,
            fault: Fault::None,
            encoders: EncoderHistory::default(),
            newest_state_utime: i64::MIN,
            state_tick: 0,
            newest_sample_utime: i64::MIN,
            heard_tick: 0,
            delay_ticks: 0,
            tare_since_tick: 0,
            started: !scenario.task.starts_by_itself,
            expectation: Expectation::new(scenario),
            start: Axes::zeros(),
            commanded: Axes::zeros(),
            motion: None,
            tilting: None,
            collision: CollisionWatch::new(&scenario.controller),
            delivery: Delivery::new(scenario.timing.command_period_ticks),
            bounds: Limits::new(scenario, &Axes::zeros()),
            limits: 0,
            assessor: Assessor::new(scenario.controller.law),
        }
    }

    /// One cycle at the tick of `state`: the command that answers it, and the status. `object` is the non-contact
    /// sensor's pose of the object, where one is published at that tick.
    ///
    /// All messages have been checked by whoever received them.
    pub fn cycle(
        &mut self,
        state: &RobotState,
        deflections: &Deflections,
        object: Option<&ObjectPose>,
    ) -> Outputs {
        let tick = state.stamp.step;
        self.encoders.update(state);
        if state.stamp.utime > self.newest_state_utime {
            self.newest_state_utime = state.stamp.utime;
            self.state_tick = tick;
        }
        if let Some(pose) = object {
            self.expectation.take(pose);
        }
        if self.phase == ControllerPhase::Init {
            self.start = state.axis_position[0];
            self.commanded = self.start;
            self.bounds.begin(&self.start);
            self.phase = ControllerPhase::Sync;
        }
        for sample in deflections.samples.iter().rev() {
            if self.sensing.usable(sample) && sample.utime > self.newest_sample_utime {
                self.newest_sample_utime = sample.utime;
                self.heard_tick = tick;
                self.delay_ticks = tick - sample.utime / TICK_US;
                self.take(sample, tick);
            }
        }
        self.slew(tick);
        self.change_phase(tick, state);
        if let Some(followed) = self.delivery.followed(tick, state.command_step) {
            self.bounds.follow(&followed);
            if let Some(motion) = &mut self.motion {
                motion.follow(&self.settings, tick, followed.set_points());
            }
        }
        let axis_position = self.set_points(tick, &state.axis_position[0]);
        self.delivery.send(tick, &axis_position);
        Outputs {
            command: self.command(tick, axis_position),
            status: self.status(tick),
        }
    }

    /// One sample of the sensor, paired with the axes at its instant.
    fn take(&mut self, sample: &DeflectionSample, tick: i64) {
        let deflection = self.sensing.deflection(sample);
        let (axes, time_s) = self.paired_with(sample, tick);
        let Some(motion) = &mut self.motion else {
            let normal_in_s = self.settings.kinematics.forward(&self.start).rotation.inverse() * Vector3::z();
            let at_tcp = deflection_at_tcp(&deflection, self.settings.d);
            self.sensing
                .take_at_rest(sample, normal_in_s.dot(&at_tcp.translation));
            return;
        };
        let taken = Sample {
            time_s,
            tick: sample.utime / TICK_US,
            deflection,
            flags: sample.flags,
            axes,
        };
        let approaching = self.phase == ControllerPhase::Approach;
        motion.take(&self.settings, &self.expectation, &taken, approaching, tick);
        match motion.contact_tick() {
            Some(contact_tick) => {
                let in_contact_s = (taken.tick - contact_tick) as f64 * TICK_S;
                self.sensing.take_in_contact(sample, in_contact_s);
            }
            // A tilted tool hangs in another way.
            None if self.tilting.is_some_and(|tilting| tilting.begun()) => {}
            None => self.sensing.take_free(motion.normal_force_n()),
        }
        self.watch_for_collision(&taken);
    }

    /// The axes that belong to a sample, and when (s): those at its instant, less what the sensor's low pass delays.
    fn paired_with(&self, sample: &DeflectionSample, tick: i64) -> (Axes, f64) {
        match self.settings.controller.pairing {
            Pairing::Sampling => {
                // The low pass shows the deflection of 1 / (2 pi f) ago.
                let lag_us = 1e6 / (TAU * self.settings.controller.sensor_bandwidth_hz);
                let utime = sample.utime as f64 - lag_us;
                (self.encoders.at(utime), 1e-6 * utime)
            }
            Pairing::Arrival => (self.encoders.newest(), tick as f64 * TICK_S),
        }
    }

    /// Lead what was asked for at run time to its values; plan anew what rests on them and on what is learnt.
    fn slew(&mut self, tick: i64) {
        let changed = self.parameters.slew(&mut self.settings, tick);
        if changed.posture {
            self.sensing.configure(self.settings.compliance);
        }
        let Some(motion) = &mut self.motion else { return };
        if changed.any {
            motion.retune(&self.settings);
        }
        if changed.posture || self.sensing.adapts() {
            motion.plan(&self.settings, &self.sensing.compliance());
        }
    }

    fn change_phase(&mut self, tick: i64, state: &RobotState) {
        let time = tick as f64 * TICK_S;
        self.follow_request(tick, state);
        match self.phase {
            ControllerPhase::Sync if self.tared(tick) => {
                if let Some(noise_m) = self.sensing.finish_tare(self.settings.controller.tare_s) {
                    let zero = self.sensing.zero();
                    let motion = Motion::new(&self.settings, &zero, noise_m, &self.start);
                    self.bounds.hang(motion.hanging_in_s());
                    self.motion = Some(motion);
                    self.tilting = Tilting::of(&self.settings, &self.start);
                    self.phase = ControllerPhase::Ready;
                }
            }
            ControllerPhase::Ready if time >= self.settings.task.standstill_s && !self.started => {
                self.start_by_itself(tick, state);
            }
            ControllerPhase::Calibrate if self.tilting.is_some_and(|tilting| tilting.done()) => {
                self.tilting = None;
                self.phase = ControllerPhase::Ready;
            }
            _ => {}
        }
        let late = self.delay_ticks as f64 * TICK_S > self.settings.controller.max_sensor_delay_s;
        if self.motion.is_some() && (late || self.silent_s(tick) > self.settings.controller.stale_fault_s) {
            return self.fail(Fault::SensorStale);
        }
        if self.fault == Fault::None {
            self.follow_program(tick);
        }
    }

    /// Whether the tare has lasted long enough at `tick`.
    fn tared(&self, tick: i64) -> bool {
        (tick - self.tare_since_tick) as f64 * TICK_S >= self.settings.controller.tare_s
    }

    /// How long the sensor has brought nothing new, s.
    fn silent_s(&self, tick: i64) -> f64 {
        (tick - self.heard_tick) as f64 * TICK_S
    }

    /// Latch `fault`, unless another one came first.
    fn fail(&mut self, fault: Fault) {
        self.phase = ControllerPhase::Fault;
        if self.fault == Fault::None {
            self.fault = fault;
        }
    }
}

#[cfg(test)]
mod tests;
