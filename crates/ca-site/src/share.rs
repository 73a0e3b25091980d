//! Links that carry a model, as the page makes them (`browser/model.js` of `ca-play`).

use base64::Engine as _;
use base64::engine::general_purpose::URL_SAFE_NO_PAD;
use flate2::Compression;
use flate2::write::DeflateEncoder;
use std::io::Write as _;

/// Returns the address of the page that plays a model, from the folder of the site.
pub(crate) fn link(text: &str) -> String {
    let mut out = DeflateEncoder::new(Vec::new(), Compression::best());
    // writing to memory does not fail
    let _ = out.write_all(text.as_bytes());
    format!("play.html#model={}", URL_SAFE_NO_PAD.encode(out.finish().unwrap_or_default()))
}
