//! What fuzzing has found worth keeping (`fuzz/corpus`), once more: see `make fuzz`.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test fails by panicking")]

#[allow(
    dead_code,
    reason = "of the modules that read something, only the reading is used"
)]
#[path = "../../fuzz/targets.rs"]
mod targets;

use std::fs;
use std::path::Path;

#[test]
fn every_corpus_is_survived() {
    let corpora = Path::new(env!("CARGO_MANIFEST_DIR")).join("../fuzz/corpus");
    for (name, target) in targets::TARGETS {
        let inputs: Vec<_> = fs::read_dir(corpora.join(name)).unwrap().collect();
        assert!(!inputs.is_empty(), "{name}");
        for input in inputs {
            target(&fs::read(input.unwrap().path()).unwrap());
        }
    }
}
