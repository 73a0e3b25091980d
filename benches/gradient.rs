//! Cost and error of derivatives, forward and in reverse.
//!
//! The cost is the time of a sample with several derivatives over the time in a render. The error is the distance from
//! a central difference of renders, and of the two modes from each other. Prints a page; with `UPDATE=1` writes it to
//! `docs/measured/gradients.md`.
//!
//! The page has ratios within one turn, and the median of several turns. Other programs take time too, and some
//! processors change their clock within a second, so that the fastest times of two programs may be at different clocks.
#![allow(missing_docs)]

use ca_benches::{at_most, machine, publish};
use ca_gradient::{Forward, Reverse, Tangents};
use cordis_anima::{Loaded, Options, Scene, tick};
use std::fmt::Write as _;
use std::sync::Arc;
use std::time::Instant;

const HEAD: &str = "# What derivatives cost

Made by `UPDATE=1 cargo bench -p ca-benches --bench gradient`: do not edit.

Half a second of each scene: a render, forward mode with the derivatives of every sample by all parameters, and
reverse mode with the derivatives of one number, the power of the sound. Reverse mode first plays with checkpoints
(*play*), for the loss, and then backwards (*back*); its time does not depend on the number of parameters. Times are
divided by the time of a render, which is only the loop over ticks. The limits are 1 + 1.5 p forward for p parameters,
and in reverse 5 for linear scenes, 8 with contacts.

*Difference* is the largest deviation of derivatives by the first parameter from a central difference of renders,
relative to the largest derivative; it includes the error of the difference itself, and in the bowed bar a contact
that begins in another sample. *Apart* is the deviation of the gradients of both modes from each other, relative to
the sum of the sizes of their terms.
";

/// Title, text, parameters, and the largest time of reverse mode.
type Case = (&'static str, &'static str, &'static [&'static str], f64);

const CASES: &[Case] = &[
    (
        "string of 200, bent at first",
        "[STRING]\nlow = { n = 200, f = '110 Hz', t60 = '4 s', m = '1 g' }\n[MAS]\nbent = { m = '1 g', dx0 = '1 mm' }\n[REF]\nheld = { between = ['bent', 'low[20]'], k = '2 kN/m', z = '0.1 N s/m' }\n[SOX]\nout = { from = 'low[3]', gain = 800 }\n",
        &["bent.dx0", "low.m", "low.f", "low.t60", "held.k", "held.z"],
        5.0,
    ),
    (
        "mesh of 20 × 20, bent at first",
        "[MESH]\nlow = { nx = 20, ny = 20, f = '110 Hz', t60 = '4 s', m = '1 g' }\n[MAS]\nbent = { m = '1 g', dx0 = '1 mm' }\n[REF]\nheld = { between = ['bent', 'low[68]'], k = '2 kN/m', z = '0.1 N s/m' }\n[SOX]\nout = { from = 'low[83]', gain = 800 }\n",
        &["bent.dx0", "low.m", "low.f", "low.t60", "held.k", "held.z"],
        5.0,
    ),
    (
        "string of 40, struck",
        "[STRING]\nlow = { n = 40, f = '110 Hz', t60 = '4 s', m = '1 g' }\n[MAS]\nhammer = { m = '20 g', x = '-5.1 mm', v = '1 m/s' }\n[BUT]\nstrike = { between = ['hammer', 'low[8]'], k = '8 kN/m', z = '0.2 N s/m' }\n[SOX]\nout = { from = 'low[3]', gain = 800 }\n",
        &NAMES,
        8.0,
    ),
    (
        "mesh of 20 × 20, struck",
        "[MESH]\nlow = { nx = 20, ny = 20, f = '110 Hz', t60 = '4 s', m = '1 g' }\n[MAS]\nhammer = { m = '20 g', x = '-5.1 mm', v = '1 m/s' }\n[BUT]\nstrike = { between = ['hammer', 'low[68]'], k = '8 kN/m', z = '0.2 N s/m' }\n[SOX]\nout = { from = 'low[83]', gain = 800 }\n",
        &NAMES,
        8.0,
    ),
    (
        "bowed bar and a clapper",
        "[CEL]\nlow = { m = '1 g', f = '220 Hz', t60 = '0.5 s' }\n[MAS]\nbow = { m = '1 kg', v = '0.2 m/s' }\nhammer = { m = '5 g', x = '-1 mm', v = '0.8 m/s' }\n[BOW]\nrub = { between = ['low', 'bow'], f = '0.3 N', v0 = '50 mm/s', method = 'secant' }\n[HRZ]\nstrike = { between = ['hammer', 'low'], k = '1e7 N/m^1.5', method = 'stable' }\n[SOX]\nout = { from = 'low' }\n",
        &NAMES,
        8.0,
    ),
];
const NAMES: [&str; 7] = ["hammer.v", "hammer.m", "hammer.x", "strike.k", "low.m", "low.f", "low.t60"];

fn timed<T>(call: impl FnOnce() -> T) -> (f64, T) {
    let begin = Instant::now();
    let made = call();
    (begin.elapsed().as_secs_f64(), made)
}

fn rendered(scene: &Scene, frames: usize) -> Vec<f64> {
    let mut s = scene.state();
    let sample = |_| {
        tick(scene, &mut s);
        s.output[0]
    };
    (0..frames).map(sample).collect()
}

/// Returns the distance of the derivatives by the first parameter from a central difference, relative to the largest.
fn from_difference(loaded: &Loaded, name: &str, t: &Tangents) -> f64 {
    let (p, h) = (&t.parameters[0], 1e-7);
    let moved = |v: f64| {
        let mut other = loaded.clone();
        assert!(other.model.put(name, format!("{v:e} {}", p.unit).into()));
        rendered(&other.compile(&Options::default()).expect("a scene").scene, t.frames)
    };
    let (up, down) = (moved(p.value + h), moved(p.value - h));
    let exact = up.iter().zip(&down).map(|(u, d)| (u - d) / (2.0 * h));
    let by = t.tangents.iter().step_by(t.parameters.len());
    let (off, most) =
        exact.zip(by).fold((0.0_f64, 0.0_f64), |(off, most), (e, by)| (off.max((e - by).abs()), most.max(e.abs())));
    off / most
}

/// Returns the distance of a gradient of the power from forward mode, relative to the sum of the sizes of its terms.
fn apart(t: &Tangents, gradient: &[f64]) -> f64 {
    let p = gradient.len();
    let of = |q: usize| {
        let terms = t.output.iter().zip(t.tangents.chunks_exact(p)).map(|(v, by)| v * by[q]);
        let (sum, sizes) = terms.fold((0.0, f64::MIN_POSITIVE), |(sum, sizes), v| (sum + v, sizes + f64::abs(v)));
        (sum - gradient[q]).abs() / sizes
    };
    (0..p).map(of).fold(0.0, f64::max)
}

fn median(mut all: Vec<f64>) -> f64 {
    all.sort_by(f64::total_cmp);
    all[all.len() / 2]
}

fn row(case: &Case, frames: usize, turns: usize) -> String {
    let (title, text, names, most) = case;
    let loaded = Loaded::read(text, "cost.ca.toml");
    let scene = loaded.compile(&Options::default()).expect("a scene").scene;
    let forward = Forward::new(&loaded, &Options::default(), names).expect("derivatives");
    let reverse = Reverse::new(&loaded, &Options::default(), names).map(Arc::new);
    let seconds = Some(frames as f64 / scene.rate);
    let render = || {
        let mut s = scene.state();
        timed(|| (0..frames).for_each(|_| tick(&scene, &mut s))).0
    };
    // renders, and times relative to the renders before and after
    let [mut plain, mut dual, mut play, mut back, mut both] = [const { Vec::new() }; 5];
    let mut found = None;
    for _ in 0..turns {
        let mut over = |time: f64, before: f64| {
            let after = render();
            plain.extend([before, after]);
            2.0 * time / (before + after)
        };
        let before = render();
        let (time, t) = timed(|| forward.tangents(seconds, None, &mut || true).expect("derivatives"));
        dual.push(over(time, before));
        let mut gradient = None;
        if let Ok(reverse) = &reverse {
            let before = render();
            let (first, played) = timed(|| reverse.play(seconds, None, &mut || true).expect("it plays"));
            let (then, g) = timed(|| played.gradient(&t.output, &mut || true).expect("a gradient"));
            let all = over(first + then, before);
            both.push(all);
            play.push(all * first / (first + then));
            back.push(all * then / (first + then));
            gradient = Some(g.parameters);
        }
        found = Some((t, gradient));
    }
    let (t, gradient) = found.expect("a turn");
    let (ns, p) = (median(plain) / frames as f64 * 1e9, names.len());
    let reverse = match &gradient {
        Some(g) => {
            let all = at_most(median(both), 1, Some(*most));
            format!("{:.1} | {:.1} | {all} | {:.0e}", median(play), median(back), apart(&t, g))
        }
        None => "– | – | not known | –".into(),
    };
    let forward = at_most(median(dual), 1, Some(1.0 + 1.5 * p as f64));
    format!("| {title} | {ns:.0} | {p} | {forward} | {reverse} | {:.0e} |", from_difference(&loaded, names[0], &t))
}

fn main() {
    // `cargo test --benches` only checks that it runs
    let long = std::env::args().any(|a| a == "--bench");
    let (frames, turns, cases) = if long { (24_000, 15, CASES) } else { (400, 1, &CASES[..1]) };
    let mut page = format!("{HEAD}\nThe machine of this page is {}.\n\n", machine());
    page += "| scene | a render [ns a sample] | p | forward | play | back | reverse | apart | difference |\n|---|---|---|---|---|---|---|---|---|\n";
    for case in cases {
        let _ = writeln!(page, "{}", row(case, frames, turns));
    }
    page += SHORT;
    publish("gradients", &page, long);
}

const SHORT: &str = "
Reasons for values beyond the limits, from samples of the processor (`perf record` of this bench):

- *Forward.* For the string of 200, half of the time is the fused pass, of the render and of six states of
  derivatives. A fifth is the forces of changed numbers, computed once per sample. The rest is the short passes of
  each state: a link at its side, the outputs, copies.
- *Reverse.* The passes run three times: to play, to play again from checkpoints, and backwards. Sums of the adjoints
  of numbers take a fifth; the rest is copies of the ticks that are played again.
- *Bowed bar.* A scene of three masses, in which the backward pass computes the links that are solved together over
  dual numbers, for seven of their input numbers at a time.
";
