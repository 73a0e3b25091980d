//! Long plays of small drawn models in space: linearised scenes keep their energy within the ripple that the certificate
//! states.

use super::soak::{decades, soak};
use crate::play::{Random, with, within};
use ca_compile::Options;
use ca_core::{Level, Scene, State, tick};
use proptest::prelude::*;
use proptest::sample::Index;
use std::fmt::Write as _;

/// Masses on a string under tension in space, tied by slack springs to others and fixed points, by LPR to cells.
#[derive(Clone, Debug)]
struct Space {
    /// Mass, length to the next, stiffness to the next.
    chain: Vec<(f64, f64, f64)>,
    /// Share of the largest tension at which no spring has a negative length.
    tension: f64,
    /// Mass, fixed point and stiffness of a stay.
    stays: Vec<(Index, [f64; 3], f64)>,
    /// From a mass to one at least two further on, onto a cell of this mass and stiffness.
    crossed: Vec<(Index, Index, f64, f64, f64)>,
    near: f64,
    seed: u64,
}

fn space() -> impl Strategy<Value = Space> {
    let chain = proptest::collection::vec((decades(1.0), 0.5..2.0, decades(1.0)), 1..5);
    let place = [-1.5..1.5, -1.5..1.5, 0.5..1.5];
    let stays = proptest::collection::vec((any::<Index>(), place, decades(1.0)), 0..4);
    let crossed =
        proptest::collection::vec((any::<Index>(), any::<Index>(), decades(1.0), decades(1.0), decades(1.0)), 0..3);
    let tension = prop_oneof![Just(0.0), 0.0..0.95];
    (chain, tension, stays, crossed, 0.05..0.97, 1u64..)
        .prop_map(|(chain, tension, stays, crossed, near, seed)| Space { chain, tension, stays, crossed, near, seed })
}

impl Space {
    /// The model at one tick a second, with all stiffness times `scale`.
    fn text(&self, scale: f64) -> String {
        let n = self.chain.len();
        // one more spring than masses, a copy of the last
        let links: Vec<(f64, f64)> =
            self.chain.iter().chain(self.chain.last()).map(|(_, length, k)| (*length, k * scale)).collect();
        let pull = self.tension * links.iter().map(|(length, k)| length * k).fold(f64::INFINITY, f64::min);
        let mut x = 0.0;
        let mut places = vec![0.0];
        for (length, _) in &links {
            x += length;
            places.push(x);
        }
        let name = |i: usize| match i {
            0 => "room.left".to_string(),
            i if i > n => "room.right".to_string(),
            i => format!("room.m{i}"),
        };
        let mut fixed = format!("left = {{ x = [0, 0, 0] }}\nright = {{ x = [{x:?}, 0, 0] }}\n");
        let (mut masses, mut springs, mut quads, mut cells) =
            (String::new(), String::new(), String::new(), String::new());
        for (i, (m, ..)) in self.chain.iter().enumerate() {
            let _ = writeln!(masses, "m{} = {{ m = {m:e}, x = [{:?}, 0, 0] }}", i + 1, places[i + 1]);
        }
        for (i, (length, k)) in links.iter().enumerate() {
            let (ends, l0) = ([name(i), name(i + 1)], length - pull / k);
            let _ = writeln!(springs, "s{i} = {{ between = {ends:?}, k = {k:e}, l0 = {l0:?} }}");
        }
        for (i, (at, by, k)) in self.stays.iter().enumerate() {
            let at = 1 + at.index(n);
            let [x, y, z] = [places[at] + by[0], by[1], by[2]];
            let _ = writeln!(fixed, "p{i} = {{ x = [{x:?}, {y:?}, {z:?}] }}");
            let ends = [name(at), format!("room.p{i}")];
            let _ = writeln!(springs, "r{i} = {{ between = {ends:?}, k = {:e} }}", k * scale);
        }
        for (i, (a, b, k, m, c)) in self.crossed.iter().enumerate() {
            let a = a.index(n + 1);
            let ends = [name(a), name(a + 1 + b.index(n + 1 - a))];
            let _ =
                writeln!(quads, "q{i} = {{ between = {ends:?}, onto = [\"wall\", \"c{i}\"], k = {:e} }}", k * scale);
            let _ = writeln!(cells, "c{i} = {{ m = {m:e}, k = {:e} }}", c * scale);
        }
        let (wall, cells) = if cells.is_empty() {
            (String::new(), String::new())
        } else {
            ("[SOL]\nwall = {}\n".to_string(), format!("[CEL]\n{cells}[LPR]\n{quads}"))
        };
        format!(
            "[rate]\nsound = 1\ngesture = 1\n[room]\ndim = 3\n[room.SOL]\n{fixed}[room.MAS]\n{masses}[REF]\n{springs}\
             {wall}{cells}[SOX]\nout = {{ from = \"room.m1\", along = \"x\" }}\n"
        )
    }

    /// The model at its share of the limit, linearised.
    fn linearised(&self) -> (String, Scene) {
        let exact = with(&self.text(1.0), &Options { exact: true, ..Options::default() });
        let (_, most) = exact.certificate.largest.expect("asked for");
        let text = self.text(self.near * 4.0 / most);
        let scene = with(&text, &Options { energy: true, ..Options::default() });
        let c = &scene.certificate;
        assert_eq!(c.level, Level::Linearised, "{c:?}\n{text}");
        let exact = 2.0 * self.near / (1.0 - self.near);
        let ripple = c.ripple.unwrap_or_else(|| panic!("no ripple\n{text}"));
        assert!(ripple >= exact * 0.5 * (1.0 - 1e-4), "{ripple} is below {exact}\n{text}");
        (text, scene.scene)
    }
}

fn held(s: &State) -> f64 {
    s.ledger.as_ref().expect("a ledger").h
}

/// Releases a scene with each place displaced by `moved` \[m\] and plays it. Returns the largest rise of its energy
/// above any earlier value, relative to that value; energies count from rest.
fn rises(scene: &Scene, mut moved: impl FnMut() -> f64, ticks: u64) -> f64 {
    let mut s = scene.state();
    (0..3).for_each(|_| tick(scene, &mut s));
    let rest = held(&s);
    let mut s = scene.state();
    for i in 0..scene.counts.n_mat {
        if s.coef[2 * scene.counts.n_mat + i] > 0.0 {
            s.x[i] += moved();
        }
    }
    tick(scene, &mut s);
    let (mut least, mut most) = (f64::INFINITY, 0.0f64);
    for _ in 0..ticks {
        tick(scene, &mut s);
        let h = held(&s) - rest;
        least = least.min(h);
        most = most.max(h / least - 1.0);
    }
    most
}

/// Displacements, for lengths of about 1.
const SMALL: f64 = 1e-4;

#[test]
fn what_is_linearised_keeps_to_its_ripple() {
    soak(space, |d, ticks| {
        let (text, scene) = d.linearised();
        let stated = scene.certificate.ripple.expect("stated");
        let mut rng = Random(d.seed);
        let rose = rises(&scene, || SMALL * rng.uniform(), ticks);
        // lengths couple modes by the square of the displacement
        assert!(rose <= stated + SMALL, "{rose} is above {stated}\n{text}");
    });
}

/// A mass between two stretched springs of nearly zero length is isotropic, and reaches the stated ripple.
#[test]
fn the_ripple_is_reached() {
    for k in [0.01, 0.2, 1.0, 1.8] {
        let text = format!(
            "[rate]\nsound = 1\ngesture = 1\n[room]\ndim = 3\n[room.SOL]\na = {{ x = [-1, 0, 0] }}\nb = {{ x = [1, 0, 0] }}\n\
             [room.MAS]\nm = {{ m = 1, x = [0, 0, 0] }}\n[REF]\ns = {{ between = [[\"room.a\", \"room.b\"], \"room.m\"], \
             k = {k:?}, l0 = 1e-6 }}\n[SOX]\nout = {{ from = \"room.m\", along = \"y\" }}\n"
        );
        let scene = with(&text, &Options { energy: true, ..Options::default() });
        let stated = scene.certificate.ripple.unwrap_or_else(|| panic!("{:?}", scene.certificate));
        within("ripple, stated", (stated - 4.0 * k / (4.0 - 2.0 * k)).abs() / stated, 1e-12);
        let mut sideways = [0.0, SMALL, 0.0].into_iter();
        let rose = rises(&scene, || sideways.next().unwrap_or(0.0), 20_000);
        within(&format!("ripple, k = {k}"), (rose / stated - 1.0).abs(), 1e-4);
    }
}
