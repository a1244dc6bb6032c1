//! Keys and tags.

use super::{Author, Refusal, Signed};
use hmac::{Hmac, KeyInit, Mac};
use sha2::Sha256;
use spatial::ports::Authenticity;
use std::fmt;

/// Bytes of a key.
pub const KEY_BYTES: usize = 32;
/// Bytes of a tag: the last ones of an encoding.
const TAG_BYTES: usize = 16;

pub(super) type HmacSha256 = Hmac<Sha256>;

/// HMAC under `secret`, which is shorter than a block of it: filled up with zeros, as HMAC does.
pub(super) fn keyed(secret: &[u8; KEY_BYTES]) -> HmacSha256 {
    let mut block = hmac::digest::Key::<HmacSha256>::default();
    block[..KEY_BYTES].copy_from_slice(secret);
    HmacSha256::new(&block)
}

fn derive(secret: &[u8; KEY_BYTES], label: &str) -> [u8; KEY_BYTES] {
    keyed(secret).chain_update(label).finalize().into_bytes().into()
}

/// The key of a cell, as what it is used for: its id, and HMAC under the key of each [`Author`].
#[derive(Clone)]
pub struct Key {
    id: i32,
    authors: [HmacSha256; 4],
}

impl fmt::Debug for Key {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Key({:08x})", self.id)
    }
}

impl Key {
    /// Of a secret.
    pub fn new(secret: &[u8; KEY_BYTES]) -> Self {
        let [a, b, c, d, ..] = derive(secret, "touchdown key id");
        Self {
            // 0 is no key.
            id: (i32::from_be_bytes([a, b, c, d]) & i32::MAX).max(1),
            authors: Author::LABELS.map(|label| keyed(&derive(secret, label))),
        }
    }

    /// Tells keys apart, and nothing of the secret.
    pub fn id(&self) -> i32 {
        self.id
    }

    /// HMAC over what the tag of `message` vouches for; `None`: it can't be encoded.
    fn over<M: Signed>(&self, message: &M) -> Option<HmacSha256> {
        let encoded = message.encode().ok()?;
        let (body, _tag) = encoded.as_bytes().split_last_chunk::<TAG_BYTES>()?;
        let mac = self.authors[M::AUTHOR as usize].clone();
        Some(mac.chain_update(M::CHANNEL).chain_update([0]).chain_update(body))
    }
}

/// The keys of a node: it signs with the first and takes what is signed with any, so that keys can be changed one node at a
/// time.
#[derive(Clone, Debug)]
pub struct Keyring {
    first: Key,
    others: Vec<Key>,
}

impl Keyring {
    /// `first` and those that are still or already valid, too.
    pub fn new(first: Key, others: Vec<Key>) -> Self {
        Self { first, others }
    }

    /// Ids of all keys; the first one signs.
    pub fn ids(&self) -> impl Iterator<Item = i32> {
        self.all().map(Key::id)
    }

    fn all(&self) -> impl Iterator<Item = &Key> {
        std::iter::once(&self.first).chain(&self.others)
    }

    /// Sign `message` as number `seq` of `session`. One that can't be encoded can't be published either, and stays as it is.
    pub fn sign<M: Signed>(&self, message: &mut M, session: i64, seq: i64) {
        *message.authenticity_mut() = Authenticity {
            session,
            seq,
            key_id: self.first.id,
            tag: [0; TAG_BYTES],
        };
        if let Some(mac) = self.first.over(message)
            && let Some((tag, _)) = mac.finalize().into_bytes().split_first_chunk()
        {
            message.authenticity_mut().tag = *tag;
        }
    }

    /// Whether the tag of `message` is right. What has been decoded is encoded again: to the same bits.
    pub fn verify<M: Signed>(&self, message: &M) -> Result<(), Refusal> {
        let Authenticity { key_id, tag, .. } = *message.authenticity();
        let key = self.all().find(|key| key.id == key_id);
        let key = key.ok_or(Refusal::Key { found: key_id })?;
        let mac = key.over(message).ok_or(Refusal::Tag)?;
        mac.verify_truncated_left(&tag).map_err(|_| Refusal::Tag)
    }
}
