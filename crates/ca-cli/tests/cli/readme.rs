//! The README does what it says: its commands run, in the order and under the names it gives.

use crate::desk::{Desk, blocks, from_root};
use std::fs;

fn readme() -> String {
    fs::read_to_string(from_root("README.md")).unwrap()
}

/// Lines of all `sh` blocks, without comments.
fn commands(readme: &str) -> Vec<&str> {
    blocks(readme, "sh").into_iter().flat_map(|(_, b)| b.lines()).filter(|l| !l.trim().is_empty()).collect()
}

#[test]
fn the_first_command_renders_and_the_second_tests() {
    let readme = readme();
    let commands = commands(&readme);
    let args = commands[0].strip_prefix("cargo run --release --bin ca -- ").expect("the first command runs `ca`");
    let desk = Desk::new();
    desk.ca(&args.split(' ').collect::<Vec<_>>()).is(0);
    let (name, _) = readme.split_once(".wav`").unwrap();
    let name = name.rsplit('`').next().unwrap();
    assert_eq!(desk.files(), [format!("{name}.wav")], "the file that the README names");

    assert_eq!(commands[1], "tests/run");
    let recipe = fs::read_to_string(from_root(".ci/run")).unwrap();
    assert_eq!(recipe.lines().last(), Some("exec tests/run"), "the recipe runs the command of the README");
    let script = fs::read_to_string(from_root("tests/run")).unwrap();
    assert!(script.contains("cargo test --workspace") && script.contains("--long"));
}

#[cfg(unix)]
#[test]
fn every_ca_line_runs() {
    let readme = readme();
    let desk = Desk::new();
    let models = blocks(&readme, "toml");
    assert_eq!(models.len(), 1, "one model, saved under one name");
    for (before, model) in models {
        // the last thing in backquotes before the model is its file
        let name = before.rsplit('`').nth(1).unwrap();
        assert!(name.ends_with(".ca.toml"), "{name}");
        desk.put(name, model);
    }
    let mut ran = 0;
    for line in commands(&readme).into_iter().filter(|l| l.starts_with("ca ")) {
        desk.sh(line).is(0);
        ran += 1;
    }
    assert!(ran >= 6, "only {ran} lines of `ca` were found");
    for file in ["mine.wav", "soft.wav", "blow.csv", "low[8].npy", "other.ca.toml"] {
        assert!(desk.path(file).is_file(), "{file}");
    }
}

#[test]
fn its_links_lead_somewhere() {
    let readme = readme();
    for link in readme.split("](").skip(1).map(|rest| rest.split(')').next().unwrap()) {
        assert!(link.starts_with("http") || from_root(link).exists(), "{link}");
    }
    for path in ["models", "tests", "benches", "fuzz"] {
        assert!(from_root(path).is_dir() && readme.contains(&format!("`{path}/`")), "{path}");
    }
}
