//! Tests the package from Python: its tests, doctests and types.
//!
//! One test runs everything in `python/` in a separate environment on Unix, because the crate is only usable from
//! Python. It is skipped without Python or a package index.

#![cfg(unix)]

#[path = "../../../tests/src/long_form.rs"]
mod long_form;
#[path = "../../../tests/src/skipped.rs"]
mod skipped;

use long_form::long_form;
use skipped::skipped;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").canonicalize().expect("the workspace")
}

/// The interpreter with all packages, if available.
#[track_caller]
fn python() -> Option<PathBuf> {
    let made =
        Command::new("bash").arg(root().join("tests/python/venv")).stderr(Stdio::piped()).output().expect("bash");
    if !made.status.success() {
        skipped("python", &format!("no Python with packages: {}", String::from_utf8_lossy(&made.stderr)));
        return None;
    }
    Some(PathBuf::from(String::from_utf8(made.stdout).expect("a path in UTF-8").trim()))
}

/// Copies the package with its folders.
fn copy(from: &Path, to: &Path) {
    std::fs::create_dir(to).expect("a folder");
    for file in std::fs::read_dir(from).expect("a folder of the package").flatten() {
        let (file, to) = (file.path(), to.join(file.file_name()));
        if file.is_dir() {
            copy(&file, &to);
        } else if file.extension().is_some_and(|e| e == "py" || e == "pyi" || e == "typed") {
            std::fs::copy(file, to).expect("a copy");
        }
    }
}

/// `tests/run` recognises it by its name.
#[test]
fn everything_in_python() {
    let Some(python) = python() else { return };
    // these tests read `CA_LONG` themselves
    long_form("the notebook that trains, others a second time, most tasks of sweeps, most calls of a render");
    let exe = std::env::current_exe().expect("this test");
    let deps = exe.parent().expect("its folder");
    let built = [deps.join("lib_core.so"), deps.join("../lib_core.so"), deps.join("lib_core.dylib")];
    let built = built.iter().find(|p| p.exists()).expect("the compiled half");
    let folder = tempfile::tempdir().expect("a folder");
    let package = folder.path().join("cordis_anima");
    copy(&root().join("crates/ca-py/python/cordis_anima"), &package);
    // linked, because it is large with debug information
    std::os::unix::fs::symlink(built, package.join("_core.abi3.so")).expect("a link");
    let command = deps.join("../ca");
    assert!(command.exists(), "`cargo test --workspace` builds the command, which the package is compared with");
    let run = Command::new(python)
        .args(["-m", "pytest", "-q", "-p", "no:cacheprovider", "--doctest-modules"])
        .arg(&package)
        .arg(root().join("crates/ca-py/tests/python"))
        .current_dir(folder.path())
        .env("PYTHONPATH", folder.path())
        .env("PYTHONDONTWRITEBYTECODE", "1")
        .env("CA_COMMAND", command)
        .env("CA_ROOT", root())
        .output()
        .expect("Python runs");
    let reported = String::from_utf8_lossy(&run.stdout);
    println!("{reported}{}", String::from_utf8_lossy(&run.stderr));
    assert!(run.status.success(), "{reported}");
    assert!(reported.contains(" passed"), "{reported}");
}
