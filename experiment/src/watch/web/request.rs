//! What a client asks for: pure.

use httparse::{EMPTY_HEADER, Request, Status};

/// So many header lines are read.
const MOST_HEADERS: usize = 64;

/// A file of the page.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct File {
    path: &'static str,
    /// Its media type.
    pub(super) kind: &'static str,
    pub(super) text: &'static str,
}

/// The page, its style, and the script that draws.
const FILES: &[File] = &[
    File {
        path: "/",
        kind: "text/html",
        text: include_str!("page.html"),
    },
    File {
        path: "/page.css",
        kind: "text/css",
        text: include_str!("page.css"),
    },
    File {
        path: "/page.js",
        kind: "text/javascript",
        text: include_str!("page.js"),
    },
];

/// What it gets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Answer {
    /// This file.
    File(&'static File),
    /// The stream of events.
    Events,
    /// This status.
    Nothing(&'static str),
}

/// What the client that has sent `head` gets from the server on `port`.
pub(super) fn answer(head: &[u8], port: u16) -> Answer {
    let mut headers = [EMPTY_HEADER; MOST_HEADERS];
    let mut request = Request::new(&mut headers);
    if !matches!(request.parse(head), Ok(Status::Complete(_))) {
        return Answer::Nothing("400 Bad Request");
    }
    if request.method != Some("GET") {
        return Answer::Nothing("405 Method Not Allowed");
    }
    // A page of somebody else's may have its own name resolved to this host, and would then count as the same origin.
    let mut hosts = request
        .headers
        .iter()
        .filter(|header| header.name.eq_ignore_ascii_case("host"));
    let own = [format!("127.0.0.1:{port}"), format!("localhost:{port}")];
    let (host, second) = (hosts.next(), hosts.next());
    let meant = |value: &[u8]| own.iter().any(|own| own.as_bytes().eq_ignore_ascii_case(value));
    if second.is_some() || !host.is_some_and(|host| meant(host.value)) {
        return Answer::Nothing("421 Misdirected Request");
    }
    let path = request.path.unwrap_or_default();
    match FILES.iter().find(|file| file.path == path) {
        Some(file) => Answer::File(file),
        None if path == "/events" => Answer::Events,
        None => Answer::Nothing("404 Not Found"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn asked(head: &str) -> Answer {
        answer(head.as_bytes(), 8765)
    }

    #[test]
    fn page_and_events_are_all_there_is() {
        let get = |path: &str, host: &str| asked(&format!("GET {path} HTTP/1.1\r\nHost: {host}\r\n\r\n"));
        for (path, kind) in [
            ("/", "text/html"),
            ("/page.css", "text/css"),
            ("/page.js", "text/javascript"),
        ] {
            let Answer::File(file) = get(path, "127.0.0.1:8765") else {
                panic!("{path} is not there");
            };
            assert_eq!((file.path, file.kind), (path, kind));
            assert!(path != "/" || (file.text.contains("\"page.css\"") && file.text.contains("\"page.js\"")));
        }
        assert_eq!(get("/events", "localhost:8765"), Answer::Events);
        assert_eq!(
            get("/../etc/passwd", "localhost:8765"),
            Answer::Nothing("404 Not Found")
        );
        assert_eq!(
            get("/", "evil.example:8765"),
            Answer::Nothing("421 Misdirected Request")
        );
        assert_eq!(
            get("/", "localhost:1"),
            Answer::Nothing("421 Misdirected Request")
        );
    }

    #[test]
    fn what_is_no_request_is_refused() {
        let bad = Answer::Nothing("400 Bad Request");
        for head in [
            "",
            "GET",
            "\u{0}\u{1}\r\n\r\n",
            "GET / HTTP/1.1\r\nHost: localhost:8765\r\n",
        ] {
            assert_eq!(asked(head), bad, "{head:?}");
        }
        let many = "X: y\r\n".repeat(100);
        assert_eq!(asked(&format!("GET / HTTP/1.1\r\n{many}\r\n")), bad);
        let post = "POST / HTTP/1.1\r\nHost: localhost:8765\r\n\r\n";
        assert_eq!(asked(post), Answer::Nothing("405 Method Not Allowed"));
        assert_eq!(
            asked("GET / HTTP/1.0\r\n\r\n"),
            Answer::Nothing("421 Misdirected Request")
        );
    }
}
