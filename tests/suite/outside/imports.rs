//! Imported MIMS models against mi.lib itself, from the first sample on.
//!
//! The text of the model is turned into a Faust program as the exporter of MIMS does. It is played in double precision
//! beside the model that the import writes. The link of mi.lib gets the delayed positions of its ends, x₋₂, as from the
//! exporter; `first_samples` in `peers.rs` describes the effect in the first sample.

use crate::outside::peers::{Channels, Played, SECOND, agree, by_faust};
use crate::play::{Random, scene};
use ca_core::{Scene, tick};
use ca_import::mims::import;
use ca_model::write::write;
use std::collections::BTreeMap;
use std::fmt::Write as _;

/// The scene of an import, through its written file, and the titles of the findings.
fn imported(text: &str) -> (Scene, Vec<String>) {
    let (model, diags) = import(text, "drawn.mdl");
    assert!(!diags.has_errors(), "{diags}{text}");
    (scene(&write(&model)).scene, diags.list.iter().map(|d| d.title.clone()).collect())
}

/// Output of the imported scene for one second.
fn by_engine(scene: &Scene, played: Played) -> Channels {
    let mut s = scene.state();
    let ports: Vec<usize> = played.iter().map(|(name, _)| scene.input(name).expect("a port")).collect();
    let mut channels = vec![Vec::with_capacity(SECOND); scene.counts.channels];
    for n in 0..SECOND {
        for (port, (_, values)) in ports.iter().zip(played) {
            s.input[*port] = values[n];
        }
        tick(scene, &mut s);
        for (row, value) in channels.iter_mut().zip(&s.output) {
            row.push(*value);
        }
    }
    channels
}

/// The Faust program of a MIMS model. Its inputs: all `posInput`, then all `frcInput`.
fn faust(text: &str) -> String {
    let lines: Vec<Vec<&str>> = text.lines().map(|l| l.split_whitespace().collect::<Vec<_>>()).collect();
    let (mut modules, mut links) = (Vec::new(), Vec::new());
    let (mut outs, mut pushes, mut moved) = (Vec::new(), Vec::new(), Vec::new());
    let mut mats: BTreeMap<&str, (usize, &str)> = BTreeMap::new();
    for l in &lines {
        let (made, delayed) = match l[1] {
            "mass" => (format!("mi.mass({}, 0, {}, {})", l[2], l[3], l[4]), l[4]),
            "massG" => (format!("mi.mass({}, {}, {}, {})", l[2], l[3], l[4], l[5]), l[5]),
            "osc" => (format!("mi.oscil({}, {}, {}, 0, {}, {})", l[2], l[3], l[4], l[5], l[6]), l[6]),
            "ground" => (format!("mi.ground({})", l[2]), l[2]),
            "posInput" => {
                moved.push(modules.len());
                (format!("mi.posInput({})", l[2]), l[2])
            }
            _ => continue,
        };
        mats.insert(l[0], (modules.len(), delayed));
        modules.push(made);
    }
    for l in &lines {
        let law = match l[1] {
            "spring" => "spring",
            "damper" => "damper",
            "springDamper" => "springDamper",
            "nlSpring2" => "nlSpringDamper2",
            "nlSpring3" => "nlSpringDamper3",
            "contact" => "collision",
            "frcInput" => {
                pushes.push(mats[l[2]].0);
                continue;
            }
            "posOutput" => {
                outs.push(mats[l[2]].0);
                continue;
            }
            _ => continue,
        };
        let ends = [mats[l[2]], mats[l[3]]];
        links.push((format!("mi.{law}({}, {}, {})", l[4..].join(", "), ends[0].1, ends[1].1), ends.map(|e| e.0)));
    }
    let (m, n, p, q, o) = (modules.len(), links.len(), moved.len(), pushes.len(), outs.len());
    let mut to_modules = String::new();
    let mut at = 0;
    for i in 0..m {
        at += 1;
        _ = write!(to_modules, ", {}, {at}", i + 1);
        if let Some(k) = moved.iter().position(|x| *x == i) {
            at += 1;
            _ = write!(to_modules, ", {}, {at}", m + k + 1);
        }
    }
    (0..q).for_each(|k| _ = write!(to_modules, ", {}, {}", m + p + k + 1, m + p + k + 1));
    let (mut to_links, mut back) = (String::new(), String::new());
    for (i, (_, ends)) in links.iter().enumerate() {
        for (k, end) in ends.iter().enumerate() {
            _ = write!(to_links, ", {}, {}", end + 1, 2 * i + k + 1);
            _ = write!(back, ", {}, {}", 2 * i + k + 1, end + 1);
        }
    }
    for (i, end) in outs.iter().enumerate() {
        _ = write!(to_links, ", {}, {}", end + 1, 2 * n + i + 1);
        _ = write!(back, ", {}, {}", 2 * n + i + 1, m + i + 1);
    }
    for (i, end) in pushes.iter().enumerate() {
        _ = write!(to_links, ", {}, {}", m + i + 1, 2 * n + o + i + 1);
        _ = write!(back, ", {}, {}", 2 * n + o + i + 1, end + 1);
    }
    let all = |list: Vec<String>| list.join(", ");
    let wires = |n: usize| all(vec!["_".to_string(); n]);
    let (made, joined) = (all(modules), all(links.into_iter().map(|l| l.0).collect()));
    let more = |n: usize| if n == 0 { String::new() } else { format!(", {}", wires(n)) };
    format!(
        "mi = library(\"mi.lib\");\nprocess = (route({}, {}{to_modules}) : ({made}{}) : route({}, {}{to_links}) : \
         ({joined}{}) : route({}, {}{back})) ~ ({}) : ({}, {});\n",
        m + p + q,
        m + p + q,
        more(q),
        m + q,
        2 * n + o + q,
        more(o + q),
        2 * n + o + q,
        m + o,
        wires(m),
        all(vec!["!".to_string(); m]),
        wires(o),
    )
}

/// Every output of the import is within 1e-12 of mi.lib, from the first sample to the last.
#[track_caller]
fn same(text: &str, played: Played) {
    let (scene, _) = imported(text);
    let Some(theirs) = by_faust(&faust(text), played) else { return };
    let ours = by_engine(&scene, played);
    assert_eq!(ours.len(), theirs.len());
    for (i, (ours, theirs)) in ours.iter().zip(&theirs).enumerate() {
        agree(&format!("output {i} of\n{text}"), ours, theirs, 1e-12);
    }
}

const SPEED: &str = "@g ground 0.\n@m mass 1.0 0. 0.1\n@s springDamper @g @m 0.1 0.1\n@out1 posOutput @m\n";
const AWAY: &str = "@g ground 0.\n@m mass 1 0.1 0.1\n@s springDamper @g @m 0.1 0.1\n@out1 posOutput @m\n";

#[test]
fn a_start_speed_is_the_step_before_the_first_sample() {
    let (scene, _) = imported(SPEED);
    let ours = by_engine(&scene, &[]);
    for (n, theirs) in [-0.1, -0.19, -0.252, -0.2826].into_iter().enumerate() {
        assert!((ours[0][n] - theirs).abs() < 1e-15, "{n}: {} {theirs}", ours[0][n]);
    }
    same(SPEED, &[]);
}

#[test]
fn a_displaced_mass_rings_about_the_place_where_it_rests() {
    let (scene, _) = imported(AWAY);
    let ours = by_engine(&scene, &[]);
    // the first link force: from the stretch, and from the delayed position taken for a speed
    assert_eq!(ours[0][0], 0.1);
    assert!((ours[0][1] - (0.1 - 0.01 - 0.02)).abs() < 1e-15);
    assert!(ours[0][SECOND - 1].abs() < 1e-15, "it comes to rest at 0: {}", ours[0][SECOND - 1]);
    same(AWAY, &[]);
}

#[test]
fn grounds_and_cells_and_weight_start_as_there() {
    let text = "@g ground 0.5\n@f ground -0.25\n@a mass 2 0.5 0.4\n@b osc 1.5 0.02 0.003 0.2 0.25\n\
                @c massG 3 1e-4 -0.1 -0.1\n@r0 springDamper @g @a 0.05 0.01\n@r1 springDamper @a @b 0.03 0.02\n\
                @r2 damper @b @c 0.01\n@r3 spring @c @f 0.04\n@r4 springDamper @f @a 0.01 0.005\n\
                @o1 posOutput @a\n@o2 posOutput @b\n@o3 posOutput @c\n@o4 posOutput @g\n";
    same(text, &[]);
}

#[test]
fn inputs_act_in_the_same_sample() {
    let text = "@in1 posInput 0.\n@a mass 1 0.02 0.01\n@b mass 1 0. 0.\n@g ground 0.\n\
                @r0 springDamper @in1 @a 0.05 0.01\n@r1 springDamper @a @b 0.1 0.002\n@r2 springDamper @b @g 0.1 0.002\n\
                @in2 frcInput @b\n@o1 posOutput @a\n@o2 posOutput @b\n@o3 posOutput @in1\n";
    let moved = (0..SECOND).map(|n| 0.01 * (n as f64 / 40.0).sin()).collect();
    let push = (0..SECOND).map(|n| if n == 0 { 1e-3 } else { 0.0 }).collect();
    same(text, &[("in1", moved), ("in2", push)]);
}

/// A network of a dozen masses with drawn speeds, places, laws and numbers, tied to two grounds.
fn drawn(seed: u64) -> String {
    let mut rng = Random(seed);
    // three digits, so that both programs read the same number
    let mut roll = |from: f64, to: f64| format!("{:.3e}", from + (to - from) * 0.5 * (rng.uniform() + 1.0));
    let mut text = format!("@g0 ground {}\n@g1 ground {}\n", roll(-0.5, 0.5), roll(-0.5, 0.5));
    let mats = 12;
    for i in 0..mats {
        let (m, x) = (roll(1.0, 3.0), roll(-0.3, 0.3));
        let x1 = if i % 4 == 0 { x.clone() } else { roll(-0.3, 0.3) };
        _ = match i % 6 {
            1 => writeln!(text, "@m{i} osc {m} {} {} {x} {x1}", roll(0.01, 0.1), roll(1e-3, 1e-2)),
            3 => writeln!(text, "@m{i} massG {m} {} {x} {x1}", roll(-1e-3, 1e-3)),
            4 => writeln!(text, "@m{i} mass {m} 0. 0."),
            _ => writeln!(text, "@m{i} mass {m} {x} {x1}"),
        };
    }
    let mut tie = |text: &mut String, name: String, a: &str, b: &str, which: usize| {
        let (k, z) = (roll(0.02, 0.1), roll(5e-3, 3e-2));
        _ = match which % 5 {
            1 => writeln!(text, "@{name} spring @{a} @{b} {k}"),
            2 => writeln!(text, "@{name} damper @{a} @{b} {z}"),
            3 => writeln!(text, "@{name} nlSpring3 @{a} @{b} {k} {} {z}", roll(0.0, 0.05)),
            _ => writeln!(text, "@{name} springDamper @{a} @{b} {k} {z}"),
        };
    };
    for i in 0..mats {
        tie(&mut text, format!("w{i}"), ["g0", "g1"][i % 2], &format!("m{i}"), 0);
        tie(&mut text, format!("r{i}"), &format!("m{i}"), &format!("m{}", (i + 1) % mats), i);
        tie(&mut text, format!("s{i}"), &format!("m{i}"), &format!("m{}", (i + 5) % mats), i + seed as usize);
    }
    for i in 0..mats {
        _ = writeln!(text, "@out{i} posOutput @m{i}");
    }
    text
}

#[test]
fn drawn_networks_move_as_in_mi_lib_for_a_second() {
    for seed in 1..=4 {
        same(&drawn(seed), &[]);
    }
}

/// The ledger books the force of the first sample as a change from outside and balances.
#[test]
fn the_ledger_counts_the_first_force() {
    let (model, _) = import(&drawn(7), "drawn.mdl");
    let scene = crate::play::audited(&write(&model));
    let mut s = scene.state();
    (0..2000).for_each(|_| tick(&scene, &mut s));
    let ledger = s.ledger.as_ref().expect("a ledger").balance();
    assert!(ledger.changed.abs() > 1e-6, "the first force did no work: {ledger:?}");
    assert!(ledger.residual.abs() < 1e-12 * ledger.peak, "{ledger:?}");
}

/// `start = "mi.lib"` is refused with another scheme than explicit, one tick per sample, not approximated.
#[test]
fn the_start_of_mi_lib_is_refused_where_mi_lib_has_no_like() {
    let first = |model: &str, rate: &str, more: &str| {
        let text = format!(
            "[model]\nstart = \"mi.lib\"\n{model}[rate]\nsound = 44100\n{rate}[SOL]\ng = {{}}\n\
             [MAS]\nm = {{ m = 1, dx0 = 1e-3 }}\n[REF]\nr = {{ between = [\"g\", \"m\"], k = 1, z = 1 }}\n{more}\
             [SOX]\no = {{ from = \"m\" }}\n"
        );
        let (_, result) =
            ca_compile::load(&text, "start.ca.toml", &ca_tests::catalog(), &ca_compile::Options::default());
        result.err().map(|d| (d.list[0].code, text[d.list[0].span().start..].lines().next().unwrap().to_string()))
    };
    let refused = Some(("E010", "\"mi.lib\"".to_string()));
    assert_eq!(first("", "", ""), None);
    assert_eq!(first("method = \"implicit\"\n", "", ""), refused);
    assert_eq!(first("", "oversample = 2\n", ""), refused);
    assert_eq!(
        first(
            "",
            "",
            "[WAVEGUIDE]\nw = { f = 200, t60 = 1, z = 0.8, at = [0.3] }\n[RES]\nx = { between = [\"w[0]\", \"m\"], k = 1 }\n"
        ),
        refused
    );
    let (_, result) = ca_compile::load(
        "[model]\nstart = \"milib\"\n[SOL]\ng = {}\n[SOX]\no = { from = \"g\" }\n",
        "",
        &ca_tests::catalog(),
        &ca_compile::Options::default(),
    );
    assert_eq!(result.err().unwrap().list[0].code, "E011");
}
