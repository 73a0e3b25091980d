//! The token that addresses of OSC begin with, in a file that this user alone can read.
//!
//! Every user of this machine can send to a UDP port of it, and the sender of a packet is not known. A token in the address
//! works with every OSC controller, since all let people choose addresses. It lies in a file because other users see the
//! arguments of a command. The file is kept, so that the patch of a controller is set up once.

use ca_device_tools::store;
use ca_haptic::host::user::uid;
use ca_io::atomic_file;
use ca_lab::Failure;
use std::fs::File;
use std::io::{ErrorKind, Read as _};
use std::os::unix::fs::MetadataExt as _;
use std::path::{Path, PathBuf};

/// Shortest and longest token \[bytes\].
const LENGTHS: std::ops::RangeInclusive<usize> = 16..=128;

/// The token and its file.
pub(super) struct Token {
    text: String,
    pub(super) path: PathBuf,
}

impl Token {
    /// The token in a file, or in the one beside the user's profiles. A file that is not there is made if it is `needed`.
    ///
    /// # Errors
    /// If others can read the file, if it holds something else, or if it cannot be written.
    pub(super) fn open(path: Option<&Path>, needed: bool) -> Result<Option<Token>, Failure> {
        let path = path.map_or_else(|| store::dir().join("osc-token"), Path::to_owned);
        let failed = |what: String| Failure::Failed(format!("the token of OSC, `{}`: {what}", path.display()));
        if let Some(text) = read(&path).map_err(failed)? {
            return Ok(Some(Token { text, path }));
        }
        if !needed {
            return Ok(None);
        }
        let mut random = [0_u8; 16];
        getrandom::fill(&mut random).map_err(|e| failed(e.to_string()))?;
        // a letter first: Pure Data would read some tokens as numbers
        let text = random.iter().fold(String::from("t"), |s, b| s + &format!("{b:02x}"));
        if let Some(folder) = path.parent() {
            std::fs::create_dir_all(folder).map_err(|e| failed(e.to_string()))?;
        }
        if let Err(e) = atomic_file::write_new_private(&path, format!("{text}\n").as_bytes()) {
            // another process may have been faster
            return match read(&path).map_err(failed)? {
                Some(text) => Ok(Some(Token { text, path })),
                None => Err(e.into()),
            };
        }
        Ok(Some(Token { text, path }))
    }

    /// The rest of an address behind the token; `None` if the address does not begin with it.
    pub(super) fn strip<'a>(&self, address: &'a str) -> Option<&'a str> {
        let (given, rest) = address.strip_prefix('/')?.split_once('/')?;
        let (given, text) = (given.as_bytes(), self.text.as_bytes());
        // how long this takes says nothing of the token
        let differs = given.iter().zip(text).fold(0, |all, (a, b)| all | (a ^ b));
        (given.len() == text.len() && differs == 0).then(|| &address[address.len() - rest.len() - 1..])
    }
}

/// The token in a file; `None` if the file is not there.
fn read(path: &Path) -> Result<Option<String>, String> {
    // a FIFO would be waited for
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
        return Err("other users can read or change it; remove it, or close it: `chmod 600`".into());
    }
    let mut text = String::new();
    file.take(4096).read_to_string(&mut text).map_err(|e| e.to_string())?;
    let token = text.trim();
    let plain = token.bytes().all(|b| b.is_ascii_alphanumeric() || matches!(b, b'_' | b'-'));
    if !LENGTHS.contains(&token.len()) || !plain {
        let [least, most] = [LENGTHS.start(), LENGTHS.end()];
        return Err(format!("a token has {least} to {most} of a-z A-Z 0-9 _ -; remove it, and a new one is made"));
    }
    Ok(Some(token.to_owned()))
}
