use super::*;

fn options(url: &str) -> PeerOptions {
    PeerOptions {
        url: url.to_owned(),
        wait: Duration::from_secs(30),
        measure: Duration::from_secs(5),
    }
}

fn peer() -> Peer {
    Peer {
        host: "control-pc".to_owned(),
        sent: 500,
        heard: 500,
        asked: 500,
        answered: 499,
        round_trip_p50_s: 210e-6,
        round_trip_p99_s: 480e-6,
        clock_offset_s: 0.0123,
        clock_bound_s: 60e-6,
    }
}

fn only(peer: Peer) -> Finding {
    let [finding] = judge(&[peer], &options(DEFAULT_URL)).unwrap().try_into().unwrap();
    finding
}

#[test]
fn a_good_peer_is_told_with_its_figures() {
    let good = only(peer());
    assert_eq!((good.verdict, good.remedy), (Verdict::Good, None));
    assert_eq!(
        good.observed,
        "control-pc: 499 of 500 answered, 500 of its 500 heard; round trip 0.21 ms (p50), 0.48 ms (p99); its wall clock \
         +0.012300 s (+- 60 us)"
    );
}

#[test]
fn loss_slowness_and_a_deaf_peer_have_their_remedies() {
    let lossy = only(Peer { heard: 480, ..peer() });
    assert_eq!(lossy.verdict, Verdict::Warning);
    assert!(
        lossy.observed.ends_with("4.0 % lost, above the limit of 1 %"),
        "{lossy:?}"
    );
    let slow = only(Peer {
        round_trip_p99_s: 3e-3,
        ..peer()
    });
    assert_eq!(slow.verdict, Verdict::Warning);
    assert!(slow.observed.ends_with("p99 above the limit of 2 ms"), "{slow:?}");
    let deaf = only(Peer {
        asked: 0,
        answered: 0,
        ..peer()
    });
    assert_eq!(deaf.verdict, Verdict::Bad);
    assert!(
        deaf.remedy.unwrap().starts_with(
            "on control-pc: sudo iptables -I INPUT -p udp -d 239.255.76.67 --dport 7667 -j ACCEPT"
        )
    );
}

#[test]
fn without_a_peer_the_probable_causes_are_named() {
    let names = |url: &str| {
        let findings = judge(&[], &options(url)).unwrap();
        assert!(findings.iter().all(|finding| finding.remedy.is_some()));
        findings
            .iter()
            .map(|finding| format!("{} {}", finding.observed, finding.remedy.as_deref().unwrap()))
            .collect::<Vec<_>>()
            .join("\n")
    };
    let here = names("udpm://239.255.76.67:7667?ttl=0");
    assert!(here.starts_with("no other host heard on 239.255.76.67:7667 for 30 s"));
    assert!(here.contains("ttl=0 keeps") && here.contains("udpm://239.255.76.67:7667?ttl=1"));
    let network = names(DEFAULT_URL);
    for word in ["ip route replace", "iptables", "rp_filter", "IGMP snooping"] {
        assert!(network.contains(word), "{network}");
    }
    assert!(!network.contains("ttl=0"));
    assert!(names("memq://").contains("stays in one process"));
}
