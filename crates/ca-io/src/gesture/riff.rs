//! RIFF: finds the format and the samples of a WAV file among its chunks.
//!
//! Reads `RIFF` and, for files beyond 4 GiB, `RF64` and `BW64` (EBU Tech 3306, ITU-R BS.2088), whose chunk `ds64` holds
//! 64-bit sizes.
//!
//! A program that writes to a pipe cannot enter a size afterwards. `ffmpeg` leaves 0xffffffff, `sox` 0x7ffff000; others
//! leave the largest number of 31 or 32 bits, a neighbour of it, that number less the header, or 0. Such samples extend
//! to the end of the file. A size of 0 means this only if the size of the whole file is open too, so that a file
//! without samples stays empty.
//!
//! No library covers this. hound 3.5 knows neither `RF64` nor open sizes, pad bytes or 64-bit floats, and reads 24 bits
//! in 32 from the wrong end. symphonia 0.6 lacks `RF64`, bwavfile 2.0 64-bit floats.

const LARGEST: u64 = 0xffff_ffff;

/// Returns true for a size that means "to the end of the file".
fn is_open(size: u64) -> bool {
    (0x7fff_f000..=0x8000_0000).contains(&size) || (0xffff_f000..=LARGEST).contains(&size)
}
/// Tag of an extensible format, and offset of the tag of its samples.
const EXTENSIBLE: (u32, usize) = (0xfffe, 24);

pub(super) struct Chunks<'b> {
    pub format: Format,
    /// Samples, as far as the file contains them.
    pub data: &'b [u8],
    /// Bytes of samples according to the file.
    pub announced: u64,
}

#[derive(Clone, Copy)]
pub(super) struct Format {
    /// 1 for integers, 3 for floats.
    pub kind: u32,
    /// Sample rate \[Hz\].
    pub rate: u32,
    pub channels: usize,
    /// Bytes of a sample.
    pub bytes: usize,
    /// Significant bits of a sample.
    pub bits: u32,
}

impl Chunks<'_> {
    /// Finds the chunks, or returns a message about the missing one.
    pub fn find(bytes: &[u8]) -> Result<Chunks<'_>, &'static str> {
        let (tag, rest) = bytes.split_at_checked(4).ok_or("`RIFF` is missing at its beginning")?;
        let long = matches!(tag, b"RF64" | b"BW64");
        if !long && tag != b"RIFF" {
            return Err("`RIFF` is missing at its beginning");
        }
        let mut whole = number(rest, 0, 4).unwrap_or(0);
        let rest = rest.get(4..).and_then(|r| r.strip_prefix(b"WAVE"));
        let mut rest = rest.ok_or("`WAVE` is missing at its beginning")?;
        let (mut format, mut size64) = (None, None);
        loop {
            let (head, body) = rest.split_at_checked(8).ok_or("the chunk `data` is missing")?;
            let size = number(head, 4, 4).unwrap_or(0);
            let n = usize::try_from(size).unwrap_or(usize::MAX);
            match &head[..4] {
                b"data" => {
                    let format: Format = format.ok_or("the chunk `fmt ` is missing before its samples")?;
                    let announced = size64.filter(|_| long && size == LARGEST).unwrap_or(size);
                    let open = is_open(announced) && announced > body.len() as u64
                        || announced == 0 && [0, LARGEST, u64::MAX].contains(&whole);
                    let frame = (format.channels * format.bytes).max(1);
                    let announced = if open { (body.len() - body.len() % frame) as u64 } else { announced };
                    let here = usize::try_from(announced).unwrap_or(usize::MAX).min(body.len());
                    return Ok(Chunks { format, data: &body[..here], announced });
                }
                b"fmt " => {
                    format = Some(Format::read(body.get(..n).unwrap_or(body)).ok_or("the chunk `fmt ` is cut short")?);
                }
                b"ds64" if long => {
                    whole = number(body, 0, 8).unwrap_or(whole);
                    size64 = number(body, 8, 8);
                }
                _ => {}
            }
            let padded = n.checked_add(n % 2).ok_or("the chunk `data` is missing")?;
            rest = body.get(padded..).ok_or("the chunk `data` is missing")?;
        }
    }
}

impl Format {
    fn read(chunk: &[u8]) -> Option<Format> {
        let at = |at, bytes| Some(number(chunk, at, bytes)? as u32);
        let (mut kind, channels, frame, mut bits) = (at(0, 2)?, at(2, 2)?, at(12, 2)?, at(14, 2)?);
        if kind == EXTENSIBLE.0 {
            kind = at(EXTENSIBLE.1, 2)?;
            bits = at(18, 2).filter(|valid| *valid > 0).unwrap_or(bits);
        }
        let bytes = frame.checked_div(channels).unwrap_or(0) as usize;
        Some(Format { kind, rate: at(4, 4)?, channels: channels as usize, bytes, bits })
    }
}

/// Reads a little-endian number of `bytes` bytes.
fn number(of: &[u8], at: usize, bytes: usize) -> Option<u64> {
    let all = of.get(at..at.checked_add(bytes)?)?;
    Some(all.iter().rev().fold(0, |n, b| n << 8 | u64::from(*b)))
}
