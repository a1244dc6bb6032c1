//! The task once the tare is known: approach, contact, and the way from the tcp's coordinates to axes.

use crate::Settings;
use crate::approach::{Approach, PathPoint, spread};
use crate::command_dynamics::CommandDynamics;
use crate::contact::{Aim, ContactSample, PREVIEW, Situation, Touch};
use crate::detection::Detector;
use crate::disturbance::Disturbance;
use crate::dofs::{Dofs, NORMAL, Selection, TaskFrame, TcpCompliance, displacement};
use crate::expectation::Expectation;
use crate::impact::ImpactMonitor;
use crate::law::{ForceControl, feeds_forward};
use crate::posture::Posture;
use nalgebra::Vector3;
use node::scenario::TaskKind;
use spatial::kinematics::{Axes, Unreachable, join, split};
use spatial::ports::{HORIZON, ImpactAssessment, SampleFlags};
use spatial::{Compliance, Deflection, Pose, TICK_S};
use std::f64::consts::TAU;

/// How long the tool stays in the air after an impact at most (PLANT.md section 7: some 5 ms).
const LONGEST_BOUNCE_TICKS: i64 = 30;

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
    /// The way to the object, once the approach has begun.
    path: Option<Path>,
    dynamics: CommandDynamics,
    /// Where the servos have yielded to when the next set-point begins to act.
    disturbance: Disturbance,
    detector: Detector,
    force_control: ForceControl,
    /// `None` where no assessment can be made of what is assumed, which no scenario allows.
    impact: Option<ImpactMonitor>,
    contact: Option<Contact>,
    /// Tick of the newest sample in contact.
    touched_tick: i64,
    newest: Sensed,
    plan: Plan,
    settled_cycles: i64,
}

/// One sample of the sensor, paired with the axes at its instant.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sample {
    /// When it was true, s.
    pub(crate) time_s: f64,
    /// The tick at which it was taken.
    pub(crate) tick: i64,
    /// At s.
    pub(crate) deflection: Deflection,
    pub(crate) flags: SampleFlags,
    pub(crate) axes: Axes,
}

/// What the newest sample says.
#[derive(Clone, Copy, Debug)]
struct Sensed {
    sample: Sample,
    /// `r_from_ta1`: where the deflected tcp is.
    r_from_ta1: Pose,
    /// Force along the normal if it is the only one, N.
    normal_force_n: f64,
    /// Wrench along the selected degrees of freedom, N and Nm.
    wrench: Dofs,
    /// How far the tcp has yielded, m.
    yields_by_m: f64,
}

/// What a cycle has decided about the coming instants, T apart.
#[derive(Clone, Copy, Debug)]
struct Plan {
    /// Coordinates of the hanging tcp.
    coordinates: [Dofs; PREVIEW],
    /// The axes there.
    axes: [Axes; PREVIEW],
    /// The coordinates of the set-point given.
    commanded: Dofs,
}

/// The least detection threshold, in standard deviations of the noise: whatever compliance is assumed, noise is no
/// contact. Three false alarms in a million samples.
const ABOVE_NOISE: f64 = 4.5;

/// The free motion that has begun.
#[derive(Clone, Copy, Debug)]
struct Path {
    approach: Approach,
    start_tick: i64,
    /// Where the object was expected at the start, m in r.
    expected: Option<Vector3<f64>>,
    /// Way over which the tcp joins the motion of the object, m.
    free_m: f64,
}

#[derive(Clone, Copy, Debug)]
struct Contact {
    /// Tick of the sample that detected it.
    sample_tick: i64,
    /// Tick of the cycle that learned of it.
    cycle_tick: i64,
    /// How far the way had led then, m.
    distance_m: f64,
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
        let compliance = tcp_compliance(&settings.compliance, &posture, &r_from_s, &selection);
        let noise_n = noise_m / compliance.along(NORMAL);
        // What the tool's inertia deflects looks like as much more force as the sensor is softer than assumed.
        let softer = if controller.adaptation.enabled {
            controller.adaptation.maximum_ratio
        } else {
            1.0
        };
        Self {
            frame,
            selection,
            r_from_s,
            posture,
            compliance,
            desired_displacement: posture.desired_displacement(),
            path: None,
            dynamics: CommandDynamics::new(
                controller.filter_frequency_hz,
                controller.filter_damping,
                controller.acceleration_limit_rad_per_s2.into(),
                settings.period_ticks,
                *start,
            ),
            disturbance: Disturbance::new(&controller.servo),
            detector: Detector::new(
                controller.detection_threshold_n.max(ABOVE_NOISE * noise_n),
                controller.apparent_mass_kg * softer,
                controller.detection_fading_s,
            ),
            force_control: ForceControl::new(controller, selection),
            impact,
            contact: None,
            touched_tick: 0,
            newest: Sensed {
                sample,
                r_from_ta1: hanging,
                normal_force_n: 0.0,
                wrench: Dofs::zeros(),
                yields_by_m: 0.0,
            },
            plan: Plan {
                coordinates: [coordinates; PREVIEW],
                axes: [*start; PREVIEW],
                commanded: coordinates,
            },
            settled_cycles: 0,
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
        let r_from_ta1 = self.posture.deflected_tcp(&r_from_s, &sample.deflection);
        let hanging = self.posture.hanging_tcp(&r_from_s);
        let displaced = displacement(&hanging, &r_from_ta1);
        let wrench = self.compliance.wrench(&displaced);
        let normal_force_n = displaced[NORMAL] / self.compliance.along(NORMAL);
        self.newest = Sensed {
            sample: *sample,
            r_from_ta1,
            normal_force_n,
            wrench,
            yields_by_m: split(&displaced).0.norm(),
        };
        if let Some(impact) = &mut self.impact {
            let heights = [&r_from_ta1, &hanging].map(|pose| pose.translation.vector[NORMAL]);
            let object = expectation
                .at(sample.time_s)
                .map(|(_, velocity)| velocity[NORMAL]);
            impact.take(sample.time_s, heights, object.unwrap_or(0.0));
        }
        if approaching && self.contact.is_none() && normal_force_n > self.detector.threshold_n() {
            self.contact = Some(Contact {
                sample_tick: sample.tick,
                cycle_tick: tick,
                distance_m: self
                    .path_point(settings, tick + settings.lead() * settings.period_ticks)
                    .distance,
            });
            if let Some(impact) = &mut self.impact {
                impact.contact();
            }
            if let Some((_, velocity)) = expectation.at(sample.time_s) {
                self.force_control.expect(&velocity);
            }
        }
        if self.contact.is_some() {
            let touch = self.touch(settings, sample.tick);
            // Paper (12).
            let object = self.frame.coordinates(&r_from_ta1);
            let actual = self.frame.coordinates(&hanging);
            self.force_control.take(|dof| ContactSample {
                time_s: sample.time_s,
                object: object[dof],
                actual: actual[dof],
                wrench: wrench[dof],
                touch,
            });
        }
    }

    /// Whether the newest sample, of `tick`, was taken in contact: along the normal, or, where that is not force
    /// controlled, along what is. Half of a small desired force is contact, too.
    fn touch(&mut self, settings: &Settings, tick: i64) -> Touch {
        let least_n = settings
            .controller
            .detection_threshold_n
            .min(0.5 * settings.task.desired_force_n);
        let force_n = if self.selection.contains(NORMAL) {
            self.newest.normal_force_n
        } else {
            split(&self.newest.wrench).0.norm()
        };
        if force_n >= least_n {
            self.touched_tick = tick;
        }
        match tick - self.touched_tick {
            0 => Touch::Contact,
            ..=LONGEST_BOUNCE_TICKS => Touch::Bounce,
            _ => Touch::Lost,
        }
    }

    /// How long the approach has lasted at `tick`, which begins with the first question, s.
    pub(crate) fn approached_for(
        &mut self,
        settings: &Settings,
        expectation: &Expectation,
        tick: i64,
    ) -> f64 {
        let start_m = self.plan.coordinates[0][NORMAL];
        let impact = self.impact.as_ref();
        let path = self
            .path
            .get_or_insert_with(|| Path::new(settings, expectation, impact, start_m, tick));
        (tick - path.start_tick) as f64 * TICK_S
    }

    /// How long the approach lasts at most, s.
    pub(crate) fn approach_duration(&self) -> f64 {
        self.path.map_or(0.0, |path| path.approach.duration())
    }

    /// Count this cycle as one with the force `inside` its band; how many there were in a row.
    pub(crate) fn count_settled(&mut self, inside: bool) -> i64 {
        self.settled_cycles = if inside { self.settled_cycles + 1 } else { 0 };
        self.settled_cycles
    }

    /// The next set-points of the axes, one period apart, and whether the bound of command minus actual binds.
    pub(crate) fn set_points(
        &mut self,
        settings: &Settings,
        expectation: &Expectation,
        tick: i64,
        actual: &Axes,
    ) -> Result<([Axes; HORIZON], bool), Unreachable> {
        // The first set-point is reached n_d + 1 periods from now.
        let reached: [i64; PREVIEW] =
            std::array::from_fn(|i| tick + (settings.lead() + i as i64) * settings.period_ticks);
        let leads = feeds_forward(settings.controller.law);
        let mut coordinates = reached.map(|tick| self.reference(settings, expectation, tick, leads));
        if self.contact.is_some() {
            for (all, demand) in coordinates.iter_mut().zip(self.demand(settings, &reached)) {
                *all = self.selection.merge(&demand, all);
            }
        }
        let axes = self.inverse(settings, &coordinates)?;
        let mut set_points = if leads {
            let proposed = &settings.controller.proposed;
            let mut led = axes;
            if proposed.disturbance_feed_forward && self.contact.is_some() {
                for (axes, deviation) in led.iter_mut().zip(self.deviations(settings, &axes[0])) {
                    *axes -= deviation;
                }
            }
            self.dynamics.follow(&led, TAU * proposed.reference_bandwidth_hz)
        } else {
            std::array::from_fn(|i| axes[i])
        };
        let bound = self.bound(settings, actual, &mut set_points);
        let acceleration = self.dynamics.advance(&set_points[0]);
        if self.contact.is_none() {
            let normal = self.along_normal(settings, &set_points[0], &acceleration);
            self.detector.follow(normal, settings.period_ticks);
        } else {
            self.detector.follow(0.0, settings.period_ticks);
        }
        let commanded = if bound {
            let r_from_s = settings.kinematics.forward(&set_points[0]);
            self.frame.coordinates(&self.posture.hanging_tcp(&r_from_s))
        } else {
            coordinates[0]
        };
        self.plan = Plan {
            coordinates,
            axes,
            commanded,
        };
        Ok((set_points, bound))
    }

    /// The component along the normal, of the tcp, of what the axes do (their rates or their accelerations at rest).
    fn along_normal(&self, settings: &Settings, axes: &Axes, rates: &Axes) -> f64 {
        let r_from_s = settings.kinematics.forward(axes);
        let lever = self.posture.hanging_tcp(&r_from_s).translation.vector - r_from_s.translation.vector;
        let (velocity, turning) = split(&(settings.kinematics.jacobian(axes) * rates));
        (velocity + turning.cross(&lever))[NORMAL]
    }

    /// Where the hanging tcp is to be at `tick` as far as no force law moves it: on the way to the object and with it,
    /// and in the posture that keeps the tool's reference. What leads the robot is led here if the law is not fed
    /// forward.
    fn reference(
        &self,
        settings: &Settings,
        expectation: &Expectation,
        tick: i64,
        fed_forward: bool,
    ) -> Dofs {
        let tilt = self.contact.map_or(PathPoint::default(), |contact| {
            let time = since(settings, contact.cycle_tick, tick);
            spread(time, settings.controller.tilt_time_s)
        });
        let share = if fed_forward {
            tilt.distance
        } else {
            self.dynamics
                .inverse(tilt.distance, tilt.speed, tilt.acceleration)
        };
        let distance = match self.contact {
            Some(contact) if settings.task.kind == TaskKind::Press => contact.distance_m,
            _ => self.path_point(settings, tick).distance,
        };
        let shift = self.path.and_then(|path| {
            let (now, _) = expectation.at(tick as f64 * TICK_S)?;
            Some((now - path.expected?) * (distance / path.free_m).min(1.0))
        });
        let mut coordinates = self
            .frame
            .coordinates(&self.posture.reference(shift.unwrap_or_default(), share));
        coordinates[NORMAL] -= distance;
        coordinates
    }

    /// What the force laws ask for at the ticks `reached`.
    fn demand(&mut self, settings: &Settings, reached: &[i64; PREVIEW]) -> [Dofs; PREVIEW] {
        let Plan {
            coordinates,
            commanded,
            ..
        } = self.plan;
        let period_s = settings.period_ticks as f64 * TICK_S;
        let desired_wrench = join(settings.desired.force, settings.desired.moment);
        let (compliance, displacement) = (self.compliance, self.desired_displacement);
        self.force_control.demand(
            |dof| Aim {
                wrench: desired_wrench[dof],
                displacement: displacement[dof],
                compliance: compliance.along(dof),
            },
            |dof| Situation {
                commanded: commanded[dof],
                desired: coordinates[0][dof],
                desired_rate: (coordinates[1][dof] - coordinates[0][dof]) / period_s,
                reached_s: reached.map(|tick| tick as f64 * TICK_S),
                period_s,
            },
        )
    }

    /// How far the servos at `axes` will have yielded to the desired wrench at the coming instants; the first of them is
    /// kept for the next cycle.
    fn deviations(&mut self, settings: &Settings, axes: &Axes) -> [Axes; PREVIEW] {
        let r_from_s = settings.kinematics.forward(axes);
        let lever = self.posture.hanging_tcp(&r_from_s).translation.vector - r_from_s.translation.vector;
        let desired = &settings.desired;
        let at_s = join(desired.force, desired.moment + lever.cross(&desired.force));
        let torque = settings.kinematics.jacobian(axes).tr_mul(&at_s);
        let mut disturbance = self.disturbance;
        std::array::from_fn(|i| {
            for _ in 0..settings.period_ticks {
                disturbance.advance(&torque);
            }
            if i == 0 {
                self.disturbance = disturbance;
            }
            *disturbance.deviation()
        })
    }

    /// The axes at `coordinates`, each on the branch of its predecessor. What was planned before for the same place, a
    /// period later in the plan, is not computed again.
    fn inverse(
        &self,
        settings: &Settings,
        coordinates: &[Dofs; PREVIEW],
    ) -> Result<[Axes; PREVIEW], Unreachable> {
        let mut known = (self.plan.coordinates[0], self.plan.axes[0]);
        let mut axes = [known.1; PREVIEW];
        for (i, (wanted, slot)) in coordinates.iter().zip(&mut axes).enumerate() {
            let planned = self.plan.coordinates.get(i + 1).zip(self.plan.axes.get(i + 1));
            known = match planned {
                _ if known.0 == *wanted => known,
                Some((coordinates, axes)) if coordinates == wanted => (*wanted, *axes),
                _ => {
                    let pose = self.posture.sensor_pose(&self.frame.pose(wanted));
                    (*wanted, settings.kinematics.inverse(&pose, &known.1)?)
                }
            };
            *slot = known.1;
        }
        Ok(axes)
    }

    /// Bounds the way from the `actual` tcp to where set-points send it; whether that changes the first one.
    fn bound(&self, settings: &Settings, actual: &Axes, set_points: &mut [Axes; HORIZON]) -> bool {
        let tcp = |axes: &Axes| {
            let r_from_s = settings.kinematics.forward(axes);
            self.posture.hanging_tcp(&r_from_s).translation.vector
        };
        let (from, most) = (tcp(actual), settings.controller.max_lead_m);
        let mut binds = [false; HORIZON];
        for (set_point, binds) in set_points.iter_mut().zip(&mut binds) {
            let lead = (tcp(set_point) - from).norm();
            if lead > most {
                *set_point = actual + (*set_point - actual) * (most / lead);
                *binds = true;
            }
        }
        binds[0]
    }

    /// The point of the approach where the robot is to be at `tick`.
    fn path_point(&self, settings: &Settings, tick: i64) -> PathPoint {
        self.path.map_or(PathPoint::default(), |path| {
            path.approach.at(since(settings, path.start_tick, tick))
        })
    }
}

impl Path {
    /// From the height `start_m` (m) of the hanging tcp at `tick`, no faster than `impact` allows.
    fn new(
        settings: &Settings,
        expectation: &Expectation,
        impact: Option<&ImpactMonitor>,
        start_m: f64,
        tick: i64,
    ) -> Self {
        let (task, expected) = (&settings.task, &settings.controller.expected);
        let allowed = |speed: f64| impact.map_or(speed, |impact| impact.allowed_speed_m_per_s(speed));
        let speed = allowed(task.approach_speed_m_per_s);
        let reached = tick + settings.lead() * settings.period_ticks;
        let object = expectation
            .at(reached as f64 * TICK_S)
            .map(|(position, _)| position);
        // What the search begins above, and the least way worth speaking of.
        let free_m = |height_m: f64| (start_m - height_m - expected.search_margin_m).max(1e-4);
        let (approach, free_m) = match object {
            Some(object) => {
                let free_m = free_m(object.z);
                let search_m = expected.search_margin_m + task.search_depth_m;
                let approach =
                    Approach::with_search(free_m, speed, search_m, allowed(expected.search_speed_m_per_s));
                (approach, free_m)
            }
            None => {
                let length_m = start_m - (task.expected_height_m - task.search_depth_m);
                (Approach::new(length_m, speed), length_m)
            }
        };
        Self {
            approach,
            start_tick: tick,
            expected: object,
            free_m,
        }
    }
}

/// The compliance of a tcp that hangs as in `posture`, in r.
fn tcp_compliance(
    compliance: &Compliance,
    posture: &Posture,
    r_from_s: &Pose,
    selection: &Selection,
) -> TcpCompliance {
    let rotation = r_from_s.rotation.to_rotation_matrix().into_inner();
    let in_r = Compliance {
        translation: rotation * compliance.translation * rotation.transpose(),
        rotation: rotation * compliance.rotation * rotation.transpose(),
    };
    TcpCompliance::new(&in_r, posture.lever(), selection)
}

/// Time (s) at `tick` since the first set-point of the cycle at `start` is reached.
fn since(settings: &Settings, start: i64, tick: i64) -> f64 {
    (tick - start - settings.lead() * settings.period_ticks) as f64 * TICK_S
}

/// What the status tells.
impl Motion {
    /// `r_from_ta1`: the deflected tcp at the newest sample.
    pub(crate) fn tcp_pose(&self) -> &Pose {
        &self.newest.r_from_ta1
    }

    pub(crate) fn deflection(&self) -> &Deflection {
        &self.newest.sample.deflection
    }

    /// Contact force along the normal at the newest sample as contact detection sees it, N.
    pub(crate) fn normal_force_n(&self) -> f64 {
        self.newest.normal_force_n
    }

    /// Contact force along the normal at the newest sample, N, with the moments that are controlled accounted for.
    pub(crate) fn force_n(&self) -> f64 {
        if self.contact.is_some() && self.selection.contains(NORMAL) {
            self.newest.wrench[NORMAL]
        } else {
            self.newest.normal_force_n
        }
    }

    /// How far the tcp yields to what it touches at the newest sample, m.
    pub(crate) fn yields_by_m(&self) -> f64 {
        self.newest.yields_by_m
    }

    pub(crate) fn threshold_n(&self) -> f64 {
        self.detector.threshold_n()
    }

    pub(crate) fn saturated(&self) -> bool {
        self.newest.sample.flags.saturated
    }

    /// The impact that the present speed would cause, or that of the contact.
    pub(crate) fn impact(&self) -> ImpactAssessment {
        self.impact
            .as_ref()
            .map(ImpactMonitor::assessment)
            .unwrap_or_default()
    }

    /// Whether the allowed force of the impact slows the approach.
    pub(crate) fn slowed(&self, settings: &Settings) -> bool {
        let requested = settings.task.approach_speed_m_per_s;
        self.impact
            .as_ref()
            .is_some_and(|impact| impact.allowed_speed_m_per_s(requested) < requested)
    }

    pub(crate) fn in_contact(&self) -> bool {
        self.contact.is_some()
    }

    /// Tick of the sample that detected the contact.
    pub(crate) fn contact_tick(&self) -> Option<i64> {
        self.contact.map(|contact| contact.sample_tick)
    }

    /// `r_from_o` with the tcp's pose where no law knows the object, and its velocity, m/s; `None` before a contact.
    pub(crate) fn object(&self) -> Option<(Pose, Vector3<f64>)> {
        let known = |dof| self.force_control.object(dof);
        self.selection.iter().find_map(known)?;
        let mut coordinates = self.frame.coordinates(&self.newest.r_from_ta1);
        let mut velocity = Vector3::zeros();
        for (dof, (position, rate)) in (0..6).filter_map(|dof| Some((dof, known(dof)?))) {
            coordinates[dof] = position;
            if dof < 3 {
                velocity[dof] = rate;
            }
        }
        Some((self.frame.pose(&coordinates), velocity))
    }
}
