//! The controller's phases and its latched fault, and what may follow what: pure.
//!
//! ```text
//! Init -> Sync <-> Ready <-> at work: Calibrate, or Approach, Contact, Settled, Retract, Search, Move among each other
//!           ^        ^
//!           +--------+----- Fault, from anywhere; out of it only by a reset
//! ```
//!
//! Who drives it says what has happened; what can't follow changes nothing.

use spatial::ports::{ControllerPhase, Fault};

/// Something that may end a phase.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Event {
    /// The robot has been heard of: zero force is being taken.
    Joined,
    /// Zero force has been taken.
    Tared,
    /// It is being taken anew.
    TaresAnew,
    /// A step of the program begins, or its contact stands otherwise: the phase that shows it.
    Works(ControllerPhase),
    /// Nothing is left to do.
    Rests,
    /// Something has gone wrong.
    Fails(Fault),
    /// A fault is cleared; whether zero force had been taken before it.
    Resets { tared: bool },
}

/// Phase and latched fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Phases {
    phase: ControllerPhase,
    fault: Fault,
}

impl Phases {
    /// Before anything has been heard.
    pub(crate) fn new() -> Self {
        Self {
            phase: ControllerPhase::Init,
            fault: Fault::None,
        }
    }

    /// The phase.
    pub(crate) fn phase(&self) -> ControllerPhase {
        self.phase
    }

    /// First cause of a latched fault.
    pub(crate) fn fault(&self) -> Fault {
        self.fault
    }

    /// Whether no fault is latched.
    pub(crate) fn well(&self) -> bool {
        self.fault == Fault::None
    }

    /// `event` has happened.
    pub(crate) fn take(&mut self, event: Event) {
        use ControllerPhase::{Calibrate, Fault as Failed, Init, Ready, Sync};
        self.phase = match (self.phase, event) {
            (Init, Event::Joined) => Sync,
            (Sync, Event::Tared) => Ready,
            (Ready, Event::TaresAnew) => Sync,
            (Ready, Event::Works(next)) if works(next) => next,
            (now, Event::Works(next))
                if works(now) && works(next) && now != Calibrate && next != Calibrate =>
            {
                next
            }
            (now, Event::Rests) if works(now) => Ready,
            (now, Event::Fails(fault)) if fault != Fault::None => {
                if now != Failed {
                    self.fault = fault;
                }
                Failed
            }
            (Failed, Event::Resets { tared }) => {
                self.fault = Fault::None;
                if tared { Ready } else { Sync }
            }
            (now, _) => now,
        };
    }
}

/// Whether something is done in `phase`.
fn works(phase: ControllerPhase) -> bool {
    use ControllerPhase::{Approach, Calibrate, Contact, Move, Retract, Search, Settled};
    matches!(
        phase,
        Calibrate | Approach | Contact | Settled | Retract | Search | Move
    )
}

#[cfg(test)]
mod tests;
