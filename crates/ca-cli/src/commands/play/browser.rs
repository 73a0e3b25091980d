//! Opens the page in the desktop's browser without the token in the arguments of a process.
//!
//! Other users can see the arguments of every process, and the token is enough to play. So the browser opens a file
//! that only this user can read, which redirects to the address. A sandboxed browser (snap, flatpak) cannot read that
//! file and is not opened. Neither is an unknown program.

use crate::term;
use ca_haptic::host::Site;
use ca_io::atomic_file::AtomicFile;
use std::env;
use std::fs;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// Parts of a command that starts a program in a sandbox.
const SANDBOXES: [&str; 4] = ["/snap/", "snap run", "flatpak run", "bin/flatpak"];
/// Longest script searched for these parts \[bytes\].
const SCRIPT: u64 = 1 << 16;

/// Redirecting file, removed on drop.
pub(super) struct Redirect(PathBuf);

impl Drop for Redirect {
    fn drop(&mut self) {
        let _ = fs::remove_file(&self.0);
    }
}

/// Opens an address, or returns `None` if the redirecting file or the thread cannot be created. A thread queries the
/// desktop, which may take a while.
pub(super) fn open(address: &str) -> Option<Redirect> {
    let redirect = match redirect(address) {
        Ok(redirect) => redirect,
        Err(why) => {
            term::note(&format!("no browser was opened ({why}); open the address in a browser"));
            return None;
        }
    };
    let path = redirect.0.clone();
    let work = move || {
        if let Err(why) = readable().and_then(|()| open::that_detached(&path).map_err(|e| e.to_string())) {
            term::note(&format!("no browser was opened ({why}); open the address in a browser"));
        }
    };
    let started = std::thread::Builder::new().name("ca browser".into()).spawn(work);
    started.is_ok().then_some(redirect)
}

/// Writes the redirecting file. Replaces a file left by a killed process.
fn redirect(address: &str) -> Result<Redirect, String> {
    let port = address.rsplit(':').next().and_then(|rest| rest.split('/').next()).unwrap_or_default();
    let site = Site::of_user().map_err(|e| e.to_string())?;
    let path = site.root().join(format!("page-{port}.html"));
    let html = format!(
        "<!doctype html>\n<meta charset=\"utf-8\">\n<title>ca play</title>\n\
         <meta http-equiv=\"refresh\" content=\"0; url={address}\">\n<a href=\"{address}\">ca play</a>\n"
    );
    let staged = AtomicFile::create_private(&path).map_err(|e| e.to_string())?;
    staged.handle().map_err(|e| e.to_string())?.write_all(html.as_bytes()).map_err(|e| e.to_string())?;
    staged.commit().map_err(|e| e.to_string())?;
    Ok(Redirect(path))
}

/// Fails if the program for the file is sandboxed or is not known to be a browser.
fn readable() -> Result<(), String> {
    if !cfg!(target_os = "linux") {
        return Ok(());
    }
    let command = match env::var("BROWSER").ok().filter(|b| !b.is_empty()) {
        Some(browser) => browser.split(':').next().unwrap_or_default().to_owned(),
        None => desktop_command()?,
    };
    if is_sandboxed(&command) {
        return Err(
            "the browser runs in a sandbox, a snap or flatpak, and would need the token in its arguments".into()
        );
    }
    Ok(())
}

/// Returns the command of the desktop's browser.
fn desktop_command() -> Result<String, String> {
    let asked = Command::new("xdg-mime").args(["query", "default", "text/html"]).stdin(Stdio::null()).output();
    let asked = asked.map_err(|e| format!("xdg-mime: {}", crate::load::reason(&e)))?;
    let name = String::from_utf8_lossy(&asked.stdout).trim().to_owned();
    if name.is_empty() || name.contains('/') {
        return Err("xdg-mime finds no browser".into());
    }
    let file = data_folders().map(|d| d.join("applications").join(&name)).find(|f| f.is_file());
    let text = file.and_then(|f| fs::read_to_string(f).ok()).ok_or_else(|| format!("`{name}` is not found"))?;
    let value = |key: &str| text.lines().find_map(|l| l.strip_prefix(key)?.strip_prefix('='));
    if !value("MimeType").is_some_and(|types| types.contains("x-scheme-handler/http")) {
        return Err(format!("`{name}` opens HTML files but is not a browser"));
    }
    if value("X-Flatpak").is_some() || value("X-SnapInstanceName").is_some() {
        return Ok("flatpak run".into());
    }
    value("Exec").map(str::to_owned).ok_or_else(|| format!("`{name}` does not define a command"))
}

/// Folders in which desktops look for applications.
fn data_folders() -> impl Iterator<Item = PathBuf> {
    let set = |name: &str| env::var(name).ok().filter(|v| !v.is_empty());
    let own = set("XDG_DATA_HOME").or_else(|| set("HOME").map(|h| format!("{h}/.local/share")));
    let all = set("XDG_DATA_DIRS").unwrap_or_else(|| "/usr/local/share:/usr/share".into());
    let all: Vec<PathBuf> = own.iter().map(String::as_str).chain(all.split(':')).map(PathBuf::from).collect();
    all.into_iter()
}

/// Returns true if a command starts a sandboxed program, judged by its text, its program or its script.
fn is_sandboxed(command: &str) -> bool {
    let says = |text: &str| SANDBOXES.iter().any(|s| text.contains(s));
    let word = command.split_whitespace().find(|w| *w != "env" && !w.contains('=')).unwrap_or_default();
    let program = word.trim_matches('"');
    let paths = env::var_os("PATH").unwrap_or_default();
    let found = if program.contains('/') {
        Some(PathBuf::from(program))
    } else {
        env::split_paths(&paths).map(|d| d.join(program)).find(|p| p.is_file())
    };
    let real = found.and_then(|f| fs::canonicalize(f).ok());
    let script = |path: &Path| {
        let short = fs::metadata(path).is_ok_and(|m| m.len() <= SCRIPT);
        short.then(|| fs::read(path).ok()).flatten().filter(|b| b.starts_with(b"#!"))
    };
    says(command)
        || real.as_deref().is_some_and(|path| {
            path.ends_with("snap")
                || says(&path.to_string_lossy())
                || script(path).is_some_and(|text| says(&String::from_utf8_lossy(&text)))
        })
}
