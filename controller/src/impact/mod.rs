//! Assessment of the impact, the paper's section IV: the force of the first milliseconds of a contact, which no
//! sensor behind the tool measures and no controller of this sampling time can change.
//!
//! Pure, one file per idea. Along the contact's normal; `h` is the indentation (m), `v` the speed of the tcp
//! towards the object (m/s), `M` the effective mass there (kg).
//!
//! | Idea | File | Paper |
//! |---|---|---|
//! | reaction force of a penetrating body | [`kick`] | (13) |
//! | what a mass at a speed does to it, by energy; the inverse questions | [`strike`] | (13), (14) |
//! | the same by integration, as a check and to draw | [`numerical`] | (14) |
//! | the paper's own example | [`flat_punch`] | (15)-(18) |
//! | the way out: restitution, remaining indentation | [`rebound`] | below (13), (18) |
//! | the tool comes back to an object that it bounces off | [`bounce`] | none |
//! | both partners' material | [`modulus`] | footnote 9 |
//! | from material and shape to (13)'s constants | [`shape`] | IV-B, footnote 9 |
//! | which mass strikes | [`effective_mass`] | M of (14) |
//! | the running controller's assessment | [`monitor`], [`speed`] | IV-C |
//! | contact of a robot with a person | [`transient_contact`] | none |
//!
//! Validity: one point in contact, one dimension, no friction, no damping, a half space that yields quasi-statically
//! (the impact lasts longer than waves take through the bodies), and nothing else that acts on the mass in that time:
//! the sensor behind it is too soft to matter when its own period is long against the impact.

pub mod bounce;
pub mod effective_mass;
pub mod flat_punch;
pub mod kick;
pub mod modulus;
pub mod monitor;
pub mod numerical;
pub mod quantity;
pub mod rebound;
pub mod shape;
pub mod speed;
pub mod strike;
pub mod transient_contact;

pub use effective_mass::ToolInertia;
pub use flat_punch::FlatPunch;
pub use kick::KicksLaw;
pub use modulus::Material;
pub use monitor::ImpactMonitor;
pub use quantity::ImpactError;
pub use rebound::Rebound;
pub use shape::{Dimension, Shape};
pub use strike::{Impact, Striker, Surface};
pub use transient_contact::TransientContact;

#[cfg(test)]
mod tests;
