//! The checked-in header matches the Rust source. `UPDATE=1` regenerates it.

use ca_haptic::frame::{About, CAUSES, DeviceFrame, ForceFrame, VERSION};
use std::fmt::Write as _;
use std::path::Path;

const HEAD: &str = "\
/* Devices for cordis-anima instruments: send positions, get the force on the hand.
 *
 * SI units: m, N, s. All functions may be called whether or not an engine runs. A device belongs to the thread that
 * opened it. Link with -lca_device. Written by a test from the Rust source; do not edit. */
";

/// Writes assertions for size and field offsets of a structure, from its message text; another test compares the two.
fn asserts(to: &mut String, c: &str, schema: &str) {
    let (mut at, mut lines) = (0, String::new());
    for line in schema.lines() {
        let (kind, name) = line.split_once(' ').unwrap();
        let (base, count) = kind.trim_end_matches(']').split_once('[').unwrap_or((kind, "1"));
        writeln!(lines, "_Static_assert(offsetof({c}, {name}) == {at}, \"{c}.{name}\");").unwrap();
        let bits: usize = base.trim_start_matches(char::is_alphabetic).parse().unwrap();
        at += bits / 8 * count.parse::<usize>().unwrap();
    }
    writeln!(to, "_Static_assert(sizeof({c}) == {at}, \"size of {c}\");\n{}", lines.trim_end()).unwrap();
}

fn trailer() -> String {
    let mut s = String::from("/* the layout both sides rely on */\n#ifndef __cplusplus\n");
    asserts(&mut s, "CaDeviceFrame", DeviceFrame::SCHEMA);
    asserts(&mut s, "CaForceFrame", ForceFrame::SCHEMA);
    asserts(&mut s, "CaAbout", About::SCHEMA);
    s.push_str("#endif\n");
    s
}

fn numbers() -> String {
    use ca_haptic::frame::{flag, status};
    let mut s = String::from("#include <stddef.h>\n\n");
    let mut put = |name: &str, n: u64| writeln!(s, "#define CA_{name} {n}").unwrap();
    put("VERSION", u64::from(VERSION));
    for (name, n) in [
        ("CONNECTED", status::CONNECTED),
        ("POWERED", status::POWERED),
        ("CALIBRATED", status::CALIBRATED),
        ("IN_USE", status::IN_USE),
        ("DEADMAN", status::DEADMAN),
        ("BRAKE", status::BRAKE),
        ("THERMAL", status::THERMAL),
        ("EDGE", status::EDGE),
        ("SIMULATED", status::SIMULATED),
    ] {
        put(&format!("STATUS_{name}"), u64::from(n));
    }
    for (name, n) in [
        ("SATURATED", flag::SATURATED),
        ("SLEWED", flag::SLEWED),
        ("PASSIVITY", flag::PASSIVITY),
        ("OSCILLATION", flag::OSCILLATION),
        ("THERMAL", flag::THERMAL),
        ("EDGE", flag::EDGE),
        ("STALE", flag::STALE),
        ("WAIT_CLEAR", flag::WAIT_CLEAR),
        ("PASSIVITY_OFF", flag::PASSIVITY_OFF),
        ("COUPLED", flag::COUPLED),
    ] {
        put(&format!("FLAG_{name}"), u64::from(n));
    }
    for cause in CAUSES {
        put(&format!("CAUSE_{}", cause.name()), cause as u64);
    }
    for (n, name) in ["OFF", "RAMP", "ON", "DAMP", "FAULT"].into_iter().enumerate() {
        put(&format!("MODE_{name}"), n as u64);
    }
    s
}

#[test]
fn the_header_is_up_to_date() {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    let frames = here.join("../src/frame");
    let mut config = cbindgen::Config {
        language: cbindgen::Language::C,
        include_guard: Some("CA_DEVICE_H".into()),
        header: Some(HEAD.trim_end().into()),
        after_includes: Some(numbers()),
        trailer: Some(trailer().trim_end().into()),
        cpp_compat: true,
        no_includes: false,
        style: cbindgen::Style::Type,
        documentation_style: cbindgen::DocumentationStyle::C99,
        line_length: 120,
        ..cbindgen::Config::default()
    };
    config.export.include = ["About", "DeviceFrame", "ForceFrame", "DOF"].map(String::from).into();
    // these are exported with prefixes
    config.export.exclude = numbers()
        .lines()
        .filter_map(|l| l.strip_prefix("#define CA_STATUS_").or(l.strip_prefix("#define CA_FLAG_")))
        .filter_map(|l| l.split(' ').next())
        .chain(["VERSION", "CAUSES", "Cause", "Mode"])
        .map(String::from)
        .collect();
    for name in ["About", "DeviceFrame", "ForceFrame"] {
        config.export.rename.insert(name.into(), format!("Ca{name}"));
    }
    config.export.rename.insert("DOF".into(), "CA_DOF".into());
    config.structure.associated_constants_in_body = false;
    let mut made = Vec::new();
    cbindgen::Builder::new()
        .with_config(config)
        .with_src(frames.join("mod.rs"))
        .with_src(frames.join("about.rs"))
        .with_src(frames.join("device.rs"))
        .with_src(frames.join("force.rs"))
        .with_src(here.join("src/lib.rs"))
        .generate()
        .expect("the source can be read")
        .write(&mut made);
    // brackets are escaped and links resolved only for rustdoc
    let made = String::from_utf8(made).unwrap().replace("\\[", "[").replace("\\]", "]").replace("(super::Cause)", "");
    let path = here.join("include/ca_device.h");
    if std::env::var_os("UPDATE").is_some() {
        std::fs::write(&path, &made).unwrap();
    }
    let there = std::fs::read_to_string(&path).unwrap_or_default();
    assert!(there == made, "{} is not what the source says; UPDATE=1 writes it:\n{made}", path.display());
}
