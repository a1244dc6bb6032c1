//! Who sent a message, and in which order.

/// The last fields of state, deflection, command and task; all zero until a key file is configured.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Authenticity {
    /// Nonce that the robot draws on arming.
    pub session: i64,
    /// Strictly increasing within a session and channel.
    pub seq: i64,
    /// Which key of the key file signed the message.
    pub key_id: i32,
    /// HMAC-SHA256 truncated to 128 bits, over channel, a zero byte and the encoding before the tag.
    pub tag: [u8; 16],
}
