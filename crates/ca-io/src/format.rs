//! Sample formats of sound files, by type and width.

/// Format in which a sample is stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// 32-bit floats.
    F32,
    /// 24-bit integers.
    I24,
    /// 16-bit integers.
    I16,
}

impl Format {
    /// Returns the width of a sample \[bits\].
    pub fn bits(self) -> u16 {
        match self {
            Format::F32 => 32,
            Format::I24 => 24,
            Format::I16 => 16,
        }
    }
}
