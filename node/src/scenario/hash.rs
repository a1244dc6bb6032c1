//! One number for all values of a scenario, so that nodes can tell whether they were given the same one.

use super::{Scenario, schema::Slot};
use sha2::{Digest, Sha256};

impl Scenario {
    /// The first 8 bytes of the SHA-256 of all resolved values.
    ///
    /// It depends on every value's bits, not on how the file writes, orders or comments them.
    pub fn hash(&self) -> i64 {
        let mut digest = Sha256::new();
        let (mut scenario, mut steps) = (self.clone(), self.program.steps().to_vec());
        let of_steps = steps.iter_mut().flat_map(|step| step.fields());
        for field in scenario.fields().chain(of_steps) {
            digest.update(field.path);
            digest.update([0]);
            match field.slot {
                Slot::Number(value, _) => digest.update(value.to_bits().to_be_bytes()),
                Slot::Array(values, _) => values
                    .iter()
                    .for_each(|value| digest.update(value.to_bits().to_be_bytes())),
                // The length keeps a longer list from being what a shorter one and its successors are.
                Slot::List(values, _) => {
                    digest.update((values.len() as u64).to_be_bytes());
                    values
                        .iter()
                        .for_each(|value| digest.update(value.to_bits().to_be_bytes()));
                }
                Slot::Integer(value, _) => digest.update(value.to_be_bytes()),
                Slot::Flag(value) => digest.update([u8::from(*value)]),
                // The name of the variant: a word may still be missing.
                Slot::Choice(choice) => digest.update(format!("{choice:?}\0")),
            }
        }
        let [a, b, c, d, e, f, g, h, ..]: [u8; 32] = digest.finalize().into();
        i64::from_be_bytes([a, b, c, d, e, f, g, h])
    }
}
