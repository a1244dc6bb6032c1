//! What two doctors say to each other: a fixed number of bytes, big endian, in an LCM message of its own channel.

/// First bytes of each word: another layout would have another last digit.
const MAGIC: [u8; 8] = *b"doctor 1";
const LENGTH: usize = 8 + 1 + 32 + 8 + 4 + 8 + 8 + 8;

/// A question or an answer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Word {
    /// Name of the sender's host, padded with zeros.
    pub(super) host: [u8; 32],
    /// Who sends it.
    pub(super) id: u64,
    /// Number of the question.
    pub(super) number: u32,
    /// Whose question it answers; 0: it is a question.
    pub(super) to: u64,
    /// When the question was received, us on the sender's clock; 0 in a question.
    pub(super) received_us: i64,
    /// When it was sent, us on the sender's clock.
    pub(super) sent_us: i64,
}

impl Word {
    pub(super) fn encode(&self) -> Vec<u8> {
        let kind = [u8::from(self.to != 0)];
        [
            &MAGIC[..],
            &kind,
            &self.host,
            &self.id.to_be_bytes(),
            &self.number.to_be_bytes(),
            &self.to.to_be_bytes(),
            &self.received_us.to_be_bytes(),
            &self.sent_us.to_be_bytes(),
        ]
        .concat()
    }

    /// `None`: these bytes are no word.
    pub(super) fn decode(bytes: &[u8]) -> Option<Self> {
        fn take<'a, const N: usize>(rest: &mut &'a [u8]) -> Option<&'a [u8; N]> {
            let (head, tail) = rest.split_first_chunk::<N>()?;
            *rest = tail;
            Some(head)
        }
        let mut rest = bytes;
        if bytes.len() != LENGTH || take(&mut rest)? != &MAGIC {
            return None;
        }
        let [kind] = *take::<1>(&mut rest)?;
        let word = Self {
            host: *take(&mut rest)?,
            id: u64::from_be_bytes(*take(&mut rest)?),
            number: u32::from_be_bytes(*take(&mut rest)?),
            to: u64::from_be_bytes(*take(&mut rest)?),
            received_us: i64::from_be_bytes(*take(&mut rest)?),
            sent_us: i64::from_be_bytes(*take(&mut rest)?),
        };
        (kind == u8::from(word.to != 0)).then_some(word)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_word_survives_and_nothing_else_is_one() {
        let word = Word {
            host: [b'h'; 32],
            id: 1,
            number: 2,
            to: 3,
            received_us: -4,
            sent_us: 5,
        };
        let bytes = word.encode();
        assert_eq!(Word::decode(&bytes), Some(word));
        assert_eq!(Word::decode(&bytes[1..]), None);
        assert_eq!(Word::decode(&[]), None);
        for i in 0..9 {
            let mut other = bytes.clone();
            other[i] ^= 2;
            assert_eq!(Word::decode(&other), None);
        }
    }
}
