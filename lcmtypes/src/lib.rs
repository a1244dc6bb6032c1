//! The wire: Touchdown's messages over LCM, and the only unsafe code of the workspace.
//!
//! A node's library sees the plain structs of [`spatial::ports`]. This crate turns each into the bytes of its
//! type in `types/*.lcm` and back ([`Message`]), sends and receives them ([`LcmBuilder`], [`Lcm`],
//! [`Subscription`]; in the calling thread by [`Inboxes`]) and reads and writes LCM's event logs ([`EventLogWriter`], [`EventLogReader`]).
//! Nothing is encoded before it has been checked, nothing is delivered before it has been checked.
//!
//! ```no_run
//! # fn main() -> Result<(), lcmtypes::LcmError> {
//! use lcmtypes::LcmBuilder;
//! use spatial::ports::{RobotState, Task};
//!
//! let mut builder = LcmBuilder::open("udpm://239.255.76.67:7667?ttl=0")?;
//! let states = builder.subscribe::<RobotState>(8);
//! let lcm = builder.start()?;
//! lcm.publish(&Task::default())?;
//! while let Ok(received) = states.receiver().recv() {
//!     println!("tick {}", received.message.stamp.step);
//! }
//! # Ok(())
//! # }
//! ```
//!
//! The contract itself, for those who speak it in another language, is in `lcmtypes/README.md`.

mod codec;
pub mod datagram;
mod error;
mod event_log;
mod inboxes;
mod kernel;
mod liblcm;
mod link;
mod message;
mod multicast;
mod ports;
mod raw;
mod router;
pub mod schema;
mod suffix;
mod tally;
mod types;
mod url;

pub use error::{DecodeError, LcmError, LogError, Refusal, Unusable};
pub use event_log::{Event, EventLogReader, EventLogWriter};
pub use inboxes::{Inboxes, Woken};
pub use link::{Lcm, LcmBuilder};
pub use message::{CHANNELS, Encoded, Message, check, fingerprints};
pub use router::{RawMessage, Received, Subscription};
pub use suffix::Suffix;
pub use tally::Counters;
pub use types::TYPE_FILES;
pub use url::Group;

/// Version of the LCM that this crate was built against.
pub const LCM_VERSION: (i32, i32, i32) = (
    raw::LCM_MAJOR_VERSION,
    raw::LCM_MINOR_VERSION,
    raw::LCM_MICRO_VERSION,
);
