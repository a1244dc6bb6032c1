//! The wire against its contract: golden bytes, round trips, hostile packets, logs, and Python's LCM.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "tests")]

mod constants;
mod draw;
mod event_log;
mod golden;
mod hostile;
mod interop;
mod link;
mod python;
mod round_trip;
mod samples;

use std::net::UdpSocket;

/// The URL of a multicast group on a port of the test's own.
fn udpm_url() -> String {
    let free = UdpSocket::bind("127.0.0.1:0").expect("a free port");
    let port = free.local_addr().expect("a bound socket").port();
    format!("udpm://239.255.76.68:{port}?ttl=0")
}

/// The value, or the error as people read it.
fn expect<T>(result: Result<T, lcmtypes::LcmError>) -> T {
    result.unwrap_or_else(|error| panic!("{error}"))
}
