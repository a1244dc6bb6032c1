//! Parameters that change at run time: checked as the scenario's file is, and brought to their new values smoothly.

use crate::approach::spread;
use crate::settings::Settings;
use node::scenario::Scenario;
use spatial::ports::TaskParameters;
use spatial::{Compliance, TICK_S};
use std::ops::RangeInclusive;

/// How many there are.
pub(crate) const COUNT: usize = TaskParameters::COUNT;

/// Index of the desired normal force.
pub(crate) const FORCE: usize = 0;
/// Indices of the desired wrench.
pub(crate) const WRENCH: std::ops::Range<usize> = 0..4;
const COMPLIANCE: std::ops::Range<usize> = 16..18;
/// Those that the loop's margins depend on: the force (a contact may be the stiffer the harder it is pressed), gains,
/// compliance.
pub(crate) const IN_THE_LOOP: [usize; 7] = [0, 11, 12, 14, 15, 16, 17];
/// Those that only the next approach or contact follows, or that are limits: set at once.
const AT_ONCE: [usize; 7] = [4, 5, 6, 8, 9, 11, 13];

/// The scenario's key of each, in the order of their bits.
const KEYS: [&str; COUNT] = [
    "task.desired_force_n",
    "task.desired_moment_nm",
    "task.desired_moment_nm",
    "task.desired_moment_nm",
    "task.approach_speed_m_per_s",
    "task.expected_height_m",
    "task.search_depth_m",
    "controller.detection_threshold_n",
    "task.max_impact_force_n",
    "task.max_contact_force_n",
    "controller.max_lead_m",
    "controller.proposed.object_filter_gain",
    "controller.proposed.reference_bandwidth_hz",
    "controller.tilt_time_s",
    "controller.pd.proportional_m_per_n",
    "controller.pd.derivative_m_per_n",
    "controller.compliance_m_per_n",
    "controller.compliance_rad_per_nm",
];

/// The place of parameter `i` in a scenario.
fn place(scenario: &mut Scenario, i: usize) -> &mut f64 {
    let (task, controller) = (&mut scenario.task, &mut scenario.controller);
    match i {
        0 => &mut task.desired_force_n,
        1..=3 => &mut task.desired_moment_nm[i - 1],
        4 => &mut task.approach_speed_m_per_s,
        5 => &mut task.expected_height_m,
        6 => &mut task.search_depth_m,
        7 => &mut controller.detection_threshold_n,
        8 => &mut task.max_impact_force_n,
        9 => &mut task.max_contact_force_n,
        10 => &mut controller.max_lead_m,
        11 => &mut controller.proposed.object_filter_gain,
        12 => &mut controller.proposed.reference_bandwidth_hz,
        13 => &mut controller.tilt_time_s,
        14 => &mut controller.pd.proportional_m_per_n,
        15 => &mut controller.pd.derivative_m_per_n,
        16 => &mut controller.compliance_m_per_n,
        _ => &mut controller.compliance_rad_per_nm,
    }
}

/// The place of parameter `i` in what is in force: of the desired wrench, in what is sought now.
fn in_force(settings: &mut Settings, i: usize) -> &mut f64 {
    let (task, controller) = (&mut settings.task, &mut settings.controller);
    match i {
        0 => &mut settings.desired.force.z,
        1..=3 => &mut settings.desired.moment[i - 1],
        4 => &mut task.approach_speed_m_per_s,
        5 => &mut task.expected_height_m,
        6 => &mut task.search_depth_m,
        7 => &mut controller.detection_threshold_n,
        8 => &mut task.max_impact_force_n,
        9 => &mut task.max_contact_force_n,
        10 => &mut controller.max_lead_m,
        11 => &mut controller.proposed.object_filter_gain,
        12 => &mut controller.proposed.reference_bandwidth_hz,
        13 => &mut controller.tilt_time_s,
        14 => &mut controller.pd.proportional_m_per_n,
        15 => &mut controller.pd.derivative_m_per_n,
        16 => &mut controller.compliance_m_per_n,
        _ => &mut controller.compliance_rad_per_nm,
    }
}

/// What one cycle's slewing has changed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Changed {
    /// The desired wrench or the compliance: the posture is to be planned anew.
    pub(crate) posture: bool,
    /// Anything at all.
    pub(crate) any: bool,
}

/// On its way from one value to another since a tick; `None`: since the coming cycle.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Ramp {
    from: f64,
    to: f64,
    start_tick: Option<i64>,
}

/// Which values can be asked for, which are in force, and which are on their way.
#[derive(Clone, Debug)]
pub(crate) struct Parameters {
    /// With the values that have been accepted.
    pub(crate) accepted: Box<Scenario>,
    limits: [RangeInclusive<f64>; COUNT],
    ramps: [Option<Ramp>; COUNT],
}

/// Why a value is not accepted: the limit, in its unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct OutOfRange {
    pub(crate) parameter: usize,
    pub(crate) limit: f64,
}

impl Parameters {
    /// As `scenario` says.
    pub(crate) fn new(scenario: &Scenario) -> Self {
        let unlimited = f64::MIN..=f64::MAX;
        Self {
            accepted: Box::new(scenario.clone()),
            limits: KEYS.map(|key| Scenario::limits(key).unwrap_or_else(|| unlimited.clone())),
            ramps: [None; COUNT],
        }
    }

    /// Accept all `values`, or none: each within its key's limits, and together with all others as a scenario's file
    /// would have to be. Not part of a cycle: this check allocates.
    pub(crate) fn accept(&mut self, values: &[Option<f64>; COUNT]) -> Result<(), OutOfRange> {
        if values.iter().all(Option::is_none) {
            return Ok(());
        }
        let mut changed = self.accepted.clone();
        let given = || (0..).zip(values).filter_map(|(i, value)| Some((i, (*value)?)));
        for (parameter, value) in given() {
            let limit = value.clamp(*self.limits[parameter].start(), *self.limits[parameter].end());
            if limit != value {
                return Err(OutOfRange { parameter, limit });
            }
            *place(&mut changed, parameter) = value;
        }
        if !changed.is_consistent() {
            // Some can only change together; the first one that can't change alone is named.
            let alone = given().find_map(|(i, value)| Some((i, self.limit_towards(i, value)?)));
            let (parameter, limit) = alone.unwrap_or((0, *place(&mut self.accepted, 0)));
            return Err(OutOfRange { parameter, limit });
        }
        self.accepted = changed;
        Ok(())
    }

    /// The last value on the way to `value` that is consistent with all others; `None`: that one is.
    fn limit_towards(&self, i: usize, value: f64) -> Option<f64> {
        let mut trial = self.accepted.clone();
        let mut holds = |value: f64| {
            *place(&mut trial, i) = value;
            trial.is_consistent()
        };
        if holds(value) {
            return None;
        }
        let (mut good, mut bad) = (*place(&mut self.accepted.clone(), i), value);
        for _ in 0..40 {
            let middle = 0.5 * (good + bad);
            if holds(middle) {
                good = middle;
            } else {
                bad = middle;
            }
        }
        Some(good)
    }

    /// Lead parameter `i` to `value` from the coming cycle on.
    pub(crate) fn lead(&mut self, settings: &mut Settings, i: usize, value: f64) {
        if AT_ONCE.contains(&i) {
            return self.set(settings, i, value);
        }
        let from = *in_force(settings, i);
        self.ramps[i] = (from != value).then_some(Ramp {
            from,
            to: value,
            start_tick: None,
        });
    }

    /// Set parameter `i` to `value` at once: where nothing follows it now.
    pub(crate) fn set(&mut self, settings: &mut Settings, i: usize, value: f64) {
        self.ramps[i] = None;
        *in_force(settings, i) = value;
    }

    /// Bring the values that are in force nearer to those that are asked for, in the cycle at `tick`.
    pub(crate) fn slew(&mut self, settings: &mut Settings, tick: i64) -> Changed {
        let mut changed = Changed::default();
        for (i, slot) in self.ramps.iter_mut().enumerate() {
            let Some(ramp) = slot else { continue };
            let elapsed_s = (tick - *ramp.start_tick.get_or_insert(tick)) as f64 * TICK_S;
            let share = spread(elapsed_s, settings.controller.slew_s).value;
            *in_force(settings, i) = if share < 1.0 {
                ramp.from + (ramp.to - ramp.from) * share
            } else {
                ramp.to
            };
            if share >= 1.0 {
                *slot = None;
            }
            changed.any = true;
            changed.posture |= WRENCH.contains(&i) || COMPLIANCE.contains(&i);
        }
        if changed.posture {
            let controller = &settings.controller;
            settings.compliance =
                Compliance::isotropic(controller.compliance_m_per_n, controller.compliance_rad_per_nm);
        }
        changed
    }
}
