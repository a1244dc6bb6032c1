//! `touchdown watch`: as lines, in a terminal, in a browser.

use super::up::{LONG, Up, WHOLE, cell, up};
use crossbeam::channel::never;
use experiment::launch;
use node::clock;
use rustix::process::Signal;
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::{LocalModes, Winsize, tcgetattr, tcsetwinsize};
use std::env;
use std::fs::{self, File, OpenOptions};
use std::io::{Read, Write};
use std::net::{Ipv4Addr, TcpStream};
use std::process::{Child, Command, Stdio};
use std::time::Duration;
use tempfile::TempDir;
use tests::{Bench, signal, touchdown};

fn watch(url: &str, arguments: &[&str]) -> Command {
    let mut command = touchdown();
    command.args(["watch", "--url", url]).args(arguments);
    command
}

#[test]
fn without_a_terminal_it_tells_a_run_in_lines_and_ends_when_asked() {
    let bench = Bench::new(&[]).unwrap();
    let lines = Up::start(watch(&bench.plan.wiring.watch, &[]));
    lines.until("listening on udpm://");
    launch::run(&bench.plan, &never(), |_| ()).unwrap();
    let settled = lines.until("  settled  ");
    let force = settled.split("force ").nth(1).unwrap().split(' ').next().unwrap();
    let force_n: f64 = force.parse().unwrap();
    assert!((force_n - 10.0).abs() < 1.0, "{settled}");
    lines.until("silent");
    assert_eq!(lines.end(), 0);
}

/// A terminal of 100 x 30 characters: the side that a person sees, and the one that a program is given.
pub(super) fn terminal() -> (File, File) {
    // A program that is given the one side must not hold the other open.
    let flags = OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC;
    let seen = openpt(flags).unwrap();
    grantpt(&seen).unwrap();
    unlockpt(&seen).unwrap();
    let name = ptsname(&seen, Vec::new()).unwrap().into_string().unwrap();
    let given = OpenOptions::new().read(true).write(true).open(name).unwrap();
    let size = Winsize {
        ws_row: 30,
        ws_col: 100,
        ws_xpixel: 0,
        ws_ypixel: 0,
    };
    tcsetwinsize(&given, size).unwrap();
    (File::from(seen), given)
}

#[test]
fn in_a_terminal_it_draws_and_leaves_it_as_it_was() {
    let bench = Bench::new(&[]).unwrap();
    let (mut seen, given) = terminal();
    let mut command = watch(&bench.plan.wiring.watch, &[]);
    command.stdin(given.try_clone().unwrap()).stderr(Stdio::null());
    let mut child = command.stdout(given.try_clone().unwrap()).spawn().unwrap();
    // It shows, then it is asked to end, then it shows no more.
    let (mut text, mut part) = (String::new(), [0; 4096]);
    let mut asked = false;
    while !text.contains("\u{1b}[?1049l") {
        let length = seen.read(&mut part).unwrap();
        assert!(length > 0, "{text}");
        text += &String::from_utf8_lossy(&part[..length]);
        if !asked && text.contains("no controller is heard") {
            // What it has drawn with, characters that are not echoed.
            assert!(!tcgetattr(&given).unwrap().local_modes.contains(LocalModes::ECHO));
            signal(child.id(), Signal::TERM);
            asked = true;
        }
    }
    assert!(asked);
    assert_eq!(child.wait().unwrap().code(), Some(0));
    assert!(text.contains("\u{1b}[?1049h"), "{text}");
    let restored = tcgetattr(&given).unwrap().local_modes;
    assert!(restored.contains(LocalModes::ECHO | LocalModes::ICANON));
}

/// A browser without a window.
fn browser() -> Option<&'static str> {
    let known = [
        // The program itself, not the script that starts it: that would be ended alone.
        "/usr/lib/chromium/chromium-headless-shell",
        "chromium-headless-shell",
        "chromium",
        "chromium-browser",
        "google-chrome",
    ];
    let there = |name: &&str| {
        Command::new(name)
            .arg("--version")
            .output()
            .is_ok_and(|it| it.status.success())
    };
    known.into_iter().find(there)
}

/// A browser that shows a page, and the directory that it keeps its own things in.
struct Shown {
    child: Child,
    profile: TempDir,
}

impl Shown {
    fn start(browser: &str, url: &str) -> Self {
        let profile = tempfile::tempdir().unwrap();
        let mut command = Command::new(browser);
        command
            .args([
                "--headless",
                "--no-sandbox",
                "--disable-gpu",
                "--remote-debugging-port=0",
            ])
            .arg(format!("--user-data-dir={}", profile.path().display()))
            .arg(url);
        let child = command
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        Self { child, profile }
    }

    /// The browser's own list of what it shows, in JSON; `None`: it is not there yet.
    fn list(&self) -> Option<String> {
        let file = fs::read_to_string(self.profile.path().join("DevToolsActivePort")).ok()?;
        let port = file.lines().next()?.parse().ok()?;
        let mut stream = TcpStream::connect((Ipv4Addr::LOCALHOST, port)).ok()?;
        stream.set_read_timeout(Some(Duration::from_secs(5))).ok()?;
        stream
            .write_all(b"GET /json/list HTTP/1.1\r\nHost: localhost\r\n\r\n")
            .ok()?;
        let (mut text, mut part) = (String::new(), [0; 4096]);
        while !text.trim_end().ends_with(']') {
            let length = stream.read(&mut part).ok().filter(|length| *length > 0)?;
            text += &String::from_utf8_lossy(&part[..length]);
        }
        Some(text)
    }

    /// The phase in the page's title and the experiment's time, s.
    fn title(&self) -> Option<(String, f64)> {
        let list = self.list()?;
        let title = list.split("\"title\": \"").nth(1)?.split('"').next()?.to_owned();
        assert!(!title.starts_with("error"), "{title}");
        let (phase, rest) = title.split_once(", ")?;
        let (_, time) = rest.trim_end_matches(" s").split_once(" N at ")?;
        Some((phase.to_owned(), time.parse().ok()?))
    }

    /// Wait for a title that `fits`.
    fn until(&self, fits: impl Fn(&(String, f64)) -> bool) -> (String, f64) {
        let give_up = clock::now() + LONG;
        while clock::now() < give_up {
            if let Some(title) = self.title().filter(&fits) {
                return title;
            }
            let _ = never::<()>().recv_timeout(Duration::from_millis(20));
        }
        panic!("the browser shows {:?}", self.list());
    }
}

impl Drop for Shown {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

#[test]
fn a_browser_shows_a_cell_that_moves() {
    let Some(browser) = browser() else {
        assert!(env::var_os("CI").is_none(), "no browser is there");
        eprintln!(
            "skipped: no browser is there; `./setup.sh test` installs one where apt has chromium-headless-shell"
        );
        return;
    };
    let bench = Bench::new(&[]).unwrap();
    let cell_up = up(&cell(&bench, "cell.toml", 7), &[]);
    cell_up.until(WHOLE);
    let server = Up::start(watch(&bench.plan.wiring.watch, &["--web", "0"]));
    let shown = Shown::start(browser, &server.until("http://127.0.0.1:"));
    let (_, first_s) = shown.until(|_| true);
    let (_, later_s) = shown.until(|(phase, time_s)| phase == "settled" && *time_s > first_s + 0.5);
    assert!(later_s > first_s);
    drop(shown);
    assert_eq!([server.end(), cell_up.end()], [0, 0]);
}
