//! libFuzzer on the target that `FUZZ_TARGET` names: see `run.sh`.
#![no_main]

#[path = "../targets.rs"]
mod targets;

use libfuzzer_sys::fuzz_target;
use std::sync::OnceLock;

fn target() -> targets::Target {
    static TARGET: OnceLock<targets::Target> = OnceLock::new();
    *TARGET.get_or_init(|| {
        let name = std::env::var("FUZZ_TARGET").unwrap_or_default();
        let known = targets::TARGETS.iter().find(|(known, _)| *known == name);
        known.map_or_else(|| panic!("FUZZ_TARGET is {name:?}, no target"), |(_, target)| *target)
    })
}

fuzz_target!(|bytes: &[u8]| target()(bytes));
