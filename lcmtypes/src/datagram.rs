//! LCM's datagrams: of short messages, which are all that the programs send, and all that they take.

/// First four bytes of a short message.
const SHORT: &[u8] = b"LC02";
/// Longest name of a channel, bytes.
pub(crate) const LONGEST_NAME: usize = 63;

/// Channel and encoding of a message.
pub type Parts<'a> = (&'a [u8], &'a [u8]);

/// The parts of a short message: magic "LC02", a sequence number, the channel, a zero byte, the encoding; `None`: it is none.
pub fn split(datagram: &[u8]) -> Option<Parts<'_>> {
    let rest = datagram.strip_prefix(SHORT)?.get(4..)?;
    let end = rest.iter().take(LONGEST_NAME + 1).position(|&byte| byte == 0)?;
    (end > 0).then_some((&rest[..end], &rest[end + 1..]))
}

/// Put the short message into `datagram`.
pub fn join(datagram: &mut Vec<u8>, sequence: u32, channel: &str, encoding: &[u8]) {
    datagram.clear();
    datagram.extend_from_slice(SHORT);
    datagram.extend_from_slice(&sequence.to_be_bytes());
    datagram.extend_from_slice(channel.as_bytes());
    datagram.push(0);
    datagram.extend_from_slice(encoding);
}

/// The tick of an encoding: what follows the fingerprint in every message.
pub fn step(encoding: &[u8]) -> Option<i64> {
    let bytes = encoding.get(8..16)?.try_into().ok()?;
    Some(i64::from_be_bytes(bytes))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Message;
    use spatial::ports::Task;

    #[test]
    fn what_is_joined_is_split() {
        let mut task = Task::default();
        task.stamp.step = 77;
        let encoded = task.encode().unwrap();
        let mut datagram = b"of before".to_vec();
        join(&mut datagram, 3, encoded.channel(), encoded.as_bytes());
        assert_eq!(datagram[..9], *b"LC02\0\0\0\x03T");
        let (channel, encoding) = split(&datagram).unwrap();
        assert_eq!((channel, encoding), (b"TASK".as_slice(), encoded.as_bytes()));
        assert_eq!(step(encoding), Some(77));
    }

    #[test]
    fn what_is_no_short_message_is_refused() {
        let endless = [b"LC02\0\0\0\0".as_slice(), &[b'x'; 64], b"\0"].concat();
        for other in [
            b"".as_slice(),
            b"LC02\0\0\0",
            b"LC03\0\0\0\0X\0",
            b"LC02\0\0\0\0X",
            b"LC02\0\0\0\0\0nameless",
            &endless,
        ] {
            assert_eq!(split(other), None);
        }
        assert_eq!(step(&[0; 15]), None);
    }
}
