//! The task once the tare is known: approach, contact, and the way from the tcp's coordinates to axes.

mod begin;
mod bounds;
mod fade;
mod normal;
mod path;
mod plan;
mod reference;
mod route;
mod sensed;
mod set_points;
mod statics;
mod told;

pub(crate) use sensed::Sample;

use crate::Settings;
use crate::command_dynamics::CommandDynamics;
use crate::contact::{ContactSample, Touch};
use crate::delivery::Followed;
use crate::detection::Detector;
use crate::disturbance::Disturbance;
use crate::dofs::{Dofs, NORMAL, Selection, TaskFrame, TcpCompliance};
use crate::elastic::Elastic;
use crate::expectation::Expectation;
use crate::impact::ImpactMonitor;
use crate::law::ForceControl;
use crate::oscillation::OscillationObserver;
use crate::posture::Posture;
use crate::shaping::swing::Swing;
use crate::shaping::{Point, Shape};
use fade::Fade;
use nalgebra::Vector3;
use path::Path;
use plan::Plan;
use route::{Spiral, Travel};
use sensed::{Contact, LONGEST_BOUNCE_TICKS, Sensed};
use spatial::kinematics::Axes;
use spatial::ports::SampleFlags;
use spatial::{Compliance, Deflection, Pose};
use statics::tcp_compliance;

/// Everything that exists only once the tare is known.
#[derive(Clone, Debug)]
pub(crate) struct Motion {
    frame: TaskFrame,
    selection: Selection,
    /// The sensor frame at the start.
    r_from_s: Pose,
    posture: Posture,
    compliance: TcpCompliance,
    /// `C f_d`.
    desired_displacement: Dofs,
    /// What the tool's acceleration deflects, and how a change of speed takes that into account.
    swing: Swing,
    shape: Shape,
    /// From the start to where the present step has begun, m in r.
    anchor: Vector3<f64>,
    /// From the nominal to the hanging tcp, m in r.
    sag: Vector3<f64>,
    /// The way to the object, once the approach has begun.
    path: Option<Path>,
    /// Another step's way.
    travel: Option<Travel>,
    spiral: Option<Spiral>,
    /// What is left of the motion before this step, and the cycle in which it was left off.
    fade: Option<(Fade, i64)>,
    /// Share of the posture that is kept while no law acts.
    share: f64,
    /// The way goes on in contact: towards a position, not until a force.
    inserts: bool,
    dynamics: CommandDynamics,
    /// Where the servos have yielded to when the next set-point begins to act.
    disturbance: Disturbance,
    detector: Detector,
    force_control: ForceControl,
    /// `None` where no assessment can be made of what is assumed, which no scenario allows.
    impact: Option<ImpactMonitor>,
    oscillation: OscillationObserver,
    contact: Option<Contact>,
    /// The tool that no law presses any more still leaves what it touches, or comes to rest where it may touch: the tick of
    /// the newest sample that shows it, or of that rest.
    leaving: Option<i64>,
    newest: Sensed,
    plan: Plan,
    /// The lowest height that a force law may seek, m.
    lowest_m: f64,
    settled_cycles: i64,
}

impl Motion {
    /// At rest at the axes `start`, with the deflection `tare` there, which shows a noise of `noise_m` (m rms) along the
    /// normal.
    pub(crate) fn new(settings: &Settings, tare: &Deflection, noise_m: f64, start: &Axes) -> Self {
        let (controller, task) = (&settings.controller, &settings.task);
        let r_from_s = settings.kinematics.forward(start);
        let posture = Posture::new(
            controller.transform,
            &settings.compliance,
            settings.d,
            *tare,
            &r_from_s,
            &settings.desired,
        );
        let hanging = posture.hanging_tcp(&r_from_s);
        let frame = TaskFrame::new(hanging.rotation);
        let coordinates = frame.coordinates(&hanging);
        let selection = Selection::new(&task.force_controlled);
        let impact = ImpactMonitor::new(controller, task, hanging.rotation.inverse() * Vector3::z()).ok();
        let sample = Sample {
            time_s: 0.0,
            tick: 0,
            deflection: *tare,
            flags: SampleFlags::default(),
            axes: *start,
        };
        let swing = Swing::new(controller, &settings.kinematics, start);
        let compliance = tcp_compliance(&settings.compliance, &posture, &r_from_s, &selection);
        let noise_n = noise_m / compliance.along(NORMAL);
        let elastic = settings.elastic.clone().map(Elastic::new);
        let dynamics = CommandDynamics::new(
            controller.filter_frequency_hz,
            controller.filter_damping,
            controller.acceleration_limit_rad_per_s2.into(),
            settings.period_ticks,
            *start,
        );
        Self {
            frame,
            selection,
            r_from_s,
            posture,
            compliance,
            desired_displacement: posture.desired_displacement(),
            swing,
            shape: Shape::new(&controller.shaping, &swing),
            anchor: Vector3::zeros(),
            sag: hanging.translation.vector - (r_from_s * nalgebra::Point3::from(settings.d)).coords,
            path: None,
            travel: None,
            spiral: None,
            fade: None,
            share: 0.0,
            inserts: false,
            dynamics,
            disturbance: Disturbance::new(&controller.servo),
            detector: Detector::of(controller, noise_n),
            force_control: ForceControl::new(controller, selection, elastic),
            impact,
            oscillation: OscillationObserver::new(controller),
            contact: None,
            leaving: None,
            newest: Sensed::new(&sample, &r_from_s, &posture, &compliance),
            plan: Plan::stay(coordinates, *start),
            lowest_m: f64::NEG_INFINITY,
            settled_cycles: 0,
        }
    }

    /// The robot as it is modelled: where it will be when the next set-point begins to act.
    pub(crate) fn dynamics(&self) -> &CommandDynamics {
        &self.dynamics
    }

    /// At `tick` the robot has `followed` other set-points than those sent last.
    pub(crate) fn follow(&mut self, settings: &Settings, tick: i64, followed: &Followed) {
        let Some(before) = followed.before().dynamics else {
            return;
        };
        self.dynamics = before;
        let set_points = followed.set_points();
        for (i, set_point) in set_points.iter().enumerate() {
            if i > 0 {
                let periods = settings.lead() - 1 - (set_points.len() - i) as i64;
                self.track(settings, tick + periods * settings.period_ticks);
            }
            self.dynamics.advance(set_point);
        }
    }

    /// Plan the contact anew with another `compliance` of the sensor; without bump if it changes as slowly as the
    /// posture is taken.
    pub(crate) fn plan(&mut self, settings: &Settings, compliance: &Compliance) {
        self.posture.plan(compliance, &settings.desired);
        self.compliance = tcp_compliance(compliance, &self.posture, &self.r_from_s, &self.selection);
        self.desired_displacement = self.posture.desired_displacement();
    }

    /// Take one sample in a cycle at `tick`; a contact counts if the robot is `approaching`.
    pub(crate) fn take(
        &mut self,
        settings: &Settings,
        expectation: &Expectation,
        sample: &Sample,
        approaching: bool,
        tick: i64,
    ) {
        let r_from_s = settings.kinematics.forward(&sample.axes);
        let sensed = Sensed::new(sample, &r_from_s, &self.posture, &self.compliance);
        self.newest = sensed;
        let object_velocity = expectation.at(sample.time_s).map(|(_, velocity)| velocity);
        if let Some(impact) = &mut self.impact {
            let heights = [&sensed.r_from_ta1, &sensed.hanging].map(|pose| pose.translation.vector[NORMAL]);
            let object = object_velocity.map_or(0.0, |velocity| velocity[NORMAL]);
            impact.take(sample.time_s, heights, object);
        }
        let looking = approaching && self.contact.is_none();
        if self.detector.take(sensed.normal_force_n, looking) {
            let reached = tick + settings.lead() * settings.period_ticks;
            let met = self
                .path
                .map_or(Point::default(), |path| path.at(settings, reached));
            self.contact = Some(Contact::new(settings, &sensed, tick, met));
            if let Some(impact) = &mut self.impact {
                impact.contact();
            }
            self.oscillation.forget();
            if let Some(velocity) = object_velocity {
                self.force_control.expect(&velocity);
            }
        }
        let touches = libm::fabs(sensed.normal_force_n) > self.detector.threshold_n();
        self.leaving = self
            .leaving
            .map(|last| if touches { last.max(sample.tick) } else { last })
            .filter(|last| sample.tick - last <= LONGEST_BOUNCE_TICKS);
        if let Some(contact) = self.contact.as_mut().filter(|contact| !contact.released) {
            let touch = contact.touch(settings, &self.selection, &sensed);
            contact.lost = touch == Touch::Lost;
            if contact.lost {
                self.oscillation.forget();
            } else if self.selection.contains(NORMAL) && !self.inserts {
                self.oscillation.take(
                    sensed.wrench[NORMAL] - settings.desired.force.z,
                    settings.desired.force.z,
                );
            }
            // Paper (12).
            let object = self.frame.coordinates(&sensed.r_from_ta1);
            let actual = self.frame.coordinates(&sensed.hanging);
            self.force_control.take(|dof| ContactSample {
                time_s: sample.time_s,
                object: object[dof],
                actual: actual[dof],
                wrench: sensed.wrench[dof],
                touch,
            });
        }
    }

    /// How long the approach has lasted at `tick`, s.
    pub(crate) fn approached_for(&self, tick: i64) -> f64 {
        self.path.map_or(0.0, |path| path.lasted_s(tick))
    }

    /// How long the approach lasts at most, until its end has been the next set-point, s.
    pub(crate) fn approach_duration(&self, settings: &Settings) -> f64 {
        self.path.map_or(0.0, |path| path.duration_s()) + settings.period_s()
    }

    /// Count this cycle as one with the force `inside` its band; how many there were in a row.
    pub(crate) fn count_settled(&mut self, inside: bool) -> i64 {
        self.settled_cycles = if inside { self.settled_cycles + 1 } else { 0 };
        self.settled_cycles
    }

    /// The contact in which a law acts.
    fn pressing(&self) -> Option<Contact> {
        self.contact.filter(|contact| !contact.released)
    }
}
