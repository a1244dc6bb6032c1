//! What the check signs in the roles that it plays, and what it makes of the tags that it hears.

use super::record::Signed;
use node::authenticity::{Author, Gate, Keyring, Refusal};
use spatial::ports::{Command, Deflections, RobotState, Role, Task};

/// A gate for each role that is played.
pub(super) struct Signatures {
    controller: Gate,
    sensor: Gate,
    operator: Gate,
    /// What was heard of the node under test.
    pub(super) heard: Signed,
}

impl Signatures {
    /// With the keys of a cell, in `session` until a robot is heard.
    pub(super) fn new(keyring: &Keyring, session: i64) -> Self {
        let [mut controller, sensor, operator] = [Author::Controller, Author::Sensor, Author::Operator]
            .map(|author| Gate::new(keyring.clone(), author));
        controller.suppose(session);
        Self {
            controller,
            sensor,
            operator,
            heard: Signed::default(),
        }
    }

    pub(super) fn hear_state(&mut self, state: &RobotState, tested: Role) {
        let _ = self.operator.admit(state);
        let outcome = self.controller.admit(state);
        if tested == Role::Robot {
            self.heard.add(outcome);
        }
    }

    pub(super) fn hear_deflections(&mut self, deflections: &Deflections, tested: Role) {
        let outcome = self.controller.admit(deflections);
        if tested == Role::Sensor {
            self.heard.add(outcome);
        }
    }

    pub(super) fn command(&mut self, command: &mut Command) {
        self.controller.sign(command);
        let _ = self.sensor.admit(command);
    }

    pub(super) fn deflections(&mut self, deflections: &mut Deflections) {
        self.sensor.sign(deflections);
    }

    pub(super) fn task(&mut self, task: &mut Task) {
        self.operator.sign(task);
    }
}

impl Signed {
    /// A message was taken, or not. What a node says before it has learnt the session counts only if its tag is wrong.
    fn add(&mut self, outcome: Result<(), Refusal>) {
        match outcome {
            Ok(()) => self.taken += 1,
            Err(Refusal::Session { .. }) if self.taken == 0 => {}
            Err(refusal) => {
                self.refused += 1;
                self.why.get_or_insert_with(|| refusal.to_string());
            }
        }
    }
}
