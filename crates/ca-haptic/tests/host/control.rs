//! Control of a running server, from another thread or process.

use crate::helpers::{spawn, temp_site, until};
use ca_haptic::host::HostErrorKind;
use ca_haptic::host::control::{ControlServer, Given, Reply, Request, ask};
use std::io::BufRead;
use std::time::Duration;

const PATIENCE: Duration = Duration::from_secs(30);

#[test]
fn a_question_is_answered() {
    let place = temp_site();
    let e = ask(&place.site, &Request::Status, PATIENCE).unwrap_err();
    assert!(e.kind == HostErrorKind::Absent && e.to_string().contains("ca serve"), "{e}");
    let mut server = ControlServer::open(&place.site).unwrap();
    let e = ControlServer::open(&place.site).err().expect("one server a place");
    assert!(e.kind == HostErrorKind::Busy && e.what.contains(&std::process::id().to_string()), "{e}");
    // a request longer than the first buffer, and an even longer reply
    let values: std::collections::BTreeMap<_, _> =
        (0..2000).map(|i| (format!("string.k{i}"), Given::Text(format!("{i} N/m")))).collect();
    let request = Request::Set { values };
    let (site, asked) = (place.site.clone(), request.clone());
    let caller = std::thread::spawn(move || {
        let long = ask(&site, &asked, PATIENCE).unwrap();
        (long, ask(&site, &Request::Arm { device: Some("key".into()) }, PATIENCE).unwrap())
    });
    let mut heard = Vec::new();
    until("both are answered", || {
        server.poll(&mut |r| {
            heard.push(r);
            if heard.len() == 1 { Reply::done("x".repeat(100_000)) } else { Reply::refused("`key` is not calibrated") }
        });
        caller.is_finished()
    });
    let (long, short) = caller.join().unwrap();
    assert!(long.ok && long.text.len() == 100_000);
    assert_eq!(short, Reply::refused("`key` is not calibrated"));
    assert_eq!(heard, [request, Request::Arm { device: Some("key".into()) }]);
    // the server does not answer
    let e = ask(&place.site, &Request::Status, Duration::from_millis(20)).unwrap_err();
    assert!(e.kind == HostErrorKind::Absent && e.what.contains("does not answer"), "{e}");
    drop(server);
    assert_eq!(ask(&place.site, &Request::Status, PATIENCE).unwrap_err().kind, HostErrorKind::Absent);
}

#[test]
fn a_killed_server_is_no_obstacle() {
    let place = temp_site();
    let mut child = spawn(&place.site, "control", "");
    let mut lines = std::io::BufReader::new(child.stdout.take().unwrap()).lines();
    assert!(lines.any(|l| l.unwrap().contains("open")), "it opens");
    assert_eq!(ask(&place.site, &Request::Status, PATIENCE).unwrap().text, child.id().to_string());
    child.kill().unwrap();
    child.wait().unwrap();
    assert_eq!(ask(&place.site, &Request::Status, PATIENCE).unwrap_err().kind, HostErrorKind::Absent);
    ControlServer::open(&place.site).unwrap();
}
