//! `touchdown watch`: what a cell does, live.

use super::task::{Channels, DEFAULT_URL};
use anyhow::{Context, Result};
use crossbeam::channel::{Receiver, RecvTimeoutError};
use experiment::watch::web::{Server, Shown};
use experiment::watch::{Ear, Lines, View, screen};
use node::clock;
use ratatui::DefaultTerminal;
use ratatui::crossterm::event::{self, Event, KeyCode, KeyEventKind, KeyModifiers};
use std::io::{ErrorKind, IsTerminal, Write, stdout};
use std::process::ExitCode;
use std::sync::Arc;
use std::time::Duration;

/// Watch a cell: nodes, phase, force, object, impact and timing, live in the terminal, as lines where there is none, or in a
/// browser. Nothing is ever sent to the cell
#[derive(clap::Args)]
#[command(after_help = "\
Without --url and --cell: udpm://239.255.76.67:7667?ttl=0, this host alone.
In the terminal q, Esc or Ctrl-C ends it; so do SIGTERM and SIGINT.

Exit codes:
  0  asked to end
  1  the URL can't be listened on, or the port of --web is taken
  2  wrong usage or cell")]
pub(crate) struct Args {
    #[command(flatten)]
    channels: Channels,
    /// Print lines, also in a terminal: one for each change, and one a second
    #[arg(long, conflicts_with_all = ["json", "web"])]
    lines: bool,
    /// Serve a page at http://127.0.0.1:PORT, for browsers on this host alone; 0: a free port [default PORT: 8765]
    #[arg(long, value_name = "PORT", num_args = 0..=1, default_missing_value = "8765", conflicts_with = "json")]
    web: Option<u16>,
    /// Print a JSON object a second, each on a line of its own, with all that is shown
    #[arg(long)]
    json: bool,
}

/// Between two pictures, and between two looks at what has come where there is no terminal.
const PERIOD: Duration = Duration::from_millis(100);
/// Between two objects of --json.
const SECOND: Duration = Duration::from_secs(1);

pub(crate) fn run(args: &Args) -> Result<ExitCode> {
    let url = args.channels.named()?.unwrap_or_else(|| DEFAULT_URL.to_owned());
    let stop = node::shell::signals()?;
    // What watches comes after what controls, also where nobody has real-time rights; it is no matter if this fails.
    let _ = rustix::process::nice(10);
    let ear = Ear::open(&url)?;
    if let Some(port) = args.web {
        return serve(port, &stop, &ear);
    }
    let mut view = View::default();
    if args.json {
        every(SECOND, &stop, || {
            ear.drain(&mut view);
            write_line(&serde_json::to_string(&view.snapshot(clock::now()))?)
        })?;
    } else if args.lines || !stdout().is_terminal() {
        write_line(&format!("listening on {url}"))?;
        let mut lines = Lines::default();
        every(PERIOD, &stop, || {
            ear.drain(&mut view);
            let now = clock::now();
            let news = lines.tell(&view.snapshot(now), now);
            let mut read = true;
            for line in news {
                read = read && write_line(&line)?;
            }
            Ok(read)
        })?;
    } else {
        let mut terminal = ratatui::try_init().context("can't use this terminal; add --lines")?;
        let ended = show(&mut terminal, &stop, &ear, &mut view, &url);
        ratatui::try_restore().context("can't restore the terminal; type reset")?;
        ended?;
    }
    Ok(ExitCode::SUCCESS)
}

/// Serve the page until a signal comes.
fn serve(port: u16, stop: &Receiver<()>, ear: &Ear) -> Result<ExitCode> {
    let shown = Arc::new(Shown::default());
    let server = Server::start(port, shown.clone()).with_context(|| {
        format!("can't serve on 127.0.0.1:{port}; choose another port, or --web 0 for a free one")
    })?;
    write_line(&format!("http://{}/", server.address()))?;
    every(PERIOD, stop, || {
        ear.drain(&mut shown.lock());
        Ok(true)
    })?;
    Ok(ExitCode::SUCCESS)
}

/// Do `work` after every `period` until a signal comes, or it says that nobody reads any more.
fn every(period: Duration, stop: &Receiver<()>, mut work: impl FnMut() -> Result<bool>) -> Result<()> {
    while stop.recv_timeout(period) == Err(RecvTimeoutError::Timeout) && work()? {}
    Ok(())
}

/// A line on stdout; `false`: its reader has gone, as `head` does.
fn write_line(line: &str) -> Result<bool> {
    match writeln!(stdout(), "{line}").and_then(|()| stdout().flush()) {
        Err(error) if error.kind() == ErrorKind::BrokenPipe => Ok(false),
        written => written.map(|()| true).map_err(Into::into),
    }
}

/// Draw until a key or a signal asks to end.
fn show(
    terminal: &mut DefaultTerminal,
    stop: &Receiver<()>,
    ear: &Ear,
    view: &mut View,
    url: &str,
) -> Result<()> {
    while stop.try_recv().is_err() {
        ear.drain(view);
        let snapshot = view.snapshot(clock::now());
        terminal.draw(|frame| screen::draw(frame, url, &snapshot, view.points()))?;
        let next = clock::now() + PERIOD;
        // A key that means nothing, or a new size, makes no picture come earlier.
        while event::poll(next.saturating_duration_since(clock::now()))? {
            if ends(&event::read()?) {
                return Ok(());
            }
        }
    }
    Ok(())
}

/// Whether `event` is a key that ends.
fn ends(event: &Event) -> bool {
    let Event::Key(key) = event else {
        return false;
    };
    let control_c = key.code == KeyCode::Char('c') && key.modifiers.contains(KeyModifiers::CONTROL);
    key.kind == KeyEventKind::Press && (control_c || matches!(key.code, KeyCode::Char('q') | KeyCode::Esc))
}
