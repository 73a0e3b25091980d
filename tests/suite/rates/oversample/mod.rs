//! Scenes with several ticks per sample: order, the same bits as at the higher rate, devices and inputs, ledgers. A
//! scene without `oversample` has none of it.

mod filter;
mod limits;

use crate::play::{TURN, apart, scene, with, within};
use ca_compile::Options;
use ca_core::internal::border::frame_due;
use ca_core::internal::op::Op;
use ca_core::{InputRole, Scene, State, compute_forces, integrate, tick};
use ca_io::perform::Performance;

/// A model with `times` ticks per sample, and the same model at `times` the sound rate.
fn coarse_and_fine(text: &str, more: &str, times: u32, options: &Options) -> [Scene; 2] {
    let rate = |sound: u32, own: &str| format!("{text}\n[rate]\nsound = {sound}\n{own}\n{more}\n");
    [rate(48_000, &format!("oversample = {times}")), rate(48_000 * times, "")].map(|t| with(&t, options).scene)
}

/// A gesture as a function of the sample number at 48 kHz.
type Hand = fn(f64) -> f64;

/// Advances the finer scene by one tick. Inputs are interpolated linearly over the `times` ticks of a sample.
fn finer(scene: &Scene, s: &mut State, times: u32, hand: Hand) {
    let sample = s.tick.div_ceil(u64::from(times));
    let j = times - (sample * u64::from(times) - s.tick) as u32;
    let sample = sample as f64;
    let (from, to) = (hand(sample - 1.0), hand(sample));
    let line = if j == times { to } else { from + f64::from(j) / f64::from(times) * (to - from) };
    give(scene, s, line, hand);
    tick(scene, s);
}

/// Writes the inputs of a tick: device inputs once a frame, port inputs at once.
fn give(scene: &Scene, s: &mut State, now: f64, hand: Hand) {
    let frame = s.tick.div_ceil(u64::from(scene.rates.ratio)) as f64;
    for (i, of) in scene.inputs.iter().enumerate() {
        if of.role != InputRole::Device {
            s.input[i] = now;
        } else if frame_due(scene, s.tick) {
            s.input[i] = hand(16.0 * frame);
        }
    }
}

/// Plays both for `samples` samples and compares all state bit by bit. Returns the largest displacement.
fn same_bits(what: &str, [coarse, fine]: &[Scene; 2], samples: u32, hand: Hand) -> f64 {
    let times = coarse.oversample();
    let (mut a, mut b, mut most) = (coarse.state(), fine.state(), 0.0f64);
    for n in 0..samples {
        give(coarse, &mut a, hand(f64::from(n)), hand);
        tick(coarse, &mut a);
        while b.tick <= u64::from(n * times) {
            finer(fine, &mut b, times, hand);
        }
        let bits = |v: &[f64]| v.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
        let probes = |scene: &Scene, s: &State| bits(&s.output[scene.counts.channels..]);
        assert_eq!(probes(coarse, &a), probes(fine, &b), "{what}, {times} ticks, sample {n}: probes");
        for (name, a, b) in [
            ("x", &a.x[..], &b.x[..]),
            ("d", &a.d, &b.d),
            ("coef", &a.coef, &b.coef),
            ("mem", &a.links.mem, &b.links.mem),
        ] {
            assert_eq!(bits(a), bits(b), "{what}, {times} ticks, sample {n}: {name}");
        }
        assert!(a.ports.border == b.ports.border && a.ledger == b.ledger, "{what}, {times} ticks, sample {n}");
        assert_eq!((a.tick, b.tick), (u64::from(n) + 1, u64::from(n * times) + 1));
        most = a.x.iter().fold(most, |m, x| m.max(x.abs()));
    }
    if let Some(ledger) = &a.ledger {
        let ledger = ledger.balance();
        within(&format!("{what}, {times} ticks: residual"), ledger.residual.abs() / ledger.peak, 1e-13);
    }
    most
}

const STRUCK: &str = "[STRING]\ns = { n = 12, m = \"2 g\", k = \"40 kN/m\", z = 0.1, zo = 0.01 }\n[MAS]\nh = { m = \"5 g\", \
    x = \"-0.1 mm\", v = 1 }\n[BUT]\nb = { between = [\"h\", \"s[4]\"], k = \"20 kN/m\", z = 0.2 }\n[SOX]\nout = { from = \
    \"s[7]\" }\n";
const BOWED: &str = "[CEL]\nreed = { m = \"1 g\", f = 220, t60 = 0.3 }\n[ENX]\nbow = {}\n[BOW]\nrub = { between = [\"reed\", \
    \"bow\"], f = 0.3, v0 = \"50 mm/s\" }\n[SOX]\nout = { from = \"reed\" }\n[SOF]\nforce = { from = \"rub\", dc = 7 }\n";
const SPACE: &str = "[room]\ndim = 3\ngravity = 9.81\nfriction = 0.01\n[room.SOL]\nground = { x = [0, 0, \"-1 mm\"] }\n[room.MAS]\na = \
    { m = \"2 g\", v = [0.1, 0, -1] }\nb = { m = \"3 g\", x = [\"3 cm\", 0, \"1 cm\"] }\n[REF]\nband = { between = [\"room.a\", \
    \"room.b\"], k = \"2 kN/m\", z = 0.01 }\n[BUT]\nfloor = { between = [\"room.ground\", [\"room.a\", \"room.b\"]], along = \
    \"z\", k = \"5 kN/m\", z = 0.1 }\n[SOF]\nout = { from = \"floor[0]\" }\n";
const WAVES: &str = "[WAVEGUIDE]\ns = { f = 220, t60 = 3, t60_high = 0.5, z = 0.6, at = [0.13, 0.6] }\n[MAS]\nh = { m = \"5 g\", x = \
    \"-0.1 mm\", v = 1 }\n[BUT]\nb = { between = [\"h\", \"s[0]\"], k = \"20 kN/m\", z = 0.2 }\n[SOX]\nout = { from = \"s[1]\" }\n";
const LEANT: &str = "[room]\ndim = 3\n[room.MAS]\na = { m = \"2 g\", v = [0, 0, 1] }\nb = { m = \"2 g\", x = [\"3 cm\", 0, 0], v = [0, \
    0, -1] }\n[STRING]\ns = { n = 12, m = \"2 g\", k = \"400 kN/m\", z = 0.2, zo = 0.01 }\n[LPR]\ne = { between = [\"room.a\", \
    \"room.b\"], onto = [\"s[1]\", \"s[2]\"], k = \"60 kN/m\", z = 0.1 }\n[SOX]\nout = { from = \"s[7]\" }\n";
const MODAL: &str = "[g]\nmethod = \"modal\"\n[g.STRING]\ns = { n = 12, m = \"2 g\", k = \"40 kN/m\", zo = 0.01 }\n[MAS]\nh = { m = \
    \"5 g\", x = \"-0.1 mm\", v = 1 }\n[BUT]\nb = { between = [\"h\", \"g.s[4]\"], k = \"20 kN/m\", z = 0.2 }\n[SOX]\nout = { from = \
    \"g.s[7]\" }\n";
const PUSHED: &str = "[STRING]\ns = { n = 12, m = \"2 g\", k = \"40 kN/m\", zo = 0.01 }\n[ENF]\npush = { to = [\"s[2]\", \"s[3]\"] }\n\
    [ENX]\nspot = {}\n[SOL]\ntop = {}\n[REF]\nslide = { between = [\"top\", \"s@spot\"], k = \"1 kN/m\", z = 0.1 }\n[SOX]\nout = { from \
    = \"s[7]\" }\n";
const KEYED: &str = "[TGR]\nkey = {}\n[MAS]\nh = { m = \"5 g\" }\n[RES]\nshank = { between = [\"key\", \"h\"], k = \"2 kN/m\" }\n[CEL]\nbar \
    = { m = \"1 g\", f = 220, t60 = 1 }\n[BUT]\nb = { between = [\"h\", \"bar\"], k = \"20 kN/m\", z = 0.5 }\n[SOX]\nout = { from = \
    \"bar\" }\n";

fn hand(sample: f64) -> f64 {
    2e-4 * (0.002 * sample).sin()
}

/// Options with the ledger, and a probe at the module of the first output.
fn audited(probe: &str) -> Options {
    Options { energy: true, probes: vec![probe.into()], ..Options::default() }
}

/// Scenes with several ticks per sample match every n-th tick of the scene at the higher rate.
#[test]
fn it_is_the_scene_at_the_higher_rate() {
    let stable = STRUCK.replace("z = 0.2 }\n[SOX]", "z = 0.2, method = \"stable\" }\n[SOX]");
    let [newton, secant] =
        ["newton", "secant"].map(|m| BOWED.replace("mm/s\" }", &format!("mm/s\", method = \"{m}\" }}")));
    let [implicit, centred] = ["implicit", "centred"].map(|m| format!("[model]\nmethod = \"{m}\"\n{STRUCK}"));
    for (what, text, probe) in [
        ("a string that is struck", STRUCK, "s[7]"),
        ("a stable contact", &stable, "s[7]"),
        ("implicit", &implicit, "s[7]"),
        ("centred", &centred, "s[7]"),
        ("a reed that is bowed", BOWED, "reed"),
        ("newton", &newton, "rub"),
        ("secant", &secant, "rub"),
        ("space", SPACE, "room.b"),
        ("waves", WAVES, "s[1]"),
        ("a quadripole", LEANT, "s[7]"),
        ("modes", MODAL, "g.s[7]"),
        ("a push and a moving point", PUSHED, "s[7]"),
    ] {
        for times in [2, 3, 16] {
            let most = same_bits(what, &coarse_and_fine(text, "gesture = 3000", times, &audited(probe)), 700, hand);
            assert!(most > 1e-6, "{what}: {most}");
        }
    }
    let text = STRUCK.replace(", z = 0.1, zo = 0.01", "").replace(", z = 0.2", "");
    let options = Options { energy: false, ..audited("s[7]") };
    let text = format!("[model]\nmethod = \"pefrl\"\n{text}");
    assert!(same_bits("pefrl", &coarse_and_fine(&text, "gesture = 3000", 3, &options), 700, hand) > 1e-6);
}

/// A device at 3 kHz, or at the sound rate, is interpolated over all ticks, with every option of the rate boundary.
#[test]
fn a_hand_is_led_through_all_ticks() {
    for more in ["", "border = \"hold\"", "latency = 2", "feedback = false"] {
        for gesture in [3000, 48_000] {
            let more = format!("gesture = {gesture}\n{more}");
            let scenes = coarse_and_fine(KEYED, &more, 4, &audited("h"));
            assert_eq!((scenes[0].rates.ratio, scenes[0].rates.frame), (48_000 / gesture, 4 * 48_000 / gesture));
            assert_eq!(scenes[1].rates.ratio, scenes[0].rates.frame);
            let most = same_bits(&more, &scenes, 2000, |n| 1e-3 * (0.01 * n).sin());
            assert!(most > 1e-4, "{more}: {most}");
        }
    }
    // the force of a sample is there after the first half of its tick
    let [scene, _] = coarse_and_fine(KEYED, "gesture = 3000", 4, &Options::default());
    let (mut halves, mut whole) = (scene.state(), scene.state());
    for n in 0..200 {
        halves.input[0] = hand(f64::from(n));
        whole.input[0] = halves.input[0];
        compute_forces(&scene, &mut halves);
        assert_eq!(halves.tick, u64::from(n as u32));
        let force = halves.ports.border[0].force;
        integrate(&scene, &mut halves);
        tick(&scene, &mut whole);
        assert!(halves == whole && force.to_bits() == whole.ports.border[0].force.to_bits());
    }
    assert!(whole.ports.border[0].force.abs() > 1e-4);
}

#[test]
fn a_live_parameter_is_ramped_over_the_frame() {
    let text = format!(
        "[param]\nstiff = {{ value = 20000, unit = \"N/m\", live = true, min = 0, max = 30000 }}\n{}",
        STRUCK.replace("k = \"20 kN/m\"", "k = \"stiff\"")
    );
    let [coarse, fine] = coarse_and_fine(&text, "gesture = 3000", 4, &audited("s[7]"));
    let (mut a, mut b) = (coarse.state(), fine.state());
    let run = |a: &mut State, b: &mut State, samples: u32| {
        (0..samples).for_each(|_| tick(&coarse, a));
        (0..4 * samples).for_each(|_| tick(&fine, b));
    };
    // up to the first tick of a frame; the finer scene has three more ticks in it
    tick(&coarse, &mut a);
    tick(&fine, &mut b);
    run(&mut a, &mut b, 32);
    for (scene, s) in [(&coarse, &mut a), (&fine, &mut b)] {
        let patch = scene.controls().set("stiff", 9e3).expect("in range");
        assert!(s.apply(&patch, scene.rates.frame));
    }
    run(&mut a, &mut b, 15);
    assert!(a.ramps.is_moving());
    run(&mut a, &mut b, 1);
    assert!(!a.ramps.is_moving() && !b.ramps.is_moving());
    run(&mut a, &mut b, 500);
    assert_eq!((&a.x, &a.coef, &a.ledger), (&b.x, &b.coef, &b.ledger));
    let still = with(&format!("{text}[rate]\noversample = 4\n"), &audited("s[7]"));
    let mut s = still.state();
    (0..549).for_each(|_| tick(&still, &mut s));
    assert!(apart(&s.x, &a.x) > 1e-9, "the change is felt");
}

/// A gesture with its corners at samples is the same if it is read at each tick.
#[test]
fn gestures_are_the_same() {
    let text = format!(
        "{}{KEYED}[ENX]\nbow = {{}}\n[FRO]\nrub = {{ between = [\"bow\", \"bar\"], z = \"felt\" }}\n[gesture]\nkey = [[0, 0], \
         [0.01, 2e-3], [0.02, 0]]\nbow = [[0, 0], [0.005, 1e-3], [0.02, -1e-3]]\nfelt = [[0, 0], [0.02, 0.1]]\n",
        "[param]\nfelt = { value = 0, unit = \"N s/m\", live = true, min = 0, max = 1 }\n"
    );
    let scenes =
        coarse_and_fine(&text, "gesture = 3000", 4, &Options { probes: vec!["bar".into()], ..Options::default() });
    let [a, b] = scenes.each_ref().map(|scene| {
        let mut p = Performance::new(scene, None).expect("it plays");
        let mut heard = Vec::new();
        for n in 0..4000 / scene.oversample() {
            p.tick();
            if n % (4 / scene.oversample()) == 0 {
                heard.push(p.state.output[scene.counts.channels]);
            }
        }
        heard
    });
    let most = a.iter().fold(0.0f64, |m, v| m.max(v.abs()));
    assert!(most > 1e-4);
    within("gestures", apart(&a, &b) / most, 1e-13);
}

#[test]
fn the_error_falls_with_the_square_of_the_ticks() {
    let w = TURN * 50.0;
    let missed = |times: u32| {
        let text = format!(
            "[rate]\nsound = 2000\noversample = {times}\n[SOL]\nwall = {{}}\n[MAS]\nbob = {{ m = 1, dx0 = 1, v = {:?} }}\n[RES]\nhold = \
             {{ between = [\"wall\", \"bob\"], k = {:?} }}\n[SOX]\nout = {{ from = \"bob\" }}\n",
            0.5 * w,
            w * w
        );
        let scene = with(&text, &Options { probes: vec!["bob".into()], ..Options::default() });
        let mut s = scene.state();
        let error = |n: u32| {
            tick(&scene, &mut s);
            let t = f64::from(n) / 2000.0;
            (s.output[1] - (w * t).cos() - 0.5 * (w * t).sin()).abs()
        };
        (0..400).map(error).fold(0.0, f64::max)
    };
    for times in [4, 16] {
        let fall = missed(times) / missed(2 * times);
        within(&format!("order of {times} ticks − 2"), (fall.log2() - 2.0).abs(), 2e-3);
    }
}

/// Non-finite inputs count once per sample: a position stays, a force becomes zero.
#[test]
fn what_is_no_number_is_refused_once_a_sample() {
    let [scene, _] = coarse_and_fine(PUSHED, "gesture = 3000", 8, &audited("s[7]"));
    let (mut s, mut zero) = (scene.state(), scene.state());
    for n in 0..400 {
        for (i, of) in scene.inputs.iter().enumerate() {
            let bad = n == 100 || n == 101;
            let stays = |v: f64| if of.role == InputRole::Force { 0.0 } else { v };
            s.input[i] = if bad { f64::NAN } else { hand(f64::from(n)) };
            zero.input[i] = if bad { stays(hand(99.0)) } else { s.input[i] };
        }
        tick(&scene, &mut s);
        tick(&scene, &mut zero);
    }
    assert_eq!((s.ports.refused, zero.ports.refused), (4, 0));
    s.ports.refused = 0;
    assert!(s == zero);
}

/// `alg` units count samples, so more ticks do not change the meaning of a model.
#[test]
fn units_are_of_the_sample() {
    let text = |more: &str, rate: &str| {
        scene(&format!(
            "[model]\nunits = \"alg\"\n{more}\n[rate]\n{rate}\n[SOL]\nw = {{}}\n[MAS]\nb = {{ m = 1, dx0 = 1 }}\n[REF]\nr = {{ between = [\"w\", \
             \"b\"], k = 0.01, z = 1e-3 }}\n[SOX]\nout = {{ from = \"b\" }}\n"
        ))
        .state()
    };
    let reference = "reference_rate = 48000";
    assert!(text("", "oversample = 4") == text(reference, "oversample = 4"));
    assert!(text("", "oversample = 4") != text("", ""));
}

/// A clone in the middle of a run continues identically, and the hash covers the interpolated inputs.
#[test]
fn it_is_part_of_the_state() {
    let [scene, _] = coarse_and_fine(BOWED, "gesture = 3000", 4, &Options::default());
    let mut s = scene.state();
    let play = |s: &mut State, from: u32| {
        for n in from..from + 50 {
            s.input[0] = hand(f64::from(n));
            tick(&scene, s);
        }
    };
    play(&mut s, 1);
    let mut copy = s.clone();
    play(&mut s, 51);
    play(&mut copy, 51);
    assert!(s == copy && s.bits() == copy.bits());
    copy.ports.glide[0][1] += 1e-12;
    assert!(s.bits() != copy.bits());
}

fn passes(scene: &Scene) -> Vec<&'static str> {
    let all: [&[Op]; 4] = [&scene.passes.reads, scene.passes.summed(), &scene.passes.writes, &scene.passes.moves];
    all.into_iter().flatten().map(ca_core::internal::op::Op::name).collect()
}

#[test]
fn only_who_asks_has_it() {
    for text in [STRUCK, BOWED, KEYED, PUSHED] {
        let [plain, one, four] =
            ["", "[rate]\noversample = 1\n", "[rate]\noversample = 4\n"].map(|r| scene(&format!("{text}{r}")));
        assert!(
            plain.rates.substeps.is_none()
                && one.rates.substeps.is_none()
                && plain.out.lowpass.is_empty()
                && one.out.lowpass.is_empty()
        );
        assert_eq!(passes(&plain), passes(&one));
        assert!(plain.state() == one.state() && one.state().ports.glide.is_empty());
        let own = ["ticks between", "inputs", "low pass", "to samples", "to ticks"];
        assert!(passes(&plain).iter().all(|p| !own.contains(p)));
        // with `oversample` a scene has these passes in addition, `inputs` only if it has inputs
        let ports = four.inputs.iter().any(|i| i.role != InputRole::Device);
        let had: Vec<_> = passes(&four).into_iter().filter(|p| !own.contains(p)).collect();
        assert_eq!(had, passes(&plain));
        assert_eq!((passes(&four).contains(&"inputs"), four.state().ports.glide.is_empty()), (ports, !ports));
    }
    // without channels there is neither a filter nor an output between samples
    let probed = "[rate]\noversample = 4\n[CEL]\nbar = { m = 1, f = 500, dx0 = 1 }\n";
    let scene = with(probed, &Options { probes: vec!["bar".into()], ..Options::default() });
    assert!(scene.out.lowpass.is_empty() && scene.state().ports.lowpass.is_empty());
    let mut s = scene.state();
    tick(&scene, &mut s);
    s.output.fill(7.0);
    let between = scene.passes.reads[0];
    (between.kernel)(&between, &scene.layout, &mut s);
    assert!(between.name() == "ticks between" && s.output.iter().all(|v| *v == 7.0));
}
