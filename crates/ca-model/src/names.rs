//! Names by their hash: whether all differ, without a tree of them.

use alloc::vec::Vec;

/// FNV-1a of a name.
pub fn hash(name: &str) -> u64 {
    name.bytes().fold(0xcbf2_9ce4_8422_2325, |h, b| (h ^ u64::from(b)).wrapping_mul(0x0100_0000_01b3))
}

/// True where no name is there twice. Two names of one hash make it false too: who then looks at them one by one finds none.
pub fn all_differ<'n>(names: impl Iterator<Item = &'n str>) -> bool {
    let mut all: Vec<u64> = names.map(hash).collect();
    all.sort_unstable();
    all.windows(2).all(|pair| pair[0] != pair[1])
}
