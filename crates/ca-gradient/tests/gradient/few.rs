//! Parameters that change few links of a row or many links outside rows, together and one by one. The forces added to
//! derivatives, and the sums of the backward pass, differ between these cases.

use crate::reference::{read, tangents};
use crate::reverse::both_ways;
use ca_gradient::Forward;
use cordis_anima::Options;
use std::fmt::Write as _;

/// Returns masses linked along and, in rows of `across`, across; links over several masses share the number `tie`.
fn by_hand(n: usize, across: Option<usize>) -> String {
    let mut text = String::from("[param]\ntie = '90 N/m'\n[SOL]\nwall = {}\n[MAS]\nm0 = { m = '1 g', dx0 = '1 mm' }\n");
    (1..n).for_each(|i| writeln!(text, "m{i} = {{ m = '1 g' }}").expect("text"));
    text += "[REF]\n";
    for i in 0..n {
        let link = |text: &mut String, name: &str, j: usize| {
            let _ = writeln!(
                text,
                "{name}{i} = {{ between = ['m{i}', 'm{j}'], k = '{} kN/m', z = '20 mN s/m' }}",
                9 + i % 4
            );
        };
        if i + 1 < n && across.is_none_or(|row| (i + 1) % row > 0) {
            link(&mut text, "r", i + 1);
        }
        if let Some(row) = across.filter(|row| i + row < n) {
            link(&mut text, "c", i + row);
        }
    }
    let _ = writeln!(text, "held = {{ between = ['wall', 'm{}'], k = '2 kN/m', z = '0.1 N s/m' }}\n[RES]", n / 2);
    for (i, (a, b)) in [(3, 50), (7, 71), (20, 61), (30, 80), (44, 85), (13, 66)].into_iter().enumerate() {
        let _ = writeln!(text, "t{i} = {{ between = ['m{a}', 'm{b}'], k = 'tie' }}");
    }
    text + "[SOX]\nout = { from = 'm5', gain = 300 }\n"
}

#[test]
fn few_links_and_many_and_each_parameter_by_itself() {
    let low = "[MAS]\nball = { m = '5 g', dx0 = '1 mm' }\n[REF]\nheld = { between = ['ball', 'low[9]'], k = '2 kN/m', z = '0.1 N s/m' }\n[SOX]\nout = { from = 'low[3]', gain = 300 }\n";
    let string = format!("[STRING]\nlow = {{ n = 90, f = '110 Hz', t60 = '1 s', m = '2 g', z = '1 mN s/m' }}\n{low}");
    let mesh =
        format!("[MESH]\nlow = {{ nx = 9, ny = 10, f = '200 Hz', t60 = '0.5 s', m = '9 g', z = '1 mN s/m' }}\n{low}");
    let generated = ["low.f", "low.t60", "low.m", "low.z", "ball.dx0", "held.k", "held.z"];
    // in a folded row of 90, a lane has twelve links: the last of a lane, the first of the next, and some within
    let row = ["r10.k", "r11.k", "r12.z", "r23.z", "r88.k", "m40.m", "tie"];
    let sheet = ["r11.k", "c11.k", "c70.z", "r83.z", "c79.k", "held.k", "tie"];
    let cases = [(string, generated), (mesh, generated), (by_hand(90, None), row), (by_hand(90, Some(9)), sheet)];
    let mut wrong = Vec::new();
    for (case, (text, names)) in cases.iter().enumerate() {
        let loaded = read(text);
        let known = Forward::by_passes(&loaded, &Options::default(), names).expect("derivatives");
        assert!(known.is_some(), "{case}: by no passes");
        for some in std::iter::once(&names[..]).chain(names.chunks(1)) {
            let title = format!("{case} by {some:?}");
            let t = tangents(&loaded, 600, some);
            assert!(t.tangents.iter().any(|v| *v != 0.0), "{title}: nothing depends on it");
            assert!(both_ways(&title, &loaded, &t, &mut wrong), "{title}: no reverse mode");
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}
