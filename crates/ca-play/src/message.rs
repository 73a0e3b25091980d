//! What goes over the line between a page and its server.
//!
//! Decides on text for what is rare (JSON, an object with a `type`) and on bytes for what is not (little-endian, first a
//! kind). To the page:
//!
//! | text | what it has |
//! |---|---|
//! | `scene` | `generation`, `title`, `model`, `rate` \[Hz\], `frame` \[ticks\], `channels`, `drawing`, `params`, `ports`, `gesture`, `seconds`, `energy` (names), `stability` (words); once, and again when another scene is played |
//! | `state` | `tick`, `seconds`, `load` (share of real time), `late`, `lost`, `clipped`, `diverged`, `playing`, `pointer` (mass, or −1), `devices`, `params`, `clients`, `sound`, `latency` \[ms\], `underruns`, `recording` (a file, or none); a few times a second |
//! | `energy` | `seconds`, `motion` \[J\], one for each name: some twenty times a second |
//! | `said` | `bad`, `text`: news for people |
//! | `reply` | `id`, `ok`, `text` and what was asked: to each request with an `id` |
//!
//! and of bytes [`view`] and [`sound`]. From the page, all of it text: `sound` (`on`), `grab` (`mass`), `drag` (`by`
//! \[m\]), `release`, `set` (`values`), `gesture` (`play`), `port` (`name`, `value`), `pick` (`mass`), `arm` (`on`),
//! `record` (`on`), `save` and `stop`.

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
