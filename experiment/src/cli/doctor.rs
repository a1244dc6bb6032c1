//! `touchdown doctor`.

use super::task::Channels;
use super::{print, print_json};
use anyhow::Result;
use experiment::doctor::peer::{self, DEFAULT_URL, Peer, PeerOptions};
use experiment::doctor::{Finding, Options, Table, examine, exit_code};
use serde::Serialize;
use std::process::ExitCode;
use std::time::Duration;

/// Examine whether this host is fit for LCM over UDP multicast, who is on a URL, and, with --peer, what two hosts hear of each
/// other; each finding with the command that mends it
#[derive(clap::Args)]
#[command(after_help = "\
Exit codes:
  0  no finding is bad (warnings: runs work, not at their best)
  1  a finding is bad
  2  wrong usage or cell")]
pub(crate) struct Args {
    #[command(flatten)]
    channels: Channels,
    /// Check two hosts: run it on both at the same time; each asks the other and answers it, on the URL's group and port
    /// [default URL then: udpm://239.255.76.67:7667?ttl=1]
    #[arg(long)]
    peer: bool,
    /// With --peer: how long to wait for the other host
    #[arg(long, default_value_t = 60, value_name = "S", value_parser = clap::value_parser!(u64).range(1..=3600), requires = "peer")]
    wait_s: u64,
    /// With --peer: how long to measure once it is heard
    #[arg(long, default_value_t = 5, value_name = "S", value_parser = clap::value_parser!(u64).range(1..=3600), requires = "peer")]
    measure_s: u64,
    /// Print one JSON object instead of text
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct Report<'a> {
    command: &'static str,
    findings: &'a [Finding],
    /// The figures of `--peer`.
    #[serde(skip_serializing_if = "Option::is_none")]
    peers: Option<Vec<Peer>>,
}

pub(crate) fn run(args: &Args) -> Result<ExitCode> {
    let named = args.channels.named()?;
    let url = named.or_else(|| args.peer.then(|| DEFAULT_URL.to_owned()));
    let mut examined = Options {
        url: url.clone(),
        ..Options::default()
    };
    if args.peer {
        // The hosts are to be asked, not the nodes, which need not have been started.
        examined.listen_for_nodes = Duration::ZERO;
    }
    let mut findings = examine(&examined)?;
    let tell = |findings: &[Finding]| match args.json {
        true => Ok(()),
        false => print(Table(findings)),
    };
    tell(&findings)?;
    let mut peers = None;
    if let Some(url) = url.filter(|_| args.peer) {
        let options = PeerOptions {
            url,
            wait: Duration::from_secs(args.wait_s),
            measure: Duration::from_secs(args.measure_s),
        };
        tracing::info!(
            "asking on {}; the same command is to run on the other host within {} s",
            options.url,
            args.wait_s
        );
        let (found, heard) = match peer::measure(&options) {
            Ok(heard) => (peer::judge(&heard, &options)?, heard),
            // It says how to mend it.
            Err(error) => (vec![Finding::bad("peer", error.to_string())], Vec::new()),
        };
        tell(&found)?;
        findings.extend(found);
        peers = Some(heard);
    }
    if args.json {
        print_json(&Report {
            command: "doctor",
            findings: &findings,
            peers,
        })?;
    }
    Ok(ExitCode::from(exit_code(&findings)))
}
