//! Multi-process tests over real LCM, in one binary.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test fails by panicking"
)]

mod bits;
mod by_hand;
mod command;
mod conform;
mod doctor;
mod failures;
mod install;
mod logs;
mod network;
mod programs;
#[path = "../../lcmtypes/tests/wire/python.rs"]
mod python;
mod runs;
mod scripting;
mod spy;
mod up;
mod upkeep;
mod watch;
