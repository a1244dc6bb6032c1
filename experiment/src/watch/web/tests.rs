use super::*;
use crate::in_process;
use crate::watch::Heard;
use node::scenario::Scenario;
use std::io::{BufRead, BufReader};

/// A server that shows a contact.
fn server() -> (Server, Arc<Shown>) {
    let shown = Arc::new(Shown::default());
    let scenario = Scenario::parse("short", "", &["timing.duration_s=0.1".to_owned()]).unwrap();
    let now = clock::now();
    in_process::run(&scenario, |tick| {
        if let Some(outputs) = &tick.controller {
            shown.lock().hear(&Heard::Controller(outputs.status), now);
        }
    });
    (Server::start(0, shown.clone()).unwrap(), shown)
}

fn ask(server: &Server, path: &str) -> TcpStream {
    let mut stream = TcpStream::connect(server.address()).unwrap();
    let port = server.address().port();
    stream
        .write_all(format!("GET {path} HTTP/1.1\r\nHost: localhost:{port}\r\n\r\n").as_bytes())
        .unwrap();
    stream
}

fn whole(mut stream: TcpStream) -> String {
    let mut text = String::new();
    stream.read_to_string(&mut text).unwrap();
    text
}

/// The next event of a stream.
fn event(lines: &mut impl BufRead) -> serde_json::Value {
    let mut line = String::new();
    while !line.starts_with("data: ") {
        line.clear();
        assert!(lines.read_line(&mut line).unwrap() > 0, "the stream has ended");
    }
    serde_json::from_str(&line[6..]).unwrap()
}

#[test]
fn the_page_needs_nothing_from_elsewhere() {
    let (server, _shown) = server();
    assert!(server.address().ip().is_loopback());
    let pages = ["/", "/page.css", "/page.js"].map(|path| whole(ask(&server, path)));
    for page in &pages {
        assert!(page.starts_with("HTTP/1.1 200 OK\r\n"), "{page}");
        // Nothing that stands in the page itself runs.
        assert!(page.contains("script-src 'self'; style-src 'self';"), "{page}");
        for elsewhere in ["http://", "https://", "//", "@import", "url("] {
            let text = page.replace("// ", "");
            assert!(!text.contains(elsewhere), "{elsewhere}");
        }
    }
    assert!(pages[0].contains("<script src=\"page.js\"></script>"));
    assert!(pages[2].contains("new EventSource('/events')"));
}

#[test]
fn events_bring_rows_and_each_point_once() {
    let (server, shown) = server();
    let mut lines = BufReader::new(ask(&server, "/events"));
    let first = event(&mut lines);
    assert_eq!(first["points"].as_array().unwrap().len(), 26);
    assert!(first["snapshot"]["controller"]["force_n"][2].is_number());
    let second = event(&mut lines);
    assert_eq!(second["points"].as_array().unwrap().len(), 0);
    // A controller that is started anew begins its plots anew.
    let mut status = shown.lock().controller.unwrap().0;
    (status.stamp.boot_id, status.stamp.step) = (7, 40);
    shown.lock().hear(&Heard::Controller(status), clock::now());
    let anew = std::iter::from_fn(|| Some(event(&mut lines)))
        .find(|event| event["anew"] == true)
        .unwrap();
    assert_eq!(anew["points"][0][0], 0.04);
    drop(server);
    // What is under way comes to its end, then the stream does.
    let mut rest = String::new();
    lines.read_to_string(&mut rest).unwrap();
}

#[test]
fn many_and_idle_clients_do_not_keep_others_away_for_long() {
    let (server, _shown) = server();
    // They ask for nothing.
    let idle: Vec<_> = (0..MOST_CLIENTS)
        .map(|_| TcpStream::connect(server.address()).unwrap())
        .collect();
    let give_up = clock::now() + Duration::from_secs(30);
    let mut served = false;
    while !served && clock::now() < give_up {
        served = whole_or_nothing(ask(&server, "/")).contains("200 OK");
        pause();
    }
    assert!(served, "the idle ones are not let go");
    drop(idle);
}

fn pause() {
    let _ = crossbeam::channel::never::<()>().recv_timeout(PERIOD / 10);
}

/// What is answered, if the connection is not closed before the request is read.
fn whole_or_nothing(mut stream: TcpStream) -> String {
    let mut text = String::new();
    let _ = stream.read_to_string(&mut text);
    text
}

#[test]
fn a_client_that_floods_is_refused() {
    let (server, _shown) = server();
    let mut stream = TcpStream::connect(server.address()).unwrap();
    let _ = stream.write_all(&vec![b'x'; 4 * LONGEST_HEAD]);
    let answer = whole_or_nothing(stream);
    assert!(
        answer.is_empty() || answer.starts_with("HTTP/1.1 400"),
        "{answer}"
    );
    assert!(whole(ask(&server, "/")).contains("200 OK"));
}

#[test]
fn a_client_that_does_not_read_is_let_go() {
    let (server, shown) = server();
    let unread = ask(&server, "/events");
    socket2::SockRef::from(&unread)
        .set_recv_buffer_size(4096)
        .unwrap();
    let give_up = clock::now() + Duration::from_secs(30);
    // This test, the server, and each client that is served.
    let served = || Arc::strong_count(&shown) == 3;
    while !served() && clock::now() < give_up {
        pause();
    }
    assert!(served(), "it is not served");
    let mut status = shown.lock().controller.unwrap().0;
    while served() && clock::now() < give_up {
        // Its buffers are full of points sooner or later.
        for _ in 0..2000 {
            status.stamp.step += 4;
            shown.lock().hear(&Heard::Controller(status), clock::now());
        }
        pause();
    }
    assert!(!served(), "it is not let go");
    drop(unread);
}
