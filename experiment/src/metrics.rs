//! What is measured of a run: peak, settling, IAE, steady error, orientation (PLANT.md section 6).

use crate::transcript::{self, Entry};
use nalgebra::{UnitQuaternion, Vector3};
use node::scenario::Scenario;
use serde::Serialize;
use spatial::ports::{ControllerStatus, Truth};
use spatial::{TICK_S, rotation};

/// How long after the first contact is judged, s.
pub const WINDOW_S: f64 = 1.5;
/// The end of that window, over which steady values are averaged, s.
const STEADY_S: f64 = 0.3;

/// The figures of one run. `null` in JSON: no contact, or never settled.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Metrics {
    /// Largest contact force as the tcp's deflection shows it, N.
    pub peak_n: f64,
    /// Last exit from desired force +- 10 %, s after the first contact.
    pub settling_10_s: f64,
    /// Last exit from desired force +- 2 %, s after the first contact.
    pub settling_2_s: f64,
    /// Integral of the force error's magnitude, N s.
    pub iae_n_s: f64,
    /// Mean of the true contact force minus the desired one at the end, N.
    pub steady_error_n: f64,
    /// Largest deviation of the tool's orientation from that before contact, rad.
    pub orientation_max_rad: f64,
    /// The same at the end, rad.
    pub orientation_end_rad: f64,
}

impl Metrics {
    /// Names of the figures, in the order of [`Metrics::values`].
    pub const NAMES: [&'static str; 7] = [
        "peak_n",
        "settling_10_s",
        "settling_2_s",
        "iae_n_s",
        "steady_error_n",
        "orientation_max_rad",
        "orientation_end_rad",
    ];

    /// The figures in the order of [`Metrics::NAMES`].
    pub fn values(&self) -> [f64; 7] {
        [
            self.peak_n,
            self.settling_10_s,
            self.settling_2_s,
            self.iae_n_s,
            self.steady_error_n,
            self.orientation_max_rad,
            self.orientation_end_rad,
        ]
    }

    /// The figures in the order of [`Metrics::NAMES`].
    pub fn from_values(values: [f64; 7]) -> Self {
        let [
            peak_n,
            settling_10_s,
            settling_2_s,
            iae_n_s,
            steady_error_n,
            orientation_max_rad,
            orientation_end_rad,
        ] = values;
        Self {
            peak_n,
            settling_10_s,
            settling_2_s,
            iae_n_s,
            steady_error_n,
            orientation_max_rad,
            orientation_end_rad,
        }
    }
}

/// The contact force over time as analysis sees it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ForceCurve {
    /// Time after the first contact, s.
    pub time_s: Vec<f64>,
    /// Force, N.
    pub force_n: Vec<f64>,
}

/// The truth of a run, tick by tick, as far as analysis needs it.
#[derive(Clone, Debug)]
pub struct Recording {
    standstill_ticks: i64,
    desired_force_n: f64,
    stiffness_n_per_m: f64,
    stiffness_nm_per_rad: f64,
    tcp_in_s: Vector3<f64>,
    first_contact_s: Option<f64>,
    ticks: Vec<Sample>,
}

#[derive(Clone, Copy, Debug)]
struct Sample {
    time_s: f64,
    deflection_z_m: f64,
    rotation: UnitQuaternion<f64>,
    contact_force_n: f64,
}

impl Recording {
    /// Nothing recorded yet of a run of `scenario`.
    pub fn new(scenario: &Scenario) -> Self {
        Self {
            standstill_ticks: libm::floor(scenario.task.standstill_s / TICK_S) as i64,
            desired_force_n: scenario.task.desired_force_n,
            stiffness_n_per_m: scenario.sensor.stiffness_n_per_m,
            stiffness_nm_per_rad: scenario.sensor.stiffness_nm_per_rad,
            tcp_in_s: scenario.tool.tcp_in_s_m.into(),
            first_contact_s: None,
            ticks: Vec::new(),
        }
    }

    /// Take the truth of the next tick.
    pub fn push(&mut self, truth: &Truth) {
        if truth.first_contact_time_s >= 0.0 {
            self.first_contact_s = Some(truth.first_contact_time_s);
        }
        self.ticks.push(Sample {
            time_s: truth.stamp.step as f64 * TICK_S,
            deflection_z_m: truth.tcp_deflection.translation.z,
            rotation: truth.tcp_pose.rotation,
            contact_force_n: truth.contact_force.z,
        });
    }

    /// The recording of the truth in `entries`, and the force that the controller measured over time after the
    /// first contact; `None`: there was no contact.
    pub fn from_transcript(scenario: &Scenario, entries: &[Entry]) -> (Self, Option<ForceCurve>) {
        let mut recording = Self::new(scenario);
        transcript::messages::<Truth>(entries).for_each(|truth| recording.push(&truth));
        let measured = recording.first_contact_s.map(|contact| {
            let mut curve = ForceCurve::default();
            for status in transcript::messages::<ControllerStatus>(entries) {
                curve.time_s.push(status.stamp.step as f64 * TICK_S - contact);
                curve.force_n.push(status.detection.statistic_n);
            }
            curve
        });
        (recording, measured)
    }

    /// What a spreadsheet needs, tick by tick: `time_s,force_n,contact_force_n,orientation_rad`, time after the
    /// first contact (after the start where there was none), force as [`Recording::force_curve`] has it.
    pub fn csv(&self) -> String {
        let mut text = String::from("time_s,force_n,contact_force_n,orientation_rad\n");
        let contact = self.first_contact_s.unwrap_or(0.0);
        let forces = self.forces().unwrap_or_default();
        let before = self
            .ticks
            .first()
            .map(|sample| sample.rotation)
            .unwrap_or_default();
        for (i, sample) in self.ticks.iter().enumerate() {
            let force = forces.get(i).copied().unwrap_or(0.0);
            let turned = rotation::log(&(sample.rotation * before.inverse())).norm();
            let time = sample.time_s - contact;
            text += &format!("{time:.6},{force:.6},{:.6},{turned:.9}\n", sample.contact_force_n);
        }
        text
    }

    /// Time of the first contact, s; `None`: there was none.
    pub fn first_contact_s(&self) -> Option<f64> {
        self.first_contact_s
    }

    /// The force over time after the first contact; `None` without contact.
    pub fn force_curve(&self) -> Option<ForceCurve> {
        let contact = self.first_contact_s?;
        Some(ForceCurve {
            time_s: self.ticks.iter().map(|sample| sample.time_s - contact).collect(),
            force_n: self.forces()?,
        })
    }

    /// The force `(s_t,z - mean at standstill) / C_tcp,zz` (N) at each tick, from the true motion before any signal
    /// chain; `None` before the standstill is recorded.
    ///
    /// Deviates from PLANT.md: C_tcp,zz = 1/K_p + (l_x^2 + l_y^2)/K_phi with the lever l of the *hanging* tool
    /// (28.05 instead of 28.27 um/N), which agrees with the true contact force at rest.
    fn forces(&self) -> Option<Vec<f64>> {
        let standstill = self.standstill()?;
        let count = standstill.len() as f64;
        let zero = standstill.iter().map(|sample| sample.deflection_z_m).sum::<f64>() / count;
        let lever = standstill[0].rotation * self.tcp_in_s;
        let compliance = 1.0 / self.stiffness_n_per_m + lever.xy().norm_squared() / self.stiffness_nm_per_rad;
        Some(
            self.ticks
                .iter()
                .map(|sample| (sample.deflection_z_m - zero) / compliance)
                .collect(),
        )
    }

    /// The figures; `None` without contact or with less than the judged window recorded after it.
    pub fn metrics(&self) -> Option<Metrics> {
        let curve = self.force_curve()?;
        let before = self.standstill()?[0].rotation;
        let start = curve.time_s.iter().position(|&t| t >= 0.0)?;
        let end = curve.time_s.iter().position(|&t| t > WINDOW_S)?;
        let desired = self.desired_force_n;
        let (time, force) = (&curve.time_s[start..end], &curve.force_n[start..end]);
        let error: Vec<f64> = force.iter().map(|f| f - desired).collect();
        let settled = |band: f64| {
            error
                .iter()
                .rposition(|e| e.abs() > band * desired)
                .map_or(0.0, |last| time[last] + TICK_S)
        };
        let ticks = &self.ticks[start..end];
        let turn = |sample: &Sample| rotation::log(&(sample.rotation * before.inverse()));
        let steady = &ticks[ticks.len() - libm::rint(STEADY_S / TICK_S) as usize..];
        let count = steady.len() as f64;
        Some(Metrics {
            peak_n: force.iter().copied().fold(0.0, f64::max),
            settling_10_s: settled(0.10),
            settling_2_s: settled(0.02),
            iae_n_s: error.iter().map(|e| e.abs()).sum::<f64>() * TICK_S,
            steady_error_n: steady.iter().map(|s| s.contact_force_n).sum::<f64>() / count - desired,
            orientation_max_rad: ticks.iter().map(|s| turn(s).norm()).fold(0.0, f64::max),
            orientation_end_rad: (steady.iter().map(turn).sum::<Vector3<f64>>() / count).norm(),
        })
    }

    fn standstill(&self) -> Option<&[Sample]> {
        let end = usize::try_from(self.standstill_ticks).ok()?.min(self.ticks.len());
        (end > 0).then(|| &self.ticks[..end])
    }
}
