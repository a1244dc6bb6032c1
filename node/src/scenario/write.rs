//! A scenario as a file that says all of it.

use super::schema::{Field, Slot, split};
use super::{Scenario, Step};

impl Scenario {
    /// Every key with the value that it has, as TOML: read again, it is this scenario, with the same
    /// [hash](Scenario::hash).
    pub fn to_toml(&self) -> String {
        let (mut scenario, mut text) = (self.clone(), String::new());
        let mut section = "";
        for field in scenario.fields() {
            let (within, name) = split(field.path);
            if within != section {
                section = within;
                text += &format!("\n[{section}]\n");
            }
            text += &line(name, &field.slot);
        }
        for step in self.program.steps() {
            text += &step.to_toml();
        }
        text.trim_start().to_owned()
    }
}

impl Step {
    fn to_toml(&self) -> String {
        let (known, mut step) = (self.known(), self.clone());
        let fields = step
            .fields()
            .map(|Field { path, slot, .. }| (split(path).1, slot));
        let lines = fields.filter(|(name, _)| known.contains(name));
        let lines = lines.map(|(name, slot)| line(name, &slot));
        format!("\n[[program.step]]\n{}", lines.collect::<String>())
    }
}

fn line(name: &str, slot: &Slot<'_>) -> String {
    format!("{name} = {}\n", slot.to_toml())
}
