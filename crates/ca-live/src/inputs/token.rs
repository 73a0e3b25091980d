//! Token at the beginning of OSC addresses, in a file that only this user can read.
//!
//! Every user of this machine can send to a UDP port, and the sender of a packet is unknown. A token in the address
//! works with every OSC controller, because all of them allow free choice of addresses. The token is in a file because
//! other users can see the arguments of a command. The file is kept, so that a controller is configured only once.

use ca_device_tools::store;
use ca_haptic::host::user::uid;
use ca_io::atomic_file;
use ca_lab::Failure;
use std::fs::File;
use std::io::{ErrorKind, Read as _};
use std::os::unix::fs::MetadataExt as _;
use std::path::{Path, PathBuf};

/// Allowed lengths of a token \[bytes\].
const LENGTHS: std::ops::RangeInclusive<usize> = 16..=128;

pub(super) struct Token {
    text: String,
    pub(super) path: PathBuf,
}

impl Token {
    /// Reads the token from `path`, or from the file beside the user's profiles. If the file is missing and the token
    /// is `needed`, creates it.
    ///
    /// # Errors
    /// Fails if other users can read the file, if it does not hold a token, or if it cannot be written.
    pub(super) fn open(path: Option<&Path>, needed: bool) -> Result<Option<Token>, Failure> {
        let path = path.map_or_else(|| store::dir().join("osc-token"), Path::to_owned);
        let failed = |what: String| Failure::Failed(format!("OSC token file `{}`: {what}", path.display()));
        if let Some(text) = read(&path).map_err(failed)? {
            return Ok(Some(Token { text, path }));
        }
        if !needed {
            return Ok(None);
        }
        let mut random = [0_u8; 16];
        getrandom::fill(&mut random).map_err(|e| failed(e.to_string()))?;
        // begins with a letter, because Pure Data would read some tokens as numbers
        let text = random.iter().fold(String::from("t"), |s, b| s + &format!("{b:02x}"));
        if let Some(folder) = path.parent() {
            std::fs::create_dir_all(folder).map_err(|e| failed(e.to_string()))?;
        }
        if let Err(e) = atomic_file::write_new_private(&path, format!("{text}\n").as_bytes()) {
            // another process may have created the file in the meantime
            return match read(&path).map_err(failed)? {
                Some(text) => Ok(Some(Token { text, path })),
                None => Err(e.into()),
            };
        }
        Ok(Some(Token { text, path }))
    }

    /// Returns the part of an address after the token, or `None` if the address does not begin with the token.
    pub(super) fn strip<'a>(&self, address: &'a str) -> Option<&'a str> {
        let (given, rest) = address.strip_prefix('/')?.split_once('/')?;
        let (given, text) = (given.as_bytes(), self.text.as_bytes());
        // constant time, so that the duration reveals nothing about the token
        let differs = given.iter().zip(text).fold(0, |all, (a, b)| all | (a ^ b));
        (given.len() == text.len() && differs == 0).then(|| &address[address.len() - rest.len() - 1..])
    }
}

/// Reads the token from a file. Returns `None` if the file does not exist.
fn read(path: &Path) -> Result<Option<String>, String> {
    // opening a FIFO would block
    let other = || "it is not a file".to_owned();
    let file = match std::fs::metadata(path).map(|about| about.is_file()) {
        Ok(true) => File::open(path).map_err(|e| e.to_string())?,
        Ok(false) => return Err(other()),
        Err(e) if e.kind() == ErrorKind::NotFound => return Ok(None),
        Err(e) => return Err(e.to_string()),
    };
    let about = file.metadata().map_err(|e| e.to_string())?;
    if !about.is_file() {
        return Err(other());
    }
    if about.uid() != uid() || about.mode() & 0o077 != 0 {
        let path = path.display();
        return Err(format!("other users can read or change it; run `chmod 600 {path}`, or delete it"));
    }
    let mut text = String::new();
    file.take(4096).read_to_string(&mut text).map_err(|e| e.to_string())?;
    let token = text.trim();
    let plain = token.bytes().all(|b| b.is_ascii_alphanumeric() || matches!(b, b'_' | b'-'));
    if !LENGTHS.contains(&token.len()) || !plain {
        let [least, most] = [LENGTHS.start(), LENGTHS.end()];
        let rule = format!("a token must have {least} to {most} characters from a-z A-Z 0-9 _ -");
        return Err(format!("{rule}; delete the file, and a new token is made"));
    }
    Ok(Some(token.to_owned()))
}
