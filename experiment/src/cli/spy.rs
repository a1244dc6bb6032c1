//! `touchdown spy`: lcm-spy with our types.

use super::task::{Channels, DEFAULT_URL};
use super::{FAILED, print, print_json};
use anyhow::{Context, Result, anyhow, bail};
use experiment::spy::Spy;
use serde::Serialize;
use std::fmt::Write;
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Build the jar of our message types for Java and start lcm-spy with it: every channel, every field, and its charts
#[derive(clap::Args)]
#[command(after_help = "\
Without --url and --cell: udpm://239.255.76.67:7667?ttl=0, this host alone. Needs Java 17 or later, lcm-gen, lcm.jar and
jchart2d, and says what to install; with LCM_PREFIX set, those of the LCM there, such as that of Python's package lcm 1.5.

Exit codes:
  0  it was closed; with --check: every channel decodes
  1  something is missing, or a channel does not decode
  2  wrong usage or cell")]
pub(crate) struct Args {
    #[command(flatten)]
    channels: Channels,
    /// Build the jar and ask lcm-spy's database for every type, but show no window
    #[arg(long)]
    check: bool,
    /// Where to build [default: target/spy of the build that this program is of, else ~/.cache/touchdown/spy]
    #[arg(long, value_name = "DIRECTORY")]
    out: Option<PathBuf>,
    /// With --check: print one JSON object instead of text
    #[arg(long, requires = "check")]
    json: bool,
}

#[derive(Serialize)]
struct Report<'a> {
    command: &'static str,
    jar: &'a Path,
    windows: bool,
    types: Vec<Type<'a>>,
}

#[derive(Serialize)]
struct Type<'a> {
    channel: &'static str,
    class: Option<&'a str>,
}

pub(crate) fn run(args: &Args) -> Result<ExitCode> {
    let url = args.channels.named()?.unwrap_or_else(|| DEFAULT_URL.to_owned());
    let out = match &args.out {
        Some(out) => out.clone(),
        None => place()?,
    };
    let spy = Spy::prepare(&out)?;
    let undecodable: Vec<_> = spy.types.iter().filter(|(_, class)| class.is_none()).collect();
    if args.check {
        tell(args, &spy)?;
    }
    if let Some((channel, _)) = undecodable.first() {
        complain_of(channel, undecodable.len());
        return Ok(ExitCode::from(FAILED));
    }
    if args.check {
        return Ok(ExitCode::SUCCESS);
    }
    if !spy.windows {
        bail!(
            "this Java can show no window here; on a desktop: sudo apt-get install default-jre; through ssh: ssh -X; or \
             `touchdown watch`, which needs a terminal alone"
        );
    }
    tracing::info!("lcm-spy on {url}, with {}", spy.jar.display());
    // It takes the place of this process, so that signals reach it.
    Err(anyhow!(spy.command(&url).exec()).context("can't start java"))
}

fn complain_of(channel: &str, count: usize) {
    super::complain(format_args!(
        "lcm-spy decodes {count} of the channels not, {channel} the first; is the jar of another LCM than lcm-gen? Set \
         LCM_PREFIX to one that has both"
    ));
}

fn tell(args: &Args, spy: &Spy) -> Result<()> {
    if args.json {
        let types = spy.types.iter().map(|(channel, class)| Type {
            channel,
            class: class.as_deref(),
        });
        return print_json(&Report {
            command: "spy",
            jar: &spy.jar,
            windows: spy.windows,
            types: types.collect(),
        });
    }
    let mut text = format!("{}\n", spy.jar.display());
    for (channel, class) in &spy.types {
        writeln!(
            text,
            "{channel:18}  {}",
            class.as_deref().unwrap_or("undecodable")
        )?;
    }
    print(text)
}

/// Beside what is built, or among what a user's programs keep.
fn place() -> Result<PathBuf> {
    let own = std::env::current_exe().context("can't find out where this program is")?;
    if let Some(target) = own.ancestors().find(|directory| directory.ends_with("target")) {
        return Ok(target.join("spy"));
    }
    let variable = |name| {
        std::env::var_os(name)
            .filter(|value| !value.is_empty())
            .map(PathBuf::from)
    };
    let cache = variable("XDG_CACHE_HOME").or_else(|| Some(variable("HOME")?.join(".cache")));
    let cache = cache.context("there is no home directory; say where to build with --out")?;
    Ok(cache.join("touchdown/spy"))
}
