//! Reverse mode against forward mode, and its derivatives by port inputs against differences.

use crate::random_models::{Draw, drawn};
use crate::reference::{column, read, tangents};
use ca_gradient::{Forward, Reverse, Tangents};
use cordis_anima::ca_io::gesture::{Gesture, Track};
use cordis_anima::{Loaded, Options};
use std::sync::Arc;

/// Compares gradients of half the sum of squares of the output. Returns whether reverse mode supports the scene.
pub fn both_ways(title: &str, loaded: &Loaded, t: &Tangents, wrong: &mut Vec<String>) -> bool {
    both_ways_within(title, loaded, t, 1e-10, wrong)
}

fn both_ways_within(title: &str, loaded: &Loaded, t: &Tangents, most: f64, wrong: &mut Vec<String>) -> bool {
    let names: Vec<&str> = t.parameters.iter().map(|p| p.name.as_str()).collect();
    by_passes(title, loaded, t, most, wrong);
    let reverse = match Reverse::new(loaded, &Options::default(), &names) {
        Ok(reverse) => reverse,
        Err(e) => {
            println!("{title}: {e}");
            return false;
        }
    };
    let loss = 0.5 * t.output.iter().map(|y| y * y).sum::<f64>();
    let reverse = Arc::new(reverse);
    let found = reverse.gradient(&t.output, None, &mut || true).unwrap_or_else(|e| panic!("{title}: {e}"));
    let played =
        reverse.play(Some(t.frames as f64 / t.rate), None, &mut || true).unwrap_or_else(|e| panic!("{title}: {e}"));
    assert_eq!(played.output, t.output, "{title}: what is heard has other bits");
    let of_it = played.gradient(&t.output, &mut || true).unwrap_or_else(|e| panic!("{title}: {e}"));
    assert_eq!(of_it, found, "{title}: of what was played, it is another gradient");
    let mut worst = 0.0_f64;
    for (k, (p, by)) in t.parameters.iter().zip(&found.parameters).enumerate() {
        let each = || column(t, k).into_iter().zip(&t.output).map(|(t, y)| t * y);
        let (sum, size) = (each().sum::<f64>(), each().map(f64::abs).sum::<f64>());
        // relative to the terms, or to the loss if the parameter changed by its own value
        let off = (sum - by).abs() / (size + loss / p.value.abs().max(1e-3)).max(f64::MIN_POSITIVE);
        worst = worst.max(off);
        let close = off < most;
        wrong.extend((!close).then(|| format!("{title}: by {} {sum:e} forward, {by:e} in reverse, {off:.1e}", p.name)));
    }
    println!("{title}: reverse {worst:.1e} from forward");
    true
}

/// Compares forward mode by the passes of a scene, where supported, with forward mode by dual numbers.
fn by_passes(title: &str, loaded: &Loaded, t: &Tangents, most: f64, wrong: &mut Vec<String>) {
    let names: Vec<&str> = t.parameters.iter().map(|p| p.name.as_str()).collect();
    let forward = Forward::by_passes(loaded, &Options::default(), &names).unwrap_or_else(|e| panic!("{title}: {e}"));
    let Some(forward) = forward else { return };
    let seconds = Some(t.frames as f64 / t.rate);
    let found = forward.tangents(seconds, None, &mut || true).unwrap_or_else(|e| panic!("{title}: {e}"));
    assert_eq!(found.output, t.output, "{title}: what is heard has other bits");
    let loud = t.output.iter().fold(0.0, |most: f64, y| most.max(y.abs()));
    let mut worst = 0.0_f64;
    for (k, p) in t.parameters.iter().enumerate() {
        let (own, other) = (column(t, k), column(&found, k));
        let size = own.iter().fold(0.0, |most: f64, v| most.max(v.abs())) + loud / p.value.abs().max(1e-3);
        let each = own.iter().zip(&other).map(|(a, b)| (a - b).abs());
        let off = each.fold(0.0, f64::max) / size.max(f64::MIN_POSITIVE);
        worst = worst.max(off);
        let close = off < most;
        wrong.extend((!close).then(|| format!("{title}: by {} {off:.1e} by passes from dual numbers", p.name)));
    }
    println!("{title}: by passes {worst:.1e} from dual numbers");
}

/// Forward mode uses the passes for a struck string and a struck mesh, but only for scenes that these support.
#[test]
fn what_is_linear_for_the_most_part_goes_by_passes() {
    let (mut wrong, struck) = (
        Vec::new(),
        "[MAS]\nball = { m = '5 g', x = '-1 mm', v = '0.8 m/s' }\n[BUT]\nhit = { between = ['ball', 'low[9]'], k = '9 kN/m', z = '0.3 N s/m' }\n[SOX]\nout = { from = 'low[3]', gain = 300 }\n",
    );
    for low in [
        "[STRING]\nlow = { n = 90, f = '110 Hz', t60 = '1 s', m = '2 g' }\n",
        "[MESH]\nlow = { nx = 9, ny = 10, f = '200 Hz', t60 = '0.5 s', m = '9 g' }\n",
    ] {
        let loaded = read(&format!("{low}{struck}"));
        let names = ["low.f", "low.t60", "low.m", "hit.k", "hit.z", "ball.m", "ball.v", "ball.x", "out.gain"];
        let known = Forward::by_passes(&loaded, &Options::default(), &names).expect("derivatives");
        assert!(known.is_some(), "{low}");
        by_passes(low, &loaded, &tangents(&loaded, 1500, &names), 1e-10, &mut wrong);
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
    let wave = read(
        "[MAS]\nball = { m = '5 g', dx0 = '1 mm' }\n[WAVEGUIDE]\nlow = { f = '110 Hz', t60 = '6 s', t60_high = '3 s', f_high = '4.4 kHz', tension = '70 N', mu = '4 g/m', at = [0.12, 0.5], m = '5 mg' }\n[RES]\ntie = { between = ['ball', 'low[0]'], k = '1 kN/m' }\n[SOX]\nout = { from = 'ball' }\n",
    );
    assert!(Forward::by_passes(&wave, &Options::default(), &["ball.m"]).expect("derivatives").is_none());
}

/// Scenes with media, filters and ports between masses and outputs, and with different layouts.
const SCENES: &[(&str, &str)] = &[
    (
        "a long string in lanes, forces of its links and on its end heard",
        "[STRING]\nlow = { n = 90, f = '110 Hz', t60 = '1 s', m = '2 g' }\n[MAS]\nball = { m = '5 g', x = '-1 mm', v = '0.8 m/s' }\n[BUT]\nhit = { between = ['ball', 'low[9]'], k = '9 kN/m', z = '0.3 N s/m' }\n[SOX]\nout = { from = 'low[3]' }\nspeed = { from = 'low[8]', hear = 'speed', gain = 0.5 }\n[SOF]\nedge = { from = 'hit', gain = 0.5 }\nsum = { from = 'ball', gain = 0.3 }\nlink = { from = 'low.link[40]', gain = 0.7 }\n",
    ),
    (
        "a skin in lanes, touched between its nodes",
        "[MESH]\nskin = { nx = 9, ny = 10, f = '200 Hz', t60 = '0.5 s', m = '9 g' }\n[MAS]\nball = { m = '5 g', x = '-1 mm', v = '0.8 m/s' }\n[HRZ]\nhit = { between = ['ball', 'skin@0.37,0.61'], k = '1e6 N/m^1.5', h = '0.2 s/m' }\n[REF]\nrag = { between = ['skin[7]', 'skin@0.37,0.61'], k = '500 N/m', z = '0.1 N s/m' }\n[SOF]\nbeside = { from = 'skin[3,6]', gain = 0.2 }\n[SOX]\nout = { from = 'skin@0.37,0.61', dc = '30 Hz' }\n",
    ),
    (
        "a low-pass, and weight",
        "[model]\ngravity = '9.81 m/s^2'\n[rate]\nfilter = '9 kHz'\n[CEL]\nbar = { m = '2 g', f = '330 Hz', t60 = '1 s' }\n[MAS]\nball = { m = '5 g', x = '-1 mm', v = '0.8 m/s' }\n[BUT]\nhit = { between = ['ball', 'bar'], k = '20 kN/m', method = 'stable' }\n[SOX]\nout = { from = 'bar' }\nhigh = { from = 'bar', dc = '20 Hz', hear = 'speed', gain = 0.3 }\n",
    ),
    (
        "a damper and a bow that ports drive",
        "[param]\nforce = { port = 'hand', span = [0, '10 mm'], min = '0.1 N', max = '1 N' }\ndamp = { port = 'palm', span = [0, '5 N'], min = '1 mN s/m', max = '90 mN s/m' }\n[ENX]\nhand = {}\nbow = {}\n[SOL]\nwall = {}\n[CEL]\nbar = { m = '1 g', f = '220 Hz', t60 = '0.5 s' }\nleaf = { m = '2 g', f = '300 Hz', t60 = '0.5 s' }\n[ENF]\npalm = { to = 'leaf' }\n[RES]\ntie = { between = ['bar', 'leaf'], k = '1 kN/m' }\n[FRO]\nfelt = { between = ['wall', 'leaf'], z = 'damp' }\n[BOW]\nrub = { between = ['bar', 'bow'], f = 'force', v0 = '50 mm/s' }\n[SOX]\nout = { from = 'leaf' }\n[gesture]\nbow = [[0, 0], [1, '0.2 m']]\nhand = [[0, '1 mm'], ['10 ms', '7 mm'], ['30 ms', '3 mm']]\npalm = [[0, 0], ['5 ms', '3 N'], ['30 ms', '1 N']]\n",
    ),
    (
        "a port of position and one of force",
        "[CEL]\nbar = { m = '2 g', f = '330 Hz', t60 = '1 s' }\n[ENX]\nkey = {}\n[ENF]\npush = { to = 'bar' }\n[CUB]\nfelt = { between = ['key', 'bar'], k = '2 kN/m', k3 = '1e9 N/m^3', z = '0.4 N s/m' }\n[gesture]\nkey = [[0, '-1 mm'], ['5 ms', '1 mm'], ['9 ms', '0 mm']]\npush = [[0, 0], ['3 ms', '2 N'], ['8 ms', '-1 N']]\n[SOX]\nout = { from = 'bar' }\n[SOF]\nhand = { from = 'key' }\n",
    ),
];

/// Energy-conserving contacts and friction: several act on one mass and are solved together.
const TOGETHER: &[(&str, &str)] = &[
    (
        "a ball between two walls",
        "[SOL]\nleft = { x = '-3 mm' }\nright = { x = '2 mm' }\n[MAS]\nball = { m = '5 g', v = '0.8 m/s' }\n[BUT]\nto_left = { between = ['left', 'ball'], k = '20 kN/m', z = '0.2 N s/m', method = 'stable' }\n[HRZ]\nto_right = { between = ['ball', 'right'], k = '1e6 N/m^1.5', method = 'stable' }\n[SOX]\nout = { from = 'ball', gain = 100 }\n[SOF]\nblow = { from = 'to_right', gain = 0.1 }\nall = { from = 'ball', gain = 0.1 }\n",
    ),
    (
        "a bar that is bowed and struck",
        "[CEL]\nbar = { m = '1 g', f = '220 Hz', t60 = '0.5 s' }\n[MAS]\nbow = { m = '1 kg', v = '0.2 m/s' }\nhammer = { m = '5 g', x = '-1 mm', v = '0.8 m/s' }\n[BOW]\nrub = { between = ['bar', 'bow'], f = '0.3 N', v0 = '50 mm/s', method = 'secant' }\n[HRZ]\nstrike = { between = ['hammer', 'bar'], k = '1e7 N/m^1.5', method = 'stable' }\n[SOX]\nout = { from = 'bar' }\n",
    ),
    (
        "two pairs that share nothing but a wall, beside a contact that is solved by itself",
        "[SOL]\nwall = {}\n[CEL]\na = { m = '2 g', f = '330 Hz', t60 = '1 s' }\nb = { m = '3 g', f = '440 Hz', t60 = '1 s' }\nc = { m = '1 g', f = '500 Hz', t60 = '1 s' }\n[MAS]\nball = { m = '5 g', x = '-1 mm', v = '0.8 m/s' }\nbead = { m = '4 g', x = '-2 mm', v = '1.1 m/s' }\ndrop = { m = '3 g', x = '-1.5 mm', v = '0.9 m/s' }\n[BUT]\nhit = { between = ['ball', 'a'], k = '20 kN/m', method = 'stable' }\nknock = { between = ['bead', 'b'], k = '30 kN/m', method = 'stable' }\nfall = { between = ['drop', 'c'], k = '25 kN/m', method = 'stable' }\n[BOW]\nrub = { between = ['wall', 'a'], f = '0.1 N', v0 = '60 mm/s', method = 'secant' }\nrag = { between = ['b', 'wall'], f = '0.2 N', v0 = '50 mm/s', method = 'secant' }\n[SOX]\nout = { from = 'a' }\nother = { from = 'b', gain = 0.7 }\nlast = { from = 'c', gain = 0.8 }\n",
    ),
    (
        "two balls in space that keep the energy of their blow",
        "[room]\ndim = 3\n[room.MAS]\nball = { m = '5 g', x = ['-4 mm', 0, '0.2 mm'], v = ['0.8 m/s', 0, 0] }\nbead = { m = '4 g', x = ['4 mm', '0.3 mm', 0], v = ['-0.7 m/s', 0, '0.1 m/s'] }\n[room.BUT]\nhit = { between = ['room.ball', 'room.bead'], d = '5 mm', k = '20 kN/m', z = '0.1 N s/m', method = 'stable' }\n[SOX]\nout = { from = 'room.bead', along = [1, 0, 0], gain = 100 }\nup = { from = 'room.bead', along = [0, 0, 1], gain = 100 }\n",
    ),
];

/// Contacts that open together store ever less, down to numbers whose inverse is infinite; derivatives stay finite.
#[test]
fn contacts_that_let_go_together_have_finite_derivatives() {
    let text = "[CEL]\nc = { m = 0.007, f = 822, t60 = 0.7, x = 0.012, v = 0.25 }\n[MAS]\na = { m = '10 g', x = 0.016, v = -1.23 }\nb = { m = '1.7 g', x = 0.020, v = -1.2 }\n[BUT]\nk3 = { between = ['c', 'a'], d = '1.6 mm', k = 12000, z = 3, method = 'stable3d' }\n[HRZ]\nk4 = { between = ['a', 'b'], d = '3.1 mm', k = '33000 N/m^1.5', h = 0.01, method = 'stable3d' }\n[SOX]\no = { from = 'a', gain = 0.1 }\n";
    let (names, mut wrong) = (["a.m", "a.v", "c.m", "k3.k", "k4.k"], Vec::new());
    for (k, text) in [text.to_string(), text.replace("stable3d", "stable")].iter().enumerate() {
        let loaded = read(text);
        let t = tangents(&loaded, 480, &names);
        assert!(t.tangents.iter().all(|v| v.is_finite()), "{k}");
        assert!(both_ways(&format!("{k}"), &loaded, &t, &mut wrong), "{k}");
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn reverse_knows_what_is_solved_together() {
    all_go_back(17, TOGETHER);
}

#[test]
fn reverse_is_forward_however_a_scene_is_laid_out() {
    all_go_back(11, SCENES);
}

fn all_go_back(seed: u64, scenes: &[(&str, &str)]) {
    let (mut draw, mut wrong) = (Draw(seed), Vec::new());
    for (title, text) in scenes {
        let mut loaded = read(text);
        let names = drawn(&mut loaded, &mut draw);
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        let t = tangents(&loaded, 1500, &names);
        assert!(t.tangents.iter().any(|v| *v != 0.0), "{title}");
        assert!(both_ways(title, &loaded, &t, &mut wrong), "{title}");
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

/// Derivatives by the input of a port in one sample, or of a device in one frame, against differences of renders.
#[test]
fn what_ports_are_given_has_its_derivatives() {
    let device = "[CEL]\nbar = { m = '2 g', f = '330 Hz', t60 = '1 s' }\n[TGR]\nkey = { device = 'hand', dof = 0 }\n[CUB]\nfelt = { between = ['key', 'bar'], k = '2 kN/m', k3 = '1e9 N/m^3', z = '0.4 N s/m' }\n[SOX]\nout = { from = 'bar' }\n";
    let held = format!("[rate]\nborder = 'hold'\n{device}");
    let (_, both) = SCENES.last().expect("a scene with ports");
    let drives = device.replace("z = '0.4 N s/m'", "z = 'damp'");
    let drives = format!(
        "[param]\ndamp = {{ port = 'key', span = ['-2 mm', 0], min = '0.1 N s/m', max = '0.9 N s/m' }}\n{drives}"
    );
    for (text, names) in [(*both, &["key", "push"][..]), (device, &["key"]), (&held, &["key"]), (&drives, &["key"])] {
        by_what_is_given(text, names);
    }
}

fn by_what_is_given(text: &str, names: &[&str]) {
    let loaded = read(text);
    let reverse = Arc::new(Reverse::new(&loaded, &Options::default(), &[]).expect("a way back"));
    assert_eq!(reverse.ports().collect::<Vec<_>>(), names);
    let (ticks, rate, n) = (600, reverse.rate(), names.len());
    let track = |port: usize, k: usize| {
        let t = k as f64 / rate;
        if names[port] == "key" { 1e-3 * (t * 700.0).sin() - 1e-3 } else { (t * 900.0).cos() }
    };
    // frames of a device end at ticks 16, 32, …
    let frame = if text.contains("TGR") { 16 } else { 1 };
    let gesture = |moved: Option<(usize, usize, f64)>| {
        let sample =
            |port: usize, k: usize| track(port, k) + moved.filter(|m| (m.0, m.1) == (port, k)).map_or(0.0, |m| m.2);
        let one = |port: usize| Track::sampled(names[port], rate, (0..ticks).map(|k| sample(port, k)).collect());
        Gesture::new((0..n).map(|port| one(port).expect("a track")).collect()).expect("a gesture")
    };
    let play =
        |gesture: &Gesture| reverse.output(Some(ticks as f64 / rate), Some(gesture), &mut || true).expect("a render");
    let own = gesture(None);
    let heard = play(&own);
    let found = reverse.gradient(&heard, Some(&own), &mut || true).expect("a gradient");
    assert_eq!(found.inputs.len(), n * ticks);
    let seconds = Some(ticks as f64 / rate);
    let played = reverse.play(seconds, Some(&own), &mut || true).expect("it plays");
    assert_eq!((played.frames(), &played.output), (ticks, &heard));
    assert_eq!(played.gradient(&heard, &mut || true).expect("a gradient"), found);
    let short = played.gradient(&heard[reverse.outputs()..], &mut || true).expect_err("a sample is missing");
    assert_eq!(short.to_string(), "the cotangent has 599 samples, but 600 were played");
    let loss = |heard: &[f64]| 0.5 * heard.iter().map(|y| y * y).sum::<f64>();
    for k in [0, 1, 2, 16, 32, 150, 400, 576, 592, 598, 599] {
        for (port, name) in names.iter().enumerate() {
            let h = if *name == "key" { 1e-7 } else { 1e-4 };
            let moved = |h: f64| loss(&play(&gesture(Some((port, k, h)))));
            let (difference, by) = ((moved(h) - moved(-h)) / (2.0 * h), found.inputs[n * k + port]);
            assert!(
                (difference - by).abs() <= 1e-6 * by.abs() + 1e-12 * loss(&heard) / h,
                "{k} {port}: {difference:e} {by:e}"
            );
            // the input in the last sample counts only where it ends a frame
            assert!(by != 0.0 || k % frame != 0 || k == 599, "{k} {port}");
        }
    }
}

/// Bundled instruments that sound soon: contacts in space, quadripoles, sets, plectra, tables and friction.
const SOON: &[&str] = &["crystal", "glass", "jack", "maracas", "piano_key", "piano_wire", "rattle", "snare", "wind"];

/// Bundled instruments, by some masses, speeds and springs. Most agree to 1e-10, but `jack`, a stiff body that turns,
/// to 1e-9.
#[test]
fn bundled_instruments_go_back_as_they_go_forward() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../models");
    let mut files: Vec<_> = std::fs::read_dir(folder).expect("models").map(|f| f.expect("a file").path()).collect();
    files.retain(|f| f.extension().is_some_and(|e| e == "toml"));
    files.sort();
    let (mut draw, mut known, mut heard, mut wrong) = (Draw(5), 0, 0, Vec::new());
    for file in files {
        let mut loaded = Loaded::open(&file).expect("a model");
        let title = loaded.name.clone();
        let all = drawn(&mut loaded, &mut draw);
        // a few, evenly spread over the model
        let some = all.iter().step_by(all.len().div_ceil(4).max(1)).map(String::as_str);
        let names: Vec<&str> =
            some.filter(|name| Forward::new(&loaded, &Options::default(), &[name]).is_ok()).collect();
        match Reverse::new(&loaded, &Options::default(), &names) {
            Ok(_) => known += 1,
            Err(e) => println!("{title}: {e}"),
        }
        if !SOON.contains(&&title[..]) {
            continue;
        }
        let forward =
            Forward::by_dual_numbers(&loaded, &Options::default(), &names).unwrap_or_else(|e| panic!("{title}: {e}"));
        let seconds = Some(4000.0 / forward.rate());
        let t = forward.tangents(seconds, None, &mut || true).unwrap_or_else(|e| panic!("{title}: {e}"));
        heard += usize::from(t.tangents.iter().any(|v| *v != 0.0));
        assert!(both_ways_within(&title, &loaded, &t, 1e-8, &mut wrong), "{title}");
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
    // all but one with waveguides and two with a point that a port moves
    assert!(known >= 31 && heard == SOON.len(), "{known} {heard}");
}
