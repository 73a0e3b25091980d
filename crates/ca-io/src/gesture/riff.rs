//! RIFF: the two chunks of a WAV file that are read, whatever stands around them.
//!
//! Decides to find them before `hound` reads the file. It takes the byte that fills up a chunk of odd size for the beginning of the next
//! one, and the length of a file that was written to a pipe, which is left open, for more than there is. It knows no floats of 64 bits
//! either, which is how SciPy writes an array of NumPy.

/// The chunks of a file.
pub(super) struct Chunks<'b> {
    format: &'b [u8],
    /// samples, as far as they are there
    pub data: &'b [u8],
    /// bytes of samples, as the file says
    announced: u32,
}

/// How floats of 64 bits are stored.
pub(super) struct Doubles {
    /// \[Hz\]
    pub rate: u32,
    pub channels: u16,
}

impl Chunks<'_> {
    /// Those of a file; `None` where it is no WAV file, or lacks one of them.
    pub fn find(bytes: &[u8]) -> Option<Chunks<'_>> {
        let mut rest = bytes.strip_prefix(b"RIFF")?.get(4..)?.strip_prefix(b"WAVE")?;
        let mut format = None;
        loop {
            let (head, body) = rest.split_at_checked(8)?;
            let announced = number(head, 4, 4)?;
            let n = usize::try_from(announced).ok()?;
            if head.starts_with(b"data") {
                let mut found = Chunks { format: format?, data: &body[..n.min(body.len())], announced };
                if announced == u32::MAX {
                    let frame = found.number(12, 2).unwrap_or(1).max(1) as usize;
                    found.data = &body[..body.len() - body.len() % frame];
                    found.announced = u32::try_from(found.data.len()).ok()?;
                }
                return Some(found);
            }
            if head.starts_with(b"fmt ") {
                format = Some(body.get(..n)?);
            }
            rest = body.get(n.checked_add(n % 2)?..)?;
        }
    }

    /// A number of the format.
    fn number(&self, at: usize, bytes: usize) -> Option<u32> {
        number(self.format, at, bytes)
    }

    /// What stands before the samples in a file that holds nothing else.
    pub fn header(&self) -> Vec<u8> {
        let mut all = b"RIFF".to_vec();
        let length = |n: usize| u32::try_from(n).unwrap_or(u32::MAX).to_le_bytes();
        all.extend(length(20 + self.format.len() + self.announced as usize));
        all.extend(b"WAVEfmt ");
        all.extend(length(self.format.len()));
        all.extend(self.format);
        all.extend(b"data");
        all.extend(self.announced.to_le_bytes());
        all
    }

    /// True where the file ends before its samples do.
    pub fn is_cut(&self) -> bool {
        self.data.len() < self.announced as usize
    }

    /// How its samples are stored, if they are floats of 64 bits.
    pub fn doubles(&self) -> Option<Doubles> {
        const FLOATS: u32 = 3;
        const EXTENSIBLE: u32 = 0xfffe;
        let mut kind = self.number(0, 2)?;
        if kind == EXTENSIBLE {
            kind = self.number(24, 2)?;
        }
        let is_so = kind == FLOATS && self.number(14, 2)? == 64;
        let channels = u16::try_from(self.number(2, 2)?).ok().filter(|n| *n > 0 && is_so)?;
        Some(Doubles { rate: self.number(4, 4)?, channels })
    }
}

/// A number of so many bytes, the least first.
fn number(of: &[u8], at: usize, bytes: usize) -> Option<u32> {
    let all = of.get(at..at.checked_add(bytes)?)?;
    Some(all.iter().rev().fold(0, |n, b| n << 8 | u32::from(*b)))
}
