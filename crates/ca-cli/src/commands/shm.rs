//! `ca shm`: shows shared memory of devices and servers, and removes what dead processes left.
//!
//! Nothing of a living process is ever removed, not even on request; to remove it, end the process. Servers and devices
//! clean up after killed processes of their version. This command also handles remains of other versions.

use crate::outcome::{Ended, Outcome};
use crate::term;
use ca_haptic::host::Site;
use ca_haptic::host::stale_shm::{self, Group};
use clap::{Args, ValueEnum};
use serde_json::{Value, json};
use std::io::Write as _;

/// Shows the shared memory of devices and servers, or removes unused parts
///
/// Devices and servers of one user use the folder `CA_SHM_ROOT`, or `/tmp/ca-<uid>`, and `/dev/shm`. `list` shows the
/// files there, their version, and the processes that use them. `clean` removes the files that no running process uses,
/// also of other versions, and lists them. Files of a running process are never removed. Exit code 3 if a file
/// could not be removed.
#[derive(Args)]
#[command(after_long_help = "Examples:
  ca shm list
  ca shm clean
  ca shm list --json")]
pub struct ShmArgs {
    /// what to do
    #[arg(value_enum)]
    pub what: ShmWhat,
    /// Prints the result as JSON
    #[arg(long)]
    pub json: bool,
}

/// An action on shared memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ShmWhat {
    /// shows the files, and the processes that use them
    List,
    /// removes the files that no process uses
    Clean,
}

/// Runs the command.
pub fn run(args: &ShmArgs) -> Outcome {
    let site = Site::of_user()?;
    match args.what {
        ShmWhat::List => list(&site, args.json),
        ShmWhat::Clean => clean(&site, args.json),
    }
}

fn size(bytes: u64) -> String {
    if bytes < 10_000 { format!("{bytes} bytes") } else { format!("{} kB", bytes / 1000) }
}

fn line(group: &Group) -> String {
    let who = group.alive.iter().map(|(id, name)| format!("{id} ({name})")).collect::<Vec<_>>().join(", ");
    let who = if who.is_empty() { "not in use".into() } else { format!("used by {who}") };
    let version = format!("frames {} over iceoryx2 {}", group.frames, group.iox);
    let version = if group.current { version } else { format!("{version}, another version") };
    format!("{version}: {} files, {}, {who}", group.files.len(), size(group.bytes()))
}

fn as_json(group: &Group) -> Value {
    let files: Vec<_> = group.files.iter().map(|(p, b)| json!({"path": p, "bytes": b})).collect();
    let alive: Vec<_> = group.alive.iter().map(|(id, name)| json!({"process": id, "name": name})).collect();
    json!({"prefix": group.prefix, "frames": group.frames, "iceoryx2": group.iox, "ours": group.current, "alive": alive,
           "bytes": group.bytes(), "files": files})
}

fn list(site: &Site, json: bool) -> Outcome {
    let groups = stale_shm::list(site);
    let mut out = std::io::stdout().lock();
    if json {
        let groups: Vec<_> = groups.iter().map(as_json).collect();
        let page = json!({"root": site.root(), "prefix": site.prefix(), "groups": groups});
        writeln!(out, "{page:#}")?;
        return Ok(Ended::Well);
    }
    writeln!(out, "{}, names begin with {}", site.root().display(), site.prefix())?;
    if groups.is_empty() {
        writeln!(out, "no shared memory")?;
    }
    for group in &groups {
        writeln!(out, "{}", line(group))?;
        for (path, bytes) in &group.files {
            writeln!(out, "  {} ({})", path.display(), size(*bytes))?;
        }
    }
    Ok(Ended::Well)
}

fn clean(site: &Site, json: bool) -> Outcome {
    let cleaned = stale_shm::clean(site);
    let bytes: u64 = cleaned.removed.iter().map(|r| r.1).sum();
    let mut out = std::io::stdout().lock();
    if json {
        let removed: Vec<_> = cleaned.removed.iter().map(|(p, b)| json!({"path": p, "bytes": b})).collect();
        let failed: Vec<_> = cleaned.failed.iter().map(|(p, why)| json!({"path": p, "why": why})).collect();
        let kept: Vec<_> = cleaned.in_use.iter().map(as_json).collect();
        writeln!(out, "{:#}", json!({"root": site.root(), "removed": removed, "failed": failed, "kept": kept}))?;
    } else {
        for (path, size) in &cleaned.removed {
            writeln!(out, "removed {} ({size} bytes)", path.display())?;
        }
        writeln!(out, "{} files removed, {}", cleaned.removed.len(), size(bytes))?;
        for group in &cleaned.in_use {
            writeln!(out, "kept {}", line(group))?;
        }
    }
    for (path, why) in &cleaned.failed {
        term::warning(&format!("`{}` cannot be removed: {why}", path.display()));
    }
    Ok(if cleaned.failed.is_empty() { Ended::Well } else { Ended::Degraded })
}
