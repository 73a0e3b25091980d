//! Checks that output files do not overwrite inputs or each other.
//!
//! Every command that writes calls this before it begins, because an overwritten file is lost. Files are compared by
//! identity, not by path, because links and path spellings give one file several names.

use crate::outcome::Failure;
use std::fs::Metadata;
use std::os::unix::fs::{FileTypeExt as _, MetadataExt as _};
use std::path::{Path, PathBuf};

/// Refuses to overwrite an input, or to write two outputs to one file. An output has its option; an input has a name
/// such as "the take".
pub fn check_distinct(outputs: &[(&str, &Path)], inputs: &[(&str, &Path)]) -> Result<(), Failure> {
    for (n, (option, path)) in outputs.iter().enumerate() {
        let shown = path.display();
        if let Some((what, _)) = inputs.iter().find(|(_, input)| input.exists() && same(path, input)) {
            let what = format!("`{shown}` is {what} and would be overwritten");
            return Err(Failure::Usage(format!("{what}; choose another file with `{option}`")));
        }
        if let Some((other, _)) = outputs.iter().take(n).find(|(_, other)| same(path, other)) {
            let by = if other == option { format!("by `{option}`") } else { format!("by `{other}` and `{option}`") };
            return Err(Failure::Usage(format!("`{shown}` would be written twice, {by}; choose two different files")));
        }
    }
    Ok(())
}

/// Returns true if two paths lead to the same file, which may not exist yet. Devices such as `/dev/null` never count as
/// the same.
fn same(a: &Path, b: &Path) -> bool {
    match (a.metadata(), b.metadata()) {
        (Ok(a), Ok(b)) => {
            let place = |m: &Metadata| (m.dev(), m.ino());
            !a.file_type().is_char_device() && place(&a) == place(&b)
        }
        (Err(_), Err(_)) => a == b || target(a).is_some_and(|a| target(b) == Some(a)),
        _ => false,
    }
}

/// Returns the path at which a missing file would be created.
fn target(path: &Path) -> Option<PathBuf> {
    let mut path = path.to_owned();
    // limit on symbolic links in Linux
    for _ in 0..40 {
        let folder = path.parent()?;
        let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
        let here = folder.canonicalize().ok()?.join(path.file_name()?);
        let Ok(to) = here.read_link() else { return Some(here) };
        path = here.with_file_name(to);
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;
    use std::os::unix::fs::symlink;

    #[test]
    fn one_file_has_many_names() {
        let dir = tempfile::tempdir().unwrap();
        let at = |name: &str| dir.path().join(name);
        fs::create_dir(at("sub")).unwrap();
        fs::write(at("there"), "").unwrap();
        fs::hard_link(at("there"), at("hard")).unwrap();
        symlink("there", at("soft")).unwrap();
        symlink("sub/../not", at("dangling")).unwrap();
        symlink("circle", at("circle")).unwrap();
        for (a, b) in [("there", "hard"), ("there", "soft"), ("sub/../there", "there")] {
            assert!(same(&at(a), &at(b)), "{a} {b}");
        }
        for (a, b) in [("not", "not"), ("not", "sub/../not"), ("not", "dangling")] {
            assert!(same(&at(a), &at(b)), "{a} {b}");
        }
        for (a, b) in [("there", "not"), ("not", "nor"), ("not", "sub/not"), ("not", "circle"), ("no/not", "not")] {
            assert!(!same(&at(a), &at(b)), "{a} {b}");
        }
        assert!(!same(Path::new("/dev/null"), Path::new("/dev/null")));
    }
}
