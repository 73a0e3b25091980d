//! Both sides in one process: traffic, access, and error messages.

use crate::helpers::{Server, about, spring, temp_site, until};
use ca_haptic::frame::{Cause, DOF, DeviceFrame, ForceFrame, FrameMismatch, text};
use ca_haptic::host::gateway::list_devices;
use ca_haptic::host::{DeviceClient, Event, Gateway, HostErrorKind, Rings, Site};
use std::path::Path;
use std::time::Duration;

#[test]
fn frames_cross_whoever_comes_first() {
    for device_first in [true, false] {
        let place = temp_site();
        let site = &place.site;
        let (mut device, mut server);
        if device_first {
            device = DeviceClient::open(site, about("key", 3)).unwrap();
            assert_eq!(device.send(&mut DeviceFrame::new("key", 3)).unwrap(), 0, "nobody there");
            server = Server::open(site, &["key"], 7);
        } else {
            server = Server::open(site, &["key"], 7);
            device = DeviceClient::open(site, about("key", 3)).unwrap();
        }
        let mut frame = DeviceFrame::new("key", 3);
        (frame.pos[0], frame.pos[2]) = (0.001, -0.003);
        assert_eq!((device.cause(), device.safe_force()), (Cause::Disconnect, [0.0; DOF]));
        until("a force arrives", || {
            device.send(&mut frame).unwrap();
            server.serve();
            device.wait(Duration::from_millis(10));
            device.safe_force()[0] != 0.0
        });
        let mut want = [0.0; DOF];
        (want[0], want[1], want[2]) = (f64::from(spring(0.001)), f64::from(spring(0.0)), f64::from(spring(-0.003)));
        device.send(&mut frame).unwrap();
        server.serve();
        assert!(device.force().is_some_and(|f| f.ack == frame.seq && f.ack_session == frame.session));
        assert_eq!(device.safe_force(), want);
        assert!(frame.t_host_ns > 0 && frame.period_ns == 1_000_000 && frame.session == device.about().session);
        // the next frame acknowledges the force that was used
        device.send(&mut frame).unwrap();
        assert_eq!(frame.ack, server.seq[0]);
        let mut events = Vec::new();
        until("the device introduces itself", || {
            server.serve();
            events.extend(std::iter::from_fn(|| server.gateway.event()));
            server.gateway.about(0).is_some_and(|a| a.n == 3)
        });
        assert_eq!(events[0], (0, Event::Here { session: frame.session }));
        // silence counts as absence
        until("the device is gone", || {
            server.serve();
            std::iter::from_fn(|| server.gateway.event()).any(|e| e == (0, Event::Gone))
        });
        assert_eq!((device.safe_force(), device.cause()), ([0.0; DOF], Cause::WatchdogOut), "H7");
    }
}

#[test]
fn a_force_that_was_only_looked_at_is_not_acknowledged() {
    let place = temp_site();
    let mut device = DeviceClient::open(&place.site, about("key", 1)).unwrap();
    let mut server = Server::open(&place.site, &["key"], 7);
    let mut frame = DeviceFrame::new("key", 1);
    let mut answer = |device: &mut DeviceClient, look: &dyn Fn(&mut DeviceClient)| {
        let before = server.seq[0];
        device.send(&mut frame).unwrap();
        until("it is answered", || {
            server.serve();
            server.seq[0] > before
        });
        until("the answer is there", || {
            look(device);
            device.watchdog().last().is_some_and(|f| f.seq == server.seq[0])
        });
        (frame.ack, server.seq[0])
    };
    let give = |d: &mut DeviceClient| {
        d.safe_force();
    };
    let look = |d: &mut DeviceClient| {
        d.cause();
    };
    let given = answer(&mut device, &give).1;
    // this answer comes while the motors still hold the last force: asking for the cause does not take the new one
    let (ack, newer) = answer(&mut device, &look);
    assert_eq!(ack, given);
    let (ack, _) = answer(&mut device, &give);
    assert_eq!(ack, given, "{newer} was only looked at");
    assert_eq!(answer(&mut device, &look).0, newer + 1);
}

#[test]
fn a_place_that_is_taken_says_who_has_it() {
    let place = temp_site();
    let site = &place.site;
    let _device = DeviceClient::open(site, about("key", 1)).unwrap();
    let e = DeviceClient::open(site, about("key", 1)).err().expect("a second device of this name");
    let me = format!("process {}", std::process::id());
    assert_eq!(e.kind, HostErrorKind::Busy);
    assert!(e.what.contains("`key`") && e.what.contains(&me), "{e}");
    let _server = Gateway::open(site, &["key"]).unwrap();
    let e = Gateway::open(site, &["other", "key"]).err().expect("a second server");
    assert!(e.kind == HostErrorKind::Busy && e.what.contains("`key`") && e.what.contains(&me), "{e}");
    // devices opened before the refusal are free again
    Gateway::open(site, &["other"]).unwrap();
    assert_eq!(Gateway::open(site, &["a", "a"]).err().unwrap().kind, HostErrorKind::Name);
}

#[test]
fn bad_names_and_places_are_refused() {
    let place = temp_site();
    for bad in ["", "a/b", "ä", "with space", "x\n"] {
        let e = DeviceClient::open(&place.site, about(bad, 1)).err().expect(bad);
        assert_eq!(e.kind, HostErrorKind::Name, "{bad}");
        assert_eq!(Gateway::open(&place.site, &[bad]).err().unwrap().kind, HostErrorKind::Name);
    }
    assert_eq!(Gateway::open(&place.site, &["seventeen-letters"]).err().unwrap().kind, HostErrorKind::Name);
    let long = format!("/tmp/{}", "x".repeat(60));
    for bad in ["relative", long.as_str(), "/proc/ca", "/etc/hostname", "/tmp"] {
        let e = Site::at(Path::new(bad)).expect_err(bad);
        assert_eq!(e.kind, HostErrorKind::Site, "{e}");
        assert!(!e.fix.is_empty());
        assert!(!Path::new(&long).exists());
    }
}

#[test]
fn the_longest_place_works() {
    let dir = tempfile::Builder::new().prefix("ca").tempdir_in("/tmp").unwrap();
    let rest = ca_haptic::host::site::LONGEST - dir.path().as_os_str().len() - 1;
    let site = Site::at(&dir.path().join("x".repeat(rest))).unwrap();
    let mut server = Server::open(&site, &["sixteen-letters."], 1);
    let mut device = DeviceClient::open(&site, about("sixteen-letters.", 1)).unwrap();
    let mut frame = DeviceFrame::new("", 1);
    until("a wake-up", || {
        device.send(&mut frame).unwrap();
        server.serve();
        device.wait(Duration::from_millis(5))
    });
    drop((device, server));
    ca_haptic::host::stale_shm::clean(&site);
}

#[test]
fn five_devices_and_twenty_four_keys_through_the_rings() {
    let place = temp_site();
    let names = ["a", "b", "c", "d", "keys"];
    let (incoming, mut from) = rtrb::RingBuffer::new(64);
    let (mut to, outgoing) = rtrb::RingBuffer::new(64);
    let (events, happened) = std::sync::mpsc::channel();
    let running = Gateway::start(
        &place.site,
        &names,
        Rings { incoming, outgoing, events },
        ca_haptic::rt::RtRequest::default(),
        Duration::ZERO,
    )
    .unwrap();
    let mut devices: Vec<_> = names.iter().map(|n| DeviceClient::open(&place.site, about(n, 24)).unwrap()).collect();
    let mut frames = names.map(|n| DeviceFrame::new(n, 24));
    let (mut got, mut seq) = ([0_u64; 5], 0);
    until("every device has 200 forces of its own", || {
        for (device, frame) in devices.iter_mut().zip(&mut frames) {
            device.send(frame).unwrap();
        }
        while let Ok((k, f)) = from.pop() {
            assert_eq!(text(&f.device), names[k as usize], "frames stay with their device");
            seq += 1;
            let mut out = ForceFrame::new(names[k as usize], 24);
            (out.session, out.seq, out.ttl_us) = (1, seq, 5000);
            out.force[23] = k as f32 + 0.5;
            let _ = to.push((k, out));
        }
        for (k, device) in devices.iter_mut().enumerate() {
            if let Some(f) = device.force() {
                assert_eq!(f.force[23], k as f32 + 0.5);
                got[k] += 1;
            }
        }
        got.iter().all(|n| *n >= 200)
    });
    let here = happened.try_iter().filter(|e| matches!(e.1, Event::Here { .. })).count();
    assert_eq!(here, 5);
    let listed: Vec<_> = list_devices(&place.site, Duration::ZERO).unwrap();
    assert!(listed.is_empty(), "nothing can be heard in no time");
    let mut listed = Vec::new();
    until("all are listed", || {
        for (device, frame) in devices.iter_mut().zip(&mut frames) {
            device.send(frame).unwrap();
        }
        // devices send from another thread while `list_devices` listens
        let site = place.site.clone();
        let list = std::thread::spawn(move || list_devices(&site, Duration::from_millis(300)).unwrap());
        while !list.is_finished() {
            for (device, frame) in devices.iter_mut().zip(&mut frames) {
                device.send(frame).unwrap();
            }
            std::thread::sleep(Duration::from_millis(1));
        }
        listed = list.join().unwrap().iter().map(|a| (text(&a.device), a.n)).collect();
        listed.len() == 5
    });
    assert_eq!(listed, names.map(|n| (n.to_owned(), 24)));
    drop(running);
    // the names are free at once
    Gateway::open(&place.site, &names).unwrap();
}

#[test]
fn a_ring_that_is_full_is_counted_and_nobody_waits() {
    let place = temp_site();
    let (incoming, from) = rtrb::RingBuffer::new(2);
    let (_to, outgoing) = rtrb::RingBuffer::new(2);
    let (events, _) = std::sync::mpsc::channel();
    let running = Gateway::start(
        &place.site,
        &["key"],
        Rings { incoming, outgoing, events },
        ca_haptic::rt::RtRequest::default(),
        Duration::ZERO,
    )
    .unwrap();
    let mut device = DeviceClient::open(&place.site, about("key", 1)).unwrap();
    let mut frame = DeviceFrame::new("key", 1);
    let load = std::sync::atomic::Ordering::Relaxed;
    until("frames find no room", || {
        device.send(&mut frame).unwrap();
        running.traffic.full.load(load) >= 10
    });
    let t = &running.traffic;
    assert_eq!(from.slots(), 2);
    assert!(t.received.load(load) >= t.full.load(load) + 2);
    // every frame sent was received, missed or is still on its way (at most four are stored)
    let known = t.received.load(load) + t.missed.load(load);
    assert!(known <= frame.seq && frame.seq - known <= 4 + 60, "{known} of {}", frame.seq);
}

#[test]
fn every_ping_comes_back_with_its_number() {
    let place = temp_site();
    let (incoming, mut from) = rtrb::RingBuffer::new(64);
    let (mut to, outgoing) = rtrb::RingBuffer::new(64);
    let (events, _told) = std::sync::mpsc::channel();
    let running = Gateway::start(
        &place.site,
        &["key"],
        Rings { incoming, outgoing, events },
        ca_haptic::rt::RtRequest::default(),
        Duration::ZERO,
    )
    .unwrap();
    let over = std::sync::atomic::AtomicBool::new(false);
    let mut times = std::thread::scope(|threads| {
        // an engine that answers at once
        threads.spawn(|| {
            let mut out = ForceFrame::new("key", 1);
            while !over.load(std::sync::atomic::Ordering::Relaxed) {
                while let Ok((k, f)) = from.pop() {
                    out.seq += 1;
                    (out.session, out.ttl_us, out.ack_session, out.ack) = (1, 5000, f.session, f.seq);
                    let _ = to.push((k, out));
                }
                std::thread::sleep(Duration::from_micros(10));
            }
        });
        let mut device = DeviceClient::open(&place.site, about("key", 1)).unwrap();
        let mut frame = DeviceFrame::new("key", 1);
        let mut times = Vec::new();
        for _ in 0..2000 {
            let start = std::time::Instant::now();
            device.send(&mut frame).unwrap();
            until("the answer", || {
                device.wait(Duration::from_millis(100));
                device.force().is_some_and(|f| f.ack == frame.seq)
            });
            times.push(start.elapsed().as_nanos() as u64);
        }
        over.store(true, std::sync::atomic::Ordering::Relaxed);
        times
    });
    assert_eq!(running.traffic.missed.load(std::sync::atomic::Ordering::Relaxed), 0);
    times.sort_unstable();
    // for people, with `--nocapture`; a shared machine proves no time
    let at = |p: usize| times[times.len() * p / 1000] / 1000;
    println!("round trip: p50 {} us, p99 {} us, p99.9 {} us", at(500), at(990), at(999));
}

#[test]
fn what_a_device_says_is_reported_once_also_where_it_is_no_number() {
    let place = temp_site();
    let mut server = Server::open(&place.site, &["key"], 7);
    let mut who = about("key", 1);
    (who.low[0], who.stiffness[0]) = (f32::NAN, f32::NAN);
    let mut device = DeviceClient::open(&place.site, who).unwrap();
    let mut frame = DeviceFrame::new("key", 1);
    let (mut reported, mut heard) = (0, 0);
    // a device describes itself once a second
    let begin = ca_haptic::rt::now_ns();
    until("it has said it three times", || {
        device.send(&mut frame).unwrap();
        server.serve();
        reported += std::iter::from_fn(|| server.gateway.event()).filter(|e| matches!(e.1, Event::About(_))).count();
        heard += 1;
        ca_haptic::rt::now_ns() - begin > 2_200_000_000
    });
    assert!(heard > 10 && server.gateway.about(0).is_some_and(|a| a.low[0].is_nan()));
    assert_eq!(reported, 1);
}

#[test]
fn frames_without_a_degree_of_freedom_are_named() {
    let place = temp_site();
    let mut server = Server::open(&place.site, &["key"], 7);
    let mut device = DeviceClient::open(&place.site, about("key", 1)).unwrap();
    let mut frame = DeviceFrame::new("key", 0);
    let mut events = Vec::new();
    until("it is reported", || {
        device.send(&mut frame).unwrap();
        server.serve();
        events.extend(std::iter::from_fn(|| server.gateway.event()));
        events.iter().any(|(_, e)| *e == Event::Foreign(FrameMismatch::Size(0)))
    });
    assert_eq!(server.got[0], 0, "none of them is used");
}

/// Two servers wait for one device. The first gets it; the second names the first, and takes over when the first ends.
#[test]
fn a_device_is_claimed_when_it_speaks_and_is_kept() {
    let place = temp_site();
    let start = |after| {
        let (incoming, from) = rtrb::RingBuffer::new(64);
        let (to, outgoing) = rtrb::RingBuffer::new(64);
        let (events, happened) = std::sync::mpsc::channel();
        let rings = Rings { incoming, outgoing, events };
        let request = ca_haptic::rt::RtRequest::default();
        (Gateway::start(&place.site, &["key"], rings, request, after).unwrap(), from, to, happened)
    };
    let (second, mut to_second, mut of_second, told_second) = start(Duration::from_millis(300));
    let (first, mut to_first, mut of_first, told_first) = start(Duration::ZERO);
    let mut device = DeviceClient::open(&place.site, about("key", 1)).unwrap();
    let mut frame = DeviceFrame::new("key", 1);
    let mut force = ForceFrame::new("key", 1);
    let mut told = Vec::new();
    let mut got = 0;
    until("the second names the first", || {
        device.send(&mut frame).unwrap();
        force.seq += 1;
        for (session, to) in [(1, &mut of_first), (2, &mut of_second)] {
            (force.session, force.ttl_us) = (session, 5000);
            let _ = to.push((0, force));
        }
        while let Some(f) = device.force() {
            assert_eq!(f.session, 1, "one server gives forces");
            got += 1;
        }
        while to_first.pop().is_ok() {}
        told.extend(told_second.try_iter());
        std::thread::sleep(Duration::from_millis(1));
        !told.is_empty() && got > 10
    });
    let me = format!("process {}", std::process::id());
    assert!(matches!(&told[..], [(0, Event::Taken(who))] if who.contains("`key`") && who.contains(&me)), "{told:?}");
    assert!(told_first.try_iter().any(|e| matches!(e, (0, Event::Here { .. }))));
    assert!(to_second.pop().is_err(), "the second hears nothing of it");
    drop(first);
    until("the second has it", || {
        device.send(&mut frame).unwrap();
        std::thread::sleep(Duration::from_millis(1));
        to_second.pop().is_ok()
    });
    let here = |e| matches!(e, (0, Event::Here { .. }));
    // the gateway reports it separately from the frames
    until("it is told so", || told_second.try_iter().any(here));
    drop(second);
}
