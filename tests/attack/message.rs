//! What has been heard of a run, and messages made of it.

use crate::site::FORGED;
use lcmtypes::schema::{Kind, Member, Type};
use lcmtypes::{LcmBuilder, Message, RawMessage, Subscription};
use rand_core::Rng;
use rand_pcg::Pcg64;
use spatial::Pose;
use spatial::ports::{ObjectPose, Stamp, Task};
use std::collections::BTreeMap;

/// So many bytes at random are there to be sent.
pub(super) const NOISE: usize = 1 << 16;
/// So many messages are kept to be said again.
const SAID: usize = 2000;

/// What is known of a run by listening.
pub(crate) struct Ear {
    heard: Subscription<RawMessage>,
    _link: lcmtypes::Lcm,
    /// The newest message of each channel (and of each node's status).
    live: BTreeMap<(String, Vec<u8>), Vec<u8>>,
    /// What has been said, a part of it: channel and encoding.
    said: Vec<(String, Vec<u8>)>,
    /// Bytes at random, to be sent as fast as can be.
    pub(super) noise: Vec<u8>,
}

impl Ear {
    pub(crate) fn open(url: &str, random: &mut Pcg64) -> Result<Self, lcmtypes::LcmError> {
        let mut builder = LcmBuilder::open(url)?;
        let heard = builder.subscribe_all(256);
        let own = [
            ObjectPose {
                stamp: Stamp::default(),
                visible: true,
                pose: Pose::identity(),
                velocity: Default::default(),
                angular_velocity: Default::default(),
                position_sigma_m: 1e-3,
            }
            .encode(),
            Task::default().encode(),
        ];
        let live = own.into_iter().flatten();
        let live = live.map(|it| ((it.channel().to_owned(), Vec::new()), it.as_bytes().to_vec()));
        Ok(Self {
            heard,
            _link: builder.start()?,
            live: live.collect(),
            said: Vec::new(),
            noise: (0..NOISE).map(|_| random.next_u64() as u8).collect(),
        })
    }

    /// Take what has come. What cannot be, or carries the mark, is the attacker's own.
    pub(crate) fn listen(&mut self, random: &mut Pcg64) {
        while let Some(it) = self.heard.take() {
            let RawMessage { channel, bytes } = it.message;
            let forged = Edit::of(&channel, &bytes).is_none_or(|edit| edit.marked());
            if !forged && lcmtypes::check(&channel, &bytes).is_ok() {
                // A status says first whose it is.
                let whose = if channel == "NODE_STATUS" {
                    bytes[32..64].to_vec()
                } else {
                    Vec::new()
                };
                if self.said.len() < SAID {
                    self.said.push((channel.clone(), bytes.clone()));
                } else if let Some(place) = self.said.get_mut(below(random, 2 * SAID)) {
                    *place = (channel.clone(), bytes.clone());
                }
                self.live.insert((channel, whose), bytes);
            }
        }
    }

    /// A live message, of those that nodes listen to.
    pub(super) fn any(&self, random: &mut Pcg64) -> Option<Edit> {
        let i = below(random, self.live.len());
        let ((channel, _), bytes) = self.live.iter().nth(i)?;
        Edit::of(channel, bytes)
    }

    /// Something that has been said, of the beginning or later.
    pub(super) fn said(&self, random: &mut Pcg64) -> Option<(&str, &[u8])> {
        let (channel, bytes) = self.said.get(below(random, self.said.len()))?;
        Some((channel, bytes))
    }

    pub(super) fn one(&self, channel: &str) -> Option<Edit> {
        let ((channel, _), bytes) = self.live.iter().find(|((known, _), _)| known == channel)?;
        Edit::of(channel, bytes)
    }
}

/// A message whose members are to be replaced.
pub(super) struct Edit {
    of: &'static Type,
    pub(super) channel: String,
    pub(super) bytes: Vec<u8>,
}

impl Edit {
    /// `None`: it is on no channel of the contract, or of another length.
    pub(super) fn of(channel: &str, bytes: &[u8]) -> Option<Self> {
        let of = Type::of(channel).filter(|it| it.size() == bytes.len())?;
        let (channel, bytes) = (channel.to_owned(), bytes.to_vec());
        Some(Self { of, channel, bytes })
    }

    /// Members with the place of each in the encoding.
    fn places(&self) -> impl Iterator<Item = (&'static Member, usize)> + use<> {
        let mut at = 8;
        self.of.members.iter().map(move |member| {
            let here = at;
            at += member.count() * member.kind.size();
            (member, here)
        })
    }

    /// The places of the elements that are `kind` and of members whose names contain `name`.
    pub(super) fn elements(&self, kind: Kind, name: &str) -> Vec<usize> {
        let fitting = self
            .places()
            .filter(|(member, _)| member.kind == kind && member.name.contains(name));
        let each =
            |(member, at): (&'static Member, usize)| (0..member.count()).map(move |i| at + i * kind.size());
        fitting.flat_map(each).collect()
    }

    pub(super) fn put(mut self, at: usize, bytes: [u8; 8]) -> Self {
        if let Some(place) = self.bytes.get_mut(at..at + 8) {
            place.copy_from_slice(&bytes);
        }
        self
    }

    /// One of those elements, replaced.
    pub(super) fn put_one(self, random: &mut Pcg64, kind: Kind, name: &str, bytes: [u8; 8]) -> Self {
        let places = self.elements(kind, name);
        match places.is_empty() {
            true => self,
            false => self.put(places[below(random, places.len())], bytes),
        }
    }

    pub(super) fn integer(self, name: &str, value: i64) -> Self {
        match self.elements(Kind::Int64, name).first() {
            Some(at) => self.put(*at, value.to_be_bytes()),
            None => self,
        }
    }

    fn mark(&self) -> Option<usize> {
        let mut places = self
            .places()
            .filter(|(member, _)| ["session", "node_fault_expected"].contains(&member.name));
        places.next().map(|(_, at)| at)
    }

    fn marked(&self) -> bool {
        let at = self.mark();
        at.is_some_and(|at| self.bytes.get(at..at + 8) == Some(&FORGED.to_be_bytes()))
    }

    pub(super) fn packet(self) -> Vec<u8> {
        let marked = match self.mark() {
            Some(at) => self.put(at, FORGED.to_be_bytes()),
            None => self,
        };
        short(marked.channel.as_bytes(), &marked.bytes)
    }
}

/// A short message.
pub(super) fn short(channel: &[u8], encoding: &[u8]) -> Vec<u8> {
    [b"LC02\0\0\0\0", channel, b"\0", encoding].concat()
}

/// Up to `most` bytes.
pub(super) fn noise(random: &mut Pcg64, most: usize) -> Vec<u8> {
    (0..below(random, most + 1))
        .map(|_| random.next_u64() as u8)
        .collect()
}

pub(super) fn below(random: &mut Pcg64, limit: usize) -> usize {
    (random.next_u64() % limit.max(1) as u64) as usize
}

pub(super) fn pick<T: Copy>(random: &mut Pcg64, of: &[T]) -> T {
    of[below(random, of.len())]
}
