//! Helper processes of tests: the watcher of forces, the device that sends arbitrary frames, load.
//!
//! A helper is this test binary, started again with one ignored test. So nothing else is built, and the helper uses the
//! same frame types. It writes its record to a file and ends when its standard input closes, so it never outlives the
//! test.

use ca_haptic::host::Site;
use std::fs::File;
use std::io::{Read as _, Seek as _, SeekFrom};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};

/// Variable with the record file of a helper; if it is not set, the test was not started as a helper.
const RECORD: &str = "CA_LOOP_RECORD";
const DEVICE: &str = "CA_LOOP_DEVICE";
const MORE: &str = "CA_LOOP_MORE";

/// A running helper, killed on drop.
pub struct HelperProcess {
    child: Child,
    record: PathBuf,
    _dir: tempfile::TempDir,
}

impl HelperProcess {
    /// Starts the test `name` as a helper at `site` and waits until it is ready.
    pub fn start(site: &Site, name: &str, device: &str, more: u64) -> HelperProcess {
        let dir = tempfile::tempdir().unwrap();
        let record = dir.path().join("record");
        let child = Command::new(std::env::current_exe().unwrap())
            .args(["--exact", name, "--ignored", "--nocapture"])
            .env("CA_SHM_ROOT", site.root())
            // name of the JACK server for helpers that use sound
            .env("JACK_DEFAULT_SERVER", device)
            .envs([(RECORD, record.as_os_str()), (DEVICE, device.as_ref()), (MORE, more.to_string().as_ref())])
            .stdin(Stdio::piped())
            .stdout(Stdio::null())
            .spawn()
            .unwrap();
        let mut role = HelperProcess { child, record, _dir: dir };
        super::sandbox::until("the part is ready", || {
            assert!(role.is_running(), "`{name}` ended at once");
            role.record.exists()
        });
        role
    }

    pub fn is_running(&mut self) -> bool {
        self.child.try_wait().unwrap().is_none()
    }

    pub fn written(&self) -> usize {
        self.record.metadata().unwrap().len() as usize
    }

    pub fn read(&self) -> Vec<u8> {
        std::fs::read(&self.record).unwrap()
    }

    /// Last complete piece of `size` bytes in the record.
    pub fn last(&self, size: usize) -> Option<Vec<u8>> {
        let end = self.written() / size * size;
        let mut file = File::open(&self.record).unwrap();
        file.seek(SeekFrom::Start(end.checked_sub(size)? as u64)).unwrap();
        let mut piece = vec![0; size];
        file.read_exact(&mut piece).unwrap();
        Some(piece)
    }

    pub fn end(mut self) -> Vec<u8> {
        drop(self.child.stdin.take());
        super::sandbox::until("the part ends", || !self.is_running());
        assert!(self.child.wait().unwrap().success(), "the part failed; what it says stands above");
        self.read()
    }
}

impl Drop for HelperProcess {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// Arguments of a helper, inside its process.
pub struct Job {
    pub site: Site,
    pub device: String,
    pub more: u64,
    record: PathBuf,
    end: Arc<AtomicBool>,
}

impl Job {
    /// Reads the arguments. Returns `None` if all ignored tests are being run.
    pub fn asked() -> Option<Job> {
        let record = PathBuf::from(std::env::var_os(RECORD)?);
        let text = |name| std::env::var(name).unwrap();
        let end = Arc::new(AtomicBool::new(false));
        let ended = end.clone();
        std::thread::spawn(move || {
            // the only event on standard input is its end
            let _ = std::io::stdin().read(&mut [0]);
            ended.store(true, Relaxed);
        });
        let site = Site::at(Path::new(&text("CA_SHM_ROOT"))).unwrap();
        Some(Job { site, device: text(DEVICE), more: text(MORE).parse().unwrap(), record, end })
    }

    /// Reports that the helper is ready and returns the file for its record.
    pub fn ready(&self) -> File {
        File::create(&self.record).unwrap()
    }

    pub fn is_over(&self) -> bool {
        self.end.load(Relaxed)
    }
}

/// Starts two helpers that keep both cores busy.
pub fn load(site: &Site) -> [HelperProcess; 2] {
    [0, 1].map(|_| HelperProcess::start(site, "helper_process::burn", "", 0))
}

#[test]
#[ignore = "a part of other tests"]
fn burn() {
    let Some(job) = Job::asked() else { return };
    job.ready();
    while !job.is_over() {
        std::hint::spin_loop();
    }
}
