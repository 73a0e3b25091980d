//! Tests `ca_tests::skipped` and the script `tests/setup`, run with a fake package manager: missing programs are
//! reported, and installed where possible.
#![cfg(unix)]

use ca_tests::skipped::{INSTALLED, skipped};
use std::fs;
use std::os::unix::fs::{PermissionsExt as _, symlink};
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

const NEEDS: &str = "CA_TEST_NEEDS";

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

#[test]
#[ignore = "a part of the next test, which says what is missing"]
fn a_test_that_is_skipped() {
    let Ok(needs) = std::env::var(NEEDS) else { return };
    skipped(&needs, "for want\nof it");
}

/// Runs the test above as cargo does, with captured output. Returns exit, stdout and stderr, and the file.
fn run(needs: &str, ci: Option<&str>) -> (Output, String) {
    let dir = tempfile::tempdir().unwrap();
    let file = dir.path().join("skipped.txt");
    fs::write(&file, "another\tsince\n").unwrap();
    let mut c = Command::new(std::env::current_exe().unwrap());
    c.args(["--exact", "skipped::a_test_that_is_skipped", "--ignored"]).env(NEEDS, needs);
    c.env("CA_SKIPPED", &file).env_remove("CI").env_remove("RUST_TEST_THREADS");
    c.envs(ci.map(|ci| ("CI", ci)));
    (c.output().unwrap(), fs::read_to_string(&file).unwrap())
}

#[test]
fn a_skipped_test_is_listed_and_fails_where_it_must_not_be() {
    let line = "tests/suite/skipped.rs skipped::a_test_that_is_skipped\tfor want of it\n";
    for (needs, ci, passes) in [
        ("faust", None, true),
        ("faust", Some("false"), true),
        ("faust", Some("true"), false),
        ("chromium", Some("true"), false),
        ("published models", Some("true"), true),
    ] {
        let (out, listed) = run(needs, ci);
        let said = text(&out.stdout) + &text(&out.stderr);
        assert_eq!(out.status.success(), passes, "{needs} {ci:?}\n{said}");
        assert_eq!(listed, format!("another\tsince\n{line}"));
        assert!(text(&out.stderr).contains("skipped: tests/suite/skipped.rs"), "captured:\n{said}");
        assert!(passes || said.contains(&format!("for want of {needs}, which tests/setup installs")), "{said}");
    }
}

fn setup() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("setup")
}

#[test]
fn setup_knows_what_may_not_be_missing() {
    for name in INSTALLED {
        let code = Command::new(setup()).args(["has", name]).status().unwrap().code();
        assert!(matches!(code, Some(0 | 1)), "{name}: {code:?}");
    }
    assert_eq!(Command::new(setup()).args(["has", "piano"]).status().unwrap().code(), Some(2));
    let script = fs::read_to_string(setup()).unwrap();
    let table = script.split("\ntable=\"").nth(1).expect("the table").split('"').next().unwrap_or_default();
    let rows: Vec<&str> = table.lines().filter_map(|l| l.split('|').next()).collect();
    assert_eq!(rows, INSTALLED, "the table of tests/setup");
}

/// A folder with the few programs the script needs, an `id` that prints `user`, and an `apt-get` that has only Faust.
fn machine(user: &str, there: &[&str]) -> tempfile::TempDir {
    let dir = tempfile::tempdir().unwrap();
    let put = |name: &str, script: &str| {
        let path = dir.path().join(name);
        fs::write(&path, format!("#!/bin/sh\n{script}\n")).unwrap();
        fs::set_permissions(&path, fs::Permissions::from_mode(0o755)).unwrap();
    };
    for name in ["bash", "sh", "cp"] {
        let path = ["/bin", "/usr/bin"].map(|d| Path::new(d).join(name));
        symlink(path.iter().find(|p| p.exists()).expect(name), dir.path().join(name)).unwrap();
    }
    for name in there {
        put(name, "exit 0");
    }
    put("id", &format!("echo {user}"));
    let here = dir.path().display();
    put(
        "apt-get",
        &format!(
            "echo \"$*\" >>{here}/log\ncase \"$*\" in\nupdate*) ;;\n*' faust') cp {here}/id {here}/faust ;;\n\
             *) echo 'reading'; echo \"E: no such package\" >&2; exit 100 ;;\nesac"
        ),
    );
    dir
}

/// Runs the script on such a machine and returns its output and the calls of `apt-get`.
fn set_up(dir: &Path) -> (String, String) {
    let out = Command::new(setup()).env_clear().env("PATH", dir).output().unwrap();
    assert!(out.status.success(), "{}{}", text(&out.stdout), text(&out.stderr));
    assert_eq!(text(&out.stderr), "");
    (text(&out.stdout), fs::read_to_string(dir.join("log")).unwrap_or_default())
}

#[test]
fn setup_says_what_it_installs_and_what_it_could_not() {
    let dir = machine("0", &["jackd", "pulseaudio", "pkg-config", "g++"]);
    let (said, asked) = set_up(dir.path());
    let at = |words: &str| said.find(words).unwrap_or_else(|| panic!("no `{words}` in\n{said}"));
    // the purpose first, then the packages, then the result
    assert!(
        at("faust is not here; with it is tested: networks") < at("installing by apt-get: faust chromium valgrind"),
        "{said}"
    );
    assert!(at("installing by apt-get") < at("faust is installed"));
    assert!(at("installing by apt-get") < at("chromium could not be installed: E: no such package"));
    assert!(!said.contains("jackd") && !said.contains("g++"), "{said}");
    let lines: Vec<&str> = asked.lines().collect();
    assert!(lines.len() == 4 && lines[0].starts_with("update") && lines[1].ends_with(" faust"), "{asked}");
}

#[test]
fn setup_installs_nothing_without_need_or_right() {
    let all = machine("0", &["jackd", "pulseaudio", "pkg-config", "faust", "c++", "chromium", "valgrind"]);
    let (said, asked) = set_up(all.path());
    assert_eq!((said.lines().count(), asked.as_str()), (1, ""), "{said}");
    let (said, asked) = set_up(machine("1000", &["faust", "c++"]).path());
    assert!(said.contains("sudo apt-get install jackd2 libasound2-dev pkg-config pulseaudio"), "{said}");
    assert_eq!(asked, "", "{said}");
}
