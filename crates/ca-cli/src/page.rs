//! HTML pages: checks their path before the work, and writes them at its end.

use crate::load::has_extension;
use crate::outcome::Failure;
use std::path::Path;

/// Refuses a path for a page without the extension `.html`, or in a missing folder.
pub fn is_page(path: &Path) -> Result<(), Failure> {
    // a device such as /dev/null does not need an extension
    let plain = !path.exists() || path.is_file();
    if plain && !has_extension(path, "html") {
        let what = format!("`{}`: the page is written as HTML", path.display());
        return Err(Failure::Usage(format!("{what}; give the file the extension `.html`")));
    }
    let folder = path.parent().filter(|f| !f.as_os_str().is_empty());
    if folder.is_some_and(|f| !f.is_dir()) {
        let what = format!("`{}` cannot be written: no such directory", path.display());
        return Err(Failure::Failed(format!("{what}; make the directory first")));
    }
    Ok(())
}

/// Writes a page.
pub fn write(path: &Path, page: &str) -> Result<(), Failure> {
    Ok(ca_io::atomic_file::write(path, page.as_bytes())?)
}
