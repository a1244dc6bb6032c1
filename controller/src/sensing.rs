//! What a sample of the sensor stands for: its zero, its compliance as it is known, and whether the zero drifts.

use crate::adaptation::Adaptation;
use crate::drift::DriftWatch;
use crate::tare::Tare;
use node::scenario::{self, SensorOutput};
use spatial::ports::DeflectionSample;
use spatial::{Compliance, Deflection, TICK_S};

/// The sensor as the controller knows it.
#[derive(Clone, Debug)]
pub(crate) struct Sensing {
    output: SensorOutput,
    configured: Compliance,
    tare: Tare,
    /// The tare is complete.
    tared: bool,
    /// What the configured compliance made of the tare's wrench then, so that another one does not move the zero.
    zero: Option<Deflection>,
    /// A sample of the tare was at the end of its range.
    saturated: bool,
    drift: DriftWatch,
    adaptation: Option<Adaptation>,
}

impl Sensing {
    /// Not tared yet, with the `configured` compliance.
    pub(crate) fn new(controller: &scenario::Controller, configured: Compliance) -> Self {
        let adaptation = &controller.adaptation;
        Self {
            output: controller.sensor_output,
            configured,
            tare: Tare::default(),
            tared: false,
            zero: None,
            saturated: false,
            drift: DriftWatch::new(controller.drift_limit_n),
            adaptation: (adaptation.enabled).then(|| Adaptation::new(adaptation, configured)),
        }
    }

    /// Whether a sample tells anything: it was taken, and it carries the output that is used.
    pub(crate) fn usable(&self, sample: &DeflectionSample) -> bool {
        let flags = sample.flags;
        match self.output {
            SensorOutput::Deflection => flags.valid,
            SensorOutput::Force => flags.valid && flags.wrench_measured,
        }
    }

    /// The deflection that a sample stands for. Paper (3), (4): a sensor that outputs forces is turned back into
    /// one that outputs deflections, with the compliance as it is known. What is adapted of it acts on the force beyond
    /// the tare alone, so that the zero stays where it is.
    pub(crate) fn deflection(&self, sample: &DeflectionSample) -> Deflection {
        match self.output {
            SensorOutput::Deflection => sample.deflection,
            SensorOutput::Force if self.tared => {
                self.zero() + self.compliance() * (sample.wrench - self.tare.wrench())
            }
            SensorOutput::Force => self.configured * sample.wrench,
        }
    }

    /// The deflection that counts as zero force; of forces that which the configured compliance gives their tare.
    pub(crate) fn zero(&self) -> Deflection {
        match self.output {
            SensorOutput::Deflection => self.tare.deflection(),
            SensorOutput::Force => self.zero.unwrap_or(self.configured * self.tare.wrench()),
        }
    }

    /// Another `configured` compliance.
    pub(crate) fn configure(&mut self, configured: Compliance) {
        self.configured = configured;
        if let Some(adaptation) = &mut self.adaptation {
            adaptation.configure(configured);
        }
    }

    /// Forget the tare, to take another one.
    pub(crate) fn tare_anew(&mut self) {
        self.tare = Tare::default();
        (self.tared, self.zero, self.saturated) = (false, None, false);
        self.drift = self.drift.anew();
    }

    /// Whether a sample of the tare was at the end of its range.
    pub(crate) fn saturated(&self) -> bool {
        self.saturated
    }

    /// The compliance as it is known: configured or adapted.
    pub(crate) fn compliance(&self) -> Compliance {
        self.adaptation
            .map_or(self.configured, |adaptation| adaptation.compliance())
    }

    /// Whether the compliance is adapted.
    pub(crate) fn adapts(&self) -> bool {
        self.adaptation.is_some()
    }

    /// Confidence in the adapted compliance, 0 to 1.
    pub(crate) fn confidence(&self) -> f64 {
        self.adaptation.map_or(0.0, |adaptation| adaptation.confidence())
    }

    /// Take a sample at standstill into the tare; it displaces the tcp by `normal_m` (m) along the contact's normal.
    pub(crate) fn take_at_rest(&mut self, sample: &DeflectionSample, normal_m: f64) {
        self.saturated |= sample.flags.saturated;
        self.tare.add(sample, normal_m);
    }

    /// The noise (m rms) of the tcp's displacement along the normal, once there are `tare_s` (s) of samples to tare with.
    pub(crate) fn finish_tare(&mut self, tare_s: f64) -> Option<f64> {
        self.tared = f64::from(self.tare.count()) >= libm::rint(tare_s / TICK_S).max(1.0);
        if self.tared && self.output == SensorOutput::Force {
            self.zero = Some(self.configured * self.tare.wrench());
        }
        self.tared.then(|| self.tare.noise_m())
    }

    /// Watch the zero: the force (N) along the normal that a sample shows without contact.
    pub(crate) fn take_free(&mut self, force_n: f64) {
        self.drift.take(force_n);
    }

    /// Take a sample `in_contact_s` after the contact was detected: what it tells of the compliance.
    pub(crate) fn take_in_contact(&mut self, sample: &DeflectionSample, in_contact_s: f64) {
        let measured = sample.flags.wrench_measured && !sample.flags.saturated;
        if let (Some(adaptation), true) = (&mut self.adaptation, measured) {
            let deflection = sample.deflection - self.tare.deflection();
            adaptation.take(in_contact_s, &deflection, &(sample.wrench - self.tare.wrench()));
        }
    }

    /// Whether the zero has drifted beyond its limit.
    pub(crate) fn drifts(&self) -> bool {
        self.drift.exceeds()
    }
}
