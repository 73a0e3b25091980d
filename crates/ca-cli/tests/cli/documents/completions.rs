//! Tests shell completion in bash.

use crate::sandbox::{BAR, Sandbox};

/// Returns the candidates of bash for the last word.
#[cfg(unix)]
fn offered(sandbox: &Sandbox, words: &str) -> Vec<String> {
    let last = words.split(' ').count() - 1;
    let word = words.split(' ').next_back().unwrap();
    let script = format!(
        "ca completions bash > ca.bash
bash -c '. ./ca.bash; complete -p ca > /dev/null; COMP_WORDS=({words} ); [ -n \"{word}\" ] || COMP_WORDS+=(\"\")
COMP_CWORD={last} COMP_TYPE=9; _clap_complete_ca ca \"{word}\" 2> err
printf \"%s\\n\" \"${{COMPREPLY[@]}}\"'; rm ca.bash err"
    );
    sandbox.sh(&script).is(0).out.lines().map(str::to_owned).collect()
}

#[cfg(unix)]
#[test]
fn bash_completes_commands_options_and_models() {
    let sandbox = Sandbox::new();
    sandbox.put("harp.ca.toml", BAR).put("harm.txt", "").put("harp.mdl", "");
    std::fs::create_dir(sandbox.path("harbour")).unwrap();
    let has = |words: &str, all: &[&str], none: &[&str]| {
        let offered = offered(&sandbox, words);
        assert!(all.iter().all(|w| offered.iter().any(|o| o == w)), "{words}: {offered:?}");
        assert!(!none.iter().any(|w| offered.iter().any(|o| o == w)), "{words}: {offered:?}");
    };
    has("ca re", &["render", "report", "replay"], &["check"]);
    has("ca render har", &["harmonic_chain", "harp.ca.toml", "harbour/"], &["harm.txt", "hammered_string"]);
    has("ca import har", &["harp.mdl", "harbour/"], &["harp.ca.toml", "harm.txt"]);
    has("ca check ham", &["hammered_string", "hammer_piano"], &["harp.ca.toml"]);
    has("ca tune memb", &["membrane"], &[]);
    has("ca list BU", &["BUT"], &[]);
    has("ca new x.ca.toml --from plat", &["plate"], &[]);
    has("ca explain E01", &["E013"], &["E003"]);
    has("ca render harmonic_chain --form", &["--format"], &[]);
    has("ca render harmonic_chain --format f", &["f32", "flac", "flac16"], &["24"]);
    has("ca render harmonic_chain --", &["--rate", "--seconds"], &["--bits", "--duration"]);
}

#[test]
fn every_shell_has_a_script() {
    let sandbox = Sandbox::new();
    for (shell, word) in [
        ("bash", "complete -o"),
        ("zsh", "#compdef ca"),
        ("fish", "complete --"),
        ("elvish", "ca"),
        ("powershell", "ca"),
    ] {
        let script = sandbox.ca(&["completions", shell]).is(0).out;
        assert!(script.contains(word) && script.contains("COMPLETE"), "{shell}: {script}");
    }
    sandbox.ca(&["completions", "csh"]).is(2).says(&["bash", "zsh", "fish"]);
}
