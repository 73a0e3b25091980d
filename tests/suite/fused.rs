//! Rows of linear links that one pass sums and integrates: the bits of the list of passes, and only where nothing can
//! tell. A scene with the energy ledger has the list.

use crate::play::{audited, mat, scene};
use ca_core::op::Integrate;
use ca_core::{Scene, tick};
use proptest::prelude::*;
use std::fmt::Write as _;

/// The fused rows: law, and what masses they integrate.
fn fused(s: &Scene) -> Vec<(&'static str, Integrate)> {
    let rows = s.moves.iter().filter(|op| op.form.integrate != Integrate::No);
    rows.map(|op| (op.name, op.form.integrate)).collect()
}

/// Plays `text` by both, and compares every bit of place and motion.
fn same(text: &str, ticks: usize) -> Vec<(&'static str, Integrate)> {
    let (fast, listed) = (scene(text), audited(text));
    assert_eq!(fused(&listed), [], "{text}");
    let (mut a, mut b) = (fast.state(), listed.state());
    let mut heard = 0.0f64;
    for n in 0..ticks {
        for s in [&mut a, &mut b] {
            s.input.iter_mut().for_each(|v| *v = 1e-3 * (0.01 * n as f64).sin());
        }
        tick(&fast, &mut a);
        tick(&listed, &mut b);
        let equal =
            |a: &[f64], b: &[f64]| a.len() == b.len() && a.iter().zip(b).all(|(a, b)| a.to_bits() == b.to_bits());
        assert!(equal(&a.x, &b.x) && equal(&a.d, &b.d) && equal(&a.output, &b.output), "{text}\ntick {n}");
        heard = heard.max(a.output[0].abs());
    }
    assert!(heard > 0.0 && heard < 1e6, "{heard} in\n{text}");
    fused(&fast)
}

/// A string of `n` masses, struck by a hammer.
fn struck(n: u32, of: &str) -> String {
    format!(
        "[STRING]\ns = {{ n = {n}, m = \"2 g\", {of} }}\n[MAS]\nh = {{ m = \"5 g\", x = \"-0.1 mm\", v = 1 }}\n[BUT]\nb = {{ \
         between = [\"h\", \"s[4]\"], k = \"20 kN/m\", z = 0.2 }}\n[SOX]\nout = {{ from = \"s[7]\" }}\n"
    )
}

proptest! {
    /// Every length around those of vectors, three laws, masses with and without dampers of their own, a moving point.
    #[test]
    fn a_row_has_the_bits_of_its_list(
        n in 11u32..70, k in 1e2f64..1e5, z in 1e-4f64..0.3, law in 0..3, own: bool, point: bool, times in 1..3
    ) {
        let of = match law {
            0 => format!("k = {k:?}"),
            1 => format!("k = {k:?}, z = {z:?}"),
            _ => format!("k = 0, z = {z:?}"),
        };
        let own = if own { ", zo = 0.01" } else { "" };
        let point = if point {
            "[ENX]\nspot = {}\n[SOL]\ntop = {}\n[REF]\nslide = { between = [\"top\", \"s@spot\"], k = \"1 kN/m\" }\n"
        } else {
            ""
        };
        let text = format!("{}{point}[rate]\noversample = {times}\n", struck(n, &(of + own)));
        same(&text, 1500);
    }
}

#[test]
fn a_row_is_fused_where_one_number_comes_behind_it() {
    let string = struck(24, "k = \"40 kN/m\", z = 0.1");
    assert_eq!(same(&string, 3000), [("REF", Integrate::Mas)]);
    assert_eq!(same(&struck(24, "k = \"40 kN/m\""), 3000), [("RES", Integrate::Mas)]);
    assert_eq!(same(&struck(24, "k = \"40 kN/m\", z = 0.1, zo = 0.01"), 3000), [("REF", Integrate::Cel)]);
    // two numbers on one mass, one before the row, one that somebody reads, one that others are solved from
    for more in [
        "[SOL]\ng = {}\n[CUB]\nc = { between = [\"g\", \"s[4]\"], k = 1e4, k3 = 1e9 }\n",
        "[ENF]\npush = { to = \"s[2]\" }\n",
        "[SOF]\nforce = { from = \"s[3]\" }\n",
        "[SOL]\ng = {}\n[BOW]\nc = { between = [\"s[9]\", \"g\"], f = 0.3, v0 = \"50 mm/s\", method = \"newton\" }\n",
        "[model]\ngravity = 9.81\n",
    ] {
        assert_eq!(same(&format!("{string}{more}"), 1500), [], "{more}");
    }
}

/// Links with a length of their own, in a row that is written by hand.
#[test]
fn a_row_under_tension_has_the_bits_of_its_list() {
    let mut text = String::from("[SOL]\nl = {}\nr = { x = \"2.4 cm\" }\n[MAS]\n");
    for i in 1..24 {
        let v = if i == 5 { ", v = 0.1" } else { "" };
        let _ = writeln!(text, "m{i} = {{ m = \"2 g\", x = \"{i} mm\"{v} }}");
    }
    text += "[REF]\n";
    for i in 0..24 {
        let [a, b] = [i, i + 1].map(|i| match i {
            0 => "l".into(),
            24 => "r".into(),
            _ => format!("m{i}"),
        });
        let _ = writeln!(text, "r{i} = {{ between = [\"{a}\", \"{b}\"], k = 4e4, z = 0.1, l0 = \"0.9 mm\" }}");
    }
    text += "[SOX]\nout = { from = \"m7\" }\n";
    assert_eq!(same(&text, 3000), [("REF", Integrate::Mas)]);
    assert!(scene(&text).moves.iter().any(|op| op.form.offset));
}

/// The sum that a pass of forces left out is in the list for whoever asks, and links keep their names.
#[test]
fn fused_links_keep_their_place() {
    let s = scene(&struck(24, "k = \"40 kN/m\", z = 0.1"));
    assert_eq!((s.fused, s.summed().len(), s.forces.len()), (1, 1, 2));
    assert_eq!((s.forces[0].name, s.forces[1].name), ("BUT", "REF"));
    assert_eq!(s.lia_name(0, 0), "b");
    assert!(s.lia_name(1, 3).starts_with("s."), "{}", s.lia_name(1, 3));
    assert!(s.mat_name(mat(&s, "s[3]")).starts_with("s["));
}
