//! The interface that multicast takes, and whether it is a member of the group.

use super::multicast::{Asked, REJECTED, Route};
use super::{Finding, Verdict, read};
use std::net::Ipv4Addr;

const UP: u32 = 0x1;
const LOOPBACK: u32 = 0x8;
const MULTICAST: u32 = 0x1000;

/// An interface and its flags (IFF_*).
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Interface {
    pub(super) name: String,
    /// `None`: they can't be read here.
    pub(super) flags: Option<u32>,
}

impl Interface {
    /// Whether it has the flag, as far as is known.
    fn has(&self, flag: u32) -> Option<bool> {
        self.flags.map(|flags| flags & flag != 0)
    }
}

/// All interfaces of this network namespace, as `devices` (`/proc/net/dev`) names them. `memberships` is `/proc/net/igmp`; both
/// are always of this namespace, while `/sys` may have been mounted in another one.
pub(super) fn interfaces(devices: &str, memberships: &str) -> Vec<Interface> {
    let indices = indices(memberships);
    let names = devices
        .lines()
        .skip(2)
        .filter_map(|line| line.split_once(':'))
        .map(|(name, _)| name.trim().to_owned());
    let flags = |name: &str| {
        let file = |key: &str| read(&format!("/sys/class/net/{name}/{key}"));
        let index = file("ifindex").trim().to_owned();
        let elsewhere = indices
            .iter()
            .any(|(here, device)| device == name && *here != index);
        let flags = u32::from_str_radix(file("flags").trim().strip_prefix("0x")?, 16).ok()?;
        (!elsewhere).then_some(flags)
    };
    names
        .map(|name| Interface {
            flags: flags(&name),
            name,
        })
        .collect()
}

/// The first interface that leads out of this host.
pub(super) fn outward(interfaces: &[Interface]) -> Option<&str> {
    let leads = |it: &&Interface| {
        it.name != "lo"
            && it.has(LOOPBACK) != Some(true)
            && [UP, MULTICAST].iter().all(|flag| it.has(*flag) != Some(false))
    };
    interfaces.iter().find(leads).map(|it| it.name.as_str())
}

/// Whether the interface that the group's datagrams take is fit for them.
pub(super) fn interface(route: Option<&Route>, interfaces: &[Interface], asked: &Asked<'_>) -> Finding {
    let finding = |verdict, observed: String| Finding::new("interface", verdict, observed);
    let wanted = asked.interface();
    let Some(route) = route else {
        return finding(Verdict::Bad, format!("none leads to {}", asked.group))
            .mended_by(format!("sudo ip route add 224.0.0.0/4 dev {wanted}"));
    };
    let name = route.interface.as_str();
    if name == "lo" && asked.ttl > 0 {
        return finding(
            Verdict::Bad,
            format!(
                "{} goes to lo, so that nothing leaves this host although ttl is {}",
                asked.group, asked.ttl
            ),
        )
        .mended_by(format!("sudo ip route replace 224.0.0.0/4 dev {wanted}"));
    }
    if name == REJECTED {
        return finding(Verdict::Bad, format!("none: {route}")).mended_by(route.removal());
    }
    let flags = interfaces
        .iter()
        .find(|it| it.name == name)
        .and_then(|it| it.flags);
    let Some(flags) = flags else {
        return finding(Verdict::Good, format!("{name}, whose flags can't be read here"));
    };
    let has = |flag| flags & flag != 0;
    if !has(UP) {
        finding(Verdict::Bad, format!("{name} is down")).mended_by(format!("sudo ip link set {name} up"))
    } else if has(LOOPBACK) && !has(MULTICAST) {
        finding(
            Verdict::Good,
            format!("{name} is up; its flag MULTICAST is not set, which Linux does not ask for on loopback"),
        )
    } else if !has(MULTICAST) {
        finding(
            Verdict::Warning,
            format!("{name} is up, but its flag MULTICAST is not set"),
        )
        .mended_by(format!("sudo ip link set dev {name} multicast on"))
    } else {
        finding(Verdict::Good, format!("{name} is up and has the flag MULTICAST"))
    }
}

/// Whether the kernel has made the interface a member of the group, as `table` (`/proc/net/igmp`) showed while a socket
/// had joined it: switches with IGMP snooping send the group's datagrams to members alone.
pub(super) fn membership(table: &str, route: Option<&Route>, group: Ipv4Addr) -> Finding {
    let finding = |verdict, observed: String| Finding::new("membership", verdict, observed);
    let members = members(table, group);
    let leaves = route.map(|route| route.interface.as_str());
    match (members.as_slice(), leaves) {
        ([], _) => finding(
            Verdict::Warning,
            format!("no interface becomes a member of {group}; see multicast"),
        ),
        (members, Some(name)) if !members.iter().any(|member| member == name) => finding(
            Verdict::Warning,
            format!(
                "{} is a member of {group}, but its datagrams leave through {name}",
                members.join(", ")
            ),
        )
        .mended_by(format!("sudo ip route replace 224.0.0.0/4 dev {name}")),
        (members, _) => finding(
            Verdict::Good,
            format!(
                "{} becomes a member of {group} when a node starts",
                members.join(", ")
            ),
        ),
    }
}

/// Index and name of the interfaces in `/proc/net/igmp`.
fn indices(table: &str) -> Vec<(String, String)> {
    let device = |line: &str| {
        let (head, _) = line.split_once(':')?;
        let mut words = head.split_ascii_whitespace();
        Some((words.next()?.to_owned(), words.next()?.to_owned()))
    };
    let heads = table.lines().skip(1).filter(|line| !line.starts_with('\t'));
    heads.filter_map(device).collect()
}

/// The interfaces that are members of `group`.
fn members(table: &str, group: Ipv4Addr) -> Vec<String> {
    let wanted = format!("{:08X}", u32::from_ne_bytes(group.octets()));
    let (mut members, mut device) = (Vec::new(), None);
    for line in table.lines().skip(1) {
        if line.starts_with('\t') {
            if line.split_ascii_whitespace().next() == Some(&wanted) {
                members.extend(device.clone());
            }
        } else {
            device = line.split_ascii_whitespace().nth(1).map(str::to_owned);
        }
    }
    members
}

#[cfg(test)]
mod tests {
    use super::*;

    const IGMP: &str = "Idx\tDevice    : Count Querier\tGroup    Users Timer\tReporter\n\
                        1\tlo        :     1      V3\n\t\t\t\t010000E0     1 0:00000000\t\t0\n\
                        4\teth0      :     2      V3\n\t\t\t\t434CFFEF     1 0:00000000\t\t0\n\
                        \t\t\t\t010000E0     1 0:00000000\t\t0\n";
    const GROUP: Ipv4Addr = Ipv4Addr::new(239, 255, 76, 67);

    fn route(name: &str) -> Route {
        Route {
            interface: name.to_owned(),
            destination: "224.0.0.0/4".to_owned(),
        }
    }

    #[test]
    fn members_and_devices_are_read() {
        assert_eq!(members(IGMP, GROUP), ["eth0"]);
        assert_eq!(members(IGMP, Ipv4Addr::new(224, 0, 0, 1)), ["lo", "eth0"]);
        assert_eq!(
            indices(IGMP),
            [("1", "lo"), ("4", "eth0")].map(|(i, name)| (i.to_owned(), name.to_owned()))
        );
        assert!(members("", GROUP).is_empty() && indices("x\ny").is_empty());
    }

    #[test]
    fn a_membership_elsewhere_is_warned_of() {
        let verdict = |name: &str| membership(IGMP, Some(&route(name)), GROUP);
        assert_eq!(verdict("eth0").verdict, Verdict::Good);
        assert_eq!(
            verdict("eth1").remedy.as_deref(),
            Some("sudo ip route replace 224.0.0.0/4 dev eth1")
        );
        assert_eq!(membership("", None, GROUP).verdict, Verdict::Warning);
    }

    #[test]
    fn what_an_interface_lacks_is_named_with_its_remedy() {
        let all = [
            ("eth0", UP | MULTICAST),
            ("eth1", 0),
            ("lo", UP | LOOPBACK),
            ("tun0", UP),
        ];
        let all = all.map(|(name, flags)| Interface {
            name: name.to_owned(),
            flags: Some(flags),
        });
        assert_eq!(outward(&all), Some("eth0"));
        let find = |name: Option<&str>, ttl| {
            let asked = Asked {
                group: GROUP,
                ttl,
                outward: outward(&all),
            };
            let found = interface(name.map(route).as_ref(), &all, &asked);
            (found.verdict, found.remedy.unwrap_or_default())
        };
        assert_eq!(find(Some("eth0"), 1).0, Verdict::Good);
        assert_eq!(find(Some("lo"), 0).0, Verdict::Good);
        assert_eq!(find(Some("ppp0"), 0).0, Verdict::Good);
        for (name, ttl, verdict, remedy) in [
            (None, 0, Verdict::Bad, "sudo ip route add 224.0.0.0/4 dev lo"),
            (None, 1, Verdict::Bad, "sudo ip route add 224.0.0.0/4 dev eth0"),
            (
                Some("lo"),
                1,
                Verdict::Bad,
                "sudo ip route replace 224.0.0.0/4 dev eth0",
            ),
            (Some("eth1"), 1, Verdict::Bad, "sudo ip link set eth1 up"),
            (
                Some("tun0"),
                1,
                Verdict::Warning,
                "sudo ip link set dev tun0 multicast on",
            ),
        ] {
            assert_eq!(find(name, ttl), (verdict, remedy.to_owned()));
        }
    }
}
