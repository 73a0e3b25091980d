//! Tests the README and the pages with commands: the commands of a page run in the given order and under the given names.

mod effects;

#[cfg(unix)]
use crate::long_form::long_form;
use crate::sandbox::{Sandbox, blocks, from_root, peak};
#[cfg(unix)]
use effects::Line;
use std::fs;

/// The pages whose commands run here.
#[cfg(unix)]
const PAGES: [&str; 3] = ["README.md", "docs/instrument.md", "docs/hand.md"];

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
    let sandbox = Sandbox::new();
    sandbox.ca(&args.split(' ').collect::<Vec<_>>()).is(0);
    let (name, _) = readme.split_once(".wav`").unwrap();
    let name = name.rsplit('`').next().unwrap();
    assert_eq!(sandbox.files(), [format!("{name}.wav")], "the file that the README names");
    assert!(peak(&sandbox.wav(&sandbox.files()[0]).1) > 0.05, "it is heard");

    assert_eq!(commands[1], "tests/run");
    let recipe = fs::read_to_string(from_root(".ci/run")).unwrap();
    assert_eq!(recipe.lines().last(), Some("exec tests/run"), "the recipe runs the command of the README");
    let script = fs::read_to_string(from_root("tests/run")).unwrap();
    assert!(script.contains("cargo test --workspace") && script.contains("--long"));
    assert!(script.lines().any(|l| l == "tests/setup"), "what tests need is set up by the one command");
}

/// Lines that run `ca`, from blocks with or without a server.
#[cfg(unix)]
fn lines(readme: &str, serve: bool) -> Vec<Line<'_>> {
    let blocks = blocks(readme, "sh").into_iter().filter(|(_, b)| b.contains("ca serve") == serve);
    blocks.flat_map(|(_, b)| b.lines()).filter_map(Line::new).collect()
}

#[cfg(unix)]
#[test]
fn every_ca_line_does_what_it_is_there_for() {
    let mut ran_lines = 0;
    for page in PAGES {
        let text = fs::read_to_string(from_root(page)).unwrap();
        let sandbox = Sandbox::new();
        let models = blocks(&text, "toml");
        assert!(models.len() <= 1, "{page}: at most one model, saved under one name");
        for (before, model) in models {
            // the file name of the model is the last text in backquotes before it
            let name = before.rsplit('`').nth(1).unwrap();
            assert!(name.ends_with(".ca.toml"), "{page}: {name}");
            sandbox.put(name, model);
        }
        let mut lines = lines(&text, false);
        if !long_form("`ca bench` as the documents have it") {
            lines.retain(|l| l.verb() != "bench");
        }
        for line in &lines {
            let before = effects::files(&sandbox);
            let ran = sandbox.sh(line.text).is(0);
            effects::check(&sandbox, line, &before, &ran);
        }
        ran_lines += lines.len();
    }
    assert!(ran_lines >= 20, "only {ran_lines} lines of `ca` were found");
}

/// Separate from the other tests, because a server plays in real time.
#[cfg(unix)]
mod in_real_time {
    use super::*;
    use crate::skipped::skipped;

    #[test]
    fn what_is_served_does_what_it_is_there_for() {
        let page = fs::read_to_string(from_root("docs/hand.md")).unwrap();
        let sandbox = Sandbox::new();
        let lines = lines(&page, true);
        let [device, server, rest @ ..] = &lines[..] else { panic!("a device and a server") };
        assert!(device.beside && server.verb() == "serve" && rest.len() >= 3);
        play(&sandbox, server, device);
        for line in rest {
            let before = effects::files(&sandbox);
            let ran = sandbox.sh(line.text).is(0);
            effects::check(&sandbox, line, &before, &ran);
        }
    }

    /// Number of periods that a busy machine left out.
    fn left_out(report: &str) -> u32 {
        let before = report.split(" periods left out").next().unwrap_or_default();
        before.rsplit(' ').next().and_then(|n| n.parse().ok()).unwrap_or(0)
    }

    /// Plays the strokes of a simulated device until the forces are as the page says. On a stalled machine the
    /// watchdogs end the forces as intended, so it plays again.
    fn play(sandbox: &Sandbox, server: &Line, device: &Line) {
        const TRIES: usize = 10;
        // half of the periods of the performance
        const HALF: u32 = 9000;
        for _ in 0..TRIES {
            sandbox.files().iter().for_each(|f| fs::remove_file(sandbox.path(f)).unwrap());
            sandbox.sh(device.text).is(0);
            let ran = sandbox.sh(server.text);
            // the device waits for the server and ends by itself
            let felt = effects::felt(sandbox, device);
            let stood_still = ran.out.contains("WATCHDOG") || left_out(&ran.out) > HALF;
            let code = if stood_still && ran.code == 3 { 3 } else { 0 };
            let ran = ran.is(code);
            if felt > 1.0 {
                return effects::check(sandbox, server, &effects::files(sandbox), &ran);
            }
            assert!(stood_still, "more than a newton, says the page, and {felt} N were felt\n{}{}", ran.out, ran.err);
        }
        skipped(
            "processor time",
            &format!("in each of {TRIES} tries this machine stood still, and watchdogs ended forces"),
        );
    }
}

/// Commands in the text: a bundled model must produce sound, and other commands must have known words and options.
#[cfg(unix)]
#[test]
fn commands_in_its_sentences_are_commands() {
    let text: String = PAGES.map(|page| fs::read_to_string(from_root(page)).unwrap()).concat();
    let mut seen = 0;
    let spans = text.split('`').skip(1).step_by(2).filter(|s| !s.contains('\n'));
    for line in spans.filter_map(Line::new) {
        let sandbox = Sandbox::new();
        let bundled = line.words.get(1).filter(|m| ca_lab::load::bundled(m).is_some());
        if bundled.is_some() && line.verb() == "render" {
            let before = effects::files(&sandbox);
            let ran = sandbox.sh(line.text).is(0);
            effects::check(&sandbox, &line, &before, &ran);
        } else {
            let help = sandbox.ca(&[line.verb(), "--help"]).is(0).out;
            for option in line.words.iter().filter(|w| w.starts_with("--")) {
                assert!(help.contains(option.as_str()), "`{}`: no {option} in\n{help}", line.text);
            }
        }
        seen += 1;
    }
    assert!(seen >= 10, "only {seen} were found");
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
