//! Tests drawings of random links.

use crate::check::{check, compiled, page, views};
use ca_view::Drawing;
use proptest::prelude::*;
use std::fmt::Write as _;

/// Writes a model with masses, ports and generators on a line and in space, and random links.
fn random(seed: u64) -> String {
    let mut state = seed;
    let mut below = |n: usize| {
        // splitmix64
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = (state ^ (state >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) % n.max(1) as u64) as usize
    };
    let (n, f, ports, cells) = (below(30), below(4), below(3), below(12));
    let mut t = String::from("[MAS]\n");
    let mut line = Vec::new();
    for i in 0..n {
        let _ = writeln!(t, "m{i} = {{ m = 1, x = {} }}", [0.0, -0.01, 0.02][below(3)]);
        line.push(format!("m{i}"));
    }
    t += "[SOL]\nanchor = {}\n";
    line.push("anchor".into());
    (0..f).for_each(|i| {
        let _ = writeln!(t, "f{i} = {{}}");
        line.push(format!("f{i}"));
    });
    t += "[ENX]\n";
    (0..ports).for_each(|i| {
        let _ = writeln!(t, "p{i} = {{}}");
        line.push(format!("p{i}"));
    });
    t += "[CEL]\n";
    (0..cells).for_each(|i| {
        let _ = writeln!(t, "c{i} = {{ m = 1, k = 100 }}");
        line.push(format!("c{i}"));
    });
    if below(2) == 0 {
        let n = 3 + below(40);
        let kind = ["STRING", "CHAIN", "RING"][below(3)];
        let _ = writeln!(t, "[{kind}]\ns = {{ n = {n}, m = 1, k = 100 }}");
        line.extend((0..n).map(|i| format!("s[{i}]")));
        line.extend((kind != "RING").then(|| format!("s@0.{}", 1 + below(8))));
    }
    if below(2) == 0 {
        let (nx, ny) = (2 + below(12), 2 + below(9));
        let edges = ["open", "closed", "corner"][below(3)];
        let _ = writeln!(t, "[MESH]\ng = {{ nx = {nx}, ny = {ny}, m = 1, k = 100, edges = \"{edges}\" }}");
        line.extend((0..nx).flat_map(|i| (0..ny).map(move |j| format!("g[{i},{j}]"))));
        line.push(format!("g@0.{},0.{}", 1 + below(8), 1 + below(8)));
    }
    let space = below(20);
    t += "[w]\ndim = 3\n[w.MAS]\n";
    for i in 0..space {
        let _ = writeln!(t, "m{i} = {{ m = 1, x = [{}, {}, {}] }}", below(9), below(9), i);
    }
    for (kind, numbers) in [("REF", "k = 10, z = 0.1"), ("BUT", "k = 10"), ("FRO", "z = 0.1"), ("BOW", "f = 1, v0 = 1")]
    {
        let _ = writeln!(t, "[{kind}]");
        for i in 0..below(40) {
            let [a, b] = [below(line.len()), below(line.len())].map(|i| line[i].clone());
            if a != b && !(a.contains('@') && b.contains('@')) {
                let _ = writeln!(t, "{kind}{i} = {{ between = [\"{a}\", \"{b}\"], {numbers} }}");
            }
            if space > 1 && below(3) == 0 {
                let (a, b) = (below(space), below(space));
                if a != b {
                    let _ = writeln!(t, "{kind}x{i} = {{ between = [\"w.m{a}\", \"w.m{b}\"], {numbers} }}");
                }
            }
            if space > 0 && below(9) == 0 && !line[i % line.len()].contains('@') {
                let (a, b) = (&line[i % line.len()], below(space));
                let along = ["x", "y", "z"][below(3)];
                let _ =
                    writeln!(t, "{kind}y{i} = {{ between = [\"{a}\", \"w.m{b}\"], along = \"{along}\", {numbers} }}");
            }
        }
    }
    // the compiler leaves out masses without outputs
    t += "[SOX]\n";
    for (i, name) in line.iter().enumerate() {
        let _ = writeln!(t, "o{i} = {{ from = \"{name}\", channel = 0 }}");
    }
    for i in 0..space {
        let _ = writeln!(t, "a{i} = {{ from = \"w.m{i}\", along = \"x\", channel = 0 }}");
    }
    t
}

fn is_drawn(seed: u64) {
    let text = random(seed);
    let scene = compiled(&text, "random.ca.toml");
    let d = Drawing::new(&scene);
    let name = format!("random {seed}");
    check(&name, &scene, &d);
    views(&name, &scene, &d, 5);
    let few = Drawing::of_at_most(&scene, 10);
    assert!(few.masses() <= d.masses(), "{name}");
    let p = page(&few);
    assert!(p.links.iter().all(|(_, _, [a, b])| a.max(b) < &p.n && a != b), "{name}");
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn what_is_linked_at_random_is_drawn(seed in any::<u64>()) {
        is_drawn(seed);
    }
}

/// A scene from an earlier run: two banks are tied to one mass in space along two axes, and cross there.
#[test]
fn two_banks_tied_to_one_mass_in_space_along_two_axes_are_drawn() {
    let seed = 10_990_588_236_738_511_851;
    let p = page(&Drawing::new(&compiled(&random(seed), "banks.ca.toml")));
    let line: Vec<usize> = (0..p.n).filter(|i| !p.space[*i]).collect();
    let cross = |i: &usize, j: &usize| i < j && p.rest[*i] == p.rest[*j] && p.axis[*i] != p.axis[*j];
    assert!(
        line.iter().any(|i| line.iter().any(|j| cross(i, j))),
        "none cross: `random` makes another scene of this seed"
    );
    is_drawn(seed);
}
