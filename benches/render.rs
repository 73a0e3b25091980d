//! Cost of `ca render` beside the sound itself, for every bundled model, in processor time of one thread.
//!
//! Requirements: the energy audit costs at most one play, and the whole render, from text to WAV, at most two. Ratios
//! are within one round, and the least of several rounds counts: times depend on the machine, ratios do not.
#![allow(missing_docs)]

use ca_accuracy::timing::processor;
use ca_benches::catalog;
use ca_compile::{Options, compile};
use ca_io::format::Format;
use ca_io::perform::Performance;
use ca_io::sound::WavOut;
use ca_lab::play::{BLOCK, audit, frames, play, seconds};
use std::path::Path;

/// Returns the result of `f` and its processor time \[ms\].
fn cost<T>(f: impl FnOnce() -> T) -> (T, f64) {
    let begin = processor();
    let done = f();
    (done, processor().saturating_sub(begin).as_secs_f64() * 1e3)
}

/// Runs one round and returns the times of all of it, of the play and of the audit \[ms\].
fn round(text: &str, name: &str, to: &Path, part: f64) -> [f64; 3] {
    let (of, all) = cost(|| {
        let catalog = catalog();
        let (model, findings) = ca_model::read::read(text, name, &catalog);
        assert!(!findings.has_errors(), "{findings}");
        let scene = compile(&model, &catalog, &Options::default()).expect("a bundled model compiles").scene;
        let performance = Performance::new(&scene, None).expect("its gesture plays");
        let n = frames(&scene, seconds(&performance, None) * part);
        let mut wav =
            WavOut::create(to, scene.rate, scene.counts.channels, Format::F32).expect("the file can be written");
        let (mut played, mut written) = (0.0, 0.0);
        let ((), both) = cost(|| {
            let heard = &mut |_: &Performance, rows: &[f64], _| {
                let (done, t) = cost(|| wav.write(rows));
                written += t;
                done
            };
            play(performance, n, BLOCK, heard).map(|_| ()).expect("the file can be written");
        });
        played += both - written;
        wav.finish().expect("the file can be written");
        let (_, audited) = cost(|| {
            let options = Options { energy: true, ..Options::default() };
            let scene = compile(&model, &catalog, &options).expect("a bundled model compiles").scene;
            audit(&scene, None, n).expect("it keeps a ledger").ledger.balance()
        });
        [played, audited]
    });
    [all, of[0], of[1]]
}

fn main() {
    // `cargo test --benches` only checks that it runs
    let long = std::env::args().any(|a| a == "--bench");
    let (rounds, part) = if long { (5, 1.0) } else { (1, 0.01) };
    let only: Vec<String> = std::env::args().skip(1).filter(|a| !a.starts_with('-')).collect();
    let dir = concat!(env!("CARGO_MANIFEST_DIR"), "/../models");
    let mut files: Vec<_> = std::fs::read_dir(dir).expect("models").map(|f| f.expect("a file").path()).collect();
    files.retain(|f| f.is_file());
    files.sort();
    let to = std::env::temp_dir().join(format!("ca-bench-render-{}.wav", std::process::id()));
    println!(
        "{:<18} {:>9} {:>9} {:>9} {:>11} {:>12}",
        "model", "play ms", "audit ms", "render ms", "audit/play", "render/play"
    );
    for file in files {
        let name =
            file.file_name().and_then(|n| n.to_str()).unwrap_or_default().trim_end_matches(".ca.toml").to_owned();
        if !only.is_empty() && !only.contains(&name) {
            continue;
        }
        let text = std::fs::read_to_string(&file).expect("a model");
        let all: Vec<[f64; 3]> = (0..rounds).map(|_| round(&text, &name, &to, part)).collect();
        let least = |f: &dyn Fn(&[f64; 3]) -> f64| all.iter().map(f).fold(f64::INFINITY, f64::min);
        let [render, play, audit] = [0, 1, 2].map(|k| least(&|r| r[k]));
        println!(
            "{name:<18} {play:>9.2} {audit:>9.2} {render:>9.2} {:>11.2} {:>12.2}",
            least(&|r| r[2] / r[1]),
            least(&|r| r[0] / r[1])
        );
    }
    let _ = std::fs::remove_file(to);
}
