//! Where profiles and calibrations of a user lie: `$CA_CONFIG`, else `~/.config/ca`.
//!
//! Decides that a word that names a file is that file; else a profile of the user's, else one that comes with us; and
//! that a calibration is found by the name of its device, because it belongs to hardware and not to a model.

use crate::outcome::Failure;
use crate::{load, term};
use ca_haptic::calibration::Calibration;
use ca_haptic::profile::{Profile, SHIPPED};
use ca_model::suggest::nearest;
use std::path::PathBuf;

/// The directory.
pub fn dir() -> PathBuf {
    let set = |name: &str| std::env::var_os(name).filter(|v| !v.is_empty()).map(PathBuf::from);
    set("CA_CONFIG")
        .or_else(|| set("XDG_CONFIG_HOME").map(|d| d.join("ca")))
        .or_else(|| set("HOME").map(|d| d.join(".config/ca")))
        .unwrap_or_else(|| PathBuf::from(".ca"))
}

/// Where the calibration of a device lies.
pub fn calibration_file(device: &str) -> PathBuf {
    dir().join("calibration").join(format!("{device}.toml"))
}

/// The file of a profile that is not shipped.
pub fn profile_file(word: &str) -> Option<PathBuf> {
    let own = dir().join("profiles").join(format!("{word}.toml"));
    [PathBuf::from(word), own].into_iter().find(|path| path.is_file())
}

/// A profile by file or name.
pub fn profile(word: &str) -> Result<Profile, Failure> {
    if let Some(path) = profile_file(word) {
        return Ok(Profile::read(&load::text(&path)?, &path.display().to_string())?);
    }
    Profile::shipped(word).ok_or_else(|| {
        let hint = match nearest(word, SHIPPED.iter().map(|s| s.0)) {
            Some(m) => format!("did you mean `{m}`?"),
            None => format!("there is {}, or a file of yours", load::ticked(SHIPPED.iter().map(|s| s.0))),
        };
        Failure::Usage(format!("no profile `{word}`; {hint}"))
    })
}

/// The profile of a device: the one given for it, else one of its own name, else `unknown`.
pub fn profile_of(device: &str, given: &[String]) -> Result<Profile, Failure> {
    let named = given.iter().find_map(|g| g.split_once('=').filter(|(d, _)| *d == device).map(|(_, p)| p));
    let plain = given.iter().find(|g| !g.contains('=')).map(String::as_str);
    if let Some(word) = named.or(plain) {
        return profile(word);
    }
    // one that is there and cannot be read is an error, not another device
    match profile(device) {
        Err(Failure::Usage(_)) => {}
        found => return found,
    }
    let p = profile("unknown")?;
    term::warning(&format!(
        "nobody has described the device `{device}`: degrees of freedom as it says itself, at most {} N; \
         say what it is with `--profile {device}=NAME`",
        p.force
    ));
    Ok(p)
}

/// The calibration of a device: the file given for it, else the user's, else none.
pub fn calibration_of(device: &str, given: &[String]) -> Result<Calibration, Failure> {
    let named = given.iter().find_map(|g| g.split_once('=').filter(|(d, _)| *d == device).map(|(_, p)| p.into()));
    let path: PathBuf = match named {
        Some(path) => path,
        None if calibration_file(device).is_file() => calibration_file(device),
        None => return Ok(Calibration::default()),
    };
    let read = Calibration::read(&load::text(&path)?, &path.display().to_string())?;
    // a file of no device is of any
    if !read.device.is_empty() && read.device != device {
        return Err(Failure::Failed(format!(
            "{}: this is the calibration of `{}`, not of `{device}`: positions and forces would be wrong by its factors; \
             give the one of `{device}`, or make it with `ca device calibrate`",
            path.display(),
            read.device
        )));
    }
    Ok(read)
}
