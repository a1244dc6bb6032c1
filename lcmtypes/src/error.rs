//! What can go wrong on the wire, each with its remedy.

use spatial::ports::Invalid;
use std::io;
use std::net::SocketAddrV4;
use std::path::PathBuf;

/// Bytes that are not a usable message of their channel.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum DecodeError {
    /// Too short or too long.
    #[error(
        "{channel} carries {found} bytes, not {expected}; regenerate the sender's types from types/*.lcm"
    )]
    Length {
        /// Channel.
        channel: &'static str,
        /// Bytes received.
        found: usize,
        /// Bytes of the type.
        expected: usize,
    },
    /// Another type, or another version of it.
    #[error(
        "{channel} carries fingerprint {found:#018x}, not {expected:#018x}; \
         regenerate the sender's types from types/*.lcm"
    )]
    Fingerprint {
        /// Channel.
        channel: &'static str,
        /// Fingerprint received.
        found: u64,
        /// Fingerprint of the type.
        expected: u64,
    },
    /// No channel of this contract.
    #[error("{0:?} is no channel of Touchdown; the channels are {all}", all = crate::CHANNELS.join(", "))]
    Channel(String),
    /// A value that can't be used.
    #[error("{channel}: {cause}")]
    Unusable {
        /// Channel.
        channel: &'static str,
        /// Which value, and why.
        cause: Unusable,
    },
}

/// A decoded value that can't be used.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Unusable {
    /// Not finite, not normalised or out of range.
    #[error(transparent)]
    Invalid(#[from] Invalid),
    /// A role that is none.
    #[error("node_role is \"{}\", not robot, sensor or controller padded with zeros; the message is refused", .0.escape_ascii())]
    Role([u8; 32]),
    /// A parameter that the mask does not name.
    #[error(
        "task_{parameter} is {value}, but bit {bit} of task_parameter_mask is not set; set the bit or send 0"
    )]
    Unmasked {
        /// Name of the parameter.
        parameter: &'static str,
        /// Its value.
        value: f64,
        /// Its mask bit.
        bit: usize,
    },
}

/// Why the last message or packet was refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Refusal {
    /// It does not decode.
    #[error(transparent)]
    Undecodable(#[from] DecodeError),
    /// It is not LCM's.
    #[error("a packet of {length} bytes is no LCM message of a single packet; another program uses the port")]
    Malformed {
        /// Bytes received.
        length: usize,
    },
    /// Its delivery panicked.
    #[error("delivering a message panicked; this is a bug")]
    Panicked,
}

/// A link that can't be had or used.
#[derive(Debug, thiserror::Error)]
pub enum LcmError {
    /// A URL that is none.
    #[error("LCM URL \"{url}\": {problem}; write e.g. udpm://239.255.76.67:7667?ttl=0 or memq://")]
    Url {
        /// The URL.
        url: String,
        /// What is wrong with it.
        problem: String,
    },
    /// The multicast group can't be joined or reached.
    #[error(
        "no route to multicast group {group}: {source}; for one machine: ip link set lo up multicast on && \
         ip route add 224.0.0.0/4 dev lo; for several: the same route on the network's interface"
    )]
    NoRoute {
        /// Group and port.
        group: SocketAddrV4,
        /// The system's answer.
        source: io::Error,
    },
    /// Sending to the group is forbidden.
    #[error(
        "sending to multicast group {group} is forbidden: {source}; a firewall does that: \
         iptables -I OUTPUT -p udp -d {address} -j ACCEPT, or allow udp to that group in your firewall's own tool",
        address = group.ip()
    )]
    Forbidden {
        /// Group and port.
        group: SocketAddrV4,
        /// The system's answer.
        source: io::Error,
    },
    /// Packets to the group don't come back.
    #[error(
        "multicast packets to {group} do not come back within {waited_ms} ms; a firewall drops them: \
         iptables -I INPUT -p udp -d {address} -j ACCEPT, or allow udp to that group in your firewall's own tool",
        address = group.ip()
    )]
    Unheard {
        /// Group and port.
        group: SocketAddrV4,
        /// How long was waited, ms.
        waited_ms: u64,
    },
    /// Another refusal of a socket by the system.
    #[error("can't {action} on {group}: {source}")]
    Socket {
        /// What was tried.
        action: &'static str,
        /// Group and port.
        group: SocketAddrV4,
        /// The system's answer.
        source: io::Error,
    },
    /// liblcm refuses the URL.
    #[error("liblcm can't open \"{url}\"; it may have said why on standard error")]
    Create {
        /// The URL.
        url: String,
    },
    /// One thread receives from so many links at most.
    #[error("a thread receives from {most} links at most; start the others with threads of their own")]
    Links {
        /// How many.
        most: usize,
    },
    /// liblcm can't wait on the descriptor.
    #[error("liblcm's descriptor for \"{url}\" is {descriptor}, not below 1024 (select); close files first")]
    Descriptor {
        /// The URL.
        url: String,
        /// The descriptor.
        descriptor: i32,
    },
    /// The thread that receives can't be started.
    #[error("can't start the thread that receives LCM messages: {0}")]
    Thread(#[source] io::Error),
    /// A message that may not be published.
    #[error("{channel} is not published: {invalid}")]
    Invalid {
        /// Channel.
        channel: &'static str,
        /// Which value, and why.
        #[source]
        invalid: Invalid,
    },
    /// The system does not take a message.
    #[error("can't publish {channel}: {source}")]
    Publish {
        /// Channel.
        channel: String,
        /// The system's answer.
        source: io::Error,
    },
    /// A channel name that LCM does not carry.
    #[error("channel name \"{0}\" is not 1 to 63 bytes without zeros, its suffix included")]
    ChannelName(String),
}

/// An event log that can't be written or read.
#[derive(Debug, thiserror::Error)]
pub enum LogError {
    /// The file can't be opened or read.
    #[error("can't open event log {path}: {source}")]
    Open {
        /// The file.
        path: PathBuf,
        /// The system's answer.
        source: io::Error,
    },
    /// The file can't be written.
    #[error("can't write event log {path}: {source}; is the disk full?")]
    Write {
        /// The file.
        path: PathBuf,
        /// The system's answer.
        source: io::Error,
    },
    /// An event that a log can't hold.
    #[error("event log {path} can't hold channel \"{channel}\" with {length} bytes")]
    Event {
        /// The file.
        path: PathBuf,
        /// Channel.
        channel: String,
        /// Bytes of the message.
        length: usize,
    },
    /// The file ends inside an event, or holds something else.
    #[error("event log {path} is damaged at byte {offset}, after {events} whole events: {problem}")]
    Damaged {
        /// The file.
        path: PathBuf,
        /// Where the damage starts.
        offset: u64,
        /// Events before it.
        events: u64,
        /// What is wrong.
        problem: &'static str,
    },
}
