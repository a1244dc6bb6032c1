use std::sync::mpsc;
use std::thread;

use super::*;

const QUIET: Duration = Duration::from_millis(50);

fn sender() -> UdpSocket {
    let socket = UdpSocket::bind((Ipv4Addr::UNSPECIFIED, 0)).unwrap();
    socket.set_multicast_ttl_v4(0).unwrap();
    socket
}

#[test]
fn a_locked_port_is_refused_until_it_is_released() {
    let run = RunPort::free(QUIET).unwrap();
    let port = run.port();
    assert!(FREE_PORTS.contains(&port) && port.is_multiple_of(2));
    assert_eq!(run.device_url(), format!("udpm://239.255.76.67:{port}?ttl=0"));
    assert_eq!(
        run.simulation_url(),
        format!("udpm://239.255.76.67:{}?ttl=0", port + 1)
    );

    // A run that overlaps by one port is refused as well.
    for asked in [port - 1, port, port + 1] {
        let error = RunPort::fixed(asked, QUIET).unwrap_err();
        assert!(matches!(error, RunPortError::Locked { .. }), "{asked}: {error}");
    }
    let other = RunPort::free(QUIET).unwrap();
    assert_ne!(other.port(), port);

    drop(run);
    assert_eq!(RunPort::fixed(port, QUIET).unwrap().port(), port);
}

#[test]
fn foreign_traffic_is_named() {
    for offset in [0, 1] {
        let port = RunPort::free(QUIET).unwrap().port();
        let (socket, (stop, stopped)) = (sender(), mpsc::channel::<()>());
        let local = socket.local_addr().unwrap().port();
        let chatter = thread::spawn(move || {
            while stopped.recv_timeout(Duration::from_millis(5)) == Err(mpsc::RecvTimeoutError::Timeout) {
                socket
                    .send_to(b"LC02\0\0\0\x07ARM_STATE\0...", (GROUP, port + offset))
                    .unwrap();
            }
        });
        let error = RunPort::fixed(port, 20 * QUIET).unwrap_err();
        drop(stop);
        chatter.join().unwrap();
        match &error {
            RunPortError::Foreign { port: on, heard, .. } => {
                assert_eq!((*on, heard.sender.port()), (port + offset, local));
                assert_eq!(heard.channel.as_deref(), Some("ARM_STATE"));
            }
            _ => panic!("{error}"),
        }
        assert!(
            error.to_string().contains("channel \"ARM_STATE\" from"),
            "{error}"
        );
    }
}

#[test]
fn a_listener_is_no_foreign_traffic() {
    let run = RunPort::free(QUIET).unwrap();
    let port = run.port();
    drop(run);
    let _spy = receiver(port).unwrap();
    assert!(RunPort::fixed(port, QUIET).is_ok());
}

#[test]
fn a_port_that_is_not_shared_is_refused() {
    let port = RunPort::free(QUIET).unwrap().port();
    let _owner = UdpSocket::bind((Ipv4Addr::UNSPECIFIED, port)).unwrap();
    let error = RunPort::fixed(port, QUIET).unwrap_err();
    assert!(matches!(error, RunPortError::Taken { .. }), "{error}");
}

#[test]
fn ports_out_of_range_are_refused() {
    for port in [0, 1023, 65_535] {
        let error = RunPort::fixed(port, QUIET).unwrap_err();
        assert!(matches!(error, RunPortError::OutOfRange { .. }), "{error}");
    }
}

#[test]
fn channels_of_short_messages_are_read_and_nothing_else() {
    assert_eq!(
        channel(b"LC02\0\0\0\x01ROBOT_STATE\0data").as_deref(),
        Some("ROBOT_STATE")
    );
    assert_eq!(channel(b"LC02\0\0\0\x01\x1b[31m\0").as_deref(), Some("\\x1b[31m"));
    let endless = [b"LC02\0\0\0\x01".as_slice(), &[b'A'; 100]].concat();
    for other in [
        b"".as_slice(),
        b"LC02",
        b"LC02\0\0\0",
        b"LC02\0\0\0\x01NO_END",
        b"LC03\0\0\0\x01A\0",
        &endless,
    ] {
        assert_eq!(channel(other), None, "{other:?}");
    }
}
