//! LCM URLs, taken apart before liblcm sees them: its own complaints name the wrong thing.

use crate::error::LcmError;
use crate::suffix::Suffix;
use std::net::{Ipv4Addr, SocketAddrV4};

/// What a URL names.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Url {
    /// `udpm://`: a multicast group, and the channels of it that are a cell's.
    Multicast(Group, Suffix),
    /// `memq://`: this link alone.
    Memory,
}

/// A multicast group and how to use it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Group {
    /// Group and port.
    pub address: SocketAddrV4,
    /// 0: this machine, 1: this network.
    pub ttl: u8,
    /// Kernel's receive buffer, bytes.
    pub receive_buffer: usize,
    /// Receive through liblcm instead of the own socket: slower, and with liblcm's defects.
    pub through_liblcm: bool,
}

impl Group {
    /// The group that `url` names; `None`: it names none, its messages stay in the process.
    pub fn of(url: &str) -> Result<Option<Self>, LcmError> {
        Ok(match Url::parse(url)? {
            Url::Multicast(group, _) => Some(group),
            Url::Memory => None,
        })
    }
}

/// liblcm's defaults.
const DEFAULT_ADDRESS: Ipv4Addr = Ipv4Addr::new(239, 255, 76, 67);
const DEFAULT_PORT: u16 = 7667;
/// Some hundred messages: a busy machine may not schedule the receiver for that long.
const DEFAULT_RECEIVE_BUFFER: usize = 1 << 20;

impl Url {
    pub(crate) fn parse(url: &str) -> Result<Self, LcmError> {
        parse(url).map_err(|problem| LcmError::Url {
            url: url.to_owned(),
            problem,
        })
    }

    /// The group whose messages the own socket receives; `None`: liblcm does.
    pub(crate) fn socket(&self) -> Option<&Group> {
        match self {
            Self::Multicast(group, _) if !group.through_liblcm => Some(group),
            _ => None,
        }
    }

    /// What ends the names of the channels.
    pub(crate) fn suffix(&self) -> Suffix {
        match self {
            Self::Multicast(_, suffix) => suffix.clone(),
            Self::Memory => Suffix::default(),
        }
    }

    /// The URL for liblcm: everything spelled out.
    pub(crate) fn for_liblcm(&self) -> String {
        match self {
            Self::Multicast(group, _) => {
                let Group { address, ttl, .. } = group;
                format!(
                    "udpm://{address}?ttl={ttl}&recv_buf_size={}",
                    group.receive_buffer
                )
            }
            Self::Memory => "memq://".to_owned(),
        }
    }
}

fn parse(url: &str) -> Result<Url, String> {
    let (provider, rest) = url.split_once("://").ok_or("it has no ://")?;
    let (network, options) = rest.split_once('?').unwrap_or((rest, ""));
    match provider {
        "udpm" => multicast(network, options),
        "memq" if rest.is_empty() => Ok(Url::Memory),
        "memq" => Err(format!("memq takes no \"{rest}\"")),
        "file" => Err("files are read and written as event logs, not as links".to_owned()),
        "tcpq" => Err("liblcm's tcpq can't publish and receive from two threads".to_owned()),
        _ => Err(format!("provider \"{provider}\" is not known")),
    }
}

fn multicast(network: &str, options: &str) -> Result<Url, String> {
    let (host, port) = network.split_once(':').unwrap_or((network, ""));
    let ip = if host.is_empty() {
        DEFAULT_ADDRESS
    } else {
        host.parse()
            .map_err(|_| format!("address \"{host}\" is no IPv4 address"))?
    };
    if !ip.is_multicast() {
        return Err(format!(
            "address {ip} is no multicast address (224.0.0.0 to 239.255.255.255)"
        ));
    }
    let port = if port.is_empty() {
        DEFAULT_PORT
    } else {
        number("port", port, 1, u16::MAX)?
    };
    let mut group = Group {
        address: SocketAddrV4::new(ip, port),
        ttl: 0,
        receive_buffer: DEFAULT_RECEIVE_BUFFER,
        through_liblcm: false,
    };
    let mut suffix = Suffix::default();
    for option in options.split('&').filter(|option| !option.is_empty()) {
        match option.split_once('=').unwrap_or((option, "")) {
            ("ttl", value) => group.ttl = number("ttl", value, 0, u8::MAX)?,
            ("recv_buf_size", value) => {
                group.receive_buffer = number("recv_buf_size", value, 1, 1 << 30)?;
            }
            ("receive", "socket") => group.through_liblcm = false,
            ("receive", "liblcm") => group.through_liblcm = true,
            ("receive", value) => return Err(format!("receive is \"{value}\", not socket or liblcm")),
            ("suffix", value) => suffix = value.parse()?,
            (name, _) => {
                return Err(format!(
                    "option \"{name}\" is not ttl, recv_buf_size, receive or suffix"
                ));
            }
        }
    }
    Ok(Url::Multicast(group, suffix))
}

fn number<T>(name: &str, text: &str, minimum: T, maximum: T) -> Result<T, String>
where
    T: std::str::FromStr + PartialOrd + std::fmt::Display,
{
    match text.parse() {
        Ok(value) if minimum <= value && value <= maximum => Ok(value),
        _ => Err(format!("{name} is \"{text}\", not within {minimum}..={maximum}")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_multicast_url_may_leave_out_what_has_a_default() {
        let spelled_out = Url::parse("udpm://239.255.76.67:7667?ttl=0");
        assert_eq!(spelled_out.unwrap(), Url::parse("udpm://").unwrap());
        let Url::Multicast(group, suffix) = Url::parse("udpm://:7001?ttl=1&recv_buf_size=65536").unwrap()
        else {
            panic!("not multicast");
        };
        assert_eq!(group.address.to_string(), "239.255.76.67:7001");
        assert_eq!((group.ttl, group.receive_buffer), (1, 65536));
        assert!(!group.through_liblcm);
        assert_eq!(suffix, Suffix::default());
        let cell = Url::parse("udpm://:7001?ttl=1&recv_buf_size=65536&suffix=_B").unwrap();
        assert_eq!(cell, Url::Multicast(group, "_B".parse().unwrap()));
        // liblcm complains about options that it does not know.
        assert!(!cell.for_liblcm().contains("suffix"));
        let liblcm = Group::of("udpm://:7001?ttl=1&recv_buf_size=65536&receive=liblcm").unwrap();
        assert_eq!(
            liblcm,
            Some(Group {
                through_liblcm: true,
                ..group
            })
        );
        assert_eq!(
            Group::of("udpm://:7001?ttl=1&recv_buf_size=65536").unwrap(),
            Some(group)
        );
        assert_eq!(Group::of("memq://").unwrap(), None);
    }

    #[test]
    fn a_bad_url_is_refused_with_the_part_that_is_wrong() {
        for (url, problem) in [
            ("", "it has no ://"),
            ("udpm:/239.0.0.1", "it has no ://"),
            (
                "udpm://localhost:7667",
                "address \"localhost\" is no IPv4 address",
            ),
            ("udpm://10.0.0.1:7667", "address 10.0.0.1 is no multicast address"),
            (
                "udpm://239.0.0.1:70000",
                "port is \"70000\", not within 1..=65535",
            ),
            ("udpm://239.0.0.1:0", "port is \"0\", not within 1..=65535"),
            (
                "udpm://239.0.0.1:7667?ttl=256",
                "ttl is \"256\", not within 0..=255",
            ),
            (
                "udpm://239.0.0.1:7667?tll=1",
                "option \"tll\" is not ttl, recv_buf_size, receive or suffix",
            ),
            (
                "udpm://239.0.0.1:7667?suffix=_A.*",
                "suffix is \"_A.*\", not _ and then letters, digits and _",
            ),
            (
                "udpm://239.0.0.1:7667?receive=python",
                "receive is \"python\", not socket or liblcm",
            ),
            ("memq://x", "memq takes no \"x\""),
            ("tcpq://", "liblcm's tcpq can't publish and receive"),
            ("udpm\0://", "provider \"udpm\0\" is not known"),
        ] {
            let message = Url::parse(url).unwrap_err().to_string();
            assert!(message.contains(problem), "{message}");
        }
    }
}
