//! How one declaration of a section becomes a struct, its defaults and the list of its keys.

use super::{Scenario, choice::Choice};
use std::ops::RangeInclusive;

/// One key of a scenario, as the reference and the tests see it.
#[derive(Clone, Debug, PartialEq)]
pub struct Key {
    /// Section and name, such as `robot.filter_frequency_hz`.
    pub path: &'static str,
    /// Unit that the name's suffix stands for; empty: none.
    pub unit: &'static str,
    /// What the key accepts.
    pub allowed: Allowed,
    /// Default in TOML.
    pub default: String,
    /// What it means.
    pub doc: &'static str,
}

impl Key {
    /// The section, such as `robot` or `controller.pd`.
    pub fn section(&self) -> &'static str {
        split(self.path).0
    }

    /// The name within the section.
    pub fn name(&self) -> &'static str {
        split(self.path).1
    }
}

/// The section (at the top level: empty) that `path` lies in, and its name therein.
pub(super) fn split(path: &str) -> (&str, &str) {
    path.rsplit_once('.').unwrap_or(("", path))
}

/// One section of a scenario, as the reference sees it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Section {
    /// Its name, such as `robot` or `controller.pd`; empty: the top level.
    pub path: &'static str,
    /// What it is about.
    pub doc: &'static str,
}

/// What a key accepts.
#[derive(Clone, Debug, PartialEq)]
pub enum Allowed {
    /// A number.
    Number(RangeInclusive<f64>),
    /// An array of numbers, each within the limits.
    Array(RangeInclusive<f64>, usize),
    /// Any number of numbers, each within the limits.
    List(RangeInclusive<f64>),
    /// A whole number.
    Integer(RangeInclusive<i64>),
    /// `true` or `false`.
    Flag,
    /// One of these words.
    Word(&'static [&'static str]),
}

/// A key together with the place of its value in a [`Scenario`].
pub(super) struct Field<'a> {
    pub(super) path: &'static str,
    pub(super) doc: &'static str,
    pub(super) slot: Slot<'a>,
}

/// The place of a value, and what may be put there.
pub(super) enum Slot<'a> {
    Number(&'a mut f64, RangeInclusive<f64>),
    Array(&'a mut [f64], RangeInclusive<f64>),
    List(&'a mut Vec<f64>, RangeInclusive<f64>),
    Integer(&'a mut i64, RangeInclusive<i64>),
    Flag(&'a mut bool),
    Choice(&'a mut dyn Choice),
}

/// A type that a key can have.
pub(super) trait Entry {
    /// How its limits are declared.
    type Limits;

    fn slot(&mut self, limits: Self::Limits) -> Slot<'_>;
}

impl Entry for f64 {
    type Limits = RangeInclusive<f64>;

    fn slot(&mut self, limits: Self::Limits) -> Slot<'_> {
        Slot::Number(self, limits)
    }
}

impl<const N: usize> Entry for [f64; N] {
    type Limits = RangeInclusive<f64>;

    fn slot(&mut self, limits: Self::Limits) -> Slot<'_> {
        Slot::Array(self, limits)
    }
}

impl Entry for Vec<f64> {
    type Limits = RangeInclusive<f64>;

    fn slot(&mut self, limits: Self::Limits) -> Slot<'_> {
        Slot::List(self, limits)
    }
}

impl Entry for i64 {
    type Limits = RangeInclusive<i64>;

    fn slot(&mut self, limits: Self::Limits) -> Slot<'_> {
        Slot::Integer(self, limits)
    }
}

impl Entry for bool {
    type Limits = ();

    fn slot(&mut self, (): ()) -> Slot<'_> {
        Slot::Flag(self)
    }
}

impl<C: Choice> Entry for C {
    type Limits = ();

    fn slot(&mut self, (): ()) -> Slot<'_> {
        Slot::Choice(self)
    }
}

/// Declares a section: `key: type = default, in limits;` with a doc comment each, and the sections inside it.
macro_rules! section {
    (
        $(#[doc = $section_doc:literal])+
        $name:ident at $path:literal $(with $($inner:ident: $Inner:ident),+)? {
            $(
                $(#[doc = $doc:literal])+
                $key:ident: $type:ty = $default:expr $(, in $limits:expr)?;
            )*
        }
    ) => {
        $(#[doc = $section_doc])+
        #[derive(Clone, Debug, PartialEq)]
        pub struct $name {
            $(
                $(#[doc = $doc])+
                #[doc = concat!(
                    "\n\nDefault `", stringify!($default), "`",
                    $(", limits `", stringify!($limits), "`",)? ".",
                )]
                pub $key: $type,
            )*
            $($(
                #[doc = concat!("Section [`", stringify!($Inner), "`].")]
                pub $inner: $Inner,
            )+)?
        }

        impl Default for $name {
            fn default() -> Self {
                Self {
                    $($key: $default,)*
                    $($($inner: $Inner::default(),)+)?
                }
            }
        }

        impl $name {
            /// Every key with the place of its value, in the order of declaration.
            pub(in crate::scenario) fn fields(&mut self) -> impl Iterator<Item = $crate::scenario::schema::Field<'_>> {
                let own = [$($crate::scenario::schema::Field {
                    path: concat!($path, ".", stringify!($key)),
                    doc: concat!($($doc),+).trim_ascii(),
                    slot: $crate::scenario::schema::Entry::slot(&mut self.$key, ($($limits)?)),
                }),*];
                own.into_iter()$($(.chain(self.$inner.fields()))+)?
            }

            /// This section and those inside it, in the order of declaration.
            pub(in crate::scenario) fn with_inner() -> impl Iterator<Item = $crate::scenario::schema::Section> {
                let own = $crate::scenario::schema::Section {
                    path: $path,
                    doc: concat!($($section_doc),+).trim_ascii(),
                };
                std::iter::once(own)$($(.chain($Inner::with_inner()))+)?
            }
        }
    };
}
pub(super) use section;

impl Scenario {
    /// Every key there is, in the order of declaration.
    pub fn keys() -> Vec<Key> {
        Self::default().fields().map(describe).collect()
    }

    /// Every section there is, in the order of declaration; `program.step`, whose keys are those of
    /// [`Step::keys`](super::Step::keys), among them.
    pub fn sections() -> Vec<Section> {
        Self::with_inner()
            .filter(|section| !section.path.is_empty())
            .collect()
    }

    /// What the key `path` accepts, if it is a number or an array of numbers.
    pub fn limits(path: &str) -> Option<RangeInclusive<f64>> {
        match Self::default()
            .fields()
            .find(|field| field.path == path)?
            .slot
            .allowed()
        {
            Allowed::Number(limits) | Allowed::Array(limits, _) => Some(limits),
            _ => None,
        }
    }
}

/// A field as a key.
pub(super) fn describe(field: Field<'_>) -> Key {
    Key {
        path: field.path,
        unit: unit(field.path),
        default: field.slot.to_toml(),
        allowed: field.slot.allowed(),
        doc: field.doc,
    }
}

impl Slot<'_> {
    fn allowed(&self) -> Allowed {
        match self {
            Self::Number(_, limits) => Allowed::Number(limits.clone()),
            Self::Array(values, limits) => Allowed::Array(limits.clone(), values.len()),
            Self::List(_, limits) => Allowed::List(limits.clone()),
            Self::Integer(_, limits) => Allowed::Integer(limits.clone()),
            Self::Flag(_) => Allowed::Flag,
            Self::Choice(choice) => Allowed::Word(choice.words()),
        }
    }

    pub(super) fn to_toml(&self) -> String {
        match self {
            Self::Number(value, _) => format!("{value:?}"),
            Self::Array(values, _) => format!("{values:?}"),
            Self::List(values, _) => format!("{values:?}"),
            Self::Integer(value, _) => value.to_string(),
            Self::Flag(value) => value.to_string(),
            Self::Choice(choice) => format!("{:?}", choice.word()),
        }
    }
}

/// Suffixes of names and the units they stand for; of those that fit, the longest counts.
const UNITS: &[(&str, &str)] = &[
    ("_hz", "Hz"),
    ("_kg", "kg"),
    ("_kg_m2", "kg m^2"),
    ("_m", "m"),
    ("_m_per_n", "m/N"),
    ("_m_per_s", "m/s"),
    ("_m_per_s2", "m/s^2"),
    ("_n", "N"),
    ("_n_per_m", "N/m"),
    ("_nm", "Nm"),
    ("_nm_per_rad", "Nm/rad"),
    ("_nms_per_rad", "Nms/rad"),
    ("_ns_per_m", "Ns/m"),
    ("_per_h", "1/h"),
    ("_per_s", "1/s"),
    ("_periods", "periods"),
    ("_rad", "rad"),
    ("_rad_per_nm", "rad/Nm"),
    ("_rad_per_s", "rad/s"),
    ("_rad_per_s2", "rad/s^2"),
    ("_s2", "s^2"),
    ("_s", "s"),
    ("_ticks", "ticks"),
];

/// The unit of the key `path` (or of its element `path[i]`) by the suffix of its name; empty: none.
pub(super) fn unit(path: &str) -> &'static str {
    let name = split(path).1.split('[').next().unwrap_or_default();
    let fitting = UNITS.iter().filter(|(suffix, _)| name.ends_with(suffix));
    fitting
        .max_by_key(|(suffix, _)| suffix.len())
        .map_or("", |(_, unit)| unit)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_longest_suffix_is_the_unit() {
        assert_eq!(unit("robot.position_gain_per_s"), "1/s");
        assert_eq!(unit("task.approach_speed_m_per_s"), "m/s");
        assert_eq!(unit("tool.tcp_in_s_m[2]"), "m");
        assert_eq!(unit("program.step[3].position_m[2]"), "m");
        assert_eq!(unit("sensor.stiffness_nm_per_rad"), "Nm/rad");
    }

    #[test]
    fn every_number_has_a_unit_or_is_known_to_have_none() {
        let plain: Vec<_> = Scenario::keys()
            .into_iter()
            .filter(|key| key.unit.is_empty() && !matches!(key.allowed, Allowed::Word(_)))
            .map(|key| key.path)
            .collect();
        assert_eq!(
            plain,
            [
                "timing.seed",
                "network.loss_ratio",
                "robot.gear_damping",
                "robot.filter_damping",
                "sensor.wrench_measured",
                "object.rebound_ratio",
                "object.exponent",
                "object.friction",
                "object_sensor.enabled",
                "task.starts_by_itself",
                "task.force_controlled.x",
                "task.force_controlled.y",
                "task.force_controlled.z",
                "task.force_controlled.about_x",
                "task.force_controlled.about_y",
                "task.force_controlled.about_z",
                "controller.filter_damping",
                "controller.plausible_mass_ratio",
                "controller.proposed.object_filter_gain",
                "controller.proposed.settled_filter_gain",
                "controller.proposed.disturbance_feed_forward",
                "controller.ros2.filter_gain",
                "controller.ros2.damping_ratio",
                "controller.fzi.proportional_translation",
                "controller.fzi.proportional_rotation",
                "controller.fzi.error_scale",
                "controller.expected.filter_gain",
                "controller.gears.damping_ratio",
                "controller.elastic.contact_weight",
                "controller.elastic.linear_range",
                "controller.elastic.governed_range",
                "controller.elastic.mode_spread",
                "controller.elastic.likelihood_memory",
                "controller.shaping.mode_error",
                "controller.adaptation.enabled",
                "controller.adaptation.gain",
                "controller.adaptation.minimum_ratio",
                "controller.adaptation.maximum_ratio",
                "controller.impact.exponent",
                "controller.impact.rebound_ratio",
                "controller.cusum.enabled",
                "controller.collision.enabled",
                "controller.oscillation.enabled",
                "controller.oscillation.least_gain",
                "controller.limits.velocity_ratio",
                "controller.limits.lead_ratio",
                "controller.limits.reversal_ratio",
            ]
        );
    }
}
