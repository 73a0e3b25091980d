//! Header of the WAV files written here.
//!
//! The header begins with a chunk `JUNK`, which other programs skip. In a file beyond 4 GiB it becomes `ds64`, with
//! 64-bit sizes, and the file becomes `RF64`, as EBU Tech 3306 proposes. The format is extensible for more than two
//! channels or 16 bits. Floats have a `fact` chunk, which the format requires for all but integers. An unfinished file
//! has open sizes.

use crate::format::Format;

/// Size that is unknown or stored in `ds64`.
const OPEN: u32 = u32::MAX;
/// Bytes of `JUNK` and of `ds64`.
const SIZES: u32 = 28;
/// Distance of the body of `fact` from the end of the header.
const FACT_FROM_END: usize = 12;
/// End of the GUID of a format that also has a number.
const GUID: [u8; 14] = [0, 0, 0, 0, 0x10, 0, 0x80, 0, 0, 0xaa, 0, 0x38, 0x9b, 0x71];

/// Makes a header with open sizes. Its last four bytes are the size of the samples.
pub(crate) fn open(format: Format, rate: u32, channels: u16) -> Vec<u8> {
    let (kind, bits) = (if format == Format::F32 { 3_u16 } else { 1 }, format.bits());
    let extensible = channels > 2 || bits > 16;
    let frame = channels * (bits / 8);
    let mut out = Vec::with_capacity(128);
    out.extend(b"RIFF");
    out.extend(OPEN.to_le_bytes());
    out.extend(b"WAVEJUNK");
    out.extend(SIZES.to_le_bytes());
    out.extend([0; SIZES as usize]);
    out.extend(b"fmt ");
    out.extend(if extensible { 40_u32 } else { 16 }.to_le_bytes());
    out.extend(if extensible { 0xfffe } else { kind }.to_le_bytes());
    out.extend(channels.to_le_bytes());
    out.extend(rate.to_le_bytes());
    out.extend(rate.wrapping_mul(frame.into()).to_le_bytes());
    out.extend(frame.to_le_bytes());
    out.extend(bits.to_le_bytes());
    if extensible {
        out.extend(22_u16.to_le_bytes());
        out.extend(bits.to_le_bytes());
        // front centre, or front left and right; more channels are not assigned to loudspeakers
        out.extend(
            match channels {
                1 => 4_u32,
                2 => 3,
                _ => 0,
            }
            .to_le_bytes(),
        );
        out.extend(kind.to_le_bytes());
        out.extend(GUID);
    }
    if format == Format::F32 {
        out.extend(b"fact");
        out.extend(4_u32.to_le_bytes());
        out.extend(OPEN.to_le_bytes());
    }
    out.extend(b"data");
    out.extend(OPEN.to_le_bytes());
    out
}

/// Enters the sizes of `frames` frames and `data` bytes of samples into a header made by [`open`].
pub(crate) fn close(header: &mut [u8], format: Format, frames: u64, data: u64) {
    let whole = header.len() as u64 - 8 + data + data % 2;
    let end = header.len();
    let mut put = |at: usize, bytes: &[u8]| header[at..at + bytes.len()].copy_from_slice(bytes);
    let short = |n: u64| u32::try_from(n).unwrap_or(OPEN).to_le_bytes();
    let long = u32::try_from(whole).is_err();
    if long {
        put(0, b"RF64");
        put(12, b"ds64");
        put(20, &whole.to_le_bytes());
        put(28, &data.to_le_bytes());
        put(36, &frames.to_le_bytes());
    }
    put(4, &short(whole));
    put(end - 4, &if long { OPEN.to_le_bytes() } else { short(data) });
    if format == Format::F32 {
        put(end - FACT_FROM_END, &short(frames));
    }
}
