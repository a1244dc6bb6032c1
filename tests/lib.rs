//! What the multi-process tests need.

mod cell;
mod programs;
mod relay;

pub use cell::{Bench, processes_naming, signal, wait_for_end};
pub use programs::{programs, touchdown};
pub use relay::{Impairment, Relay};
