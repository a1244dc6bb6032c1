//! What an attacker who holds no key sends to running nodes: seeded, and made of what the nodes themselves say.

mod message;

pub(crate) use message::Ear;

use lcmtypes::schema::Kind;
use lcmtypes::{CHANNELS, Message};
use message::{Edit, NOISE, below, noise, pick, short};
use rand_core::Rng;
use rand_pcg::Pcg64;
use spatial::ports::{Task, TaskAction};
use std::fmt;

/// A kind of packets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Attack {
    /// LCM's header, and no zero after the channel's name.
    NoNul,
    /// Eight bytes.
    EightBytes,
    /// None.
    Empty,
    /// Real channels with up to 65,000 bytes, and first fragments of messages that say to be of up to 2^32 - 1.
    HugeLengths,
    /// Real channels with another type's fingerprint, or none's.
    Fingerprints,
    /// Live messages in which a number is NaN or infinite.
    NotFinite,
    /// Live messages as of another process, all numbers denormal.
    Denormals,
    /// Poses whose quaternion is not of length 1.
    Quaternions,
    /// Live messages with an impossible time or tick.
    Times,
    /// Live messages as of another process, with a time or tick far away or close by.
    StrangersTimes,
    /// Live messages as of the process itself, with tick and time of the future.
    FarSteps,
    /// Fragments: the same twice, one over the other, ends that wrap around, and messages that are never completed.
    Fragments,
    /// Each packet on a channel of its own.
    UnknownChannels,
    /// Statuses of processes that nobody knows, each another one.
    Strangers,
    /// Requests with any values, from many senders.
    Requests,
    /// Live messages in which some bits are other ones.
    Bits,
    /// All these at once.
    Everything,
    /// Packets of any length as fast as they can be sent.
    Flood,
    /// Live messages as of the process itself, in which some bits are other ones.
    PeersBits,
    /// What nodes have said, new and old, once more, and on other channels.
    Replays,
    /// Requests for any action.
    Orders,
}

/// A header of LCM's fragments ("LC03"), with its five numbers, and what follows.
fn fragment(random: &mut Pcg64) -> Vec<u8> {
    let extreme = |random: &mut Pcg64| match below(random, 6) {
        0 => 0,
        1 => u32::MAX,
        2 => u32::MAX - below(random, 2000) as u32,
        3 => 1 << 31,
        _ => below(random, 4000) as u32,
    };
    // A sequence number of few: the same message again and again.
    let mut packet = b"LC03".to_vec();
    packet.extend(below(random, 8).to_be_bytes()[4..].iter());
    packet.extend(extreme(random).to_be_bytes());
    packet.extend(extreme(random).to_be_bytes());
    packet.extend((extreme(random) as u16).to_be_bytes());
    packet.extend((extreme(random) as u16).to_be_bytes());
    packet.extend(CHANNELS[below(random, CHANNELS.len())].as_bytes());
    packet.push(0);
    packet.extend(noise(random, 1300));
    packet
}

impl Attack {
    /// What nodes without a key endure.
    pub const ALL: [Self; 18] = [
        Self::NoNul,
        Self::EightBytes,
        Self::Empty,
        Self::HugeLengths,
        Self::Fingerprints,
        Self::NotFinite,
        Self::Denormals,
        Self::Quaternions,
        Self::Times,
        Self::StrangersTimes,
        Self::FarSteps,
        Self::Fragments,
        Self::UnknownChannels,
        Self::Strangers,
        Self::Requests,
        Self::Bits,
        Self::Everything,
        Self::Flood,
    ];

    /// What nodes without a key would believe: it is tried on nodes with one alone.
    pub const FORGERIES: [Self; 3] = [Self::PeersBits, Self::Replays, Self::Orders];

    /// The next packet; `None`: nothing has been heard yet that it could be made of.
    pub(crate) fn packet(self, ear: &Ear, random: &mut Pcg64) -> Option<Vec<u8>> {
        const FAR: i64 = 9_000_000_000_000;
        let stranger = |random: &mut Pcg64| (random.next_u64() >> 1) as i64;
        Some(match self {
            Self::NoNul => {
                let name: Vec<u8> = noise(random, 1392).iter().map(|byte| byte | 1).collect();
                [b"LC02\0\0\0\0", name.as_slice()].concat()
            }
            Self::EightBytes => match random.next_u64() {
                number if number % 2 == 0 => b"LC02\0\0\0\0".to_vec(),
                number => number.to_be_bytes().to_vec(),
            },
            Self::Empty => Vec::new(),
            Self::HugeLengths => match below(random, 2) {
                0 => short(
                    pick(random, CHANNELS).as_bytes(),
                    &vec![0xff; below(random, 65_000)],
                ),
                _ => fragment(random),
            },
            Self::Fingerprints => {
                let mut edit = ear.any(random)?;
                edit.channel = pick(random, CHANNELS).to_owned();
                match below(random, 2) {
                    0 => edit.packet(),
                    _ => edit.put(0, random.next_u64().to_be_bytes()).packet(),
                }
            }
            Self::NotFinite => {
                let value = pick(random, &[f64::NAN, -f64::NAN, f64::INFINITY, f64::NEG_INFINITY]);
                ear.any(random)?
                    .put_one(random, Kind::Double, "", value.to_be_bytes())
                    .packet()
            }
            Self::Denormals => {
                let mut edit = ear.any(random)?.integer("boot_id", stranger(random));
                for at in edit.elements(Kind::Double, "") {
                    let denormal = f64::from_bits(random.next_u64() & 0x800f_ffff_ffff_ffff);
                    edit = edit.put(at, denormal.to_be_bytes());
                }
                edit.packet()
            }
            Self::Quaternions => {
                let length = pick(random, &[0.0, 1e-300, 0.5, 1.001, 2.0, 1e300]);
                let mut edit = ear.one("OBJECT_POSE")?;
                for (i, at) in edit.elements(Kind::Double, "quaternion").into_iter().enumerate() {
                    let value: f64 = if i == 0 { length } else { 0.0 };
                    edit = edit.put(at, value.to_be_bytes());
                }
                edit.packet()
            }
            Self::Times => {
                let value = pick(random, &[i64::MIN, i64::MAX, FAR + 1, -FAR - 1, -2, 1 << 53]);
                let name = pick(random, &["step", "utime"]);
                ear.any(random)?
                    .put_one(random, Kind::Int64, name, value.to_be_bytes())
                    .packet()
            }
            Self::StrangersTimes => {
                let edit = ear.any(random)?.integer("boot_id", stranger(random));
                let (step, utime) = (stranger(random) % FAR, stranger(random) % (1000 * FAR));
                edit.integer("step", step).integer("utime", utime).packet()
            }
            Self::FarSteps => {
                let ahead = pick(random, &[1, 4, 8, 1000, 1_000_000, 6_000_000_000_000]);
                let edit = ear.any(random)?;
                let number =
                    |at: usize| Some(i64::from_be_bytes(edit.bytes.get(at..at + 8)?.try_into().ok()?));
                let (step, utime) = (number(8)?, number(16)?);
                let later = edit.integer("step", step + ahead);
                later
                    .integer("utime", utime.saturating_add(1000 * ahead))
                    .packet()
            }
            Self::Fragments => fragment(random),
            Self::UnknownChannels => {
                let name = format!("X{:016x}{:016x}", random.next_u64(), random.next_u64());
                short(name.as_bytes(), &noise(random, 64))
            }
            Self::Strangers => {
                let edit = ear.one("NODE_STATUS")?.integer("boot_id", stranger(random));
                edit.integer("node_run_id", stranger(random)).packet()
            }
            Self::Requests => {
                let mut task = Task::default();
                task.stamp.boot_id = stranger(random) % 1000;
                task.stamp.step = stranger(random) % FAR;
                // Parameters alone: any sender may ask for an action as long as there is no key.
                let value = |random: &mut Pcg64| f64::from_bits(random.next_u64());
                let values = std::array::from_fn(|_| {
                    Some(value(random)).filter(|it| it.is_finite() && it.abs() > 1e9)
                });
                task.parameters = spatial::ports::TaskParameters::from_values(values);
                let encoded = task.encode().ok()?;
                Edit::of("TASK", encoded.as_bytes())?.packet()
            }
            Self::Bits => {
                // A request is anybody's: one bit makes a stop of none.
                let mut edit = Some(ear.any(random)?).filter(|edit| edit.channel != "TASK")?;
                for _ in 0..1 + below(random, 16) {
                    let bit = below(random, 8 * edit.bytes.len());
                    edit.bytes[bit / 8] ^= 1 << (bit % 8);
                }
                // As of a stranger: without a key nobody can tell a wrong bit of a number.
                edit.integer("boot_id", stranger(random)).packet()
            }
            Self::PeersBits => {
                let mut edit = ear.any(random)?;
                let bit = below(random, 8 * edit.bytes.len());
                edit.bytes[bit / 8] ^= 1 << (bit % 8);
                edit.packet()
            }
            Self::Replays => {
                let (channel, bytes) = ear.said(random)?;
                match below(random, 4) {
                    0 => short(pick(random, CHANNELS).as_bytes(), bytes),
                    _ => short(channel.as_bytes(), bytes),
                }
            }
            Self::Orders => {
                let mut task = Task::default();
                task.stamp.boot_id = stranger(random);
                task.action = pick(random, TaskAction::ALL);
                Edit::of("TASK", task.encode().ok()?.as_bytes())?.packet()
            }
            Self::Everything => {
                let others = Self::ALL.len() - 2;
                Self::ALL[below(random, others)].packet(ear, random)?
            }
            Self::Flood => {
                let (start, length) = (below(random, NOISE / 2), below(random, 1400));
                ear.noise[start..start + length].to_vec()
            }
        })
    }

    /// Whether its packets are of no use to anybody.
    pub fn is_unusable(self) -> bool {
        !matches!(
            self,
            Self::Denormals
                | Self::StrangersTimes
                | Self::FarSteps
                | Self::Strangers
                | Self::Requests
                | Self::Bits
                | Self::Everything
                | Self::PeersBits
                | Self::Replays
                | Self::Orders
        )
    }

    /// Packets per ms; `None`: as many as can be sent.
    pub(crate) fn per_ms(self) -> Option<u32> {
        match self {
            Self::Flood => None,
            // A hundred thousand in all.
            Self::UnknownChannels => Some(25),
            _ => Some(10),
        }
    }
}

impl fmt::Display for Attack {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::NoNul => "no zero after the name",
            Self::EightBytes => "eight bytes",
            Self::Empty => "empty",
            Self::HugeLengths => "huge lengths",
            Self::Fingerprints => "wrong fingerprints",
            Self::NotFinite => "NaN and infinities",
            Self::Denormals => "denormals of a stranger",
            Self::Quaternions => "unnormalised quaternions",
            Self::Times => "impossible times and ticks",
            Self::StrangersTimes => "any times of a stranger",
            Self::FarSteps => "a peer's times of the future",
            Self::Fragments => "fragments",
            Self::UnknownChannels => "unknown channels",
            Self::Strangers => "statuses of strangers",
            Self::Requests => "requests beyond all limits",
            Self::Bits => "wrong bits of a stranger",
            Self::Everything => "all of these",
            Self::Flood => "flood at line rate",
            Self::PeersBits => "wrong bits of a peer",
            Self::Replays => "replays, also elsewhere",
            Self::Orders => "orders without a key",
        })
    }
}
