//! Where robot meets object (Fig. 3): the compliant sensor, the tool that hangs on it, and the contact.
//!
//! Pure: a [`SensorSim`] takes the motion of the robot's last link tick by tick and answers with the motion of the
//! tool plate, the samples of the sensors and the truth. It integrates real dynamics with exact rotations; the paper's
//! equations live in the controller alone, so that a sign error can't cancel itself.

pub mod contact;
pub mod contacts;
pub mod exponential;
mod integration;
pub mod noise;
pub mod object;
pub mod object_sensor;
pub mod signal;
pub mod smooth;
pub mod swing;
pub mod tool;

use contacts::Contacts;
use integration::Steps;
use nalgebra::Vector3;
use node::scenario::Scenario;
use object::Base;
use object_sensor::ObjectSensor;
use signal::{Reading, SignalChain};
use smooth::Smooth;
use spatial::ports::{
    Authenticity, ClockEcho, Deflections, LinkMotion, ObjectPose, Role, Stamp, ToolMotion, Truth,
};
use spatial::{Deflection, Motion, Pose, TICK_S, Wrench};
use tool::{Body, Instant, Rates, State, Work};

/// What one tick brings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outputs {
    /// The sensor's half of the physics.
    pub tool_motion: ToolMotion,
    /// What the controller gets to see.
    pub deflections: Deflections,
    /// The non-contact sensor's, at the ticks at which it publishes.
    pub object_pose: Option<ObjectPose>,
    /// What only analysis gets to see.
    pub truth: Truth,
}

/// Sensor, tool and contact.
#[derive(Clone, Debug)]
pub struct SensorSim {
    seed: i64,
    body: Body,
    contacts: Contacts,
    s_from_t: Pose,
    steps: Steps,
    smooth: Smooth,
    state: State,
    now: Instant,
    /// How the state changes now, once that is known.
    rates: Option<Rates>,
    /// Of the deepest point, m; negative: distance.
    indentation_m: f64,
    chain: SignalChain,
    wrench_measured: bool,
    object_sensor: Option<ObjectSensor>,
    work: Work,
    contact_force_peak_n: f64,
    first_contact: Option<FirstContact>,
}

/// From where it touches nothing to where it presses the tool of a node that joins is lowered for so long; as long again, and it
/// is at rest.
const LOWERING_TICKS: i64 = 1000;
/// Above the object it begins so high, m.
const CLEAR_M: f64 = 1e-4;

#[derive(Clone, Copy, Debug)]
struct FirstContact {
    time_s: f64,
    speed_m_per_s: f64,
}

impl SensorSim {
    /// The tool hanging at rest, in balance, on a link that is at rest as `link` says at tick 0.
    pub fn new(scenario: &Scenario, link: &Motion) -> Self {
        let body = Body::new(&scenario.tool, &scenario.sensor);
        Self::at(scenario, link, 0, body.hanging(&link.pose))
    }

    /// At rest, in balance, on the link of a robot that is at the tick of `link` already: where the tool would hang inside the
    /// object, it has come to rest pressing on it.
    pub fn joining(scenario: &Scenario, link: &LinkMotion) -> Self {
        let tick = link.stamp.step;
        let body = Body::new(&scenario.tool, &scenario.sensor);
        let hangs = |link: &Motion| Self::at(scenario, link, tick, body.hanging(&link.pose));
        let simulation = hangs(&link.motion);
        if simulation.indentation_m <= 0.0 {
            return simulation;
        }
        // Let go where it hangs it would spring off, and leave a mark: it is lowered from above instead.
        let force = simulation.contact_force(&simulation.now.base);
        let up = force.try_normalize(0.0).unwrap_or_else(Vector3::z) * (simulation.indentation_m + CLEAR_M);
        let lowered = |ticks: i64| {
            let s = (ticks as f64 / LOWERING_TICKS as f64).min(1.0);
            let mut held = Motion::at_rest(link.motion.pose);
            held.pose.translation.vector += up * (1.0 - s * s * (3.0 - 2.0 * s));
            held.velocity = up * (-6.0 * s * (1.0 - s) / (LOWERING_TICKS as f64 * TICK_S));
            held
        };
        let mut simulation = hangs(&lowered(0));
        for ticks in 1..=2 * LOWERING_TICKS {
            simulation.integrate(tick, &lowered(ticks));
            // The object stays where it is.
            let base = simulation.contacts.object().base(tick as f64 * TICK_S);
            simulation.now.base = base;
        }
        Self::at(scenario, &link.motion, tick, simulation.state)
    }

    fn at(scenario: &Scenario, link: &Motion, tick: i64, state: State) -> Self {
        let (tool, sensor) = (&scenario.tool, &scenario.sensor);
        let body = Body::new(tool, sensor);
        let contacts = Contacts::new(tool, &scenario.object);
        let base = contacts.object().base(tick as f64 * TICK_S);
        let seed = scenario.timing.seed;
        let reading = reading(&body, &state, link, sensor.wrench_measured);
        let chain = SignalChain::new(sensor, seed, &reading);
        let steps = Steps::new(sensor, &chain);
        Self {
            seed,
            s_from_t: spatial::pose(tool.tcp_in_s_m.into(), Vector3::zeros()),
            smooth: steps.smooth(),
            steps,
            state,
            now: Instant { link: *link, base },
            rates: None,
            indentation_m: contacts.deepest(&state, &base).indentation_m,
            body,
            contacts,
            chain,
            wrench_measured: sensor.wrench_measured,
            object_sensor: scenario
                .object_sensor
                .enabled
                .then(|| ObjectSensor::new(&scenario.object_sensor, seed)),
            work: Work::default(),
            contact_force_peak_n: 0.0,
            first_contact: None,
        }
    }

    /// Integrate over one tick to the link's motion at its end, and say what is seen there.
    ///
    /// At tick 0 there is nothing to integrate. The caller hands the ticks over one by one, without a gap.
    pub fn advance(&mut self, link: &LinkMotion) -> Outputs {
        let tick = link.stamp.step;
        self.contact_force_peak_n = 0.0;
        if tick > 0 {
            self.integrate(tick - 1, &link.motion);
        }
        self.now = Instant {
            link: link.motion,
            base: self.contacts.object().base(tick as f64 * TICK_S),
        };
        self.outputs(tick)
    }

    fn contact_force(&self, base: &Base) -> Vector3<f64> {
        let rotation = self.state.rotation.to_rotation_matrix();
        self.contacts.load(&self.state, &rotation, base).force
    }

    fn outputs(&mut self, tick: i64) -> Outputs {
        let stamp = Stamp::lockstep(tick, self.seed, Role::Sensor);
        let rates = self.rates();
        let motion = self.body.plate_motion(&self.state, &rates);
        let samples = self.chain.sample(tick);
        Outputs {
            tool_motion: ToolMotion { stamp, motion },
            deflections: Deflections {
                stamp: Stamp {
                    utime: samples[0].utime,
                    ..stamp
                },
                samples,
                echo: ClockEcho::default(),
                authenticity: Authenticity::default(),
            },
            object_pose: self.object_pose(stamp),
            truth: self.truth(stamp),
        }
    }

    fn object_pose(&mut self, stamp: Stamp) -> Option<ObjectPose> {
        let sensor = self.object_sensor.as_mut()?;
        let r_from_o = self.contacts.object_pose(&self.state, &self.now.base);
        let (r_from_t, _) = self.body.tcp_motion(&self.state);
        sensor.sample(stamp, &r_from_o, &r_from_t.translation.vector)
    }

    fn truth(&self, stamp: Stamp) -> Truth {
        let Instant { link, base } = &self.now;
        let (tcp_pose, tcp_velocity) = self.body.tcp_motion(&self.state);
        let deepest = self.contacts.deepest(&self.state, base);
        let r_from_ta = link.pose * self.s_from_t;
        Truth {
            stamp,
            tcp_pose,
            tcp_velocity,
            tcp_deflection: Deflection::from_pose(&(r_from_ta.inverse() * tcp_pose)),
            contact_force: self.contact_force(base),
            contact_force_peak_n: self.contact_force_peak_n,
            indentation_m: deepest.indentation_m,
            remaining_indentation_m: deepest.remaining_m,
            object_height_m: self.contacts.object_pose(&self.state, base).translation.z,
            first_contact_speed_m_per_s: self.first_contact.map_or(0.0, |c| c.speed_m_per_s),
            first_contact_time_s: self.first_contact.map_or(-1.0, |c| c.time_s),
            kinetic_energy_j: self.body.kinetic_energy(&self.state),
            gravity_energy_j: self.body.gravity_energy(&self.state),
            elastic_energy_j: self.body.suspension.energy(link, &self.body.plate(&self.state)),
            link_work_j: self.work.by_link,
            dissipated_energy_j: self.work.dissipated,
            contact_work_j: self.work.on_object,
        }
    }
}

/// What the sensor feels before its signal chain: the deflection s -> s', and the wrench on it at s if `with_wrench`,
/// both in s.
fn reading(body: &Body, state: &State, link: &Motion, with_wrench: bool) -> Reading {
    let plate = body.plate(state);
    let mut reading = Reading {
        deflection: Deflection::from_pose(&(link.pose.inverse() * plate.pose)),
        wrench: Wrench::default(),
    };
    if with_wrench {
        // What the suspension exerts on the tool, the tool exerts on the sensor, the other way round.
        let on_tool = body.suspension.wrench_on_tool(link, &plate);
        let arm = plate.pose.translation.vector - link.pose.translation.vector;
        let into_s = link.pose.rotation.inverse();
        reading.wrench = Wrench {
            force: into_s * -on_tool.force,
            moment: into_s * -(on_tool.moment + arm.cross(&on_tool.force)),
        };
    }
    reading
}
