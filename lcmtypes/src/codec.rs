//! The generated C encoders and decoders behind safe functions.
#![allow(unsafe_code, reason = "calls the C that lcm-gen writes")]

use crate::raw;
use std::ffi::c_int;
use std::sync::OnceLock;

/// A C struct of `types/*.lcm`: fixed size, no pointers (`Send` refuses a type with a variable array or a string).
pub trait Codec: Copy + Default + Send {
    /// Bytes of its encoding, fingerprint included.
    const SIZE: usize;

    /// LCM's hash over its member names and types.
    fn fingerprint() -> u64;

    /// Writes the encoding to the start of `buffer`; false if it doesn't fit.
    fn write(&self, buffer: &mut [u8]) -> bool;

    /// Reads an encoding; none if length or fingerprint are wrong.
    fn read(bytes: &[u8]) -> Option<Self>;
}

macro_rules! codecs {
    ($($module:ident: $size:literal,)*) => {$(
        impl Codec for raw::$module::Raw {
            const SIZE: usize = $size;

            fn fingerprint() -> u64 {
                // The C code caches the hash in two plain variables: they must be written before a second
                // thread reads them, hence every call passes here first.
                static FINGERPRINT: OnceLock<u64> = OnceLock::new();
                *FINGERPRINT.get_or_init(|| {
                    // SAFETY: takes no argument and touches only the two variables above, once.
                    unsafe { raw::$module::get_hash() }.cast_unsigned()
                })
            }

            fn write(&self, buffer: &mut [u8]) -> bool {
                Self::fingerprint();
                let capacity = c_int::try_from(buffer.len()).unwrap_or(c_int::MAX);
                // SAFETY: both pointers are valid for the call; the encoder writes at most `capacity` bytes.
                let written = unsafe { raw::$module::encode(buffer.as_mut_ptr().cast(), 0, capacity, self) };
                usize::try_from(written) == Ok(Self::SIZE)
            }

            fn read(bytes: &[u8]) -> Option<Self> {
                Self::fingerprint();
                let mut value = Self::default();
                let length = c_int::try_from(bytes.len()).ok()?;
                // SAFETY: both pointers are valid for the call; the decoder reads at most `length` bytes, and
                // fills a struct without pointers, so that it allocates nothing.
                let read = unsafe { raw::$module::decode(bytes.as_ptr().cast(), 0, length, &mut value) };
                (read == length && bytes.len() == Self::SIZE).then_some(value)
            }
        }
    )*};
}

codecs! {
    robot_state: 604,
    sensor_deflection: 956,
    robot_command: 461,
    controller_status: 613,
    node_status: 422,
    task: 224,
    object_pose: 145,
    sim_link_motion: 216,
    sim_tool_motion: 184,
    sim_truth: 280,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_those_of_the_generated_encoders() {
        macro_rules! check {
            ($($module:ident)*) => {$(
                // SAFETY: reads a valid struct.
                let size = unsafe { raw::$module::encoded_size(&raw::$module::Raw::default()) };
                assert_eq!(usize::try_from(size), Ok(raw::$module::Raw::SIZE), stringify!($module));
            )*};
        }
        check!(robot_state sensor_deflection robot_command controller_status node_status task object_pose
            sim_link_motion sim_tool_motion sim_truth);
    }
}
