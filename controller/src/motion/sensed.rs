//! What a sample of the sensor says about the contact.

use crate::Settings;
use crate::contact::Touch;
use crate::dofs::{Dofs, NORMAL, Selection, TcpCompliance, displacement};
use crate::posture::Posture;
use crate::shaping::Point;
use spatial::kinematics::{Axes, split};
use spatial::ports::SampleFlags;
use spatial::{Deflection, Pose};

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

/// What a sample says.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sensed {
    pub(super) sample: Sample,
    /// `r_from_ta1`: where the deflected tcp is, (12).
    pub(super) r_from_ta1: Pose,
    /// Where the tcp would be without contact.
    pub(super) hanging: Pose,
    /// Force along the normal if it is the only one, N.
    pub(super) normal_force_n: f64,
    /// Wrench along the selected degrees of freedom, N and Nm.
    pub(super) wrench: Dofs,
    /// How far the tcp has yielded, m.
    pub(super) yields_by_m: f64,
}

impl Sensed {
    /// What `sample` says with the sensor frame at `r_from_s`.
    pub(super) fn new(
        sample: &Sample,
        r_from_s: &Pose,
        posture: &Posture,
        compliance: &TcpCompliance,
    ) -> Self {
        let r_from_ta1 = posture.deflected_tcp(r_from_s, &sample.deflection);
        let hanging = posture.hanging_tcp(r_from_s);
        let displaced = displacement(&hanging, &r_from_ta1);
        Self {
            sample: *sample,
            r_from_ta1,
            hanging,
            normal_force_n: displaced[NORMAL] / compliance.along(NORMAL),
            wrench: compliance.wrench(&displaced),
            yields_by_m: split(&displaced).0.norm(),
        }
    }
}

/// A contact that was detected.
#[derive(Clone, Copy, Debug)]
pub(super) struct Contact {
    /// Tick of the sample that detected it.
    pub(super) sample_tick: i64,
    /// Tick of the cycle that learned of it.
    pub(super) cycle_tick: i64,
    /// Where on its way the robot will be then, when what it is told can act.
    pub(super) met: Point,
    /// Where the deflected tcp was then, m in r.
    pub(super) height_m: f64,
    /// Time over which the posture is taken, s.
    pub(super) tilt_time_s: f64,
    /// No law acts any more: the tool is held where it is, or leaves the object.
    pub(super) released: bool,
    /// Whether the tool has lost the object.
    pub(super) lost: bool,
    /// Whether the newest sample shows less force than a contact: the tool may be in the air.
    pub(super) airborne: bool,
    /// Tick of the newest sample in contact.
    touched_tick: i64,
}

/// How long the tool stays in the air after an impact at most (PLANT.md section 7: some 5 ms).
pub(super) const LONGEST_BOUNCE_TICKS: i64 = 30;

impl Contact {
    /// Detected by what was `sensed` in the cycle at `cycle_tick`, with the robot at `met` on its way when that can act.
    pub(super) fn new(settings: &Settings, sensed: &Sensed, cycle_tick: i64, met: Point) -> Self {
        Self {
            sample_tick: sensed.sample.tick,
            cycle_tick,
            met,
            height_m: sensed.r_from_ta1.translation.vector[NORMAL],
            tilt_time_s: settings.controller.tilt_time_s,
            released: false,
            lost: false,
            airborne: false,
            touched_tick: sensed.sample.tick,
        }
    }

    /// Whether what was `sensed` was sensed in contact: along the normal, or, where that is not force controlled, along
    /// what is. Half of a small desired force is contact, too.
    pub(super) fn touch(&mut self, settings: &Settings, selection: &Selection, sensed: &Sensed) -> Touch {
        let least_n = settings
            .controller
            .detection_threshold_n
            .min(0.5 * settings.task.desired_force_n);
        let force_n = if selection.contains(NORMAL) {
            sensed.normal_force_n.max(sensed.wrench[NORMAL])
        } else {
            split(&sensed.wrench).0.norm()
        };
        self.airborne = force_n < least_n;
        // What the cumulative sum has detected is a contact, however small.
        if !self.airborne || sensed.sample.tick == self.sample_tick {
            self.touched_tick = sensed.sample.tick;
        }
        match sensed.sample.tick - self.touched_tick {
            0 => Touch::Contact,
            ..=LONGEST_BOUNCE_TICKS => Touch::Bounce,
            _ => Touch::Lost,
        }
    }
}
