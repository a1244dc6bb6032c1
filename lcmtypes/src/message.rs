//! A message: a port struct, its channel, its bytes.

use crate::codec::Codec;
use crate::error::DecodeError;
use crate::ports::{Port, Wire};
use crate::raw;
use spatial::ports::{
    Check, Command, ControllerStatus, Deflections, Invalid, LinkMotion, NodeStatus, ObjectPose, RobotState,
    Stamp, Task, ToolMotion, Truth,
};
use std::ffi::CStr;
use std::fmt;

/// Largest encoding: with LCM's header (8 bytes) and the channel's name a packet stays below 1400 bytes.
const CAPACITY: usize = 1024;

/// A port struct that travels on a channel of its own. Sealed: the types of `types/*.lcm` are all there are.
pub trait Message: Port + Check + Copy + Send + 'static {
    /// Name of its LCM channel.
    const CHANNEL: &'static str;

    /// Step, sampling instant and sender.
    fn stamp(&self) -> Stamp;

    /// Checks the values and encodes them. The encoding can be published again and again, bit for bit.
    fn encode(&self) -> Result<Encoded, Invalid> {
        self.check()?;
        let mut encoded = Encoded {
            channel: Self::NAME,
            length: Self::Raw::SIZE,
            bytes: [0; CAPACITY],
        };
        let fits = self.to_raw().write(&mut encoded.bytes);
        debug_assert!(fits, "{} is larger than {CAPACITY} bytes", Self::CHANNEL);
        Ok(encoded)
    }

    /// Decodes and checks. The bits of every number stay as they are: quaternions are not renormalised.
    fn decode(bytes: &[u8]) -> Result<Self, DecodeError> {
        let fail = |cause| DecodeError::Unusable {
            channel: Self::CHANNEL,
            cause,
        };
        let raw = read::<Self::Raw>(Self::CHANNEL, bytes)?;
        let message = Self::from_raw(&raw).map_err(fail)?;
        message.check().map_err(|invalid| fail(invalid.into()))?;
        Ok(message)
    }

    /// LCM's hash over the type's member names and types: the first eight bytes of every encoding.
    fn fingerprint() -> u64 {
        Self::Raw::fingerprint()
    }
}

fn read<R: Codec>(channel: &'static str, bytes: &[u8]) -> Result<R, DecodeError> {
    check_head(channel, bytes, R::SIZE, R::fingerprint())?;
    R::read(bytes).ok_or(DecodeError::Length {
        channel,
        found: bytes.len(),
        expected: R::SIZE,
    })
}

/// Whether `bytes` begin with the fingerprint `expected` and are `size` long.
pub(crate) fn check_head(
    channel: &'static str,
    bytes: &[u8],
    size: usize,
    expected: u64,
) -> Result<(), DecodeError> {
    let length = DecodeError::Length {
        channel,
        found: bytes.len(),
        expected: size,
    };
    let Some((head, _)) = bytes.split_first_chunk() else {
        return Err(length);
    };
    let found = u64::from_be_bytes(*head);
    if found != expected {
        return Err(DecodeError::Fingerprint {
            channel,
            found,
            expected,
        });
    }
    if bytes.len() != size {
        return Err(length);
    }
    Ok(())
}

/// The bytes of one checked message and the channel they belong to.
#[derive(Clone, PartialEq, Eq)]
pub struct Encoded {
    channel: &'static CStr,
    length: usize,
    bytes: [u8; CAPACITY],
}

impl Encoded {
    /// The encoding: fingerprint, then the members, big-endian.
    pub fn as_bytes(&self) -> &[u8] {
        &self.bytes[..self.length]
    }

    /// Name of the channel.
    pub fn channel(&self) -> &'static str {
        ascii(self.channel)
    }

    pub(crate) fn channel_name(&self) -> &'static CStr {
        self.channel
    }
}

impl fmt::Debug for Encoded {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} ({} bytes)", self.channel(), self.length)
    }
}

const fn ascii(name: &'static CStr) -> &'static str {
    match name.to_str() {
        Ok(name) => name,
        Err(_) => "",
    }
}

/// Every channel with the fingerprint of its type.
pub fn fingerprints() -> impl Iterator<Item = (&'static str, u64)> {
    let channels = CHANNELS.iter();
    channels.filter_map(|&channel| Some((channel, type_of(channel)?.1)))
}

macro_rules! messages {
    ($($port:ty: $module:ident on $name:literal,)*) => {
        /// The names of all channels.
        pub const CHANNELS: &[&str] = &[$(<$port as Message>::CHANNEL,)*];

        /// The name of the type in `types/*.lcm` that `channel` carries, and its fingerprint.
        pub(crate) fn type_of(channel: &str) -> Option<(&'static str, u64)> {
            $(if channel == <$port as Message>::CHANNEL {
                return Some((concat!(stringify!($module), "_t"), <$port as Message>::fingerprint()));
            })*
            None
        }

        /// Why `bytes` are no usable message of `channel`.
        pub fn check(channel: &str, bytes: &[u8]) -> Result<(), DecodeError> {
            $(if channel == <$port as Message>::CHANNEL {
                return <$port>::decode(bytes).map(drop);
            })*
            Err(DecodeError::Channel(channel.to_owned()))
        }

        $(
            const _: () = assert!(raw::$module::Raw::SIZE <= CAPACITY);

            impl Message for $port {
                const CHANNEL: &'static str = ascii(Self::NAME);

                fn stamp(&self) -> Stamp {
                    self.stamp
                }
            }

            impl Wire for $port {
                type Raw = raw::$module::Raw;
                const NAME: &'static CStr = $name;
            }
        )*
    };
}

messages! {
    RobotState: robot_state on c"ROBOT_STATE",
    Deflections: sensor_deflection on c"SENSOR_DEFLECTION",
    Command: robot_command on c"ROBOT_COMMAND",
    ControllerStatus: controller_status on c"CONTROLLER_STATUS",
    NodeStatus: node_status on c"NODE_STATUS",
    Task: task on c"TASK",
    ObjectPose: object_pose on c"OBJECT_POSE",
    LinkMotion: sim_link_motion on c"SIM_LINK_MOTION",
    ToolMotion: sim_tool_motion on c"SIM_TOOL_MOTION",
    Truth: sim_truth on c"SIM_TRUTH",
}
