//! Tests the server over real sockets: access with the token, and refusal of everything else.

#[path = "../../../tests/src/skipped.rs"]
mod skipped;

use ca_play::{MakesText, Offers, Page};
use ca_session::Pages as _;
use ca_session::protocol::{self, NumberedRequest, Request, binary};
use proptest::prelude::*;
use serde_json::{Value, json};
use std::io::{Read as _, Write as _};
use std::net::TcpStream;
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};
use tungstenite::client::IntoClientRequest as _;
use tungstenite::{Message, WebSocket};

fn page() -> Page {
    Page::open(0, &said_by("first"), false, Offers::default()).unwrap()
}

fn said_by(text: &str) -> protocol::Message {
    protocol::Message::Said { bad: false, text: text.into() }
}

fn place(page: &Page) -> (String, String) {
    let address = page.address();
    let rest = address.strip_prefix("http://").unwrap();
    let (host, path) = rest.split_once('/').unwrap();
    (host.into(), format!("/{path}"))
}

/// Sends bytes and returns the answer of the server until it closes.
fn sent(page: &Page, bytes: &[u8]) -> String {
    let mut stream = TcpStream::connect(place(page).0).unwrap();
    stream.set_read_timeout(Some(Duration::from_secs(10))).unwrap();
    let _ = stream.write_all(bytes);
    let _ = stream.shutdown(std::net::Shutdown::Write);
    let mut all = Vec::new();
    let _ = stream.read_to_end(&mut all);
    String::from_utf8_lossy(&all).into_owned()
}

fn socket(page: &Page) -> WebSocket<TcpStream> {
    let (host, path) = place(page);
    let stream = TcpStream::connect(&host).unwrap();
    stream.set_read_timeout(Some(Duration::from_secs(10))).unwrap();
    let mut request = format!("ws://{host}{path}ws").into_client_request().unwrap();
    request.headers_mut().insert("Origin", format!("http://{host}").parse().unwrap());
    tungstenite::client(request, stream).unwrap().0
}

fn text(socket: &mut WebSocket<TcpStream>) -> Value {
    loop {
        if let Message::Text(text) = socket.read().unwrap() {
            return serde_json::from_str(&text).unwrap();
        }
    }
}

fn until(what: &str, mut is: impl FnMut() -> bool) {
    let end = Instant::now() + Duration::from_secs(10);
    while !is() {
        assert!(Instant::now() < end, "{what}");
        std::thread::sleep(Duration::from_millis(1));
    }
}

#[test]
fn the_page_is_served_to_who_knows_the_token() {
    let page = page();
    let (host, path) = place(&page);
    let got = sent(&page, format!("GET {path} HTTP/1.1\r\nHost: {host}\r\n\r\n").as_bytes());
    assert!(got.starts_with("HTTP/1.1 200") && got.contains("<!doctype html>"), "{got}");
    assert!(got.contains("Content-Security-Policy: default-src 'none'"), "{got}");
    for (path, host) in [
        ("/".to_string(), host.clone()),
        (path.replace(&path[1..5], "0000"), host.clone()),
        (format!("{path}../Cargo.toml"), host.clone()),
        (format!("{path}%2e%2e/Cargo.toml"), host.clone()),
        (path.clone(), "evil.example".into()),
    ] {
        let got = sent(&page, format!("GET {path} HTTP/1.1\r\nHost: {host}\r\n\r\n").as_bytes());
        assert!(got.starts_with("HTTP/1.1 40"), "{path} of {host}: {got}");
        assert!(!got.contains('<'), "no word more: {got}");
    }
    let long = format!("GET {path} HTTP/1.1\r\nHost: {host}\r\nX: {}\r\n\r\n", "a".repeat(9000));
    assert!(sent(&page, long.as_bytes()).starts_with("HTTP/1.1 4"), "a head without end");
}

/// The model is behind the token too, as a text and as one file, and is not there before a page stored it.
#[test]
fn the_model_is_served_as_the_page_is() {
    let made = Arc::new(Mutex::new(None));
    let make = |shared: &Arc<Mutex<Option<String>>>| -> Option<MakesText> {
        let shared = shared.clone();
        Some(Box::new(move || shared.lock().unwrap().clone()))
    };
    let offers = Offers { site: Some("https://example.org/ca/".into()), model: make(&made), one_file: make(&made) };
    let page = Page::open(0, &said_by("first"), false, offers).unwrap();
    let (host, path) = place(&page);
    let get = |page: &Page, path: &str, host: &str, more: &str| {
        sent(page, format!("GET {path} HTTP/1.1\r\nHost: {host}\r\n{more}\r\n").as_bytes())
    };
    let index = get(&page, &path, &host, "");
    assert!(index.contains("data-site=\"https://example.org/ca/\" data-one-file=\"instrument.html\""), "{index}");
    let file = format!("{path}instrument.html");
    assert!(get(&page, &file, &host, "").starts_with("HTTP/1.1 404"));
    *made.lock().unwrap() = Some("<!doctype html>made".to_owned());
    let got = get(&page, &file, &host, "");
    assert!(got.starts_with("HTTP/1.1 200") && got.ends_with("<!doctype html>made"), "{got}");
    let text = get(&page, &format!("{path}model.ca.toml"), &host, "");
    assert!(text.contains("Content-Type: text/plain") && text.ends_with("made"), "{text}");
    // opened at this address, its scripts would not run
    assert!(got.contains("script-src 'self'; "), "{got}");
    for (path, host, more) in [
        ("/instrument.html", &*host, ""),
        ("/model.ca.toml", &*host, ""),
        (&*file, "evil.example", ""),
        (&*file, &*host, "Origin: http://evil.example\r\n"),
    ] {
        let got = get(&page, path, host, more);
        assert!(got.starts_with("HTTP/1.1 40") && !got.contains("made"), "{path} of {host}: {got}");
    }
    // a page without offers has neither
    let plain = self::page();
    let (host, path) = place(&plain);
    assert!(!get(&plain, &path, &host, "").contains("data-site"));
    for name in ["instrument.html", "model.ca.toml"] {
        assert!(get(&plain, &format!("{path}{name}"), &host, "").starts_with("HTTP/1.1 404"), "{name}");
    }
}

#[test]
fn a_page_is_greeted_asks_and_is_answered() {
    let page = page();
    let mut s = socket(&page);
    assert_eq!(text(&mut s), json!({"type": "said", "bad": false, "text": "first"}));
    s.send(Message::text(r#"{"id": 7, "type": "grab", "mass": 3}"#)).unwrap();
    let mut asked = Vec::new();
    until("the request comes", || {
        asked.extend(page.requests());
        !asked.is_empty()
    });
    let grab = NumberedRequest { id: Some(json!(7)), request: Ok(Request::Grab { mass: Some(3), finger: None }) };
    assert_eq!(asked[0].request, Some(grab));
    let reply = protocol::Message::Reply { id: json!(7), ok: true, text: "held".into(), picked: None };
    page.feed().send(asked[0].client, &reply);
    assert_eq!(text(&mut s)["id"], 7);
    for wrong in ["", "7", "[]", "{", "null", "\"x\""] {
        s.send(Message::text(wrong)).unwrap();
        let reply = text(&mut s);
        assert_eq!((&reply["type"], &reply["ok"]), (&json!("reply"), &json!(false)), "{wrong:?}: {reply}");
    }
    page.feed().greet(&said_by("second"));
    assert_eq!(text(&mut s)["text"], "second");
    assert_eq!(text(&mut socket(&page))["text"], "second");
    // the departure of a client is reported, so that the session releases what it held
    let before = page.feed().count();
    drop(s);
    let mut gone = Vec::new();
    until("it is gone", || {
        gone.extend(page.requests().filter(|a| a.request.is_none()));
        gone.iter().any(|g| g.client == asked[0].client)
    });
    assert!(page.feed().count() < before);
}

#[test]
fn sound_goes_to_who_asked_and_of_pictures_the_newest() {
    let page = page();
    let (mut hears, mut sees) = (socket(&page), socket(&page));
    text(&mut hears);
    text(&mut sees);
    let feed = page.feed();
    assert!(feed.is_seen() && !feed.is_heard());
    hears.send(Message::text(r#"{"type": "sound", "on": true}"#)).unwrap();
    assert_eq!(text(&mut hears)["ok"], true);
    assert!(feed.is_heard());
    let mut block = Vec::new();
    binary::sound(&mut block, 1, 480.0, &[0.5, -0.25]);
    feed.sound(&block);
    binary::view(&mut block, 9, 480.0);
    block.extend_from_slice(&1.5_f32.to_le_bytes());
    feed.view(&block);
    let Message::Binary(sound) = hears.read().unwrap() else { panic!("no sound") };
    assert_eq!(sound[..4], 2_u32.to_le_bytes());
    assert_eq!(sound[8..16], 480.0_f64.to_le_bytes());
    assert_eq!(sound[16..], [0.5_f32.to_le_bytes(), (-0.25_f32).to_le_bytes()].concat());
    let Message::Binary(picture) = sees.read().unwrap() else { panic!("no picture") };
    assert_eq!((&picture[..4], &picture[4..8]), (&1_u32.to_le_bytes()[..], &9_u32.to_le_bytes()[..]));
    assert_eq!(picture[16..], 1.5_f32.to_le_bytes());
}

#[test]
fn a_client_that_does_not_fetch_stands_in_nobodys_way() {
    let page = page();
    let (mut slow, mut quick) = (socket(&page), socket(&page));
    text(&mut slow);
    text(&mut quick);
    let feed = page.feed();
    // far more than the socket buffers of the system hold
    let picture = vec![0_u8; 1 << 20];
    for n in 0..200 {
        feed.view(&picture);
        page.feed().send_all(&said_by(&n.to_string()));
    }
    for n in 0..200 {
        assert_eq!(text(&mut quick)["text"], n.to_string());
    }
    // the slow client sends nothing, but the queue of its messages is limited
    let news = said_by(&"x".repeat(1000));
    let begin = Instant::now();
    while page.feed().count() == 2 && begin.elapsed() < Duration::from_secs(60) {
        // the fast client keeps up even on a busy machine
        (0..16).for_each(|_| page.feed().send_all(&news));
        (0..16).for_each(|_| drop(text(&mut quick)));
    }
    assert_eq!(page.feed().count(), 1, "the slow one is closed");
}

#[test]
fn who_floods_is_closed() {
    let page = page();
    for long in [false, true] {
        let mut s = socket(&page);
        text(&mut s);
        let message = if long { "x".repeat(1 << 17) } else { r#"{"type": "drag"}"#.into() };
        let mut sent = 0;
        while sent < 20_000 && s.send(Message::text(message.clone())).is_ok() {
            sent += 1;
            // requests are answered quickly
            let _ = page.requests().count();
        }
        assert!(sent < 20_000, "closed after {sent}");
        until("no client is left", || page.feed().count() == 0);
    }
}

/// Empty frames do not count as messages but are limited too.
#[test]
fn who_sends_frames_without_end_is_closed() {
    let page = page();
    let mut s = socket(&page);
    text(&mut s);
    let s = s.get_mut();
    // a text that is never complete: empty fragments, masked as by a client
    let begun = s.write_all(&[0x01, 0x80, 0, 0, 0, 0]).is_ok();
    let pieces = [0x00, 0x80, 0, 0, 0, 0].repeat(1000);
    let sent = (0..5000).take_while(|_| s.write_all(&pieces).is_ok()).count();
    assert!(begun && sent < 5000, "closed after {sent}");
    until("no client is left", || page.feed().count() == 0);
}

/// A client that stays connected but reads nothing loses what it holds.
#[test]
fn who_answers_no_ping_lets_go() {
    let page = page();
    let (mut deaf, mut alive) = (socket(&page), socket(&page));
    text(&mut deaf);
    text(&mut alive);
    deaf.send(Message::text(r#"{"type": "grab"}"#)).unwrap();
    alive.get_mut().set_read_timeout(Some(Duration::from_millis(5))).unwrap();
    // on a machine that stalls this test for a second, a reading client does not answer either
    let mut released = Vec::new();
    let end = Instant::now() + Duration::from_secs(60);
    while !released.contains(&0) && Instant::now() < end {
        // reading answers pings
        let _ = alive.read();
        let all = page
            .requests()
            .filter(|a| a.request.as_ref().is_some_and(|r| r.request == Ok(Request::Release { finger: None })));
        released.extend(all.map(|a| a.client));
    }
    assert!(released.contains(&0), "the first client holds what it held: {released:?}");
    let other = socket(&page);
    assert!(page.feed().count() >= 2, "it is still there");
    drop(other);
}

#[test]
fn connections_have_an_end() {
    let page = page();
    let (host, path) = place(&page);
    let ask = || sent(&page, format!("GET {path} HTTP/1.1\r\nHost: {host}\r\n\r\n").as_bytes());
    let open: Vec<_> = (0..32).map(|_| socket(&page)).collect();
    until("one more is refused", || ask().starts_with("HTTP/1.1 503"));
    drop(open);
    until("served again", || ask().starts_with("HTTP/1.1 200"));
}

/// Connections without the token do not occupy the slots of connections with it.
#[cfg(target_os = "linux")]
#[test]
fn silent_connections_of_another_user_keep_nobody_out() {
    use std::io::{BufRead as _, BufReader};
    use std::os::unix::fs::MetadataExt as _;
    use std::os::unix::process::CommandExt as _;
    use std::process::{Command, Stdio};

    if std::fs::metadata("/proc/self").unwrap().uid() != 0 {
        return skipped::skipped("root", "only root can be another user");
    }
    let page = page();
    let (host, path) = place(&page);
    for many in [34, 80] {
        let (_, port) = host.split_once(':').unwrap();
        let line = format!(
            "for n in $(seq {many}); do exec {{f}}<>/dev/tcp/127.0.0.1/{port} || exit 1; done; echo open; read end; true"
        );
        let mut other = Command::new("bash");
        other.args(["-c", &line]).current_dir("/").uid(65534).gid(65534).stdin(Stdio::piped()).stdout(Stdio::piped());
        let mut other = other.spawn().unwrap();
        let mut open = String::new();
        BufReader::new(other.stdout.take().unwrap()).read_line(&mut open).unwrap();
        assert_eq!(open, "open\n", "{many} connections");
        for n in 0..60 {
            let got = sent(&page, format!("GET {path} HTTP/1.1\r\nHost: {host}\r\n\r\n").as_bytes());
            assert!(got.starts_with("HTTP/1.1 200"), "request {n} beside {many}: {got}");
        }
        // bash ends with its standard input
        drop(other.stdin.take());
        assert!(other.wait().unwrap().success());
    }
}

#[test]
fn pages_are_closed_at_the_end() {
    let page = page();
    let mut s = socket(&page);
    text(&mut s);
    drop(page);
    let Ok(Message::Close(Some(frame))) = s.read() else { panic!("not closed") };
    assert_eq!(u16::from(frame.code), 1001);
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, ..ProptestConfig::default() })]

    /// The server survives arbitrary input.
    #[test]
    fn anything_may_come(bytes in prop::collection::vec(any::<u8>(), 0..400), in_socket in any::<bool>()) {
        let page = page();
        if in_socket {
            let mut s = socket(&page);
            let _ = s.get_mut().write_all(&bytes);
            let _ = s.get_mut().shutdown(std::net::Shutdown::Write);
            while s.read().is_ok() {}
        } else {
            sent(&page, &bytes);
        }
        let (host, path) = place(&page);
        let got = sent(&page, format!("GET {path} HTTP/1.1\r\nHost: {host}\r\n\r\n").as_bytes());
        prop_assert!(got.starts_with("HTTP/1.1 200"), "{}", got);
    }
}
