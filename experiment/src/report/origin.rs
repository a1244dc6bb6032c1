//! How to make a figure or a table again.

use node::scenario::Scenario;

/// Where a figure or a table comes from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Origin {
    /// The command that computes it.
    pub command: String,
    /// What that command's JSON calls `configuration_hash`: 16 hexadecimal digits.
    pub configuration_hash: String,
    /// First and last seed.
    pub seeds: [i64; 2],
}

impl Origin {
    /// Of `command`, which runs `scenario` with `seeds` seeds from `timing.seed` on.
    pub fn new(command: String, scenario: &Scenario, seeds: usize) -> Self {
        let first = scenario.timing.seed;
        Self {
            command,
            configuration_hash: format!("{:016x}", scenario.hash()),
            // As `compare::variations` counts: from the largest seed on to 0.
            seeds: [first, first.wrapping_add(seeds as i64 - 1) & i64::MAX],
        }
    }

    /// `seed 1`, or `seeds 1 to 3`.
    pub fn seeds_text(&self) -> String {
        match self.seeds {
            [first, last] if first == last => format!("seed {first}"),
            [first, last] => format!("seeds {first} to {last}"),
        }
    }
}

/// `text` as one word of a command line.
pub(super) fn quoted(text: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "_-./=,:+".contains(c);
    if !text.is_empty() && text.chars().all(plain) {
        return text.to_owned();
    }
    format!("'{}'", text.replace('\'', r"'\''"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_shell_would_take_apart_is_quoted() {
        assert_eq!(quoted("a/b.toml"), "a/b.toml");
        assert_eq!(quoted("my file.toml"), "'my file.toml'");
        assert_eq!(quoted("it's"), r"'it'\''s'");
    }

    #[test]
    fn seeds_are_told_in_words() {
        let scenario = Scenario::default();
        let text = |seeds| Origin::new(String::new(), &scenario, seeds).seeds_text();
        assert_eq!([text(1), text(3)], ["seed 1", "seeds 1 to 3"]);
    }
}
