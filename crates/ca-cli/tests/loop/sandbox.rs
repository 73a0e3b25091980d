//! A private environment for servers and devices, which end with the test.

use ca_haptic::host::Site;
use ca_haptic::host::control::{Reply, Request, ask};
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::atomic::{AtomicU32, Ordering::Relaxed};
use std::sync::{PoisonError, RwLock, RwLockReadGuard, RwLockWriteGuard};
use std::time::{Duration, Instant};

/// A weak spring: 0.45 N at the rest of the key, which counts as nothing.
pub const KEY: &str = r#"
[TGR]
key = { device = "key", dof = 0 }
[SOL]
wall = { x = "0.9 mm" }
[RES]
spring = { between = ["key", "wall"], k = 500, l0 = 0 }
[SOX]
out = { from = "key" }
"#;

/// A key: one twelfth of the TGR, with forces on after an eighth of a second. Its watchdogs are patient, because this
/// machine may stall for 20 ms at a time and these tests are not about that.
pub const PROFILE: &str = r#"
name = "key"
title = "one key"
source = "tgr12"
dof = 1
range = [-0.01, 0.01]
force = 10.0
stiffness = 40000
rate = 3000
[body]
mass = 0.2
friction = 2.0
[guard]
speed = 0.5
clear_time = 0.025
ramp = 0.1
hold = 0.05
zero = 0.09
ttl = 0.06
"#;

/// Changes a profile so that the device holds a force for 0.1 s instead of 5 ms, as long as an engine in lock-step
/// waits for its device. Deadlines do not matter there, so a stall of 10 ms changes nothing.
pub fn patient(profile: &str) -> String {
    assert!(!profile.contains("\nttl"), "{profile}");
    let (before, after) = profile.split_once("[guard]\n").unwrap_or((profile, ""));
    format!("{before}\n[guard]\nttl = 0.1\n{after}")
}

/// A private environment with the profile of the device `key`.
pub struct Sandbox {
    dir: tempfile::TempDir,
    pub site: Site,
    runs: AtomicU32,
    _lock: Lock,
}

/// Runs one sandbox at a time, because each has real-time threads and this machine has few cores. Sandboxes whose tests mostly
/// wait, and retry on a busy machine, run together.
static ONE: RwLock<()> = RwLock::new(());

enum Lock {
    Alone(#[expect(dead_code, reason = "held until the sandbox is dropped")] RwLockWriteGuard<'static, ()>),
    Shared(#[expect(dead_code, reason = "held until the sandbox is dropped")] RwLockReadGuard<'static, ()>),
}

/// A child process, killed on drop.
pub struct Proc {
    child: Child,
    out: PathBuf,
    err: PathBuf,
}

pub struct RunOutput {
    pub code: Option<i32>,
    pub out: String,
    pub err: String,
}

/// Waits until the condition holds, with a long limit for machines under load.
#[track_caller]
pub fn until(what: &str, mut is: impl FnMut() -> bool) {
    let end = Instant::now() + Duration::from_secs(120);
    while !is() {
        assert!(Instant::now() < end, "{what}: not within 120 s");
        std::thread::sleep(Duration::from_millis(5));
    }
}

impl Sandbox {
    pub fn new() -> Sandbox {
        Sandbox::of(Lock::Alone(ONE.write().unwrap_or_else(PoisonError::into_inner)))
    }
    /// Creates a sandbox that may run together with other such sandboxes.
    pub fn shared() -> Sandbox {
        Sandbox::of(Lock::Shared(ONE.read().unwrap_or_else(PoisonError::into_inner)))
    }
    fn of(lock: Lock) -> Sandbox {
        // the path must be short, whatever the system default
        let dir = tempfile::Builder::new().prefix("cal").tempdir_in("/tmp").unwrap();
        let site = Site::at(&dir.path().join("s")).unwrap();
        fs::create_dir_all(dir.path().join("c/profiles")).unwrap();
        let sandbox = Sandbox { dir, site, runs: AtomicU32::new(0), _lock: lock };
        sandbox.put("c/profiles/key.toml", PROFILE).put("key.ca.toml", KEY);
        sandbox
    }
    pub fn path(&self, name: &str) -> PathBuf {
        self.dir.path().join(name)
    }
    pub fn put(&self, name: &str, text: &str) -> &Sandbox {
        fs::write(self.path(name), text).unwrap();
        self
    }
    pub fn read(&self, name: &str) -> String {
        fs::read_to_string(self.path(name)).unwrap()
    }
    /// Prepares a program in this environment.
    pub fn command(&self, program: &str, args: &[&str]) -> Command {
        let mut c = Command::new(program);
        c.args(args).current_dir(&self.dir).env("CA_SHM_ROOT", self.site.root()).env("CA_CONFIG", self.path("c"));
        c
    }
    pub fn start(&self, mut command: Command) -> Proc {
        let n = self.runs.fetch_add(1, Relaxed);
        let (out, err) = (self.path(&format!("{n}.out")), self.path(&format!("{n}.err")));
        command.stdin(Stdio::null()).stdout(File::create(&out).unwrap()).stderr(File::create(&err).unwrap());
        Proc { child: command.spawn().unwrap(), out, err }
    }
    pub fn spawn(&self, args: &[&str]) -> Proc {
        self.start(self.command(env!("CARGO_BIN_EXE_ca"), args))
    }
    pub fn ca(&self, args: &[&str]) -> RunOutput {
        self.spawn(args).end()
    }
    /// Runs a shell line in which `ca` is the built command.
    pub fn sh(&self, line: &str) -> RunOutput {
        let bin = Path::new(env!("CARGO_BIN_EXE_ca")).parent().unwrap();
        let mut c = self.command("sh", &["-ec", line]);
        c.env("PATH", format!("{}:{}", bin.display(), std::env::var("PATH").unwrap()));
        self.start(c).end()
    }
    /// Starts a server of `model` and waits until it answers.
    pub fn serve(&self, model: &str, more: &[&str]) -> Proc {
        let mut server = self.spawn(&[&["serve", model], more].concat());
        until("the server answers", || {
            assert!(server.is_running(), "{}", server.stderr());
            self.ask(&Request::Status).is_some()
        });
        server
    }
    pub fn key(&self, more: &[&str]) -> Proc {
        self.spawn(&[&["device", "sim", "--profile", "key"], more].concat())
    }
    pub fn ask(&self, request: &Request) -> Option<Reply> {
        ask(&self.site, request, Duration::from_secs(2)).ok()
    }
    /// Mode and cause of the first device, and the number of its frames.
    pub fn state(&self) -> (String, String, u64) {
        let Some(r) = self.ask(&Request::Status) else { return Default::default() };
        let d = &r.fields["devices"][0];
        let text = |k: &str| d[k].as_str().unwrap().to_owned();
        (text("mode"), text("cause"), d["frames"].as_u64().unwrap())
    }
    pub fn arm(&self) {
        self.ask(&Request::Arm { device: None });
    }
    /// Arms until forces are on. On a busy machine, watchdogs may trip as intended.
    pub fn on(&self) {
        self.armed("forces on", |mode, _| mode == "on");
    }
    /// Waits until the condition holds, and arms whenever forces are off.
    pub fn armed(&self, what: &str, is: impl Fn(&str, &str) -> bool) {
        let end = Instant::now() + Duration::from_secs(30);
        loop {
            let (mode, cause, frames) = self.state();
            if is(&mode, &cause) {
                return;
            }
            assert!(Instant::now() < end, "{what}: not within 30 s, but {mode}, {cause}, {frames} frames");
            if mode == "fault" || cause == "DISARMED" {
                self.arm();
            }
            std::thread::sleep(Duration::from_millis(10));
        }
    }
}

impl Drop for Sandbox {
    fn drop(&mut self) {
        // removes the files in /dev/shm, which are outside the folder
        ca_haptic::host::stale_shm::clean(&self.site);
    }
}

impl Proc {
    pub fn id(&self) -> u32 {
        self.child.id()
    }
    pub fn is_running(&mut self) -> bool {
        self.child.try_wait().unwrap().is_none()
    }
    pub fn signal(&self, name: &str) {
        let id = self.child.id().to_string();
        assert!(Command::new("kill").args([format!("-{name}"), id]).status().unwrap().success());
    }
    pub fn stderr(&self) -> String {
        [&self.out, &self.err].map(|p| fs::read_to_string(p).unwrap()).concat()
    }
    pub fn end(mut self) -> RunOutput {
        // a soak test lasts longest
        let end = Instant::now() + Duration::from_secs(180);
        while self.is_running() {
            assert!(Instant::now() < end, "it does not end\n{}", self.stderr());
            std::thread::sleep(Duration::from_millis(5));
        }
        let read = |p: &PathBuf| fs::read_to_string(p).unwrap();
        RunOutput { code: self.child.wait().unwrap().code(), out: read(&self.out), err: read(&self.err) }
    }
    pub fn stop(self) -> RunOutput {
        self.signal("INT");
        self.end()
    }
    pub fn kill(mut self) {
        self.child.kill().unwrap();
        self.child.wait().unwrap();
    }
}

impl Drop for Proc {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

impl RunOutput {
    /// Checks that `frames` were served. On a busy machine, forces without a reader may be lost, which gives exit code
    /// 3.
    #[track_caller]
    pub fn served(self, frames: u32) -> RunOutput {
        let (before, _) = self.out.split_once(" forces not read").unwrap_or_default();
        let late = before.rsplit(' ').next().and_then(|n| n.parse().ok()).is_some_and(|n: u64| n > 0);
        assert!(!["clipped", "not written"].iter().any(|w| self.out.contains(w)), "{}", self.out);
        let words = format!(" in {frames} gesture frames");
        self.is(if late { 3 } else { 0 }).says(&[&words, "lost           nothing", "faults         none"])
    }
    #[track_caller]
    pub fn is(self, code: i32) -> RunOutput {
        assert_eq!(self.code, Some(code), "stdout:\n{}\nstderr:\n{}", self.out, self.err);
        self
    }
    #[track_caller]
    pub fn says(self, words: &[&str]) -> RunOutput {
        for w in words {
            assert!(self.out.contains(w) || self.err.contains(w), "no `{w}` in\n{}\n{}", self.out, self.err);
        }
        self
    }
    #[track_caller]
    pub fn json(&self) -> serde_json::Value {
        serde_json::from_str(&self.out).unwrap_or_else(|e| panic!("{e}\n{}\n{}", self.out, self.err))
    }
}
