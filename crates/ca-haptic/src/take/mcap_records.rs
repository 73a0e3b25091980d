//! Reads the records of an MCAP file one by one and checks them before the library does.
//!
//! mcap 0.26 does not check these lengths. Its parser slices an attachment without its CRC out of range, and its reader
//! subtracts the length of a record from the rest of an uncompressed chunk; both panic on a corrupt file. Its parser
//! also allocates a text by its stated length, which may be 4 GB in a file of 69 bytes.

use mcap::McapError;
use mcap::records::op;
use std::io::{self, BufRead, Read};

/// Bytes before the body of a record: its kind and the length of the body.
const HEAD: usize = 1 + 8;

/// Reads the next record into `to`, as far as the file goes; of one longer than `most` only the header, to be refused.
pub fn next(file: &mut impl BufRead, most: u64, to: &mut Vec<u8>) -> io::Result<()> {
    to.clear();
    file.by_ref().take(HEAD as u64).read_to_end(to)?;
    match number(to, 1) {
        Some(length) if length <= most => file.take(length).read_to_end(to).map(|_| ()),
        _ => Ok(()),
    }
}

/// Returns kind and body of the record that [`next`] read; `None` where the file ends within it.
pub fn record(bytes: &[u8]) -> Option<(u8, &[u8])> {
    let (head, body) = bytes.split_at_checked(HEAD)?;
    (number(head, 1)? == body.len() as u64).then_some((head[0], body))
}

/// Refuses records that would make the library panic, and texts longer than their record.
pub fn check(kind: u8, body: &[u8]) -> Result<(), McapError> {
    match kind {
        op::ATTACHMENT => attachment(body),
        op::CHUNK => chunk(body),
        _ => texts(kind, body),
    }
}

enum Part {
    /// This many bytes.
    Bytes(usize),
    /// A text or other bytes, after their length.
    Text,
    /// Pairs of texts, after their total length.
    Pairs,
}

/// Returns the parts of a record up to its last text.
fn parts(kind: u8) -> &'static [Part] {
    use Part::{Bytes, Pairs, Text};
    match kind {
        op::HEADER => &[Text, Text],
        op::SCHEMA => &[Bytes(2), Text, Text, Text],
        op::CHANNEL => &[Bytes(4), Text, Text, Pairs],
        op::CHUNK_INDEX => &[Bytes(32), Text, Bytes(8), Text],
        op::ATTACHMENT_INDEX => &[Bytes(40), Text, Text],
        op::METADATA => &[Text, Pairs],
        op::METADATA_INDEX => &[Bytes(16), Text],
        _ => &[],
    }
}

fn texts(kind: u8, body: &[u8]) -> Result<(), McapError> {
    let after = |at: usize| Some(at + 4 + length(body, at)?).filter(|end| *end <= body.len());
    let read = |at: usize, part: &Part| match part {
        Part::Bytes(n) => Some(at + n),
        Part::Text => after(at),
        Part::Pairs => {
            let (mut at, end) = (at + 4, after(at)?);
            while at < end {
                at = after(after(at)?)?;
            }
            Some(at)
        }
    };
    let all = parts(kind).iter().try_fold(0, read);
    all.map(drop).ok_or(McapError::RecordTooLarge { opcode: kind, len: body.len() as u64 })
}

/// Checks an attachment: times, two texts and the data with their lengths, and a CRC of 4 bytes.
fn attachment(body: &[u8]) -> Result<(), McapError> {
    let short = |header| McapError::BadAttachmentLength { header, available: body.len() as u64 };
    let mut at = 16;
    for _ in 0..2 {
        at += 4 + length(body, at).ok_or(short(at as u64 + 4))?;
    }
    let needed = at as u64 + 8 + 4;
    let needed = needed.saturating_add(number(body, at).ok_or(short(needed))?);
    if needed > body.len() as u64 { Err(short(needed)) } else { Ok(()) }
}

/// Checks that the records of an uncompressed chunk end where it ends.
fn chunk(body: &[u8]) -> Result<(), McapError> {
    const COMPRESSION: usize = 28;
    if length(body, COMPRESSION) != Some(0) {
        return Ok(());
    }
    let Some(records) = number(body, COMPRESSION + 4) else { return Err(McapError::UnexpectedEoc) };
    let rest = body.get(COMPRESSION + 12..).unwrap_or(&[]);
    let mut rest = rest.get(..usize::try_from(records).unwrap_or(usize::MAX)).ok_or(McapError::UnexpectedEoc)?;
    while !rest.is_empty() {
        let body = number(rest, 1).and_then(|n| usize::try_from(n).ok()).and_then(|n| n.checked_add(HEAD));
        rest = body.and_then(|n| rest.get(n..)).ok_or(McapError::UnexpectedEoc)?;
    }
    Ok(())
}

fn number(of: &[u8], at: usize) -> Option<u64> {
    of.get(at..)?.first_chunk().map(|b| u64::from_le_bytes(*b))
}

fn length(of: &[u8], at: usize) -> Option<usize> {
    of.get(at..)?.first_chunk().map(|b| u32::from_le_bytes(*b) as usize)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns a valid record with an empty text in each place, and the places of their lengths.
    fn record(kind: u8) -> (Vec<u8>, Vec<usize>) {
        let (mut body, mut at) = (Vec::new(), Vec::new());
        for part in parts(kind) {
            match part {
                Part::Bytes(n) => body.resize(body.len() + n, 0),
                Part::Text => {
                    at.push(body.len());
                    body.extend([0; 4]);
                }
                Part::Pairs => {
                    body.extend(8_u32.to_le_bytes());
                    at.extend([body.len() - 4, body.len(), body.len() + 4]);
                    body.extend([0; 8]);
                }
            }
        }
        (body, at)
    }

    #[test]
    fn no_text_is_longer_than_its_record() {
        let kinds = [op::HEADER, op::SCHEMA, op::CHANNEL, op::CHUNK_INDEX, op::ATTACHMENT_INDEX, op::METADATA];
        for kind in kinds.into_iter().chain([op::METADATA_INDEX]) {
            let (body, texts) = record(kind);
            assert!(check(kind, &body).is_ok() && !texts.is_empty(), "{kind:#x}");
            for at in texts {
                for length in [body.len() as u32, 0xe100_0000, u32::MAX] {
                    let mut wrong = body.clone();
                    wrong[at..at + 4].copy_from_slice(&length.to_le_bytes());
                    assert!(check(kind, &wrong).is_err(), "{kind:#x}, byte {at}: {length}");
                }
            }
            assert!(check(kind, &body[..body.len() - 1]).is_err(), "{kind:#x}, cut");
        }
    }
}
