//! Shared helpers of the tests: a temporary place, a device, a gateway, and waiting for a condition.

use ca_haptic::frame::{About, DOF, ForceFrame, Mode};
use ca_haptic::host::{Gateway, Site};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// A place that is removed with the test.
pub struct TempSite {
    pub site: Site,
    _dir: tempfile::TempDir,
}

pub fn temp_site() -> TempSite {
    let dir = tempfile::Builder::new().prefix("ca").tempdir_in("/tmp").unwrap();
    TempSite { site: Site::at(dir.path()).unwrap(), _dir: dir }
}

impl Drop for TempSite {
    fn drop(&mut self) {
        // its files in /dev/shm are not in the folder
        ca_haptic::host::stale_shm::clean(&self.site);
    }
}

pub fn about(name: &str, n: usize) -> About {
    About { high: [0.02; DOF], force: [10.0; DOF], continuous: [10.0; DOF], ..About::new(name, 1000, n) }
}

/// Returns the force for a position: a spring, so that values can be checked.
pub fn spring(x: f64) -> f32 {
    (-1000.0 * x) as f32
}

/// Waits until `is` holds, for up to 30 s, since a loaded machine may be slow.
pub fn until(what: &str, mut is: impl FnMut() -> bool) {
    let end = Instant::now() + Duration::from_secs(30);
    while !is() {
        assert!(Instant::now() < end, "{what}: not within 30 s");
        std::thread::sleep(Duration::from_micros(500));
    }
}

/// Server without a scene: answers every frame with the force of a spring, at first with forces off.
pub struct Server {
    pub gateway: Gateway,
    pub session: u64,
    pub seq: Vec<u64>,
    /// Frames received from each device.
    pub got: Vec<u64>,
    /// Stiffness \[N/m\], constant force \[N\], and time to live \[µs\] of its forces.
    pub plays: (f64, f64, u32),
    names: Vec<String>,
}

impl Server {
    pub fn open(site: &Site, names: &[&str], session: u64) -> Server {
        Server {
            gateway: Gateway::open(site, names).unwrap(),
            session,
            seq: vec![0; names.len()],
            got: vec![0; names.len()],
            plays: (1000.0, 0.0, 5000),
            names: names.iter().map(|n| (*n).into()).collect(),
        }
    }

    /// Returns the error of a second server for this device.
    pub fn refused(site: &Site, name: &str) -> String {
        Gateway::open(site, &[name]).err().expect("one server a device").to_string()
    }

    pub fn serve(&mut self) {
        let mut came = Vec::new();
        self.gateway.poll(&mut |k, f| came.push((k, f)));
        for (k, f) in came {
            self.got[k] += 1;
            self.seq[k] += 1;
            let mut out = ForceFrame::new(&self.names[k], f.n as usize);
            (out.session, out.seq, out.ack_session, out.ack) = (self.session, self.seq[k], f.session, f.seq);
            out.ttl_us = self.plays.2;
            if self.seq[k] > 3 {
                out.mode = Mode::On as u32;
                out.cause = 0;
                for d in 0..f.n as usize {
                    out.force[d] = (self.plays.1 - self.plays.0 * f.pos[d]) as f32;
                }
            }
            out.t_host_ns = ca_haptic::rt::now_ns();
            self.gateway.send(k, &out);
        }
    }
}

/// Serves an example until it ends: a finger of 100 g, pushed with 0.5 N on 100 N/m, comes to rest at 5 mm.
pub fn played(place: &TempSite, mut child: Child) {
    let mut server = Server::open(&place.site, &["finger"], 3);
    server.plays = (100.0, 0.5, 100_000);
    until("it ends", || {
        server.serve();
        child.try_wait().unwrap().is_some()
    });
    let out = child.wait_with_output().unwrap();
    let (said, err) = (String::from_utf8_lossy(&out.stdout), String::from_utf8_lossy(&out.stderr));
    assert!(out.status.success(), "{said}\n{err}");
    let line = said.lines().find_map(|l| l.find("sent ").map(|at| &l[at..])).unwrap_or_else(|| panic!("{said}\n{err}"));
    let words: Vec<_> = line.split_whitespace().collect();
    let number = |name: &str| words[words.iter().position(|w| *w == name).unwrap() + 1].parse::<f64>().unwrap();
    assert_eq!((number("sent"), words.last().copied()), (2000.0, Some("on")), "{line}");
    assert!(number("seen") > 100.0 && number("felt") > 100.0, "{line}");
    assert!((number("x") - 0.005).abs() < 0.0005, "{line}");
    assert!(number("most") <= 0.5 + 1e-6, "it never swings back beyond the push: {line}");
    let device = server.gateway.about(0).expect("it says who it is");
    assert_eq!((device.n, device.rate, device.force[0]), (1, 1000, 10.0));
    // frames beyond the queue are lost while this process sleeps on a busy machine
    assert!(server.got[0] >= 1000, "{} of 2000 frames came", server.got[0]);
}

/// Runs a role of [`crate::processes`] in a child process.
pub fn spawn(site: &Site, role: &str, args: &str) -> Child {
    Command::new(std::env::current_exe().unwrap())
        .args(["--exact", "processes::role", "--nocapture", "--quiet"])
        .env("CA_SHM_ROOT", site.root())
        .env("CA_TEST_ROLE", role)
        .env("CA_TEST_ARGS", args)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap()
}
