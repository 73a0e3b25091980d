//! Pictures and sound, as bytes: little-endian, first the kind.

/// The beginning of a picture: kind 1, generation of the scene, tick; behind it come displacements \[m\], f32, one for each
/// drawn mass on a line and three for one in space.
pub fn view(out: &mut Vec<u8>, generation: u32, tick: f64) {
    out.clear();
    out.extend_from_slice(&1_u32.to_le_bytes());
    out.extend_from_slice(&generation.to_le_bytes());
    out.extend_from_slice(&tick.to_le_bytes());
}

/// Sound: kind 2, channels, tick of the first sample, samples as f32, interleaved.
pub fn sound(out: &mut Vec<u8>, channels: u32, tick: f64, samples: &[f64]) {
    out.clear();
    out.extend_from_slice(&2_u32.to_le_bytes());
    out.extend_from_slice(&channels.to_le_bytes());
    out.extend_from_slice(&tick.to_le_bytes());
    out.extend(samples.iter().flat_map(|x| (*x as f32).to_le_bytes()));
}
