//! Tests that a flood of requests does not block disarming.

use crate::sandbox::{KEY, Proc, Sandbox, until};
use ca_haptic::host::control::Request;
use rosc::{OscBundle, OscMessage, OscPacket, OscTime, encoder};
use std::fmt::Write as _;
use std::net::UdpSocket;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::thread;

pub fn port(server: &Proc) -> u16 {
    let port = || server.stderr().split("OSC: UDP port ").nth(1)?.split(' ').next()?.parse::<u16>().ok();
    until("it says where it listens", || port().is_some());
    port().unwrap()
}

/// Live parameters; each is a packet in every answer to `/state`.
const PARAMS: usize = 100;

/// Two programs send bundles of OSC requests as fast as they can, one with the token and one without. The server still
/// disarms and stops.
#[test]
fn a_flood_of_osc_does_not_keep_forces_on() {
    let sandbox = Sandbox::new();
    let mut model = String::from("[param]\n");
    for n in 0..PARAMS {
        let _ = writeln!(model, "p{n} = {{ value = 1, live = true, min = 0, max = 2 }}");
    }
    sandbox.put("many.ca.toml", &(model + KEY));
    let server = sandbox.serve("many.ca.toml", &["--osc", "0"]);
    let _key = sandbox.key(&[]);
    sandbox.on();
    let to = (std::net::Ipv4Addr::LOCALHOST, port(&server));

    let token = sandbox.read("c/osc-token");
    let over = Arc::new(AtomicBool::new(false));
    let senders: Vec<_> = [format!("/{}/state", token.trim()), "/state".into()]
        .into_iter()
        .map(|addr| {
            let ask = OscPacket::Message(OscMessage { addr, args: Vec::new() });
            let timetag = OscTime { seconds: 0, fractional: 1 };
            // as many messages as a packet can hold
            let many = 4000 / (encoder::encode(&ask).unwrap().len() + 4);
            let bundle = encoder::encode(&OscPacket::Bundle(OscBundle { timetag, content: vec![ask; many] })).unwrap();
            let over = over.clone();
            thread::spawn(move || {
                let socket = UdpSocket::bind((std::net::Ipv4Addr::LOCALHOST, 0)).unwrap();
                while !over.load(Relaxed) {
                    let _ = socket.send_to(&bundle, to);
                    // faster than any answer, but leaves a core free
                    thread::sleep(std::time::Duration::from_micros(100));
                }
            })
        })
        .collect();
    thread::sleep(std::time::Duration::from_millis(500));
    // a busy machine may switch forces off by itself, which is also accepted
    let answered = sandbox.ask(&Request::Disarm { device: None });
    assert!(answered.is_some_and(|r| r.ok), "no answer to disarm: {}", server.stderr());
    until("forces are off", || sandbox.state().0 == "off");
    let ended = sandbox.ask(&Request::Stop);
    assert!(ended.is_some_and(|r| r.ok), "no answer to stop: {}", server.stderr());
    let ran = server.end();
    over.store(true, Relaxed);
    for sender in senders {
        sender.join().unwrap();
    }
    assert!(matches!(ran.code, Some(0 | 3)), "{}{}", ran.out, ran.err);
}
