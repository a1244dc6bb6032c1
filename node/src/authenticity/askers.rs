//! Who has asked for what: any number of askers, none of whose requests is taken twice.

/// As many are remembered.
const MANY: usize = 64;

/// The last request of each of the latest askers. Their `seq` are instants: of those that are forgotten it is known that nothing
/// they have asked is later than the earliest remembered.
#[derive(Clone, Debug)]
pub(super) struct Askers {
    /// Process and its last `seq`, 0: nobody.
    known: [(i64, i64); MANY],
    /// No later one has been forgotten.
    forgotten: i64,
}

impl Default for Askers {
    fn default() -> Self {
        Self {
            known: [(0, 0); MANY],
            forgotten: 0,
        }
    }
}

impl Askers {
    /// Whether request `seq` of the process `boot_id` is new.
    pub(super) fn admit(&mut self, boot_id: i64, seq: i64) -> bool {
        let known = self
            .known
            .iter_mut()
            .find(|(known, last)| *last > 0 && *known == boot_id);
        if let Some((_, last)) = known {
            return seq > std::mem::replace(last, seq.max(*last));
        }
        let new = seq > self.forgotten;
        if let Some(slot) = self.known.iter_mut().min_by_key(|(_, last)| *last)
            && new
        {
            self.forgotten = self.forgotten.max(slot.1);
            *slot = (boot_id, seq);
        }
        new
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_request_is_taken_twice_however_many_have_asked_since() {
        let mut askers = Askers::default();
        let requests = || (1..1000).map(|i| (1_000_000 + i % 300, 10 * i));
        assert!(requests().all(|(asker, seq)| askers.admit(asker, seq)));
        assert!(!requests().any(|(asker, seq)| askers.admit(asker, seq)));
    }

    #[test]
    fn an_asker_whose_clock_is_behind_is_heard_too() {
        let mut askers = Askers::default();
        assert!(askers.admit(1, 5_000_000) && askers.admit(2, 3_000) && askers.admit(2, 3_001));
        assert!(!askers.admit(2, 3_000) && !askers.admit(1, 5_000_000) && !askers.admit(3, 0));
    }
}
