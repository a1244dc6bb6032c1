//! Where robot meets object (Fig. 3): the compliant sensor, the tool that hangs on it, and the contact.
//!
//! Pure: a [`SensorSim`] takes the motion of the robot's last link tick by tick and answers with the motion of the
//! tool plate, the sensor's samples and the truth. It integrates real dynamics with exact rotations; the paper's
//! equations live in the controller alone, so that a sign error can't cancel itself.

pub mod contact;
pub mod contacts;
pub mod object;
pub mod signal;
pub mod tool;

use contacts::Contacts;
use nalgebra::Vector3;
use node::scenario::Scenario;
use object::Base;
use signal::{Reading, SignalChain};
use spatial::ports::{Authenticity, ClockEcho, Deflections, LinkMotion, Role, Stamp, ToolMotion, Truth};
use spatial::{Deflection, Motion, MotionSegment, Pose, TICK_S, Wrench};
use tool::{Body, State, Surroundings, Work};

/// What one tick brings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outputs {
    /// The sensor's half of the physics.
    pub tool_motion: ToolMotion,
    /// What the controller gets to see.
    pub deflections: Deflections,
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
    step_s: f64,
    steps_per_tick: usize,
    state: State,
    link: Motion,
    chain: SignalChain,
    work: Work,
    contact_force_peak_n: f64,
    first_contact: Option<FirstContact>,
}

#[derive(Clone, Copy, Debug)]
struct FirstContact {
    time_s: f64,
    speed_m_per_s: f64,
}

impl SensorSim {
    /// The tool hanging at rest, in balance, on a link that is at rest as `link` says at tick 0.
    pub fn new(scenario: &Scenario, link: &Motion) -> Self {
        let body = Body::new(&scenario.tool, &scenario.sensor);
        let state = body.hanging(&link.pose);
        let steps = libm::rint(TICK_S / scenario.sensor.integration_step_s).max(1.0);
        let seed = scenario.timing.seed;
        Self {
            seed,
            body,
            contacts: Contacts::new(&scenario.tool, &scenario.object),
            s_from_t: spatial::pose(scenario.tool.tcp_in_s_m.into(), Vector3::zeros()),
            step_s: TICK_S / steps,
            steps_per_tick: steps as usize,
            state,
            link: *link,
            chain: SignalChain::new(&scenario.sensor, seed, &reading(&body, &state, link)),
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
        self.link = link.motion;
        self.outputs(tick)
    }

    fn integrate(&mut self, start_tick: i64, end: &Motion) {
        let start_s = start_tick as f64 * TICK_S;
        let segment = MotionSegment::new(self.link, *end, TICK_S);
        let mut before = reading(&self.body, &self.state, &self.link);
        let mut h_before = self
            .contacts
            .deepest(&self.state, &self.base(start_s))
            .indentation_m;
        for i in 0..self.steps_per_tick {
            let time = i as f64 * self.step_s;
            let around = Surroundings {
                link: &segment,
                start_s,
                contacts: &self.contacts,
            };
            let (state, work) = self.body.integrate(&self.state, &around, time, self.step_s);
            self.state = state;
            self.work.by_link += work.by_link;
            self.work.dissipated += work.dissipated;
            self.work.on_object += work.on_object;

            let base = self.base(start_s + time + self.step_s);
            let h = self.contacts.deepest(&self.state, &base).indentation_m;
            if h > 0.0 {
                if self.first_contact.is_none() {
                    let inside = self.step_s * (-h_before / (h - h_before));
                    self.first_contact = Some(FirstContact {
                        time_s: start_s + time + inside,
                        speed_m_per_s: (h - h_before) / self.step_s,
                    });
                }
                let force = self.contacts.load(&self.state, self.state.rotation, &base).force;
                self.contact_force_peak_n = self.contact_force_peak_n.max(force.norm());
            }
            self.contacts.remember(&self.state, &base);
            h_before = h;

            let now = reading(&self.body, &self.state, &segment.at(time + self.step_s));
            self.chain.follow(&before, &now, self.step_s);
            before = now;
        }
    }

    /// Where the object is at `time`, s after the start.
    fn base(&self, time: f64) -> Base {
        self.contacts.object().base(time)
    }

    fn outputs(&mut self, tick: i64) -> Outputs {
        let stamp = Stamp::lockstep(tick, self.seed, Role::Sensor);
        let base = self.base(tick as f64 * TICK_S);
        let motion = self
            .body
            .plate_motion(&self.state, &self.link, &self.contacts, &base);
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
            truth: self.truth(stamp, &base),
        }
    }

    fn truth(&self, stamp: Stamp, base: &Base) -> Truth {
        let (tcp_pose, tcp_velocity) = self.body.tcp_motion(&self.state);
        let deepest = self.contacts.deepest(&self.state, base);
        let r_from_ta = self.link.pose * self.s_from_t;
        Truth {
            stamp,
            tcp_pose,
            tcp_velocity,
            tcp_deflection: Deflection::from_pose(&(r_from_ta.inverse() * tcp_pose)),
            contact_force: self.contacts.load(&self.state, self.state.rotation, base).force,
            contact_force_peak_n: self.contact_force_peak_n,
            indentation_m: deepest.indentation_m,
            remaining_indentation_m: deepest.remaining_m,
            object_height_m: self.contacts.height_m(&self.state, base),
            first_contact_speed_m_per_s: self.first_contact.map_or(0.0, |c| c.speed_m_per_s),
            first_contact_time_s: self.first_contact.map_or(-1.0, |c| c.time_s),
            kinetic_energy_j: self.body.kinetic_energy(&self.state),
            gravity_energy_j: self.body.gravity_energy(&self.state),
            elastic_energy_j: self
                .body
                .suspension
                .energy(&self.link, &self.body.plate(&self.state)),
            link_work_j: self.work.by_link,
            dissipated_energy_j: self.work.dissipated,
            contact_work_j: self.work.on_object,
        }
    }
}

/// What the sensor feels before its signal chain: the deflection s -> s' and the wrench on it at s, both in s.
fn reading(body: &Body, state: &State, link: &Motion) -> Reading {
    let plate = body.plate(state);
    let deflection = Deflection::from_pose(&(link.pose.inverse() * plate.pose));
    // What the suspension exerts on the tool, the tool exerts on the sensor, the other way round.
    let on_tool = body.suspension.wrench_on_tool(link, &plate);
    let arm = plate.pose.translation.vector - link.pose.translation.vector;
    let into_s = link.pose.rotation.inverse();
    Reading {
        deflection,
        wrench: Wrench {
            force: into_s * -on_tool.force,
            moment: into_s * -(on_tool.moment + arm.cross(&on_tool.force)),
        },
    }
}
