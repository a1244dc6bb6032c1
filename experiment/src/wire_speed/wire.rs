//! A raw UDP multicast socket, to hear a port with, and one to send to it.

use super::WireSpeedError;
use crate::run_port::{GROUP, receiver};
use lcmtypes::datagram::{self, Parts};
use socket2::SockRef;
use std::io::{self, ErrorKind};
use std::net::{Ipv4Addr, UdpSocket};
use std::time::Duration;

/// As much as the programs ask for: some hundred messages.
const RECEIVE_BUFFER: usize = 1 << 20;

/// A port of the group, on this host.
#[derive(Debug)]
pub(super) struct Wire {
    pub(super) port: u16,
    ear: UdpSocket,
    mouth: UdpSocket,
    sequence: u32,
    outgoing: Vec<u8>,
    incoming: [u8; 2048],
}

impl Wire {
    /// Hear `port`, for at most `patience` at a time.
    pub(super) fn join(port: u16, patience: Duration) -> Result<Self, WireSpeedError> {
        let open = || -> io::Result<(UdpSocket, UdpSocket)> {
            let ear = receiver(port)?;
            SockRef::from(&ear).set_recv_buffer_size(RECEIVE_BUFFER)?;
            ear.set_read_timeout(Some(patience))?;
            let mouth = UdpSocket::bind((Ipv4Addr::UNSPECIFIED, 0))?;
            mouth.set_multicast_ttl_v4(0)?;
            Ok((ear, mouth))
        };
        let (ear, mouth) = open().map_err(failed("open a multicast socket", port))?;
        Ok(Self {
            port,
            ear,
            mouth,
            sequence: 0,
            outgoing: Vec::with_capacity(2048),
            incoming: [0; 2048],
        })
    }

    /// Send a short message.
    pub(super) fn send(&mut self, channel: &str, encoding: &[u8]) -> Result<(), WireSpeedError> {
        datagram::join(&mut self.outgoing, self.sequence, channel, encoding);
        self.sequence = self.sequence.wrapping_add(1);
        let sent = self.mouth.send_to(&self.outgoing, (GROUP, self.port));
        sent.map(|_| ()).map_err(failed("send", self.port))
    }

    /// The next short message, the own ones included; `None`: none has come in time.
    pub(super) fn receive(&mut self) -> Result<Option<Parts<'_>>, WireSpeedError> {
        match self.ear.recv(&mut self.incoming) {
            Ok(length) => Ok(datagram::split(&self.incoming[..length])),
            Err(error) if is_timeout(&error) => Ok(None),
            Err(error) => Err(failed("receive", self.port)(error)),
        }
    }
}

fn is_timeout(error: &io::Error) -> bool {
    matches!(
        error.kind(),
        ErrorKind::WouldBlock | ErrorKind::TimedOut | ErrorKind::Interrupted
    )
}

fn failed(action: &'static str, port: u16) -> impl Fn(io::Error) -> WireSpeedError {
    move |source| WireSpeedError::Socket { action, port, source }
}
