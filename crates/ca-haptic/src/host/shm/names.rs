//! The names of shared memory.
//!
//! A name begins with a prefix, e.g. `ca1-0.10.0-1a2b3c4d_`. The prefix holds the version of our frames, the release of iceoryx2
//! and the digits of a place, which [`prefix`](super::prefix) claims.

use crate::frame::VERSION;

/// The folder in which shared memory has its names.
pub(in crate::host) const SHM: &str = "/dev/shm";
/// Release of iceoryx2 this build speaks.
pub(in crate::host) const IOX: &str = "0.10.0";

/// The part of the prefix before the digits of the folder: the version.
pub(in crate::host) fn stamp() -> String {
    format!("ca{VERSION}-{IOX}-")
}

/// The prefix with these digits.
pub(in crate::host) fn prefix(digits: &str) -> String {
    format!("{}{digits}_", stamp())
}

/// True for the digits of a folder.
pub(super) fn is_hash(text: &str) -> bool {
    text.len() == 8 && text.bytes().all(|b| b.is_ascii_hexdigit())
}

/// Version of frames, release of iceoryx2 and digits of the folder, from the name of a file.
pub(in crate::host) fn parse(name: &str) -> Option<(&str, &str, &str)> {
    let (prefix, _) = name.strip_prefix("ca")?.split_once('_')?;
    let (rest, hash) = prefix.rsplit_once('-')?;
    let (frames, iox) = rest.split_once('-')?;
    let digits = |s: &str| !s.is_empty() && s.bytes().all(|b| b.is_ascii_digit() || b == b'.');
    (digits(frames) && digits(iox) && is_hash(hash)).then_some((frames, iox, hash))
}

#[cfg(test)]
mod tests {
    use super::parse;

    #[test]
    fn only_names_of_ours_are_read() {
        assert_eq!(parse("ca1-0.10.0-1a2b3c4d_abc.data"), Some(("1", "0.10.0", "1a2b3c4d")));
        assert_eq!(parse("ca12-0.9.3-00000000_"), Some(("12", "0.9.3", "00000000")));
        for other in
            ["iox2_abc.data", "ca1-0.10.0-1a2b3c4d", "cat-0.10.0-1a2b3c4d_", "ca1-x-1a2b3c4d_", "ca1-0.10.0-1a2b_x"]
        {
            assert_eq!(parse(other), None, "{other}");
        }
    }
}
