//! Tests `ca bench`: tables, page, and the message for an unknown name. The speed of this machine is not tested.

use crate::sandbox::Sandbox;
use std::fs;

#[test]
fn what_fits_was_measured_to_be_in_time() {
    let sandbox = Sandbox::new();
    let j = sandbox.ca(&["bench", "--only", "string,cells", "--json"]).is(0).json();
    let names: Vec<&str> = j["networks"].as_array().unwrap().iter().map(|n| n["network"].as_str().unwrap()).collect();
    assert_eq!(names, ["string", "cells"]);
    for network in j["networks"].as_array().unwrap() {
        for at in network["in_real_time"].as_array().unwrap() {
            let of = |key: &str| at[key].as_f64().unwrap();
            assert!(of("modules") >= 30.0 && of("ns_per_tick") > 0.0, "{network}");
            assert!(of("ns_per_tick") <= 1e9 / of("rate"), "{network}");
        }
    }
    let paper: Vec<u64> = j["paper"].as_array().unwrap().iter().map(|p| p["modules"].as_u64().unwrap()).collect();
    assert_eq!(paper, [20, 140, 200], "Leonard, Castagné and Cadoz 2013, Table 1");
    assert!(!j["machine"].as_str().unwrap().is_empty());
}

#[test]
fn a_page_has_what_was_printed() {
    let sandbox = Sandbox::new();
    let shown = sandbox
        .ca(&["bench", "--only", "BUT", "--page", "bench.html"])
        .is(0)
        .says(&["BUT", "44.1 kHz", "48 kHz", "140"]);
    let page = fs::read_to_string(sandbox.path("bench.html")).unwrap();
    let row = shown.out.lines().find(|l| l.trim_start().starts_with("BUT ")).unwrap();
    for number in row.split_whitespace().skip(1).take(3) {
        assert!(page.contains(number), "{number} of `{row}` is not on the page");
    }
    sandbox.ca(&["bench", "--only", "string", "--page", "bench.txt"]).is(2);
    sandbox
        .ca(&["bench", "--page", "nowhere/bench.html"])
        .is(1)
        .says(&["nowhere/bench.html", "make the directory first"]);
    assert_eq!(sandbox.files(), ["bench.html"]);
}

#[test]
fn a_name_that_is_misspelt_gets_an_answer() {
    let sandbox = Sandbox::new();
    sandbox.ca(&["bench", "--only", "strnig"]).is(2).says(&["did you mean `string`?"]);
    sandbox.ca(&["bench", "--only", "mesh,zzzzzz"]).is(2).says(&["no network `zzzzzz`", "string, cells, mesh"]);
}

/// A misspelt value would compare a processor with itself.
#[test]
fn vectors_that_there_are_not_are_refused() {
    let sandbox = Sandbox::new();
    let ran = sandbox.with(&[("CA_VECTORS", "AVX2")], &["list"]).is(2).says(&["neither `portable` nor `avx2`"]);
    assert_eq!(ran.out, "");
    let sounds = ["portable", "avx2"].map(|vectors| {
        sandbox.with(&[("CA_VECTORS", vectors)], &["render", "plate", "--seconds", "0.2", "-o", "a.wav"]).is(0);
        fs::read(sandbox.path("a.wav")).unwrap()
    });
    sandbox.ca(&["render", "plate", "--seconds", "0.2", "-o", "b.wav"]).is(0);
    assert!(sounds.iter().all(|s| *s == fs::read(sandbox.path("b.wav")).unwrap()), "the same bits");
}
