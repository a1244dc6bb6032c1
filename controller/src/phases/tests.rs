//! Every state that can be reached, with all that can happen in it.

use super::*;
use ControllerPhase::{Calibrate, Init, Ready, Sync};

/// What happens next, and whether zero force has been taken: what a [`Event::Resets`] is told.
fn events(tared: bool) -> Vec<Event> {
    let mut events = vec![
        Event::Joined,
        Event::Tared,
        Event::TaresAnew,
        Event::Rests,
        Event::Resets { tared },
    ];
    events.extend(ControllerPhase::ALL.iter().copied().map(Event::Works));
    events.extend(Fault::ALL.iter().copied().map(Event::Fails));
    events
}

/// A machine: what an event makes of a state.
type Machine = fn(&mut Phases, Event);

/// Visit all that can be reached; the first invariant that does not hold, and how many states there are.
fn explore(machine: Machine) -> Result<usize, String> {
    let start = (Phases::new(), false);
    let (mut known, mut open) = (vec![start], vec![start]);
    while let Some((before, tared)) = open.pop() {
        for event in events(tared) {
            let mut after = before;
            machine(&mut after, event);
            // As it is, not as the machine has it.
            let tared = match event {
                Event::Tared if before.phase == Sync => true,
                Event::TaresAnew if before.phase == Ready => false,
                _ => tared,
            };
            if let Some(broken) = broken(&before, event, &after, tared) {
                return Err(format!("{broken}: {before:?}, {event:?}, {after:?}"));
            }
            if !known.contains(&(after, tared)) {
                known.push((after, tared));
                open.push((after, tared));
            }
        }
    }
    Ok(known.len())
}

/// The invariant that a step breaks.
fn broken(before: &Phases, event: Event, after: &Phases, tared: bool) -> Option<&'static str> {
    let resets = matches!(event, Event::Resets { .. });
    let failed = before.phase == ControllerPhase::Fault;
    if (after.fault != Fault::None) != (after.phase == ControllerPhase::Fault) {
        return Some("a fault outside Fault, or Fault without one");
    }
    if failed && after.fault != before.fault && !resets {
        return Some("the first fault is not kept");
    }
    if failed && after.phase != before.phase && !resets {
        return Some("a way out of Fault without a reset");
    }
    if failed && works(after.phase) {
        return Some("it works on after a fault");
    }
    if let Event::Fails(fault) = event
        && fault != Fault::None
        && after.phase != ControllerPhase::Fault
    {
        return Some("a fault is not latched");
    }
    if works(after.phase) && !tared {
        return Some("it works without zero force");
    }
    if works(after.phase) && !works(before.phase) && before.phase != Ready {
        return Some("work begins elsewhere than in Ready");
    }
    if (before.phase == Calibrate) != (after.phase == Calibrate) && works(before.phase) && works(after.phase)
    {
        return Some("a calibration and a program at once");
    }
    if after.phase == Init && before.phase != Init {
        return Some("a way back to Init");
    }
    None
}

#[test]
fn no_state_that_can_be_reached_breaks_an_invariant() {
    let states = explore(|phases, event| phases.take(event)).unwrap_or_else(|broken| panic!("{broken}"));
    // Init, Sync, Ready, seven at work, and each fault with and without zero force taken before it.
    assert_eq!(states, 3 + 7 + 2 * (Fault::ALL.len() - 1));
}

/// The exploration finds mistakes: machines with one each.
#[test]
fn mistakes_are_found() {
    let newest_fault: Machine = |phases, event| match event {
        Event::Fails(fault) if fault != Fault::None => {
            (phases.phase, phases.fault) = (ControllerPhase::Fault, fault);
        }
        _ => phases.take(event),
    };
    let works_at_once: Machine = |phases, event| match (phases.phase, event) {
        (Sync, Event::Works(ControllerPhase::Approach)) => phases.phase = ControllerPhase::Approach,
        _ => phases.take(event),
    };
    let rests_after_a_fault: Machine = |phases, event| match event {
        Event::Rests => (phases.phase, phases.fault) = (Ready, Fault::None),
        _ => phases.take(event),
    };
    for (machine, expected) in [
        (newest_fault, "the first fault is not kept"),
        (works_at_once, "it works without zero force"),
        (rests_after_a_fault, "the first fault is not kept"),
    ] {
        let found = explore(machine).expect_err("a mistake is not found");
        assert!(found.starts_with(expected), "{found}");
    }
}
