//! Where robot meets object (Fig. 3): the compliant sensor, the tool that hangs on it, and the contact.
//!
//! Pure: a [`SensorSim`] takes the motion of the robot's last link tick by tick and answers with the motion of the
//! tool plate, the sensor's samples and the truth. It integrates real dynamics with exact rotations; the paper's
//! equations live in the controller alone, so that a sign error can't cancel itself.

pub mod contact;
pub mod signal;
pub mod tool;

use contact::Contact;
use nalgebra::Vector3;
use node::scenario::Scenario;
use signal::SignalChain;
use spatial::ports::{Authenticity, ClockEcho, Deflections, LinkMotion, Role, Stamp, ToolMotion, Truth};
use spatial::{Deflection, Motion, MotionSegment, Pose, TICK_S};
use tool::{Body, State, Surface, Work};

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
    contact: Contact,
    object_height_m: f64,
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
            contact: Contact::new(&scenario.object),
            object_height_m: scenario.object.height_m,
            s_from_t: spatial::pose(scenario.tool.tcp_in_s_m.into(), Vector3::zeros()),
            step_s: TICK_S / steps,
            steps_per_tick: steps as usize,
            state,
            link: *link,
            chain: SignalChain::new(&scenario.sensor, seed, &deflection(&body, &state, link)),
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
        let segment = MotionSegment::new(self.link, *end, TICK_S);
        let mut before = deflection(&self.body, &self.state, &self.link);
        let mut h_before = self.body.indentation(&self.state, self.object_height_m);
        for i in 0..self.steps_per_tick {
            let time = i as f64 * self.step_s;
            let surface = Surface {
                contact: &self.contact,
                height: self.object_height_m,
            };
            let (state, work) = self
                .body
                .integrate(&self.state, &segment, time, self.step_s, &surface);
            self.state = state;
            self.work.by_link += work.by_link;
            self.work.dissipated += work.dissipated;
            self.work.on_object += work.on_object;

            let h = self.body.indentation(&self.state, self.object_height_m);
            if h > 0.0 {
                if self.first_contact.is_none() {
                    let inside = self.step_s * (-h_before / (h - h_before));
                    self.first_contact = Some(FirstContact {
                        time_s: start_tick as f64 * TICK_S + time + inside,
                        speed_m_per_s: (h - h_before) / self.step_s,
                    });
                }
                self.contact_force_peak_n = self.contact_force_peak_n.max(self.contact.force(h));
            }
            self.contact.remember(h);
            h_before = h;

            let now = deflection(&self.body, &self.state, &segment.at(time + self.step_s));
            self.chain.follow(&before, &now, self.step_s);
            before = now;
        }
    }

    fn outputs(&mut self, tick: i64) -> Outputs {
        let stamp = Stamp::lockstep(tick, self.seed, Role::Sensor);
        let surface = Surface {
            contact: &self.contact,
            height: self.object_height_m,
        };
        let motion = self.body.plate_motion(&self.state, &self.link, &surface);
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
            truth: self.truth(stamp),
        }
    }

    fn truth(&self, stamp: Stamp) -> Truth {
        let (tcp_pose, tcp_velocity) = self.body.tcp_motion(&self.state);
        let h = self.body.indentation(&self.state, self.object_height_m);
        let r_from_ta = self.link.pose * self.s_from_t;
        Truth {
            stamp,
            tcp_pose,
            tcp_velocity,
            tcp_deflection: Deflection::from_pose(&(r_from_ta.inverse() * tcp_pose)),
            contact_force: Vector3::new(0.0, 0.0, self.contact.force(h)),
            contact_force_peak_n: self.contact_force_peak_n,
            indentation_m: h,
            remaining_indentation_m: self.contact.remaining_m(),
            object_height_m: self.object_height_m,
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

/// The true deflection s -> s' in s.
fn deflection(body: &Body, state: &State, link: &Motion) -> Deflection {
    Deflection::from_pose(&(link.pose.inverse() * body.plate(state).pose))
}
