//! Experiments: the whole loop in one process, the three programs, and what is measured of them.

pub mod bound;
pub mod calibrate;
pub mod compare;
pub mod conditions;
pub mod conform;
pub mod detection;
pub mod doctor;
pub mod figure;
pub mod free_motion;
pub mod impact;
pub mod in_process;
pub mod launch;
pub mod linear;
pub mod log;
pub mod metrics;
pub mod network;
pub mod out;
pub mod program;
pub mod report;
pub mod run_port;
pub mod scenarios;
pub mod sweep;
pub mod table;
pub mod transcript;
pub mod tuning;
pub mod up;
