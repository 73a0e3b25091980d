//! What derivatives cost: the time of a tick with several of them over that of a render, in one run, forward and in reverse, beside how
//! far they are from a central difference of renders. In reverse what is heard is played with checkpoints, for the loss, and then gone
//! back over.
//!
//! `cargo run --release -p ca-gradient --example cost`

use ca_gradient::{Forward, Reverse};
use cordis_anima::{Loaded, Options, tick};
use std::sync::Arc;
use std::time::Instant;

const SCENES: &[(&str, &str, &[&str])] = &[
    (
        "a string of 200, which starts bent",
        "[STRING]\nlow = { n = 200, f = '110 Hz', t60 = '4 s', m = '1 g' }\n[MAS]\nbent = { m = '1 g', dx0 = '1 mm' }\n[REF]\nheld = { between = ['bent', 'low[20]'], k = '2 kN/m', z = '0.1 N s/m' }\n[SOX]\nout = { from = 'low[3]', gain = 800 }\n",
        &["bent.dx0", "low.m", "low.f", "low.t60", "held.k", "held.z"],
    ),
    (
        "a mesh of 20 × 20, which starts bent",
        "[MESH]\nlow = { nx = 20, ny = 20, f = '110 Hz', t60 = '4 s', m = '1 g' }\n[MAS]\nbent = { m = '1 g', dx0 = '1 mm' }\n[REF]\nheld = { between = ['bent', 'low[68]'], k = '2 kN/m', z = '0.1 N s/m' }\n[SOX]\nout = { from = 'low[83]', gain = 800 }\n",
        &["bent.dx0", "low.m", "low.f", "low.t60", "held.k", "held.z"],
    ),
    (
        "a struck string of 40",
        "[STRING]\nlow = { n = 40, f = '110 Hz', t60 = '4 s', m = '1 g' }\n[MAS]\nhammer = { m = '20 g', x = '-5.1 mm', v = '1 m/s' }\n[BUT]\nstrike = { between = ['hammer', 'low[8]'], k = '8 kN/m', z = '0.2 N s/m' }\n[SOX]\nout = { from = 'low[3]', gain = 800 }\n",
        &NAMES,
    ),
    (
        "a mesh of 20 × 20, struck",
        "[MESH]\nlow = { nx = 20, ny = 20, f = '110 Hz', t60 = '4 s', m = '1 g' }\n[MAS]\nhammer = { m = '20 g', x = '-5.1 mm', v = '1 m/s' }\n[BUT]\nstrike = { between = ['hammer', 'low[68]'], k = '8 kN/m', z = '0.2 N s/m' }\n[SOX]\nout = { from = 'low[83]', gain = 800 }\n",
        &NAMES,
    ),
    (
        "a bowed bar and a clapper",
        "[CEL]\nlow = { m = '1 g', f = '220 Hz', t60 = '0.5 s' }\n[MAS]\nbow = { m = '1 kg', v = '0.2 m/s' }\nhammer = { m = '5 g', x = '-1 mm', v = '0.8 m/s' }\n[BOW]\nrub = { between = ['low', 'bow'], f = '0.3 N', v0 = '50 mm/s', method = 'secant' }\n[HRZ]\nstrike = { between = ['hammer', 'low'], k = '1e7 N/m^1.5', method = 'stable' }\n[SOX]\nout = { from = 'low' }\n",
        &NAMES,
    ),
];
const NAMES: [&str; 7] = ["hammer.v", "hammer.m", "hammer.x", "strike.k", "low.m", "low.f", "low.t60"];
const FRAMES: usize = 24_000;

fn main() {
    for (title, text, names) in SCENES {
        let loaded = Loaded::read(text, "cost.ca.toml");
        let scene = loaded.compile(&Options::default()).expect("a scene").scene;
        let forward = Forward::new(&loaded, &Options::default(), names).expect("derivatives");
        let seconds = Some(FRAMES as f64 / scene.rate);
        // the best of several, in turns: other programs take time too
        let reverse = Reverse::new(&loaded, &Options::default(), names).map(Arc::new);
        let [mut plain, mut dual, mut play, mut back] = [f64::INFINITY; 4];
        let mut t = None;
        for _ in 0..7 {
            let (mut s, begin) = (scene.state(), Instant::now());
            (0..FRAMES).for_each(|_| tick(&scene, &mut s));
            plain = plain.min(begin.elapsed().as_secs_f64());
            let begin = Instant::now();
            t = Some(forward.tangents(seconds, None, &mut || true).expect("derivatives"));
            dual = dual.min(begin.elapsed().as_secs_f64());
            if let (Ok(reverse), Some(t)) = (&reverse, &t) {
                let begin = Instant::now();
                let played = reverse.play(seconds, None, &mut || true).expect("it plays");
                play = play.min(begin.elapsed().as_secs_f64());
                let begin = Instant::now();
                let g = played.gradient(&t.output, &mut || true).expect("a gradient");
                back = back.min(begin.elapsed().as_secs_f64());
                assert!(g.parameters[0].is_finite());
            }
        }
        let t = t.expect("it was played");
        let h = 1e-7;
        let moved = |v: f64| {
            let mut other = loaded.clone();
            assert!(other.model.put(names[0], format!("{v:e} {}", t.parameters[0].unit).into()));
            let scene = other.compile(&Options::default()).expect("a scene").scene;
            let mut s = scene.state();
            let all = (0..FRAMES).map(|_| {
                tick(&scene, &mut s);
                s.output[0]
            });
            all.collect::<Vec<f64>>()
        };
        let v = t.parameters[0].value;
        let (up, down) = (moved(v + h), moved(v - h));
        let exact = up.iter().zip(&down).map(|(u, d)| (u - d) / (2.0 * h));
        let (mut off, mut most) = (0.0_f64, 0.0_f64);
        for (e, by) in exact.zip(t.tangents.iter().step_by(names.len())) {
            (off, most) = (off.max((e - by).abs()), most.max(e.abs()));
        }
        let ns = |s: f64| s / FRAMES as f64 * 1e9;
        println!(
            "{title}: {:.0} ns a tick, with {} derivatives {:.0} ns: {:.1} renders; {:.0e} from a difference",
            ns(plain),
            names.len(),
            ns(dual),
            dual / plain,
            off / most
        );
        match &reverse {
            Ok(_) => println!(
                "    in reverse {:.0} ns: {:.1} renders, whatever the number of parameters, behind a play with checkpoints of {:.1}",
                ns(back),
                back / plain,
                play / plain
            ),
            Err(e) => println!("    {e}"),
        }
    }
}
