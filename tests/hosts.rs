//! Three hosts and a network between them, out of this machine's namespaces.
//!
//! Who needs them runs itself once more as root of namespaces of its own ([`on_hosts`], [`enter`]): there a bridge joins three
//! network namespaces, and each program's monotonic clock starts elsewhere.

use spatial::ports::Role;
use std::env;
use std::ffi::OsStr;
use std::process::{Command, ExitStatus, Output, Stdio};

/// Set for a test that runs inside.
const INSIDE: &str = "TOUCHDOWN_HOSTS";
/// By role: name of the host, its address, and how far its monotonic clock is ahead, s.
const HOSTS: [(&str, &str, &str); 3] = [
    ("robot", "10.77.0.1/24", "1000"),
    ("sensor", "10.77.0.2/24", "250000"),
    ("controller", "10.77.0.3/24", "70"),
];

/// The three hosts.
pub struct Hosts(());

impl Hosts {
    /// By role: what starts a program on its host.
    pub fn through(&self) -> [Vec<String>; 3] {
        HOSTS.map(|(name, _, ahead)| {
            let words =
                format!("ip netns exec {name} unshare --time --monotonic {ahead} --fork --kill-child");
            words.split(' ').map(str::to_owned).collect()
        })
    }

    /// `program` on the host of `role`, which has that name, by the clock of this one.
    pub fn command(&self, role: Role, program: impl AsRef<OsStr>) -> Command {
        let (name, ..) = HOSTS[role as usize];
        let mut command = Command::new("ip");
        command.args(["netns", "exec", name, "unshare", "--uts", "sh", "-c"]);
        command
            .args(["hostname \"$0\" && exec \"$@\"", name])
            .arg(program);
        command
    }

    fn set_up() -> Result<Self, String> {
        // Multicast is forwarded to every port of the bridge: nobody answers group queries here.
        run("mount -t tmpfs tmpfs /run")?;
        run("ip link set lo up")?;
        run("ip link add hub type bridge mcast_snooping 0")?;
        run("ip addr add 10.77.0.100/24 dev hub")?;
        run("ip link set hub up")?;
        run("ip route add 224.0.0.0/4 dev hub")?;
        for (name, address, _) in HOSTS {
            run(&format!("ip netns add {name}"))?;
            run(&format!(
                "ip link add to-{name} type veth peer name eth0 netns {name}"
            ))?;
            run(&format!("ip link set to-{name} master hub up"))?;
            run(&format!("ip -n {name} addr add {address} dev eth0"))?;
            run(&format!("ip -n {name} link set lo up"))?;
            run(&format!("ip -n {name} link set eth0 up"))?;
            run(&format!("ip -n {name} route add 224.0.0.0/4 dev eth0"))?;
        }
        Ok(Self(()))
    }
}

/// Run `body` on three hosts, in the test of this `name` (with its modules). Where namespaces are not allowed it is
/// skipped, which is said; in continuous integration that is a failure.
pub fn on_hosts(name: &str, body: impl FnOnce(&Hosts)) {
    match enter(&[name, "--exact", "--nocapture"]) {
        Entered::Inside(hosts) => body(&hosts),
        Entered::Done(status) => assert!(status.success(), "it failed inside, see above"),
        Entered::Not(cause) => {
            assert!(env::var_os("CI").is_none(), "there are no hosts here: {cause}");
            eprintln!("skipped: there are no hosts here: {cause}");
        }
    }
}

/// Where a program is that wants to be among three hosts.
pub enum Entered {
    /// There.
    Inside(Hosts),
    /// It has been there, and ended so.
    Done(ExitStatus),
    /// Not there, and why.
    Not(String),
}

/// Run this program once more with `arguments` where three hosts are, unless it is there already.
pub fn enter(arguments: &[&str]) -> Entered {
    if env::var_os(INSIDE).is_some() {
        return Hosts::set_up().map_or_else(
            |cause| Entered::Not(format!("no network between them: {cause}")),
            Entered::Inside,
        );
    }
    let allowed = Command::new("unshare").args(["-Urnm", "true"]).output();
    if !allowed.as_ref().is_ok_and(|output| output.status.success()) {
        let cause = allowed.map_or_else(|error| error.to_string(), |output| said(&output));
        return Entered::Not(format!("namespaces are not allowed: {cause}"));
    }
    let run = |own| {
        Command::new("unshare")
            .args(["-Urnm", "--kill-child", "--fork"])
            .arg(own)
            .args(arguments)
            .env(INSIDE, "1")
            .stdin(Stdio::null())
            .status()
    };
    env::current_exe()
        .and_then(run)
        .map_or_else(|error| Entered::Not(error.to_string()), Entered::Done)
}

fn run(words: &str) -> Result<(), String> {
    let mut parts = words.split(' ');
    let output = Command::new(parts.next().unwrap_or_default())
        .args(parts)
        .output()
        .map_err(|error| format!("{words}: {error}"))?;
    match output.status.success() {
        true => Ok(()),
        false => Err(format!("{words}: {}", said(&output))),
    }
}

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).trim().to_owned()
}
