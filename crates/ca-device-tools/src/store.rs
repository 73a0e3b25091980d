//! Finds the profiles and calibrations of a user in `$CA_CONFIG`, else `~/.config/ca`.
//!
//! A profile is first looked up as a file path, then among the user's profiles, then among the shipped ones. A
//! calibration is found by the name of its device, because it belongs to the hardware and not to a model.

use crate::{Message, ToolError};
use ca_haptic::calibration::Calibration;
use ca_haptic::profile::{Profile, SHIPPED};
use ca_io::error::reason;
use ca_model::suggest::{listed, nearest};
use cordis_anima::loaded::text;
use std::path::{Path, PathBuf};

/// Returns the configuration directory.
pub fn dir() -> PathBuf {
    let set = |name: &str| std::env::var_os(name).filter(|v| !v.is_empty()).map(PathBuf::from);
    set("CA_CONFIG")
        .or_else(|| set("XDG_CONFIG_HOME").map(|d| d.join("ca")))
        .or_else(|| set("HOME").map(|d| d.join(".config/ca")))
        .unwrap_or_else(|| PathBuf::from(".ca"))
}

/// Returns the path of the calibration of a device.
pub fn calibration_file(device: &str) -> PathBuf {
    dir().join("calibration").join(format!("{device}.toml"))
}

/// Returns the file of a profile that is not shipped.
pub fn profile_file(word: &str) -> Option<PathBuf> {
    let own = dir().join("profiles").join(format!("{word}.toml"));
    [PathBuf::from(word), own].into_iter().find(|path| path.is_file())
}

/// Returns a profile by file or name.
///
/// # Errors
/// [`ToolError::Usage`] if there is none, [`ToolError::File`] if its file cannot be read.
pub fn profile(word: &str) -> Result<Profile, ToolError> {
    if let Some(path) = profile_file(word) {
        return Ok(Profile::read(&text(&path)?, &path.display().to_string())?);
    }
    Profile::shipped(word).ok_or_else(|| {
        let hint = match nearest(word, SHIPPED.iter().map(|s| s.0)) {
            Some(m) => format!("did you mean `{m}`?"),
            None => format!("choose from {}, or give a file", listed(SHIPPED.iter().map(|s| s.0))),
        };
        ToolError::Usage(format!("no profile `{word}`; {hint}"))
    })
}

/// Returns the profile of a device: the one given as `DEVICE=PROFILE` or for all, else one with the name of the device,
/// else `unknown`, with a warning.
///
/// # Errors
/// As [`profile`]; a device without a profile is not an error.
pub fn profile_of(device: &str, given: &[String], say: &mut dyn FnMut(Message)) -> Result<Profile, ToolError> {
    let named = given.iter().find_map(|g| g.split_once('=').filter(|(d, _)| *d == device).map(|(_, p)| p));
    let plain = given.iter().find(|g| !g.contains('=')).map(String::as_str);
    if let Some(word) = named.or(plain) {
        return profile(word);
    }
    // an existing profile that cannot be read is an error, not replaced by `unknown`
    match profile(device) {
        Err(ToolError::Usage(_)) => {}
        found => return found,
    }
    let p = profile("unknown")?;
    say(Message::Warning(format!(
        "no profile for device `{device}`: using the degrees of freedom it reports and a {} N limit; choose a profile \
         with `--profile {device}=NAME` (`ca device list` shows them)",
        p.force
    )));
    Ok(p)
}

/// Returns the calibration of a device: the file given as `DEVICE=FILE`, else the user's, else none.
///
/// # Errors
/// If its file cannot be read, or belongs to another device.
pub fn calibration_of(device: &str, given: &[String]) -> Result<Calibration, ToolError> {
    let named = given.iter().find_map(|g| g.split_once('=').filter(|(d, _)| *d == device).map(|(_, p)| p.into()));
    let path: PathBuf = match named {
        Some(path) => path,
        None if calibration_file(device).is_file() => calibration_file(device),
        None => return Ok(Calibration::default()),
    };
    let read = Calibration::read(&text(&path)?, &path.display().to_string())?;
    // a file without a device fits any
    if !read.device.is_empty() && read.device != device {
        return Err(ToolError::Failed(format!(
            "{}: this calibration is for `{}`, not for `{device}`, so positions and forces would be wrong; give the \
             calibration of `{device}`, or make one with `ca device calibrate {device}`",
            path.display(),
            read.device
        )));
    }
    Ok(read)
}

/// Returns all profiles by name, with true for a user's own. A user's profile replaces a shipped one of the same
/// name.
///
/// # Errors
/// If a file of the user cannot be read.
pub fn profiles() -> Result<Vec<(Profile, bool)>, ToolError> {
    let mut list: Vec<(Profile, bool)> =
        SHIPPED.iter().filter_map(|(name, _)| Some((Profile::shipped(name)?, false))).collect();
    let own = std::fs::read_dir(dir().join("profiles")).into_iter().flatten().flatten();
    let is_toml = |path: &PathBuf| path.extension().is_some_and(|e| e.eq_ignore_ascii_case("toml"));
    let mut files: Vec<_> = own.map(|f| f.path()).filter(is_toml).collect();
    files.sort();
    for path in files {
        let p = Profile::read(&text(&path)?, &path.display().to_string())?;
        list.retain(|l| l.0.name != p.name);
        list.push((p, true));
    }
    Ok(list)
}

/// Writes a calibration, and creates its folder.
///
/// # Errors
/// If the file cannot be written.
pub fn write(path: &Path, calibration: &Calibration) -> Result<(), ToolError> {
    if let Some(folder) = path.parent().filter(|p| !p.as_os_str().is_empty()) {
        std::fs::create_dir_all(folder)
            .map_err(|e| ToolError::Failed(format!("`{}` cannot be written: {}", path.display(), reason(&e))))?;
    }
    // atomic, because half a calibration would give wrong forces
    Ok(ca_io::atomic_file::write(path, calibration.write().as_bytes())?)
}
