//! Several cells on one group and port: each adds a suffix of its own to the names of all its channels.

use crate::datagram::LONGEST_NAME;
use std::ffi::CStr;
use std::fmt;

/// Longest suffix, bytes.
const LONGEST: usize = 24;

/// What ends the names of a cell's channels on the wire; empty: nothing does.
#[derive(Clone, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Suffix(String);

impl std::str::FromStr for Suffix {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        // What LCM's regular expressions and a shell take as it stands, and what tells TASK_B from somebody's TASKS.
        let plain = |c: char| c.is_ascii_alphanumeric() || c == '_';
        let begins = text.is_empty() || text.starts_with('_');
        if begins && text.len() <= LONGEST && text.chars().all(plain) {
            Ok(Self(text.to_owned()))
        } else {
            Err(format!(
                "suffix is \"{text}\", not _ and then letters, digits and _, {LONGEST} in all at most"
            ))
        }
    }
}

impl fmt::Display for Suffix {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl Suffix {
    /// The name of `channel` without the suffix; `None`: it is another cell's.
    pub fn strip<'a>(&self, channel: &'a str) -> Option<&'a str> {
        channel.strip_suffix(self.0.as_str())
    }

    pub(crate) fn strip_bytes<'a>(&self, channel: &'a [u8]) -> Option<&'a [u8]> {
        channel.strip_suffix(self.0.as_bytes())
    }

    /// The name of `channel` on the wire, in `buffer` where it is another one; `None`: it is too long or empty. Allocates
    /// nothing.
    pub(crate) fn append<'a>(
        &self,
        channel: &'a CStr,
        buffer: &'a mut [u8; LONGEST_NAME + 1],
    ) -> Option<&'a CStr> {
        let (name, suffix) = (channel.to_bytes(), self.0.as_bytes());
        let length = name.len() + suffix.len();
        if name.is_empty() || length > LONGEST_NAME {
            return None;
        }
        if suffix.is_empty() {
            return Some(channel);
        }
        buffer[..name.len()].copy_from_slice(name);
        buffer[name.len()..length].copy_from_slice(suffix);
        buffer[length] = 0;
        CStr::from_bytes_with_nul(&buffer[..=length]).ok()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_appended_is_stripped_again() {
        let mut buffer = [0; LONGEST_NAME + 1];
        for text in ["", "_B", "_CELL_12", "_bcdefghijklmnopqrstuvwx"] {
            let suffix: Suffix = text.parse().unwrap();
            let name = suffix.append(c"TASK", &mut buffer).unwrap().to_str().unwrap();
            assert_eq!(name, format!("TASK{text}"));
            assert_eq!(suffix.strip(name), Some("TASK"));
            assert_eq!(suffix.strip_bytes(name.as_bytes()), Some(&b"TASK"[..]));
            assert_eq!(suffix.append(c"", &mut buffer), None);
        }
        let suffix: Suffix = "_B".parse().unwrap();
        assert_eq!(suffix.strip("TASK"), None);
        assert_eq!(suffix.strip("TASK_C"), None);
        let longest = "x".repeat(LONGEST_NAME - 1);
        assert_eq!(
            suffix.append(&std::ffi::CString::new(longest).unwrap(), &mut buffer),
            None
        );
    }

    #[test]
    fn a_suffix_needs_no_quotes() {
        for bad in ["B", "_A.B", "_A*", " ", "_ä", "_bcdefghijklmnopqrstuvwxy"] {
            let problem = bad.parse::<Suffix>().unwrap_err();
            assert_eq!(
                problem,
                format!("suffix is \"{bad}\", not _ and then letters, digits and _, 24 in all at most")
            );
        }
    }
}
