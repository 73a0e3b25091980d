//! The moving picture of the README: a string in slow motion after a stroke of its hammer, as SVG. `UPDATE=1 cargo test
//! $ALL --test suite -- moving_picture` writes it (`$ALL` is in CONTRIBUTING.md).

use ca_io::perform::Performance;
use cordis_anima::{Loaded, Options};
use std::fmt::Write as _;
use std::path::PathBuf;

/// Masses of the string.
const MASSES: usize = 79;
/// Place of the hammer at load \[m\], and the mass that it strikes, as the model has them.
const HAMMER: f64 = -8e-3;
const STRUCK: usize = 8;
/// Pictures, ticks between two of them, and the time for which one is shown \[s\].
const PICTURES: usize = 56;
const TICKS: usize = 16;
const SHOWN: f64 = 0.08;
/// Size \[px\]: of the picture, of the largest displacement of the string, and of its distance from the edge.
const SIZE: [f64; 2] = [640.0, 240.0];
const AMPLITUDE: f64 = 70.0;
const MARGIN: f64 = 30.0;

/// The displacements of the string and the place of the hammer \[m\], from 2 ms before the string first moves.
fn film() -> Vec<(Vec<f64>, f64)> {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../models/hammered_string.ca.toml");
    let scene = Loaded::open(folder).expect("a bundled model").compile(&Options::default()).expect("it compiles").scene;
    let place = |name: &str| {
        let at = scene.symbols.iter().position(|s| s.name == *name).expect("such a mass");
        scene.symbols.places()[at] as usize
    };
    let string: Vec<usize> = (0..MASSES).map(|i| place(&format!("low[{i}]"))).collect();
    let hammer = place("hammer");
    let mut p = Performance::new(&scene, None).expect("its own gesture");
    let mut before: Vec<(Vec<f64>, f64)> = Vec::new();
    let mut all = Vec::new();
    while all.len() < PICTURES {
        p.tick();
        if !p.state.tick.is_multiple_of(TICKS as u64) {
            continue;
        }
        let line: Vec<f64> = string.iter().map(|i| p.state.x[*i]).collect();
        // the picture leaves out the thickness of the felt
        let place = (HAMMER + p.state.x[hammer]).min(line[STRUCK]);
        let now = (line, place);
        let moves = now.0.iter().any(|x| x.abs() > 1e-5);
        if all.is_empty() && !moves {
            before.push(now);
            continue;
        }
        if all.is_empty() {
            all.extend(before.drain(before.len().saturating_sub(6)..));
        }
        all.push(now);
    }
    all
}

fn svg(film: &[(Vec<f64>, f64)]) -> String {
    let largest = film.iter().flat_map(|f| &f.0).fold(0.0, |m: f64, x| m.max(x.abs()));
    let scale = AMPLITUDE / largest;
    let (middle, step) = (0.45 * SIZE[1], (SIZE[0] - 2.0 * MARGIN) / (MASSES + 1) as f64);
    let x = |i: usize| MARGIN + step * i as f64;
    let line = |at: &[f64]| {
        let mut points = format!("{:.1},{middle:.1}", x(0));
        for (i, y) in at.iter().enumerate() {
            let _ = write!(points, " {:.1},{:.1}", x(i + 1), middle - scale * y);
        }
        points + &format!(" {:.1},{middle:.1}", x(MASSES + 1))
    };
    // the hammer touches the string at displacement 0
    let radius = 11.0;
    let under = |y: f64| (middle + radius + 2.0 - scale * y).min(SIZE[1] + 40.0);
    let lines: Vec<String> = film.iter().map(|f| line(&f.0)).collect();
    let heights: Vec<String> = film.iter().map(|f| format!("{:.1}", under(f.1))).collect();
    let seconds = SHOWN * film.len() as f64;
    let repeats = format!("dur=\"{seconds:.2}s\" repeatCount=\"indefinite\"");
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {w} {h}\" width=\"{w}\" height=\"{h}\" role=\"img\">\n\
         <title>A string after a stroke of its hammer, {slow:.0} times slower; displacements are enlarged {times:.0} times</title>\n\
         <rect width=\"{w}\" height=\"{h}\" rx=\"10\" fill=\"#10141a\"/>\n\
         <polyline fill=\"none\" stroke=\"#4aa8e8\" stroke-width=\"3\" stroke-linejoin=\"round\" points=\"{first}\">\
         <animate attributeName=\"points\" {repeats} values=\"{lines}\"/></polyline>\n\
         <circle cx=\"{hammer:.1}\" cy=\"{start}\" r=\"{radius}\" fill=\"#f2c14e\">\
         <animate attributeName=\"cy\" {repeats} values=\"{heights}\"/></circle>\n\
         <circle cx=\"{left:.1}\" cy=\"{middle:.1}\" r=\"5\" fill=\"#9aa6b4\"/>\
         <circle cx=\"{right:.1}\" cy=\"{middle:.1}\" r=\"5\" fill=\"#9aa6b4\"/>\n</svg>\n",
        w = SIZE[0],
        h = SIZE[1],
        slow = SHOWN * 48_000.0 / TICKS as f64,
        // of 96 px an inch
        times = scale * 25.4e-3 / 96.0,
        first = lines[0],
        lines = lines.join(";"),
        hammer = x(STRUCK + 1),
        start = heights[0],
        heights = heights.join(";"),
        left = x(0),
        right = x(MASSES + 1),
    )
}

#[test]
fn the_moving_picture_is_of_this_engine() {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../docs/pictures/hammered_string.svg");
    let is = svg(&film());
    if std::env::var_os("UPDATE").is_some() {
        std::fs::write(&path, &is).expect("it can be written");
    }
    let was = std::fs::read_to_string(&path).unwrap_or_default();
    assert!(was == is, "docs/pictures/hammered_string.svg is of another build; see the header of this file");
}
