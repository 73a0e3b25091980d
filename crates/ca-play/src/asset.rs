//! Files of the page.
//!
//! They are compiled into the program. So the server cannot expose any file on disk, and page and server always have
//! the same version.

pub(crate) struct Asset {
    pub(crate) name: &'static str,
    pub(crate) kind: &'static str,
    pub(crate) bytes: &'static [u8],
}

macro_rules! assets {
    ($($name:literal $kind:literal),* $(,)?) => {
        &[$(Asset { name: $name, kind: $kind, bytes: include_bytes!(concat!("../page/", $name)) }),*]
    };
}

const ASSETS: &[Asset] = assets![
    "index.html" "text/html; charset=utf-8",
    "browser/accuracy.js" "text/javascript; charset=utf-8",
    "browser/compiler-worker.js" "text/javascript; charset=utf-8",
    "browser/compiler.js" "text/javascript; charset=utf-8",
    "browser/connection.js" "text/javascript; charset=utf-8",
    "browser/model.js" "text/javascript; charset=utf-8",
    "browser/modes.js" "text/javascript; charset=utf-8",
    "browser/parts.js" "text/javascript; charset=utf-8",
    "browser/sound.js" "text/javascript; charset=utf-8",
    "browser/table.js" "text/javascript; charset=utf-8",
    "browser/text.js" "text/javascript; charset=utf-8",
    "browser/wasm.js" "text/javascript; charset=utf-8",
    "browser/worklet.js" "text/javascript; charset=utf-8",
    "picture/camera.js" "text/javascript; charset=utf-8",
    "picture/colour.js" "text/javascript; charset=utf-8",
    "controls.js" "text/javascript; charset=utf-8",
    "energy.js" "text/javascript; charset=utf-8",
    "picture/film.js" "text/javascript; charset=utf-8",
    "gamepad.js" "text/javascript; charset=utf-8",
    "picture/gl.js" "text/javascript; charset=utf-8",
    "keyboard.js" "text/javascript; charset=utf-8",
    "main.js" "text/javascript; charset=utf-8",
    "messages.js" "text/javascript; charset=utf-8",
    "meters.js" "text/javascript; charset=utf-8",
    "motion.js" "text/javascript; charset=utf-8",
    "page.css" "text/css; charset=utf-8",
    "pointer.js" "text/javascript; charset=utf-8",
    "presets.js" "text/javascript; charset=utf-8",
    "picture/scene.js" "text/javascript; charset=utf-8",
    "picture/shaders.js" "text/javascript; charset=utf-8",
    "socket.js" "text/javascript; charset=utf-8",
    "share.js" "text/javascript; charset=utf-8",
    "sound.js" "text/javascript; charset=utf-8",
    "status.js" "text/javascript; charset=utf-8",
    "units.js" "text/javascript; charset=utf-8",
    "view.js" "text/javascript; charset=utf-8",
    "worklet.js" "text/javascript; charset=utf-8",
];

/// The page, as HTML that refers to its style and its script.
pub const PAGE: &str = include_str!("../page/index.html");

/// The style of the page.
pub const STYLE: &str = include_str!("../page/page.css");

/// Returns the text of a file of the page; empty if there is none.
pub fn module(name: &str) -> &'static str {
    find(name).and_then(|a| std::str::from_utf8(a.bytes).ok()).unwrap_or_default()
}

/// Returns the file with this name; an empty name means the page itself.
pub(crate) fn find(name: &str) -> Option<&'static Asset> {
    let name = if name.is_empty() { "index.html" } else { name };
    ASSETS.iter().find(|a| a.name == name)
}
