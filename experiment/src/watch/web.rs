//! The browser: one page that needs no network, served on 127.0.0.1 alone.
//!
//! A browser gets the page, its style and the script that draws, and then a stream of events, each with all rows and the points since the event before. Nothing is
//! queued for it: a slow one gets fewer events, one that does not read at all is let go, and what it may ask for is bounded in
//! size, number and time.

mod request;

use super::View;
use super::points::Point;
use crossbeam::channel::{Receiver, RecvTimeoutError, Sender, bounded};
use node::clock;
use request::{Answer, answer};
use serde_json::json;
use std::io::{self, Read, Write};
use std::net::{Ipv4Addr, SocketAddr, TcpListener, TcpStream};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

/// Longest head of a request, bytes.
const LONGEST_HEAD: usize = 8 * 1024;
/// A client has so long to ask, and to take what is sent.
const PATIENCE: Duration = Duration::from_secs(2);
/// So many clients at once.
const MOST_CLIENTS: usize = 16;
/// Between two events.
const PERIOD: Duration = Duration::from_millis(100);

/// What all clients are shown.
#[derive(Default)]
pub struct Shown(Mutex<View>);

impl Shown {
    /// To be brought up to date.
    pub fn lock(&self) -> MutexGuard<'_, View> {
        // A view is whole between two messages, whoever has panicked.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// One event: the rows, and the points from number `next` on; `next` becomes the number to go on with.
    fn event(&self, next: &mut u64) -> String {
        let view = self.lock();
        let points: Vec<_> = view.points().since(*next).map(numbers).collect();
        // Points that are gone are to be forgotten there, too.
        let anew = *next < view.points().first();
        *next = view.points().next();
        let snapshot = view.snapshot(clock::now());
        drop(view);
        json!({ "snapshot": snapshot, "points": points, "anew": anew }).to_string()
    }
}

/// A point as the page takes it: time s, force N, desired force N, tcp m, object m.
fn numbers(point: &Point) -> [Option<f64>; 5] {
    [
        Some(point.time_s),
        Some(point.force_n),
        Some(point.desired_force_n),
        Some(point.tcp_height_m),
        point.object_height_m,
    ]
}

/// A server; it ends when this is dropped.
pub struct Server {
    address: SocketAddr,
    /// Dropped, it ends the streams.
    stop: Option<Sender<()>>,
}

impl Server {
    /// Serve `shown` on `port` of 127.0.0.1; 0: a free one.
    pub fn start(port: u16, shown: Arc<Shown>) -> io::Result<Self> {
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port))?;
        let address = listener.local_addr()?;
        let (stop, stopped) = bounded(0);
        std::thread::Builder::new()
            .name("web".to_owned())
            .spawn(move || accept(&listener, &shown, &stopped))?;
        Ok(Self {
            address,
            stop: Some(stop),
        })
    }

    /// Where it is heard.
    pub fn address(&self) -> SocketAddr {
        self.address
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        self.stop = None;
        // So that it looks.
        let _ = TcpStream::connect_timeout(&self.address, PATIENCE);
    }
}

fn ended(stopped: &Receiver<()>) -> bool {
    stopped.try_recv() == Err(crossbeam::channel::TryRecvError::Disconnected)
}

fn accept(listener: &TcpListener, shown: &Arc<Shown>, stopped: &Receiver<()>) {
    let clients = Arc::new(AtomicUsize::new(0));
    loop {
        let Ok((stream, _)) = listener.accept() else {
            // No descriptors left, or the client has gone; don't burn the processor.
            let _ = stopped.recv_timeout(PERIOD);
            continue;
        };
        if ended(stopped) {
            return;
        }
        if clients.fetch_add(1, Ordering::AcqRel) >= MOST_CLIENTS {
            clients.fetch_sub(1, Ordering::AcqRel);
            refuse(stream);
            continue;
        }
        let (shown, stopped, own) = (shown.clone(), stopped.clone(), clients.clone());
        let thread = std::thread::Builder::new().name("web-client".to_owned());
        let spawned = thread.spawn(move || {
            // A client that has gone is none to speak of.
            let _ = serve(stream, &shown, &stopped);
            own.fetch_sub(1, Ordering::AcqRel);
        });
        if spawned.is_err() {
            clients.fetch_sub(1, Ordering::AcqRel);
        }
    }
}

/// Tell a client that there are enough; it never makes the others wait.
fn refuse(mut stream: TcpStream) {
    let _ = stream.set_nonblocking(true);
    let _ = stream.write(head("503 Service Unavailable", "text/plain", "connection: close\r\n").as_bytes());
}

fn head(status: &str, kind: &str, more: &str) -> String {
    // What this server has is all that the page may use; no other page may read it.
    format!(
        "HTTP/1.1 {status}\r\ncontent-type: {kind}; charset=utf-8\r\ncache-control: no-store\r\n\
         x-content-type-options: nosniff\r\nx-frame-options: DENY\r\ncontent-security-policy: default-src 'none'; \
         script-src 'self'; style-src 'self'; connect-src 'self'; img-src data:\r\n{more}\r\n"
    )
}

fn serve(mut stream: TcpStream, shown: &Shown, stopped: &Receiver<()>) -> io::Result<()> {
    stream.set_write_timeout(Some(PATIENCE))?;
    let whole = |status: &str, kind: &str, body: &str| {
        let length = format!("content-length: {}\r\nconnection: close\r\n", body.len());
        head(status, kind, &length) + body
    };
    let asked = read_head(&mut stream)?;
    match answer(&asked, stream.local_addr()?.port()) {
        Answer::File(file) => stream.write_all(whole("200 OK", file.kind, file.text).as_bytes()),
        Answer::Nothing(status) => stream.write_all(whole(status, "text/plain", status).as_bytes()),
        Answer::Events => {
            stream.write_all(head("200 OK", "text/event-stream", "connection: close\r\n").as_bytes())?;
            let mut next = 0;
            loop {
                let event = format!("data: {}\n\n", shown.event(&mut next));
                stream.write_all(event.as_bytes())?;
                if stopped.recv_timeout(PERIOD) != Err(RecvTimeoutError::Timeout) {
                    return Ok(());
                }
            }
        }
    }
}

/// The head of a request, as far as it comes in time.
fn read_head(stream: &mut TcpStream) -> io::Result<Vec<u8>> {
    let until = clock::now() + PATIENCE;
    let (mut head, mut part) = (Vec::new(), [0; 1024]);
    while head.len() < LONGEST_HEAD && !head.windows(4).any(|end| end == b"\r\n\r\n") {
        let left = until.saturating_duration_since(clock::now());
        if left.is_zero() {
            break;
        }
        stream.set_read_timeout(Some(left))?;
        match stream.read(&mut part)? {
            0 => break,
            length => head.extend_from_slice(&part[..length]),
        }
    }
    Ok(head)
}

#[cfg(test)]
mod tests;
