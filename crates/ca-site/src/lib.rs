//! Instruments as web pages that need no server.
//!
//! [`one_file`] puts an instrument into one HTML file with the engine inside. [`site`] writes a folder for any web
//! server: a gallery of the bundled instruments, the page that plays them, and a package for other pages. All use
//! the page of `ca play` ([`ca_play::PAGE`]), with the engine of `ca-web` in place of a server.
#![forbid(unsafe_code)]

mod gallery;
mod one_file;
mod picture;
mod site;

pub use one_file::one_file;
pub use site::site;

/// The WebAssembly modules of `ca-web`.
#[derive(Clone, Copy)]
pub struct WebModules {
    /// Engine.
    pub engine: &'static [u8],
    /// Compiler.
    pub compiler: &'static [u8],
}

/// Returns the modules inside this program, if it was built with them (`tools/site`).
pub fn modules() -> Option<WebModules> {
    #[cfg(engine)]
    let found = Some(WebModules {
        engine: include_bytes!(env!("CA_WEB_ENGINE_FILE")),
        compiler: include_bytes!(env!("CA_WEB_COMPILER_FILE")),
    });
    #[cfg(not(engine))]
    let found = None;
    found
}

/// The page with its first lines changed for an engine in the browser.
fn page(head: &str, script: &str) -> String {
    ca_play::PAGE
        .replace("<html lang=\"en\"", "<html lang=\"en\" data-engine=\"browser\"")
        .replace("<link rel=\"stylesheet\" href=\"page.css\">\n", head)
        .replace("<script type=\"module\" src=\"main.js\"></script>\n", script)
}
