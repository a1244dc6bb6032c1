//! The loop's margins, as the controller published them last.

use ::experiment::transcript::{self, Entry};
use controller::margins::Assessment;
use serde::Serialize;
use spatial::ports::ControllerStatus;

/// Of one law, by what the controller assumes; `null`: not assessed.
#[derive(Clone, Debug, Serialize)]
pub(super) struct LoopMargins {
    law: String,
    gain_margin: Option<f64>,
    phase_margin_rad: Option<f64>,
}

impl LoopMargins {
    /// From what was said in a run of `law`.
    pub(super) fn of(law: &str, entries: &[Entry]) -> Self {
        let last = transcript::messages::<ControllerStatus>(entries).last();
        let known = last
            .map(|status| Assessment::of(&status))
            .filter(Assessment::known);
        Self {
            law: law.to_owned(),
            gain_margin: known.map(|found| found.gain_margin),
            phase_margin_rad: known.map(|found| found.phase_margin_rad),
        }
    }
}
