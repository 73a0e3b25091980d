//! Tests that a decoded film equals the performance to half a step of 16 bits, and that films of large scenes are
//! small.

use super::check::{compiled, models};
use ca_view::{Drawing, Film};
use cordis_anima::ca_core::Scene;
use flate2::read::ZlibDecoder;
use std::io::Read as _;

/// Decodes the displacements of all pictures, as `film.js` does.
fn decoded(film: &Film) -> (Vec<Vec<f64>>, serde_json::Value, usize) {
    let (about, packed) = film.json().unwrap();
    let mut bytes = Vec::new();
    ZlibDecoder::new(&packed[..]).read_to_end(&mut bytes).unwrap();
    let [n, frames] = ["numbers", "frames"].map(|k| about[k].as_u64().unwrap() as usize);
    assert_eq!(bytes.len(), 2 * n * frames);
    let space = about["drawing"]["space"].as_array().unwrap().iter().map(|s| s == 1);
    let scales: Vec<f64> = space
        .flat_map(|s| std::iter::repeat_n(about["scale"][usize::from(s)].as_f64().unwrap(), if s { 3 } else { 1 }))
        .collect();
    let (low, high) = bytes.split_at(n * frames);
    let mut now = vec![0_i16; n];
    let view = |f: usize| {
        for (now, at) in now.iter_mut().zip(f * n..) {
            *now = now.wrapping_add(i16::from_le_bytes([low[at], high[at]]));
        }
        now.iter().zip(&scales).map(|(v, s)| f64::from(*v) * s).collect()
    };
    ((0..frames).map(view).collect(), about, packed.len())
}

/// Plays `seconds` with some motion, records 240 times a second, and returns the expected pictures.
fn played(scene: &Scene, film: &mut Film, seconds: f64) -> Vec<Vec<f64>> {
    let drawing = Drawing::new(scene);
    let mut s = scene.state();
    for (i, d) in s.d.iter_mut().enumerate() {
        *d += 1e-6 * ((i * 7) % 11) as f64;
    }
    s.placed();
    let mut shown = Vec::new();
    let every = (scene.rate / 240.0) as u64;
    while (s.tick as f64) < seconds * scene.rate {
        if s.tick.is_multiple_of(every) {
            let before = film.frames();
            film.look(s.tick as f64 / scene.rate, &s.x);
            if film.frames() > before {
                let mut bytes = Vec::new();
                drawing.view(&s.x, &mut bytes);
                let of = |b: &[u8]| f64::from(f32::from_le_bytes([b[0], b[1], b[2], b[3]]));
                shown.push(bytes.chunks_exact(4).map(of).collect());
            }
        }
        cordis_anima::tick(scene, &mut s);
    }
    shown
}

#[test]
fn a_film_is_what_was_played() {
    for (name, scene) in models() {
        let mut film = Film::new(&scene, 0.3);
        assert_eq!(film.rate(), 60.0, "{name}");
        let shown = played(&scene, &mut film, 0.3);
        assert_eq!((film.frames(), shown.len()), (18, 18), "{name}");
        let (views, about, _) = decoded(&film);
        let step = [0, 1].map(|k| about["scale"][k].as_f64().unwrap()).into_iter().fold(0.0, f64::max);
        for (f, (view, shown)) in views.iter().zip(&shown).enumerate() {
            for (i, (a, b)) in view.iter().zip(shown).enumerate() {
                assert!((a - b).abs() <= 0.501 * step, "{name}: picture {f}, number {i}: {a} {b}");
            }
        }
    }
}

#[test]
fn a_film_of_too_much_is_small() {
    let mesh = |side: u32| {
        format!(
            "[MESH]\nm = {{ nx = {side}, ny = {side}, m = \"1 g\", k = 900 }}\n[SOX]\no = {{ from = \"m[1,1]\" }}\n"
        )
    };
    // a lower rate, then fewer masses
    for (side, seconds, rate) in [(40, 30.0, 20.0..60.0), (120, 60.0, 19.0..60.0)] {
        let scene = compiled(&mesh(side), "mesh");
        let mut film = Film::new(&scene, seconds);
        assert!(rate.contains(&film.rate()), "{}", film.rate());
        // noise, which does not compress
        let mut x = vec![0.0; scene.counts.n_mat];
        let mut seed = 1_u32;
        for n in 0..(seconds * 60.0) as u32 {
            for x in &mut x {
                seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                *x = f64::from(seed >> 8);
            }
            film.look(f64::from(n) / 60.0, &x);
        }
        let (about, packed) = film.json().unwrap();
        let size = packed.len().div_ceil(3) * 4 + about.to_string().len();
        assert!(size < 5_500_000, "{size} bytes of {side} × {side}");
        assert_eq!(about["drawing"]["decimated"].is_null(), side == 40);
    }
    // invalid times, then an empty state
    let scene = compiled(&mesh(4), "mesh");
    let mut film = Film::new(&scene, 0.0);
    for t in [f64::NAN, f64::INFINITY, -1.0] {
        film.look(t, &[f64::NAN; 16]);
    }
    assert_eq!(film.frames(), 0);
    film.look(0.0, &[f64::NAN; 16]);
    let (views, ..) = decoded(&film);
    assert!(views.len() == 1 && views[0].iter().all(|v| *v == 0.0));
}
