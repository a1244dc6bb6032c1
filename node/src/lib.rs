//! What every process of Touchdown does once.
//!
//! [`scenario`]: one TOML file per experiment, read by all nodes.

pub mod scenario;
