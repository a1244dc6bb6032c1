use super::multicast::{Asked, NoEcho, Route};
use super::*;

const HEADER: &str = "Iface\tDestination\tGateway\tFlags\tRefCnt\tUse\tMetric\tMask\tMTU\tWindow\tIRTT\n";

#[test]
fn this_host_is_examined() {
    let options = Options {
        listen: Duration::from_millis(20),
        ..Options::default()
    };
    let findings = examine(&options).unwrap();
    let names: Vec<_> = findings.iter().map(|finding| finding.name).collect();
    assert_eq!(
        names,
        [
            "liblcm",
            "loopback",
            "multicast",
            "interface",
            "membership",
            "receive buffer",
            "udp sockets",
            "other lcm",
            "real-time rights",
            "wake-ups",
        ]
    );
    // The tests need multicast themselves.
    assert_eq!(exit_code(&findings), 0, "{}", Table(&findings));
}

#[test]
fn the_most_specific_route_counts() {
    let default = "eth0\t00000000\t010200C0\t0003\t0\t0\t100\t00000000\t0\t0\t0\n";
    let better_default = "wlan0\t00000000\t010200C0\t0003\t0\t0\t50\t00000000\t0\t0\t0\n";
    let elsewhere = "eth1\t000200C0\t00000000\t0001\t0\t0\t0\t00FFFFFF\t0\t0\t0\n";
    let multicast = "lo\t000000E0\t00000000\t0001\t0\t0\t0\t000000F0\t0\t0\t0\n";
    let rejecting = "*\t000000E0\t00000000\t0201\t0\t0\t0\t000000F0\t0\t0\t0\n";
    let through =
        |lines: &[&str]| route(&format!("{HEADER}{}", lines.concat()), GROUP).map(|route| route.interface);
    assert_eq!(through(&[]), None);
    assert_eq!(through(&[elsewhere]), None);
    assert_eq!(
        through(&[elsewhere, default, better_default]).as_deref(),
        Some("wlan0")
    );
    assert_eq!(through(&[default, multicast]).as_deref(), Some("lo"));
    assert_eq!(through(&[default, rejecting]).as_deref(), Some("*"));
    assert_eq!(route("garbage\nlo x y z\n", GROUP), None);
}

#[test]
fn each_cause_has_its_remedy() {
    let lo = Route {
        interface: "lo".to_owned(),
        destination: "224.0.0.0/4".to_owned(),
    };
    let eth0 = Route {
        interface: "eth0".to_owned(),
        destination: "0.0.0.0/0".to_owned(),
    };
    let table = format!("{HEADER}*\t434CFFEF\t00000000\t0201\t0\t0\t0\tFFFFFFFF\t0\t0\t0\n");
    let rejecting = route(&table, GROUP).unwrap();
    let denied = || io::Error::from(io::ErrorKind::PermissionDenied);
    let unreachable = || io::Error::from(io::ErrorKind::NetworkUnreachable);
    let silence = || NoEcho::Silence(Duration::from_millis(500));
    let cases = [
        (
            NoEcho::Join(unreachable()),
            None,
            "no route",
            "ip route add 224.0.0.0/4 dev lo",
        ),
        (
            NoEcho::Send(unreachable()),
            None,
            "no route",
            "ip route add 224.0.0.0/4 dev lo",
        ),
        (
            NoEcho::Send(denied()),
            Some(&eth0),
            "firewall",
            "iptables -I OUTPUT",
        ),
        (
            silence(),
            Some(&eth0),
            "through eth0 (the default route) did not come back within 500 ms",
            "-I INPUT",
        ),
        (
            NoEcho::Join(unreachable()),
            Some(&rejecting),
            "through the route for 239.255.76.67/32, which rejects it",
            "sudo ip route del 239.255.76.67/32",
        ),
        (silence(), Some(&lo), "firewall", "ip link set lo multicast on"),
    ];
    let asked = Asked {
        group: GROUP,
        ttl: 0,
        outward: Some("eth0"),
    };
    for (failure, route, observed, remedy) in cases {
        let finding = multicast(Err(failure), route, &asked);
        assert_eq!(finding.verdict, Verdict::Bad);
        assert!(finding.observed.contains(observed), "{finding:?}");
        assert!(
            finding
                .remedy
                .as_deref()
                .is_some_and(|text| text.contains(remedy)),
            "{finding:?}"
        );
    }
}

#[test]
fn small_receive_buffers_are_warned_of() {
    let finding = receive_buffers(
        2 << 20,
        [("rmem_default", Some(212_992)), ("rmem_max", Some(4 << 20))],
    );
    assert_eq!(finding.verdict, Verdict::Warning);
    assert_eq!(
        finding.remedy.as_deref(),
        Some("sudo sysctl -w net.core.rmem_default=2097152")
    );
    let finding = receive_buffers(2 << 20, [("rmem_default", Some(2 << 20)), ("rmem_max", None)]);
    assert_eq!((finding.verdict, finding.remedy), (Verdict::Good, None));
}

#[test]
fn sockets_and_their_losses_are_counted() {
    let line = |port: u16, drops: u32| {
        format!(" 1: 00000000:{port:04X} 00000000:0000 07 0:0 0:0 0 0 0 9 2 0 {drops}\n")
    };
    let table = [
        "header\n".to_owned(),
        line(7667, 0),
        line(20_000, 3),
        line(31_999, 4),
        line(32_000, 9),
    ]
    .concat();
    let finding = sockets(&table, LCM_DEFAULT_PORT);
    assert_eq!(finding.verdict, Verdict::Warning);
    assert!(
        finding
            .observed
            .starts_with("2 on ports 20000..=31999 (runs), 1 on 7667"),
        "{}",
        finding.observed
    );
    assert!(
        finding.observed.contains("7 datagrams dropped"),
        "{}",
        finding.observed
    );
}

#[test]
fn the_loaded_library_is_named() {
    let maps = "7f00-7f01 r-xp 00000000 08:01 42    /usr/lib/liblcm.so.1.3.4\n7f02-7f03 rw-p 0 00:00 0 \n";
    assert!(
        library((1, 3, 1), maps)
            .observed
            .contains("/usr/lib/liblcm.so.1.3.4")
    );
    assert!(
        library((1, 5, 0), "")
            .observed
            .contains("linked into this program")
    );
}

#[test]
fn the_table_is_aligned_and_json_has_the_same() {
    let findings = [
        Finding::new("loopback", Verdict::Good, "127.0.0.1 is up"),
        Finding::new("multicast", Verdict::Bad, "no route").mended_by("sudo x"),
    ];
    let expected = "good     loopback   127.0.0.1 is up\n\
                    BAD      multicast  no route\n                    remedy: sudo x\n";
    assert_eq!(Table(&findings).to_string(), expected);
    assert_eq!(exit_code(&findings), 1);
    let json = serde_json::to_string(&findings[1]).unwrap();
    assert_eq!(
        json,
        r#"{"name":"multicast","verdict":"bad","observed":"no route","remedy":"sudo x"}"#
    );
}
