//! FNV-1a hash of words of eight bytes, lowest byte first.
//!
//! Zero bytes only multiply the hash, so they are skipped in one product. Most words of a scene at load hold several,
//! since masses are at rest and indices are small. The result is the same as hashing every byte.

use core::hash::Hasher as _;
use fnv::FnvHasher;

/// Powers 0 to 8 of the FNV prime.
const POWERS: [u64; 9] = {
    let mut all = [1_u64; 9];
    let mut i = 1;
    while i < 9 {
        all[i] = all[i - 1].wrapping_mul(0x0100_0000_01b3);
        i += 1;
    }
    all
};

pub(crate) fn word(h: &mut FnvHasher, v: u64) {
    let zeros = |n: u32| (n / 8).min(8) as usize;
    let skip = |h: &FnvHasher, n: usize| {
        FnvHasher::with_key(h.finish().wrapping_mul(POWERS.get(n).copied().unwrap_or_default()))
    };
    let (low, high) = (zeros(v.trailing_zeros()), zeros(v.leading_zeros()));
    *h = skip(h, low);
    if low < 8 {
        let bytes = v.to_le_bytes();
        h.write(bytes.get(low..8 - high).unwrap_or_default());
        *h = skip(h, high);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_word_is_hashed_as_its_bytes() {
        let words = [0, 1, 0xff00, u64::MAX, 1 << 63, 2.0_f64.to_bits(), 0.1_f64.to_bits(), 0x0001_0000_ff00_0000];
        let (mut ours, mut plain) = (FnvHasher::default(), FnvHasher::default());
        for v in words {
            word(&mut ours, v);
            plain.write(&v.to_le_bytes());
            assert_eq!(ours.finish(), plain.finish(), "{v:x}");
        }
    }
}
