//! One node as a child process.

use super::{LaunchError, NodeCommand};
use node::clock;
use node::greeting::role_name;
use spatial::ports::{NodeStatus, Role};
use std::io::{self, BufRead, BufReader, Write};
use std::os::unix::process::{CommandExt, ExitStatusExt};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// A child process, what it has said, and when.
pub(super) struct Node {
    pub(super) role: Role,
    pub(super) child: Child,
    pub(super) last_words: Arc<Mutex<String>>,
    pub(super) listener: Option<JoinHandle<()>>,
    pub(super) status: Option<NodeStatus>,
    pub(super) heard: Instant,
}

impl Node {
    pub(super) fn start(node: &NodeCommand) -> Result<Self, LaunchError> {
        let role = node.role;
        let mut command = match node.through.split_first() {
            None => Command::new(&node.program),
            Some((first, rest)) => {
                let mut command = Command::new(first);
                command.args(rest).arg(&node.program);
                command
            }
        };
        command.args(&node.arguments);
        if node.through.is_empty() {
            command.args(["--with-parent", &std::process::id().to_string()]);
        }
        if std::env::var_os("RUST_LOG").is_none() {
            command.env("RUST_LOG", node.log);
        }
        // Ctrl-C in a terminal reaches the launcher alone, which then stops the nodes.
        command
            .process_group(0)
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::piped());
        let start = |source| LaunchError::Start {
            path: node.program.clone(),
            source,
        };
        let mut child = command.spawn().map_err(start)?;
        let last_words = Arc::new(Mutex::new(String::new()));
        let listener = child.stderr.take().map(|stderr| {
            let words = last_words.clone();
            std::thread::spawn(move || {
                for line in BufReader::new(stderr).lines().map_while(Result::ok) {
                    // A terminal that is gone does not end the listening: the node would write to nobody.
                    let _ = writeln!(io::stderr(), "{}: {line}", role_name(role));
                    *words.lock().unwrap_or_else(PoisonError::into_inner) = line;
                }
            })
        });
        Ok(Self {
            role,
            child,
            last_words,
            listener,
            status: None,
            heard: clock::now(),
        })
    }

    pub(super) fn last_words(&self) -> String {
        let words = self.last_words.lock().unwrap_or_else(PoisonError::into_inner);
        if words.is_empty() {
            return "none".to_owned();
        }
        words.trim().to_owned()
    }

    pub(super) fn listen_to_the_end(&mut self) {
        if let Some(listener) = self.listener.take() {
            let _ = listener.join();
        }
    }

    pub(super) fn signal(&self, signal: rustix::process::Signal) {
        let id = i32::try_from(self.child.id())
            .ok()
            .and_then(rustix::process::Pid::from_raw);
        if let Some(id) = id {
            // Its group: whatever has started it in between is not the node. It may have ended already.
            let _ = rustix::process::kill_process_group(id, signal);
        }
    }

    /// Wait for the end of the process; kill it at `give_up`.
    pub(super) fn wait_until(&mut self, give_up: Instant) -> Option<ExitStatus> {
        let never = crossbeam::channel::never::<()>();
        loop {
            match self.child.try_wait() {
                Ok(Some(status)) => {
                    self.listen_to_the_end();
                    return Some(status);
                }
                Ok(None) if clock::now() < give_up => {
                    let _ = never.recv_timeout(Duration::from_millis(2));
                }
                _ => {
                    let _ = self.child.kill();
                    let _ = self.child.wait();
                    self.listen_to_the_end();
                    return None;
                }
            }
        }
    }
}

/// How a process ended, in words.
pub(super) fn how(status: ExitStatus) -> String {
    match (status.code(), status.signal()) {
        (Some(code), _) => format!("exit code {code}"),
        (None, Some(signal)) => format!("signal {signal}"),
        (None, None) => "unknown end".to_owned(),
    }
}
