//! What people watch while a cell is at work: what has been heard ([`View`]), what is shown of it ([`Snapshot`]), and where:
//! in a terminal ([`screen`]), as lines ([`Lines`]), in a browser ([`web`]).
//!
//! Nothing is ever sent. [`Ear`] takes what has come in the meantime at once, some ten times a second, from queues that
//! drop the oldest, so that nobody waits for who watches.

mod ear;
mod lines;
mod points;
mod rows;
pub mod screen;
mod stream;
mod view;
pub mod web;

pub use ear::Ear;
pub use lines::Lines;
pub use points::{Point, Points, WINDOW_S};
pub use rows::{
    ClockRow, ControllerRow, DetectionRow, ImpactRow, NodeRow, ObjectRow, Percentiles, RobotRow, SensorRow,
    Snapshot,
};
pub use view::{Heard, View};

#[cfg(test)]
mod tests;
