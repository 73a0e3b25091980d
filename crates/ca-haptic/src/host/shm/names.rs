//! Builds and parses the names of shared memory.
//!
//! A name begins with a prefix, e.g. `ca1-0.10.0-1a2b3c4d_`. The prefix holds the version of the frames, the release of
//! iceoryx2 and the digits of a site, which [`prefix`](super::prefix) claims.

use crate::frame::VERSION;

pub(in crate::host) const SHM: &str = "/dev/shm";
/// Release of iceoryx2 that this build uses.
pub(in crate::host) const IOX: &str = "0.10.0";

/// Returns the part of the prefix before the digits of the folder: the versions.
pub(in crate::host) fn stamp() -> String {
    format!("ca{VERSION}-{IOX}-")
}

pub(in crate::host) fn prefix(digits: &str) -> String {
    format!("{}{digits}_", stamp())
}

pub(super) fn is_hash(text: &str) -> bool {
    text.len() == 8 && text.bytes().all(|b| b.is_ascii_hexdigit())
}

/// Parses the name of a file: version of the frames, release of iceoryx2 and digits of the folder.
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
