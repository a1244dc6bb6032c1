//! The outer loop of the paper's Fig. 2: from encoder and sensor values to the commanded pose.
//!
//! Pure: a [`Controller`] takes what has come of the robot's states and the sensors' samples until a cycle and answers
//! with a command and its status. It sees only what a real one would. The only home of eqs. (1)-(18); each file is one idea:
//!
//! | Idea | File | Paper |
//! |---|---|---|
//! | messages that come late or not at all | `heard.rs`, [`pairing`], [`delivery`] | |
//! | actual pose and deflection at the same instant | [`pairing`] | below (2) |
//! | object expected before the contact | [`expectation`], [`approach`] | II-B, IV-C, footnote 3 |
//! | free motion that leaves nothing swinging | [`shaping`], [`approach`] | VI |
//! | contact or not; collision | [`detection`], [`collision`] | V |
//! | limits of the command | [`limits`] | |
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
//! | whether a start can be answered for; one away from where zero force is known | `readiness`, `homing` | |
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

mod heard;
mod homing;
mod motion;
mod parameters;
mod phases;
mod program;
mod protection;
mod readiness;
mod requests;
mod sensing;
mod settings;
mod status;
mod steps;

pub use heard::Heard;

use collision::CollisionWatch;
use delivery::Delivery;
use expectation::Expectation;
use homing::Homing;
use limits::Limits;
use margins::Assessor;
use motion::Motion;
use node::scenario::{self, Scenario};
use pairing::{EncoderHistory, Waiting};
use parameters::Parameters;
use phases::{Event, Phases};
use program::Program;
use requests::Requests;
use sensing::Sensing;
use settings::Settings;
use spatial::TICK_S;
use spatial::kinematics::Axes;
use spatial::ports::{Command, ControllerPhase, ControllerStatus, Fault, HORIZON, RobotMode, RobotState};
use tilting::Tilting;

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
    phases: Phases,
    /// The robot's newest state; `None`: none has come yet.
    robot: Option<RobotState>,
    encoders: EncoderHistory,
    newest_state_utime: i64,
    /// Tick at which that state came.
    state_tick: i64,
    /// Samples without encoder readings.
    waiting: Waiting,
    newest_sample_utime: i64,
    /// Tick at which that sample came.
    heard_tick: i64,
    /// How old that sample was then, ticks.
    delay_ticks: i64,
    /// Tick since which the tare is taken.
    tare_since_tick: i64,
    /// The task has begun, or was kept from it: it does not begin by itself any more.
    started: bool,
    /// A fault has been cleared or the robot released, and it does not follow yet: it is held where it stands.
    rejoins: bool,
    /// The robot is given to whoever asks for it.
    released: bool,
    homing: Homing,
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
            phases: Phases::new(),
            robot: None,
            encoders: EncoderHistory::default(),
            waiting: Waiting::default(),
            newest_state_utime: i64::MIN,
            state_tick: 0,
            newest_sample_utime: i64::MIN,
            heard_tick: 0,
            delay_ticks: 0,
            tare_since_tick: 0,
            started: !scenario.task.starts_by_itself,
            rejoins: false,
            released: false,
            homing: Homing::new(scenario),
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

    /// One cycle, due every T whatever has come: the command and the status of its tick. Before the first state of the robot,
    /// while it has a fault, and once it is released, the command enables nothing.
    ///
    /// All messages have been checked by whoever received them.
    pub fn cycle(&mut self, heard: &Heard<'_>) -> Outputs {
        let tick = heard.tick;
        // One that has been overtaken tells nothing.
        let news = heard
            .state
            .filter(|state| state.stamp.utime >= self.newest_state_utime);
        let stood_still = news.is_some_and(|state| self.hear_robot(state, tick));
        if let Some(pose) = heard.object {
            self.expectation.take(pose);
        }
        let Some(state) = self.robot else {
            return self.outputs(tick, false, [Axes::zeros(); HORIZON]);
        };
        self.follow_robot(tick, news.map(|state| state.command_step), stood_still);
        self.hear_sensor(heard.deflections, tick);
        self.slew(tick);
        self.change_phase(tick, &state);
        self.go_on_from(&state, tick);
        let before = self.modelled();
        let axis_position = self.set_points(tick, &self.actual(&state, tick));
        self.delivery.send(tick, &axis_position, before);
        let enable = state.fault == Fault::None && !self.released;
        self.outputs(tick, enable, axis_position)
    }

    /// A robot that does not follow stands where its servos hold it: from there it goes on.
    fn go_on_from(&mut self, state: &RobotState, tick: i64) {
        let Some(motion) = &mut self.motion else { return };
        if !follows(state) {
            self.commanded = state.axis_setpoint;
        } else if self.rejoins && !self.released {
            self.rejoins = false;
            motion.recover(&self.settings, &self.commanded, tick);
        }
    }

    fn outputs(&self, tick: i64, enable: bool, axis_position: [Axes; HORIZON]) -> Outputs {
        Outputs {
            command: self.command(tick, enable, axis_position),
            status: self.status(tick),
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
        match self.phases.phase() {
            ControllerPhase::Sync if self.tared(tick) => {
                if let Some(noise_m) = self.sensing.finish_tare(self.settings.controller.tare_s) {
                    let zero = self.sensing.zero();
                    let motion = Motion::new(&self.settings, &zero, noise_m, &self.start);
                    self.bounds.hang(motion.hanging_in_s());
                    self.motion = Some(motion);
                    self.tilting = Tilting::of(&self.settings, &self.start);
                    self.phases.take(Event::Tared);
                }
            }
            ControllerPhase::Ready if time >= self.settings.task.standstill_s && !self.started => {
                self.start_by_itself(tick, state);
            }
            ControllerPhase::Calibrate if self.tilting.is_some_and(|tilting| tilting.done()) => {
                self.tilting = None;
                self.phases.take(Event::Rests);
            }
            _ => {}
        }
        self.arrive_home(tick);
        if state.fault != Fault::None {
            return self.fail(state.fault);
        }
        let late = self.delay_ticks as f64 * TICK_S > self.settings.controller.max_sensor_delay_s;
        if self.motion.is_some()
            && (late || self.sensor_silent_s(tick) > self.settings.controller.stale_fault_s)
        {
            return self.fail(Fault::SensorStale);
        }
        if self.motion.is_some() && self.robot_stale(tick) {
            return self.fail(Fault::StateStale);
        }
        if self.phases.well() {
            self.follow_program(tick);
        }
    }

    /// Whether the tare has lasted long enough at `tick`.
    fn tared(&self, tick: i64) -> bool {
        (tick - self.tare_since_tick) as f64 * TICK_S >= self.settings.controller.tare_s
    }

    /// Latch `fault`, which comes from elsewhere; before the tare there is nothing yet that it could spoil.
    pub fn latch(&mut self, fault: Fault) {
        if self.motion.is_some() {
            self.fail(fault);
        }
    }

    /// Latch `fault`, unless another one came first.
    fn fail(&mut self, fault: Fault) {
        self.phases.take(Event::Fails(fault));
    }
}

/// Whether the robot executes commands.
fn follows(state: &RobotState) -> bool {
    matches!(state.mode, RobotMode::Following | RobotMode::Bridging)
}

#[cfg(test)]
mod tests;
