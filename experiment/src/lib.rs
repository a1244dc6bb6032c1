//! Experiments: the whole loop in one process, the three programs, and what is measured of them.

pub mod compare;
pub mod in_process;
pub mod metrics;
