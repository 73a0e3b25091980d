//! Measures error against run time of twelve scenes, with `ca accuracy` as a process.
//!
//! The bench uses only the output of the command, so that readers of the page can repeat it for their models. It prints
//! the page. With `UPDATE=1` it writes the page to `docs/measured/accuracy.md` and the pictures to
//! `docs/measured/accuracy/`.
#![allow(missing_docs)]

use ca_benches::accuracy::{CASES, ErrorRow, Found, STIFF, claims, page::page, stiffened, svg};
use serde_json::Value;
use std::path::Path;
use std::process::{Command, ExitCode, Stdio};

/// Runs `ca accuracy` on a model and parses its output.
fn measured(text: &str, seconds: &str, times: &str, reference: &str) -> Found {
    let dir = tempfile::tempdir().expect("a folder");
    let path = dir.path().join("model.ca.toml");
    std::fs::write(&path, text).expect("the model is written");
    let mut ca = Command::new(env!("CARGO_BIN_EXE_ca"));
    ca.arg("accuracy").arg(&path).args(["--seconds", seconds, "--times", times, "--reference", reference, "--json"]);
    let out = ca.env_remove("CA_CONFIG").stderr(Stdio::inherit()).output().expect("ca starts");
    let reported: Value = serde_json::from_slice(&out.stdout).expect("ca tells of it as JSON");
    let number = |v: &Value| v.as_f64();
    let word = |v: &Value| v.as_str().unwrap_or_default().to_string();
    let rows = reported["rows"].as_array().into_iter().flatten().map(|r| ErrorRow {
        method: word(&r["method"]),
        times: r["times"].as_u64().unwrap_or(0) as u32,
        error: number(&r["error"]).unwrap_or(f64::INFINITY),
        spectrum: number(&r["spectrum_error"]).unwrap_or(f64::INFINITY),
        cents: number(&r["cents"]),
        decay: number(&r["decay_db"]),
        made: number(&r["made"]),
        ns: number(&r["ns_per_sample"]).unwrap_or(f64::NAN),
        stability: word(&r["stability"]),
        front: r["front"] == true,
    });
    let list = |key: &str, what: &str, how: &str| -> Vec<String> {
        let all = reported[key].as_array().into_iter().flatten();
        all.map(|r| format!("{how} `{}`: {}.", word(&r["method"]), word(&r[what]))).collect()
    };
    Found {
        against: word(&reported["reference"]["words"]),
        known: number(&reported["reference"]["known"]).unwrap_or(f64::INFINITY),
        rows: rows.collect(),
        reported: [list("refused", "why", "Not by"), list("warned", "what", "By")].concat(),
    }
}

fn main() -> ExitCode {
    // `cargo test --benches` only checks that it runs
    let long = std::env::args().any(|a| a == "--bench");
    if !long {
        let one = measured(&stiffened(1), "0.005", "1", "8");
        assert!(!one.rows.is_empty(), "no way to play it");
        return ExitCode::SUCCESS;
    }
    let docs = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/measured");
    let update = std::env::var_os("UPDATE").is_some();
    let mut found = Vec::new();
    for case in &CASES {
        let f = measured(&(case.text)(), case.seconds, case.times, case.reference);
        if update {
            let folder = docs.join("accuracy");
            std::fs::create_dir_all(&folder).expect("a folder for the pictures");
            let picture = svg::draw(case.title, &f);
            std::fs::write(folder.join(format!("{}.svg", case.name)), picture).expect("a picture is written");
        }
        found.push(f);
    }
    let long = measured(&stiffened(0), "1", "1", "8");
    let stiff = STIFF.map(|n| measured(&stiffened(n), "0.1", "1", "8"));
    let claims = claims(&found[0], &long, &stiff);
    let text = page(&found, &stiff, &claims, &ca_benches::machine());
    println!("{text}");
    if update {
        std::fs::write(docs.join("accuracy.md"), text).expect("the page can be written");
    }
    // errors do not depend on the machine and must hold; times are only reported
    let errors = claims.iter().filter(|c| c.what.starts_with("error"));
    if errors.clone().all(ca_benches::accuracy::Claim::holds) { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}
