//! What the kernel says that a process has used.

use std::fs;
use std::io::{self, ErrorKind};
use std::ops::Sub;

/// What a process has used since its start, or between two instants.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Usage {
    /// Time of all its threads on a core, s.
    pub core_s: f64,
    /// Page faults that took no reading from a disk.
    pub minor_faults: u64,
    /// Page faults that did.
    pub major_faults: u64,
}

impl Usage {
    /// Of the process `id` up to now. Linux alone tells.
    pub fn of(id: u32) -> io::Result<Self> {
        let mut core_ns = 0;
        for thread in fs::read_dir(format!("/proc/{id}/task"))? {
            // On the core, and waiting for one, ns.
            core_ns += number(&fs::read_to_string(thread?.path().join("schedstat"))?, 0)?;
        }
        let stat = fs::read_to_string(format!("/proc/{id}/stat"))?;
        // The program's name, in brackets, may have spaces.
        let (_, fields) = stat.rsplit_once(')').ok_or(ErrorKind::InvalidData)?;
        Ok(Self {
            core_s: 1e-9 * core_ns as f64,
            minor_faults: number(fields, 7)?,
            major_faults: number(fields, 9)?,
        })
    }
}

impl Sub for Usage {
    type Output = Self;

    fn sub(self, before: Self) -> Self {
        Self {
            core_s: self.core_s - before.core_s,
            minor_faults: self.minor_faults - before.minor_faults,
            major_faults: self.major_faults - before.major_faults,
        }
    }
}

fn number(text: &str, place: usize) -> io::Result<u64> {
    let word = text.split_ascii_whitespace().nth(place);
    word.and_then(|word| word.parse().ok())
        .ok_or_else(|| ErrorKind::InvalidData.into())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::hint::black_box;

    #[test]
    fn work_and_fresh_pages_are_seen() {
        let id = std::process::id();
        let before = Usage::of(id).unwrap();
        let fresh = black_box(vec![1_u8; 1 << 24]);
        // Until the kernel's account, which it brings up to date at times, has it.
        while (Usage::of(id).unwrap() - before).core_s <= 0.0 {
            black_box(fresh.iter().map(|byte| u64::from(*byte)).sum::<u64>());
        }
        let used = Usage::of(id).unwrap() - before;
        assert!(used.minor_faults > 8, "{used:?}");
        assert!(Usage::of(u32::MAX).is_err());
    }
}
