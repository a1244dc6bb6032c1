//! What every process of Touchdown does once.
//!
//! | Idea | Module |
//! |---|---|
//! | one TOML file per experiment, read by all nodes | [`scenario`] |
//! | who answers what in lockstep (pure) | [`lockstep`] |
//! | whether two nodes may work together (pure) | [`greeting`] |
//! | the only place that reads a clock | [`clock`] |
//! | how a peer's clock differs, from four time stamps (pure) | [`clock_sync`] |
//! | whom a node works with in real time (pure) | [`peers`] |
//! | who has sent a message, and whether it is new (pure) | [`authenticity`] |
//! | the files that hold the keys for that | [`key_file`] |
//! | the robot's states, and who may command it (pure) | [`robot_states`] |
//! | which commands a robot can execute (pure) | [`guard`] |
//! | from set-points to each tick's (pure) | [`command_path`] |
//! | what a robot does with commands: the three above as one (pure) | [`commanded`] |
//! | real-time rights | [`rights`] |
//! | flags, configuration, logging, signals, links and records of a process | [`shell`] |
//! | what a process publishes of itself | [`health`] |
//! | what ends a process's work | [`problem`] |
//! | what a process has published, in an LCM event log | [`record`] |
//! | the last seconds of it, once a fault latches | [`flight`] |

pub mod authenticity;
pub mod clock;
pub mod clock_sync;
pub mod command_path;
pub mod commanded;
pub mod flight;
pub mod greeting;
pub mod guard;
pub mod health;
pub mod key_file;
pub mod lockstep;
pub mod peers;
pub mod problem;
pub mod record;
pub mod rights;
pub mod robot_states;
pub mod scenario;
pub mod shell;
