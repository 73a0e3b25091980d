//! Tests `ca device calibrate` in a terminal: a user brings a device to its stops, skips an axis, and lets it move.

use crate::faulty_device::FaultyDevice;
use crate::sandbox::{Sandbox, until};
use crate::skipped::skipped;
use std::fs::File;
use std::io::Write as _;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicI64, Ordering::Relaxed};

/// The command in a terminal created by `script` of util-linux. It is killed on drop.
struct Terminal {
    child: Child,
    shown: std::path::PathBuf,
    seen: usize,
}

impl Terminal {
    fn of(sandbox: &Sandbox, line: &str) -> Terminal {
        let shown = sandbox.path("shown");
        let bin = Path::new(env!("CARGO_BIN_EXE_ca")).parent().unwrap();
        let mut c = sandbox.command("script", &["-qefc", line, "/dev/null"]);
        c.env("PATH", format!("{}:{}", bin.display(), std::env::var("PATH").unwrap()));
        c.stdin(Stdio::piped()).stdout(File::create(&shown).unwrap()).stderr(Stdio::null());
        Terminal { child: c.spawn().unwrap(), shown, seen: 0 }
    }
    fn shows(&mut self, words: &str) {
        until(words, || {
            let all = std::fs::read(&self.shown).unwrap();
            let new = String::from_utf8_lossy(&all[self.seen.min(all.len())..]).into_owned();
            let found = new.find(words);
            if let Some(at) = found {
                self.seen += at + words.len();
            }
            found.is_some()
        });
    }
    fn types(&mut self, line: &str) {
        writeln!(self.child.stdin.as_mut().unwrap(), "{line}").unwrap();
    }
}

impl Drop for Terminal {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

#[test]
fn a_person_is_asked_for_each_stop() {
    if Command::new("script").arg("--version").output().is_err() {
        skipped("script", "no `script`, so there is no terminal in which somebody is asked");
        return;
    }
    let sandbox = Sandbox::new();
    let profile = crate::sandbox::PROFILE.replace("dof = 1", "dof = 2");
    sandbox.put("c/profiles/key.toml", &profile);
    // reading of the sensor in counts; it shakes while this is negative
    let says = Arc::new(AtomicI64::new(100));
    let counts = says.clone();
    let _device = FaultyDevice::moving(&sandbox.site, "key", move |n, f| {
        let at = counts.load(Relaxed);
        f.n = 2;
        f.pos[0] = if at < 0 { 1000.0 * (n % 2) as f64 } else { at as f64 };
    });
    sandbox.ca(&["device", "calibrate", "key", "--low", "0", "--high", "1"]).is(0);
    let mut t = Terminal::of(&sandbox, "ca device calibrate key");
    t.shows("axis 0, low stop: ");
    t.types("");
    t.shows("axis 0, high stop: ");
    // it moves during the reading, so the command asks again from the beginning
    says.store(-1, Relaxed);
    t.types("");
    t.shows("it moved during a reading");
    t.shows("axis 0, low stop: ");
    says.store(4100, Relaxed);
    t.types("");
    t.shows("axis 0, high stop: ");
    says.store(100, Relaxed);
    t.types("");
    t.shows("axis 1, low stop: ");
    t.types("s");
    t.shows("calibration");
    until("it ends", || t.child.try_wait().unwrap().is_some());
    let text = sandbox.read("c/calibration/key.toml");
    let c = ca_haptic::calibration::Calibration::read(&text, "key.toml").unwrap();
    // 20 mm over 4000 counts, reversed; the skipped axis is unchanged
    assert!((c.axis[0].scale + 5e-6).abs() < 1e-15 && (c.axis[0].offset - 0.0105).abs() < 1e-12, "{text}");
    assert!((c.axis[1].scale - 0.02).abs() < 1e-15, "{text}");
    assert_eq!(c.device, "key");
}
