//! `analysis::modes` against closed forms and against the running engine: A02, A07, D05, coupled damping.

use crate::play::{PI, case, list, mats, model, num, off, rows, scene, within};
use ca_compile::Options;
use ca_compile::analysis::modes::{Modes, modes};
use ca_core::tick;
use ca_tests::catalog;
use std::fmt::Write as _;

fn of(text: &str) -> (ca_compile::analysis::Network, Modes) {
    let network = ca_compile::linear(&model(text), &catalog(), &Options::default()).expect("it compiles");
    let found = modes(&network).expect("they are found");
    (network, found)
}

#[test]
fn a02_cells_are_warped_as_the_table_says() {
    let c = case("A02");
    let table = rows(c, "values/rows_f0_fsim_cents");
    let mut text = String::from("[CEL]\n");
    for (i, row) in table.iter().enumerate() {
        let _ = writeln!(text, "c{i} = {{ m = 1, k = {:e} }}", (2.0 * PI * row[0]).powi(2));
    }
    text += "[SOX]\n";
    (0..table.len()).for_each(|i| _ = writeln!(text, "o{i} = {{ from = \"c{i}\" }}"));
    let (_, found) = of(&text);
    for (m, row) in found.list.iter().zip(&table) {
        within("A02 free", off(m.f, row[0]), 1e-8);
        within("A02 heard", off(m.heard, row[1]), 1e-8);
        assert!((m.cents() - row[2]).abs() < 2e-5 && m.t60.is_infinite(), "{m:?}");
    }
}

#[test]
fn a07_the_modes_of_a_chain() {
    let c = case("A07");
    let (n, a) = (num(c, "setup/N") as usize, num(c, "setup/a"));
    let text = format!(
        "[STRING]\ns = {{ n = {n}, m = 1, k = {:e} }}\n[SOX]\nout = {{ from = \"s[9]\" }}\n[ENF]\nhand = {{ to = \"s@0.21\" }}\n",
        a * 48e3 * 48e3
    );
    let (network, found) = of(&text);
    assert_eq!(found.list.len(), n);
    for (j, m) in found.list.iter().enumerate() {
        let angle = (j + 1) as f64 * PI / (2.0 * (n as f64 + 1.0));
        within("A07 heard", off(m.heard, 48e3 / PI * (a.sqrt() * angle.sin()).asin()), 1e-10);
        within("A07 free", off(m.f, 48e3 / PI * a.sqrt() * angle.sin()), 1e-10);
        // of unit modal mass: √(2/(N + 1)) sin
        let shape = (2.0 / (n as f64 + 1.0)).sqrt();
        let want = shape * (2.0 * angle * 10.0).sin().abs();
        within("A07 at the output", (m.at(&network.ports[0].at).abs() - want).abs(), 1e-9);
    }
    // a point between two masses has the mean of both
    let push = &network.ports.iter().find(|p| p.role == "pushes").expect("a port").at;
    within("A07 a point's weights", (push.iter().map(|e| e.1).sum::<f64>() - 1.0).abs(), 1e-15);
    assert_eq!(push.len(), 2);
}

/// A damper at a node of a mode does not damp it beyond rounding: the mode rings forever.
#[test]
fn a_mode_that_nothing_damps_sounds_for_ever() {
    for method in ["", "[model]\nmethod = \"centred\"\n"] {
        let text = format!(
            "{method}[STRING]\ns = {{ n = 15, m = \"1 g\", k = \"100 kN/m\" }}\n[SOL]\nw = {{}}\n[FRO]\nz = {{ between = [\"w\", \"s[7]\"], z = \"20 mN s/m\" }}\n\
             [SOX]\nout = {{ from = \"s[2]\" }}\n"
        );
        let found = of(&text).1;
        for (j, m) in found.list.iter().enumerate() {
            // modes two, four and so on have a node in the middle
            assert_eq!(m.t60.is_infinite(), j % 2 == 1, "mode {j}: {}", m.t60);
            assert_eq!(m.t60_free.is_infinite(), j % 2 == 1, "mode {j}: {}", m.t60_free);
        }
    }
}

#[test]
fn d05_the_stretching_modes_of_a_tetrahedron() {
    let c = case("D05");
    let mut text = String::from("[b]\ndim = 3\n[b.MAS]\n");
    for (i, [x, y, z]) in [[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]].into_iter().enumerate() {
        let _ = writeln!(text, "v{i} = {{ m = 1, x = [{x}, {y}, {z}] }}");
    }
    text += "[b.RES]\n";
    for (i, j) in [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)] {
        let _ = writeln!(text, "e{i}{j} = {{ between = [\"b.v{i}\", \"b.v{j}\"], k = 1e8 }}");
    }
    text += "[SOX]\nout = { from = \"b.v0\", along = \"x\" }\n";
    let (_, found) = of(&text);
    let mut lambda: Vec<f64> = found.list.iter().map(|m| m.a * 48e3 * 48e3 / 1e8).collect();
    lambda.reverse();
    let want = list(c, "values/lam");
    for (got, want) in lambda.iter().zip(want.iter().chain([0.0; 6].iter())) {
        within("D05", (got - want).abs(), 1e-12);
    }
    assert!(found.list[..6].iter().all(|m| m.heard == 0.0 && m.t60.is_infinite()), "six motions are free");
}

/// A damper at one place of a string couples its modes: pitch and decay agree with the running engine.
#[test]
fn coupled_damping_is_that_of_the_engine() {
    let text = "[STRING]\ns = { n = 12, m = \"1 g\", f = \"800 Hz\" }\n[FRO]\nfelt = { between = [\"ground\", \"s[3]\"], z = 1.5 }\n\
                [SOL]\nground = {}\n[SOX]\nout = { from = \"s[5]\" }\n";
    let (_, found) = of(text);
    assert!(!found.approximate && found.list.iter().any(|m| m.coupled > 1e-3));
    let s = scene(text);
    let places = mats(&s, "s");
    let start = s.state();
    let n = places.len();
    let mut map = faer::Mat::<f64>::zeros(2 * n, 2 * n);
    for j in 0..2 * n {
        let mut state = start.clone();
        state.x.fill(0.0);
        state.d.fill(0.0);
        if j < n {
            state.x[places[j]] = 1.0;
        } else {
            state.d[places[j - n]] = 1.0;
        }
        tick(&s, &mut state);
        for i in 0..n {
            map[(i, j)] = state.x[places[i]];
            map[(n + i, j)] = state.d[places[i]];
        }
    }
    let mut poles: Vec<(f64, f64)> = map
        .eigenvalues()
        .expect("they are found")
        .iter()
        .filter(|w| w.im > 1e-9)
        .map(|w| {
            (w.im.atan2(w.re) * 48e3 / (2.0 * PI), 3.0 * std::f64::consts::LN_10 / (-w.re.hypot(w.im).ln() * 48e3))
        })
        .collect();
    poles.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut ours: Vec<(f64, f64)> = found.list.iter().filter(|m| m.heard > 0.0).map(|m| (m.heard, m.t60)).collect();
    ours.sort_by(|a, b| a.0.total_cmp(&b.0));
    assert_eq!(ours.len(), poles.len());
    for (a, b) in ours.iter().zip(&poles) {
        within("pitch", off(a.0, b.0), 1e-9);
        within("decay", off(a.1, b.1), 1e-7);
    }
}

/// Proportional damping against the closed form of docs/numerics.md §1.4.
#[test]
fn damping_by_itself() {
    let (f, t60) = (440.0, 2.0);
    let (_, found) = of("[CEL]\nc = { m = \"1 g\", f = \"440 Hz\", t60 = \"2 s\" }\n[SOX]\nout = { from = \"c\" }\n");
    let m = &found.list[0];
    within("heard", off(m.heard, f), 1e-12);
    within("t60", off(m.t60, t60), 1e-9);
    // a free mass in a medium has one decay but no pitch
    let (_, found) = of(
        "[param]\n[MAS]\nm = { m = \"1 g\" }\n[SOL]\nw = {}\n[FRO]\nf = { between = [\"w\", \"m\"], z = \"1 mN s/m\" }\n[SOX]\nout = { from = \"m\" }\n",
    );
    within("free decay", off(found.list[0].t60_free, 3.0 * std::f64::consts::LN_10), 1e-12);
    assert!((found.list[0].t60 / found.list[0].t60_free - 1.0).abs() < 1e-4);
    let (_, found) = of("[CEL]\nc = { m = \"1 g\", k = \"10 MN/m\" }\n[SOX]\nout = { from = \"c\" }\n");
    assert!(found.list[0].grows && found.list[0].heard == 0.0);
    // a heavy damper: no pitch, and the slower of the two decays
    let (_, found) =
        of("[CEL]\nc = { m = \"1 g\", k = \"1 kN/m\", z = \"20 N s/m\" }\n[SOX]\nout = { from = \"c\" }\n");
    let m = &found.list[0];
    assert!(m.f == 0.0 && m.heard == 0.0);
    let (a, b) = (1e6 / 48e3 / 48e3, 20.0 / 1e-3 / 48e3);
    let half: f64 = 1.0 - 0.5 * (a + b);
    let pole = half + (half * half - (1.0 - b)).sqrt();
    within("the slower decay", off(m.t60, 3.0 * std::f64::consts::LN_10 / (-pole.ln() * 48e3)), 1e-9);
}
