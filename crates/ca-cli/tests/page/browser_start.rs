//! Tests that `ca play` opens a browser without its token in the arguments of a process, which every user can read.

use crate::host::{command, until};
use crate::skipped::skipped;
use std::fs;
use std::io::{BufRead as _, BufReader};
use std::os::unix::fs::{MetadataExt as _, PermissionsExt as _};
use std::os::unix::process::CommandExt as _;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{Receiver, channel};

/// `ca play` on a desktop whose browser is started by a command.
struct Desktop {
    dir: tempfile::TempDir,
    child: Child,
    said: Receiver<String>,
}

impl Desktop {
    fn new(exec: &str) -> Desktop {
        let dir = tempfile::Builder::new().prefix("cao").tempdir_in("/tmp").unwrap();
        let at = |name: &str| dir.path().join(name);
        fs::write(at("model.ca.toml"), crate::STRING).unwrap();
        fs::create_dir_all(at("share/applications")).unwrap();
        let entry = format!("[Desktop Entry]\nExec={exec}\nMimeType=text/html;x-scheme-handler/http;\n");
        fs::write(at("share/applications/b.desktop"), entry).unwrap();
        fs::create_dir(at("bin")).unwrap();
        let put = |name: &str, text: &str| {
            fs::write(at("bin").join(name), format!("#!/bin/sh\n{text}\n")).unwrap();
            fs::set_permissions(at("bin").join(name), fs::Permissions::from_mode(0o755)).unwrap();
        };
        put("xdg-mime", "echo b.desktop");
        put("plain", "exit 0");
        put("wrapper", "exec /snap/bin/plain \"$@\"");
        // lives as long as a browser would
        put("xdg-open", &format!("echo \"$@\" > {0}.new; mv {0}.new {0}; exec sleep 20", at("opened").display()));
        let mut c = command(dir.path());
        let path = format!("{}:{}", at("bin").display(), std::env::var("PATH").unwrap());
        c.args(["play", "model.ca.toml", "--priority", "0", "--no-lock", "--audio", "page", "--seconds", "60"]);
        c.env("PATH", path).env("DISPLAY", ":77").env("XDG_DATA_DIRS", at("share")).env_remove("BROWSER");
        c.env("HOME", dir.path()).env_remove("XDG_DATA_HOME");
        let mut child = c.stderr(Stdio::piped()).stdout(Stdio::null()).spawn().unwrap();
        let lines = BufReader::new(child.stderr.take().unwrap()).lines();
        let (tell, said) = channel();
        std::thread::spawn(move || lines.map_while(Result::ok).try_for_each(|line| tell.send(line)));
        Desktop { dir, child, said }
    }

    /// Returns the next line with these words.
    fn says(&self, words: &str) -> String {
        self.said.iter().find(|line| line.contains(words)).unwrap_or_else(|| panic!("it ended without `{words}`"))
    }

    fn opened(&self) -> PathBuf {
        self.dir.path().join("opened")
    }
}

impl Drop for Desktop {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// Returns the arguments of all processes, as seen by another user.
#[track_caller]
fn seen_by_another_user() -> Option<String> {
    if fs::metadata("/proc/self").unwrap().uid() != 0 {
        skipped("root", "only root can be another user");
        return None;
    }
    let line = "for p in /proc/[0-9]*/cmdline; do tr '\\0' ' ' < $p; echo; done 2>/dev/null; true";
    let seen = Command::new("sh").args(["-c", line]).current_dir("/").uid(65534).gid(65534).output().unwrap();
    Some(String::from_utf8_lossy(&seen.stdout).into_owned())
}

fn read_by_another_user(path: &Path) -> bool {
    let cat = Command::new("cat").arg(path).current_dir("/").uid(65534).gid(65534).output().unwrap();
    cat.status.success()
}

pub fn by_a_file() {
    let mut desktop = Desktop::new("plain %u");
    let line = desktop.says("play it at");
    let address = line.split(' ').find(|w| w.starts_with("http://")).unwrap();
    let token = address.trim_end_matches('/').rsplit('/').next().unwrap();
    assert_eq!(token.len(), 32);
    until("the browser is started", || desktop.opened().exists());
    let given = fs::read_to_string(desktop.opened()).unwrap();
    let file = Path::new(given.trim());
    let html = fs::read_to_string(file).unwrap();
    assert!(html.contains(&format!("url={address}\"")), "{html}");
    assert_eq!(fs::metadata(file).unwrap().mode() & 0o777, 0o600);
    if let Some(seen) = seen_by_another_user() {
        assert!(seen.contains("model.ca.toml"), "arguments are seen: {seen}");
        assert!(!seen.contains(token), "{seen}");
        assert!(!read_by_another_user(file));
    }
    // a real browser follows the redirect in the file
    if let Some(mut tab) = crate::browser::Tab::open(&format!("file://{}", file.display())) {
        until("the page", || tab.js("document.getElementById('title')?.textContent") == "A string and a bob");
    }
    let file = file.to_owned();
    assert!(Command::new("kill").args(["-INT", &desktop.child.id().to_string()]).status().unwrap().success());
    until("it ends", || desktop.child.try_wait().unwrap().is_some());
    assert!(!file.exists(), "the file is gone with the page");
}

pub fn not_in_a_sandbox() {
    for exec in ["env BAMF=1 /snap/bin/firefox %u", "/usr/bin/flatpak run --branch=stable org.b %u", "wrapper %u"] {
        let desktop = Desktop::new(exec);
        desktop.says("play it at");
        desktop.says("sandbox");
        assert!(!desktop.opened().exists(), "{exec}");
    }
}
