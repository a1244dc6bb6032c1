//! Whatever arrives on the port: it is counted, and messages go on arriving.

use crate::link::next;
use crate::{expect, udpm_url};
use lcmtypes::{LcmBuilder, Message};
use spatial::ports::Task;
use std::net::UdpSocket;

/// A header of LCM's fragments ("LC03"), with its five numbers.
fn fragment(size: u32, offset: u32, number: u16, count: u16, rest: &[u8]) -> Vec<u8> {
    let numbers = [
        &7u32.to_be_bytes()[..],
        &size.to_be_bytes(),
        &offset.to_be_bytes(),
    ]
    .concat();
    [
        b"LC03",
        &numbers[..],
        &number.to_be_bytes(),
        &count.to_be_bytes(),
        rest,
    ]
    .concat()
}

#[test]
fn malformed_packets_are_survived_and_counted() {
    let url = udpm_url();
    let group = url.trim_start_matches("udpm://").split('?').next().unwrap();
    let mut builder = expect(LcmBuilder::open(&url));
    let tasks = builder.subscribe::<Task>(8);
    let all = builder.subscribe_all(64);
    let lcm = expect(builder.start());

    let socket = UdpSocket::bind("0.0.0.0:0").unwrap();
    socket.set_multicast_ttl_v4(0).unwrap();
    let malformed = [
        vec![],
        vec![0],
        b"LC02\0\0\0\0".to_vec(),
        b"LC02\0\0\0\0TASK".to_vec(),
        b"LC02\0\0\0\0\0nameless".to_vec(),
        [b"LC02\0\0\0\0".as_slice(), &[b'N'; 64], b"\0"].concat(),
        [b"LC02\0\0\0\0".as_slice(), &[b'N'; 1392]].concat(),
        b"GET / HTTP/1.1\r\n\r\n".to_vec(),
        vec![0xff; 1400],
        // Copies outside the buffer in liblcm: the length wraps around below zero, the offset above 2^32.
        fragment(224, 1, 0, 2, b"TASK"),
        fragment(224, 0xffff_fff0, 0, 2, b"TASK\0aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa"),
        fragment(0xffff_ffff, 0, 0, 0xffff, b"TASK\0"),
        fragment(0, 0, 0xffff, 0, b""),
        b"LC03".to_vec(),
    ];
    for packet in &malformed {
        socket.send_to(packet, group).unwrap();
    }
    // Well formed, but of no use.
    let task = Task::default();
    let encoding = task.encode().unwrap();
    let useless = [
        b"LC02\0\0\0\0TASK\0".as_slice(),
        b"LC02\0\0\0\0TASK\0short",
        b"LC02\xff\xff\xff\xff\xfe\xff\0",
    ];
    for packet in useless {
        socket.send_to(packet, group).unwrap();
    }
    let good = [b"LC02\0\0\0\0TASK\0", encoding.as_bytes()].concat();
    socket.send_to(&good, group).unwrap();

    assert_eq!(next(&tasks), task);
    let counters = lcm.counters();
    assert_eq!(counters.malformed, malformed.len() as u64);
    assert_eq!(
        (counters.undecodable, counters.panics, counters.dropped),
        (2, 0, 0)
    );
    let channels: Vec<String> = (0..4).map(|_| next(&all).channel).collect();
    assert_eq!(channels, ["TASK", "TASK", "\u{fffd}\u{fffd}", "TASK"]);
    let refusal = lcm.last_refusal().unwrap().to_string();
    assert_eq!(
        refusal,
        "a packet of 4 bytes is no LCM message of a single packet; another program uses the port"
    );
}
