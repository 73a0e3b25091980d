//! Instruments as web pages that need no server.
//!
//! [`one_file`] puts an instrument into one HTML file with the engine inside. [`site`] writes a folder for any web
//! server: a gallery of the bundled instruments, the page that plays them, the documents, and a package for other pages.
//! The instruments use the page of `ca play` ([`ca_play::PAGE`]), with the engine of `ca-web` in place of a server.
#![forbid(unsafe_code)]

mod documents;
mod gallery;
mod one_file;
mod picture;
mod share;
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
    /// Measurement of accuracy.
    pub accuracy: &'static [u8],
}

/// Returns the modules inside this program, if it was built with them (`tools/site`).
pub fn modules() -> Option<WebModules> {
    #[cfg(engine)]
    let found = Some(WebModules {
        engine: include_bytes!(env!("CA_WEB_ENGINE_FILE")),
        compiler: include_bytes!(env!("CA_WEB_COMPILER_FILE")),
        accuracy: include_bytes!(env!("CA_WEB_ACCURACY_FILE")),
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

#[cfg(test)]
mod tests {
    use super::*;

    /// The page of `ca play` has the lines that a page without a server changes, and the documents have its limits.
    #[test]
    fn pages_without_a_server_follow_the_page_of_the_program() {
        let page =
            one_file("# a </script>", "a.ca.toml", "", WebModules { engine: b"e", compiler: b"c", accuracy: b"a" });
        assert!(page.contains("data-engine=\"browser\"") && page.contains("<style>") && page.contains("caParts"));
        for gone in ["href=\"page.css\"", "src=\"main.js\"", "# a </script>"] {
            assert!(!page.contains(gone), "{gone}");
        }
        let words = include_str!("../../../docs/web.md").split_whitespace().collect::<Vec<_>>().join(" ");
        for (file, code, word) in [
            ("browser/model.js", "LONGEST = 300000, MODULES = 20000", "300 kB and its model at most 20 000 modules"),
            ("browser/compiler.js", "LONGEST = 20000;", "stopped after 20 s"),
        ] {
            assert!(ca_play::module(file).contains(code), "{code}");
            assert!(words.contains(word), "{word}");
        }
    }
}
