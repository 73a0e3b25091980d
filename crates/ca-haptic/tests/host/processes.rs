//! Devices and servers in separate processes, which are killed, stopped and started again.

use crate::helpers::{Server, about, spawn, temp_site, until};
use ca_haptic::frame::{Cause, DOF, DeviceFrame, Mode};
use ca_haptic::host::{DeviceClient, Event, Site};
use std::io::BufRead;
use std::process::{Child, Command};
use std::time::Duration;

#[path = "../../examples/device.rs"]
mod example;

/// Runs the role of a child process; does nothing in the parent.
#[test]
fn role() {
    let Ok(role) = std::env::var("CA_TEST_ROLE") else { return };
    let args = std::env::var("CA_TEST_ARGS").unwrap_or_default();
    match role.as_str() {
        "device" => {
            let (name, frames) = args.split_once(' ').unwrap();
            println!("{}", example::run(name, frames.parse().unwrap()).unwrap());
        }
        "server" => {
            let names: Vec<_> = args.split(' ').collect();
            let mut server = Server::open(&Site::of_user().unwrap(), &names, u64::from(std::process::id()));
            println!("open");
            loop {
                server.serve();
                std::thread::sleep(std::time::Duration::from_micros(100));
            }
        }
        "control" => {
            let mut server = ca_haptic::host::control::ControlServer::open(&Site::of_user().unwrap()).unwrap();
            println!("open");
            loop {
                server.poll(&mut |_| ca_haptic::host::control::Reply::done(std::process::id().to_string()));
                std::thread::sleep(std::time::Duration::from_micros(100));
            }
        }
        other => panic!("no role `{other}`"),
    }
}

fn signal(child: &Child, name: &str) {
    let id = child.id().to_string();
    assert!(Command::new("kill").args([format!("-{name}"), id]).status().unwrap().success());
}

fn server(place: &crate::helpers::TempSite, names: &str) -> Child {
    let mut child = spawn(&place.site, "server", names);
    let mut lines = std::io::BufReader::new(child.stdout.take().unwrap()).lines();
    assert!(lines.any(|l| l.unwrap().contains("open")), "the server opens");
    child
}

/// Sends frames until the force matches the spring of the server.
fn play(device: &mut DeviceClient, frame: &mut DeviceFrame) {
    until("forces come", || {
        device.send(frame).unwrap();
        device.wait(Duration::from_millis(5));
        device.safe_force()[0] == f64::from(crate::helpers::spring(frame.pos[0]))
    });
}

/// Sends frames until the last force is too old, and then checks that there is none.
fn falls_silent(device: &mut DeviceClient, frame: &mut DeviceFrame) {
    until("the force ends", || {
        device.send(frame).unwrap();
        std::thread::sleep(Duration::from_millis(1));
        device.cause() == Cause::WatchdogOut
    });
    for _ in 0..50 {
        device.send(frame).unwrap();
        assert_eq!(device.safe_force(), [0.0; DOF]);
    }
}

#[test]
fn a_server_that_is_killed_is_zero_force_and_the_next_one_takes_its_place() {
    let place = temp_site();
    let mut device = DeviceClient::open(&place.site, about("key", 2)).unwrap();
    let mut frame = DeviceFrame::new("key", 2);
    frame.pos[0] = 0.002;
    for round in 0..3 {
        let mut child = server(&place, "key");
        play(&mut device, &mut frame);
        let last = *device.watchdog().last().unwrap();
        assert_eq!((last.session, device.watchdog().restarts), (u64::from(child.id()), round));
        assert_eq!(Mode::read(last.mode), Mode::On);
        child.kill().unwrap();
        child.wait().unwrap();
        falls_silent(&mut device, &mut frame);
    }
}

#[test]
fn a_server_that_is_stopped_is_zero_force_until_it_goes_on() {
    let place = temp_site();
    let mut child = server(&place, "key");
    let mut device = DeviceClient::open(&place.site, about("key", 1)).unwrap();
    let mut frame = DeviceFrame::new("key", 1);
    frame.pos[0] = 0.001;
    play(&mut device, &mut frame);
    signal(&child, "STOP");
    // on a busy machine it may send once more before it stops
    let stat = format!("/proc/{}/stat", child.id());
    until("it stops", || std::fs::read_to_string(&stat).is_ok_and(|s| s.contains(") T ")));
    falls_silent(&mut device, &mut frame);
    // it still owns the name
    let busy = Server::refused(&place.site, "key");
    assert!(busy.contains(&child.id().to_string()), "{busy}");
    signal(&child, "CONT");
    play(&mut device, &mut frame);
    child.kill().unwrap();
    child.wait().unwrap();
}

#[test]
fn a_device_that_is_killed_is_gone_and_its_place_is_free() {
    let place = temp_site();
    let mut server = Server::open(&place.site, &["key"], 5);
    let mut sessions = Vec::new();
    for _ in 0..3 {
        let mut child = spawn(&place.site, "device", "key 1000000");
        let mut gone = false;
        until("it plays", || {
            server.serve();
            for (_, event) in std::iter::from_fn(|| server.gateway.event()) {
                if let Event::Here { session } = event {
                    sessions.push(session);
                }
            }
            server.got[0] > 100
        });
        // the name is taken while it lives
        let e = DeviceClient::open(&place.site, about("key", 1)).err().expect("a second one");
        assert!(e.what.contains(&format!("process {}", child.id())), "{e}");
        child.kill().unwrap();
        child.wait().unwrap();
        until("silence is reported", || {
            server.serve();
            gone |= std::iter::from_fn(|| server.gateway.event()).any(|e| e == (0, Event::Gone));
            gone
        });
        server.got[0] = 0;
    }
    assert_eq!(sessions.len(), 3);
    assert!(sessions[0] != sessions[1] && sessions[1] != sessions[2]);
    until("the dead are swept", || place.site.remove_dead().removed > 0);
}

#[test]
fn a_device_that_is_stopped_does_not_stop_the_server() {
    let place = temp_site();
    let mut server = Server::open(&place.site, &["key", "other"], 5);
    let mut child = spawn(&place.site, "device", "key 1000000");
    let mut other = DeviceClient::open(&place.site, about("other", 1)).unwrap();
    let mut frame = DeviceFrame::new("other", 1);
    frame.pos[0] = 0.004;
    until("it plays", || {
        server.serve();
        server.got[0] > 20
    });
    signal(&child, "STOP");
    // far more forces than its queues and its event service hold
    let before = server.got[1];
    until("10 000 forces go to both", || {
        other.send(&mut frame).unwrap();
        server.serve();
        let mut out = ca_haptic::frame::ForceFrame::new("key", 1);
        server.seq[0] += 1;
        (out.session, out.seq) = (5, server.seq[0]);
        out.t_host_ns = ca_haptic::rt::now_ns();
        server.gateway.send(0, &out);
        other.safe_force();
        server.got[1] - before > 10_000
    });
    let traffic = server.gateway.traffic();
    assert_eq!(traffic.unsent.load(std::sync::atomic::Ordering::Relaxed), 0);
    // it continues with the newest force, as the same process
    signal(&child, "CONT");
    let heard = server.got[0];
    until("it plays again", || {
        server.serve();
        server.got[0] > heard + 20
    });
    child.kill().unwrap();
    child.wait().unwrap();
}

#[test]
fn both_killed_leave_nothing_to_clean_by_hand() {
    let place = temp_site();
    let mut child = server(&place, "key");
    let mut player = spawn(&place.site, "device", "key 1000000");
    std::thread::sleep(Duration::from_millis(100));
    for c in [&mut child, &mut player] {
        c.kill().unwrap();
        c.wait().unwrap();
    }
    let mut child = server(&place, "key");
    let mut device = DeviceClient::open(&place.site, about("key", 1)).unwrap();
    let mut frame = DeviceFrame::new("key", 1);
    frame.pos[0] = 0.003;
    play(&mut device, &mut frame);
    child.kill().unwrap();
    child.wait().unwrap();
}
