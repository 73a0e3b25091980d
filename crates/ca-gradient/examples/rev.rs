#![allow(missing_docs)]
use ca_gradient::Reverse;
use cordis_anima::{Loaded, Options, tick};
use std::time::Instant;
fn main() {
    let text = std::fs::read_to_string(std::env::args().nth(1).unwrap()).unwrap();
    let names: Vec<String> = std::env::args().skip(2).collect();
    let names: Vec<&str> = names.iter().map(|s| s.as_str()).collect();
    let loaded = Loaded::read(&text, "x.toml");
    let scene = loaded.compile(&Options::default()).unwrap().scene;
    let reverse = Reverse::new(&loaded, &Options::default(), &names).unwrap_or_else(|e| panic!("{e}"));
    let frames = 24000;
    let cot = vec![1.0; frames * scene.n_out];
    let (mut p, mut b) = (f64::INFINITY, f64::INFINITY);
    for _ in 0..7 {
        let (mut s, t) = (scene.state(), Instant::now());
        (0..frames).for_each(|_| tick(&scene, &mut s));
        p = p.min(t.elapsed().as_secs_f64());
        let t = Instant::now();
        let g = reverse.gradient(&cot, None, &mut || true).unwrap();
        b = b.min(t.elapsed().as_secs_f64());
        std::hint::black_box(g);
    }
    println!("{:.0} ns, reverse {:.0} ns: {:.1}", p / frames as f64 * 1e9, b / frames as f64 * 1e9, b / p);
}
