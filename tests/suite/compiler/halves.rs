//! A scene in two halves, played by two threads: the bits of the whole link by link, and the same to rounding by the fast
//! passes, whatever is cut, heard, driven or diverges; and no cut where something needs all of it.

use crate::play::{Random, model, with};
use ca_compile::{KernelClass, Options};
use ca_core::scene::Halves;
use ca_io::gesture::{Gesture, Track};
use ca_io::perform::Performance;
use ca_io::{FileError, FileErrorKind};
use ca_tests::{catalog, texts};
use std::fmt::Write as _;

/// The halves of a model, or why there are none.
fn cut(text: &str, options: &Options) -> Result<Halves, String> {
    ca_compile::halves(&model(text), &catalog(), options, &with(text, options))
}

/// Plays `text` whole and in halves, and compares what is heard, and where all ends.
fn same(text: &str, probes: &[&str], gesture: Option<&Gesture>, frames: u64) -> Result<Halves, String> {
    for kernel in [KernelClass::Fast, KernelClass::Reference] {
        let options = Options { kernel, probes: probes.iter().map(|p| (*p).into()).collect(), ..Options::default() };
        let halves = cut(text, &options)?;
        let scene = with(text, &options);
        let mut whole = Performance::new(&scene, gesture).expect("a gesture that fits");
        let mut rows = Vec::new();
        for _ in 0..frames {
            whole.tick();
            rows.extend_from_slice(&whole.state.output);
        }
        let begun = Performance::new(&scene, gesture).expect("a gesture that fits");
        let mut heard = Vec::new();
        let mut sink = |rows: &[f64], done: u64| {
            heard.extend_from_slice(rows);
            assert_eq!(heard.len() as u64, done * scene.n_out as u64);
            Ok::<(), FileError>(())
        };
        let ended = ca_io::halves::play(begun, &halves, gesture, (frames, 250), &mut sink);
        let ended = ended.expect("a gesture that fits, and a sink that takes all");
        assert_eq!(rows.len(), heard.len(), "{text}");
        let moved = |[_, at]: &[u32; 2]| *at as usize;
        let places: Vec<usize> = halves.halves.iter().flat_map(|h| h.own.iter().map(moved)).collect();
        let at = |all: &[f64]| places.iter().map(|i| all[*i]).collect::<Vec<_>>();
        let columns = [
            ("output", rows, heard),
            ("x", at(&whole.state.x), at(&ended.state.x)),
            ("d", at(&whole.state.d), at(&ended.state.d)),
        ];
        for (what, whole, parts) in &columns {
            // rows are found in each half by itself, and sum in another order where that pays
            let peak = whole.iter().fold(0.0, |p: f64, v| p.max(v.abs()));
            let tolerance = if kernel == KernelClass::Reference { 0.0 } else { 1e-9 * peak };
            let near = |a: f64, b: f64| a.to_bits() == b.to_bits() || (a - b).abs() <= tolerance;
            let differs = |(a, b): (&f64, &f64)| !near(*a, *b);
            let first = whole.iter().zip(parts).position(differs);
            if let Some(i) = first {
                panic!(
                    "{kernel:?}: {what} of {i} is {} in halves, {} in the whole, of {peak}:\n{text}",
                    parts[i], whole[i]
                );
            }
        }
        assert_eq!((whole.state.tick, whole.diverged), (ended.state.tick, ended.diverged), "{text}");
    }
    cut(text, &Options::default())
}

/// Masses, and links between any two of them; every third a contact.
fn random(seed: u64, n: usize, space: bool) -> String {
    let mut random = Random(seed);
    // a group of its own, on a line or in space
    let (dim, ground) = if space { ("3\ngravity = [0, 0, -9.81]", "{ x = [0, 0, 0] }") } else { ("1", "{}") };
    let mut text = format!("[w]\ndim = {dim}\n[w.SOL]\ng = {ground}\n[w.MAS]\n");
    for i in 0..n {
        let [x, y, z] = [0; 3].map(|_| 0.1 * random.uniform());
        let at = if space { format!("[{x}, {y}, {z}]") } else { format!("{x}") };
        let v = if i % 7 == 0 { if space { ", v = [0.1, 0, 0.2]" } else { ", v = 0.1" } } else { "" };
        let _ = writeln!(text, "m{i} = {{ m = \"{} g\", x = {at}{v} }}", 1 + i % 3);
    }
    let pair = |random: &mut Random| {
        let [a, b] = [0; 2].map(|_| ((random.uniform() + 1.0) * 0.5 * n as f64) as usize % n);
        (a, if a == b { (b + 1) % n } else { b })
    };
    text += "[w.REF]\n";
    for i in 0..n {
        let _ = writeln!(text, "g{i} = {{ between = [\"w.g\", \"w.m{i}\"], k = 20, z = 1e-3 }}");
    }
    for i in 0..n {
        let (a, b) = pair(&mut random);
        let _ = writeln!(text, "r{i} = {{ between = [\"w.m{a}\", \"w.m{b}\"], k = 400, z = 1e-2 }}");
    }
    text += "[w.BUT]\n";
    for i in 0..n / 3 {
        let (a, b) = pair(&mut random);
        let _ = writeln!(text, "b{i} = {{ between = [\"w.m{a}\", \"w.m{b}\"], k = 900, z = 1e-2 }}");
    }
    let along = if space { ", along = [1, 0, 0]" } else { "" };
    let _ = writeln!(text, "[SOX]\nleft = {{ from = \"w.m0\"{along} }}\nright = {{ from = \"w.m{}\"{along} }}", n - 1);
    text
}

#[test]
fn a_string_and_a_mesh_have_the_bits_of_the_whole() {
    let string = "[STRING]\ns = { n = 201, m = \"1 g\", k = \"100 kN/m\", z = 0.1 }\n[MAS]\nh = { m = \"5 g\", x = \"-0.1 mm\", v = 1 \
                  }\n[BUT]\nb = { between = [\"h\", \"s[4]\"], k = \"20 kN/m\", z = 0.2 }\n[SOX]\nout = { from = \"s[7]\", channel = 0 }\n\
                  far = { from = \"s[190]\", channel = 0 }\n[SOF]\nbridge = { from = \"s[150]\" }\n";
    let halves = same(string, &["s[100]", "s[99]", "s[101]", "b"], None, 3000).expect("it is cut");
    assert!(halves.across <= 2, "{}", halves.across);
    assert!((0.5..0.53).contains(&halves.share), "{}", halves.share);
    let mesh = "[MESH]\nm = { nx = 24, ny = 20, m = \"1 g\", k = \"50 kN/m\", z = 0.05 }\n[MAS]\nh = { m = \"5 g\", v = 1 }\n[BUT]\nb = { \
                between = [\"h\", \"m[4,3]\"], k = 9e3 }\n[SOX]\nout = { from = \"m[12,10]\" }\n";
    let halves = same(mesh, &["m[0,0]", "m[23,19]"], None, 2000).expect("it is cut");
    assert!(halves.share < 0.6 && halves.across < 40, "{} {}", halves.share, halves.across);
}

#[test]
fn what_is_linked_at_random_has_the_bits_of_the_whole() {
    for seed in 1..6 {
        for space in [false, true] {
            same(&random(seed * 77, 40, space), &[], None, 1200).expect("it is cut");
        }
    }
}

/// Two strings that nothing ties together are cut between them, and a port or a live parameter acts in both.
#[test]
fn gestures_and_live_parameters_reach_both_halves() {
    let text = "[param]\ndial = { value = 0.1, unit = \"N s/m\", live = true, min = 0.05, max = 0.2 }\n[ENX]\nkey = {}\n[STRING]\na = \
                { n = 60, m = \"1 g\", k = \"90 kN/m\", z = \"dial\" }\nb = { n = 60, m = \"1 g\", k = \"80 kN/m\", z = \"dial\" \
                }\n[BUT]\nka = { between = [\"key\", \"a[9]\"], k = \"9 kN/m\" }\nkb = { between = [\"key\", \"b[9]\"], k = \"9 kN/m\" \
                }\n[ENF]\npush = { to = \"b[30]\" }\n[SOX]\nout = { from = \"a[7]\" }\nfar = { from = \"b[7]\" }\n";
    let track = |name: &str, points: &[(f64, f64)]| Track::points(name, points.to_vec()).expect("a track");
    let gesture = Gesture::new(vec![
        track("key", &[(0.0, -1e-3), (0.01, 1e-3), (0.02, -1e-3)]),
        track("dial", &[(0.0, 0.1), (0.03, 0.2)]),
        track("push", &[(0.01, 0.0), (0.02, 0.5)]),
    ])
    .expect("a gesture");
    let halves = same(text, &["a[1]", "kb"], Some(&gesture), 2400).expect("it is cut");
    assert_eq!(halves.across, 0);
}

#[test]
fn what_diverges_is_silent_in_both_halves_from_the_same_tick_on() {
    let text = "[STRING]\ns = { n = 80, m = \"1 g\", k = \"1 MN/m\" }\n[MAS]\nh = { m = \"5 g\", v = 1 }\n[RES]\nb = { between = [\"h\", \
                \"s[4]\"], k = \"20 MN/m\" }\n[SOX]\nout = { from = \"s[7]\" }\nfar = { from = \"s[70]\" }\n";
    // which half is ahead of the other is chance
    for _ in 0..20 {
        same(text, &["s[79]"], None, 2000).expect("it is cut");
    }
}

/// Each bundled model is cut, or says why it is not.
#[test]
fn bundled_models_have_the_bits_of_the_whole() {
    let mut cuts = Vec::new();
    for (name, text) in texts() {
        match same(&text, &[], None, 1500) {
            Ok(_) => cuts.push(name),
            Err(why) => assert!(why.len() > 10 && why != "it has errors", "{name}: {why}"),
        }
    }
    assert!(cuts.len() >= 10, "{cuts:?}");
}

#[test]
fn what_needs_all_of_it_is_not_cut_and_says_so() {
    let string = "[STRING]\ns = { n = 30, m = \"1 g\", k = \"10 kN/m\" }\n[SOX]\nout = { from = \"s[7]\" }\n";
    let refused = |text: &str, options: &Options, why: &str| {
        let said = cut(text, options).expect_err(why);
        assert!(said.contains(why), "{said}");
    };
    refused(string, &Options { energy: true, ..Options::default() }, "energy ledger");
    let plain = Options::default();
    refused(&format!("{string}[rate]\noversample = 2\n"), &plain, "several ticks");
    refused(&format!("{string}[model]\nmethod = \"pefrl\"\n"), &plain, "several times");
    refused("[CEL]\na = { f = \"440 Hz\", m = \"1 g\", v = 1 }\n[SOX]\nout = { from = \"a\" }\n", &plain, "no link");
    refused(&format!("{string}[model]\nstart = \"mi.lib\"\n"), &plain, "mi.lib");
    let live = "[param]\nkk = { value = 100, unit = \"N/m\", live = true, min = 0, max = 1000 }\n[SOL]\ng = {}\n[REF]\nl = { between = \
                [\"b\", \"g\"], k = \"kk\", method = \"implicit\" }\n[RES]\nr = { between = [\"b\", \"c\"], k = \"kk\" }\n[CEL]\nb = { \
                m = \"2 g\", f = 357, dx0 = \"1 mm\" }\nc = { m = \"2 g\", f = 357 }\n[SOX]\no = { from = \"c\" }\n";
    refused(live, &plain, "live parameter");
    // a port that an implicit link holds is under way for all
    let port = "[ENX]\ng = {}\n[REF]\nl1 = { between = [\"a\", \"g\"], k = 1000, method = \"implicit\" }\nl2 = { between = [\"b\", \"g\"], k \
                = 1000, z = 1 }\n[CEL]\na = { m = \"2 g\", f = 244 }\nb = { m = \"2 g\", f = 183 }\n[SOX]\no = { from = \"a\" }\np = { from = \"b\" \
                }\n[gesture]\ng = [[0, 0], [0.02, \"-10 mm\"]]\n";
    refused(port, &plain, "solved at once");
    let implicit = format!("{string}[model]\nmethod = \"implicit\"\n");
    refused(&implicit, &plain, "solved at once");
}

/// Who hears no more ends both threads.
#[test]
fn a_sink_that_fails_ends_both_threads() {
    let text = "[STRING]\ns = { n = 30, m = \"1 g\", k = \"10 kN/m\" }\n[SOX]\nout = { from = \"s[7]\" }\n";
    let halves = cut(text, &Options::default()).expect("it is cut");
    let scene = with(text, &Options::default());
    let whole = Performance::new(&scene, None).expect("no gesture");
    let mut blocks = 0;
    let mut sink = |_: &[f64], _| {
        blocks += 1;
        if blocks < 5 { Ok(()) } else { Err(FileError::new(FileErrorKind::Usage, "full")) }
    };
    let ended = ca_io::halves::play(whole, &halves, None, (1 << 40, 100), &mut sink);
    assert_eq!(ended.err().map(|e| e.to_string()).as_deref(), Some("full"));
}
