//! What the multi-process tests need.

mod attack;
mod cell;
pub mod faults;
pub mod hostile;
pub mod hosts;
mod programs;
mod relay;
pub mod site;

pub use attack::Attack;
pub use cell::{Bench, processes_naming, signal, wait_for_end};
pub use programs::{programs, touchdown};
pub use relay::{Impairment, Relay};
