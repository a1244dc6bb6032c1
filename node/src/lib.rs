//! What every process of Touchdown does once.
//!
//! | Idea | Module |
//! |---|---|
//! | one TOML file per experiment, read by all nodes | [`scenario`] |
//! | who answers what in lockstep (pure) | [`lockstep`] |
//! | whether two nodes may work together (pure) | [`greeting`] |
//! | the only place that reads a clock | [`clock`] |
//! | flags, configuration, logging, signals, links and records of a process | [`shell`] |
//! | what a process publishes of itself | [`health`] |
//! | what ends a process's work | [`problem`] |
//! | what a process has published, in an LCM event log | [`record`] |

pub mod clock;
pub mod greeting;
pub mod health;
pub mod lockstep;
pub mod problem;
pub mod record;
pub mod scenario;
pub mod shell;
