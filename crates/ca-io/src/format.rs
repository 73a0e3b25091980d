//! The formats of the samples of a sound file, by their type and width.

/// The formats in which a sample is stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// 32-bit floats
    F32,
    /// 24-bit integers
    I24,
    /// 16-bit integers
    I16,
}

impl Format {
    /// Width of a sample \[bits\].
    pub fn bits(self) -> u16 {
        match self {
            Format::F32 => 32,
            Format::I24 => 24,
            Format::I16 => 16,
        }
    }
}
