//! Linear links and cells by `centred` and `implicit`: A14, A15, H04, orders, ledgers, outputs.

use crate::play::{Random, apart, audited, case, list, mat, mats, num, off, reference, scene, with, within};
use ca_core::internal::numeric::ldl::Pattern;
use ca_core::{Level, Scene, State, tick};
use ca_tests::catalog;
use std::fmt::Write as _;

/// A mass on a link to a wall, T = 1.
fn bob(link: &str) -> String {
    format!(
        "[rate]\nsound = 1\ngesture = 1\n[SOL]\nwall = {{}}\n[MAS]\nbob = {{ m = 1 }}\n[REF]\nhold = {{ between = [\"wall\", \
         \"bob\"], {link} }}\n[SOX]\nout = {{ from = \"bob\" }}\n"
    )
}

fn cell(own: &str) -> String {
    format!("[rate]\nsound = 1\ngesture = 1\n[CEL]\nbob = {{ m = 1, {own} }}\n[SOX]\nout = {{ from = \"bob\" }}\n")
}

/// An oscillator written as a link and as a cell, which are the same scheme.
fn both(own: &str) -> [String; 2] {
    [bob(own), cell(own)]
}

/// Largest |x| of `n` ticks from x = x₋ = 1.
fn largest(scene: &Scene, n: usize) -> f64 {
    let (mut s, i) = (scene.state(), mat(scene, "bob"));
    (s.x[i], s.d[i]) = (1.0, 0.0);
    let mut most = 0.0f64;
    for _ in 0..n {
        tick(scene, &mut s);
        most = if s.x[i].is_finite() { most.max(s.x[i].abs()) } else { return f64::INFINITY };
    }
    most
}

#[test]
fn a14_one_link_stiffened() {
    let c = case("A14");
    let [n, at] = ["N", "stiff_link"].map(|k| num(c, &format!("setup/{k}")) as usize);
    let (a, times, steps) = (num(c, "setup/a"), num(c, "setup/factor"), num(c, "setup/steps") as usize);
    let text = |method: &str| {
        // a string cut at the stiff link
        format!(
            "[rate]\nsound = 1\ngesture = 1\n[SOL]\nl = {{}}\nr = {{}}\n[CHAIN]\ns = {{ n = {at}, m = 1, k = {a:?} }}\nt = {{ n = {}, \
             m = 1, k = {a:?} }}\n[RES]\nfirst = {{ between = [\"l\", \"s[0]\"], k = {a:?} }}\nlast = {{ between = [\"t[-1]\", \"r\"], \
             k = {a:?} }}\nstiff = {{ between = [\"s[-1]\", \"t[0]\"], k = {:?}, {method} }}\n[SOX]\nout = {{ from = \"s[3]\" }}\n",
            n - at,
            times * a
        )
    };
    let level = |method: &str| scene(&text(method)).certificate.level;
    assert_eq!(level("method = \"ca\""), Level::Unstable);
    for theta in list(c, "setup/theta") {
        let method = format!("method = \"implicit\", theta = {theta:?}");
        assert_eq!(level(&method), Level::Proven);
        let scene = audited(&text(&method));
        let mut s = scene.state();
        // plucked at a fifth, with the stiff link at its rest length
        for (j, i) in [mats(&scene, "s"), mats(&scene, "t")].concat().into_iter().enumerate() {
            let u = (j + usize::from(j < at)) as f64 / n as f64;
            s.x[i] = 1e-3 * (u / 0.2).min((1.0 - u) / 0.8);
        }
        let mut worst = 0.0f64;
        for t in 0..steps {
            tick(&scene, &mut s);
            let ledger = s.ledger.as_ref().expect("a ledger");
            if t > 0 {
                worst = worst.max(off(ledger.h, ledger.h0));
            }
        }
        within(&format!("A14, theta {theta}"), worst, num(c, "tolerance/energy_rel"));
        let b = s.ledger.as_ref().expect("a ledger").balance();
        within("A14, not explained", b.residual.abs() / b.peak, 1e-12);
    }
}

#[test]
fn a15_beyond_any_limit() {
    let c = case("A15");
    let steps = num(c, "setup/steps") as usize;
    let known = [(0.25, "max_abs_theta_quarter"), (0.5, "max_abs_theta_half")];
    for (i, a) in list(c, "setup/a").into_iter().enumerate() {
        for (theta, values) in known {
            for text in both(&format!("k = {a:?}, method = \"implicit\", theta = {theta:?}")) {
                let scene = scene(&text);
                assert_eq!(scene.certificate.level, Level::Proven);
                let most = largest(&scene, steps);
                within(
                    &format!("A15, a = {a:e}, theta {theta}"),
                    off(most, list(c, &format!("values/{values}"))[i]),
                    1e-4,
                );
                if theta == 0.5 {
                    assert!(most <= num(c, "tolerance/theta_half_max"));
                }
            }
        }
        for text in both(&format!("k = {a:?}")) {
            let scene = scene(&text);
            assert_eq!((scene.certificate.level, largest(&scene, 2000)), (Level::Unstable, f64::INFINITY));
        }
    }
}

#[test]
fn h04_huge_damping() {
    let c = case("H04");
    let (steps, most) = (num(c, "setup/steps") as usize, num(c, "tolerance/max"));
    for b in [1e3, 1e9] {
        for text in both(&format!("k = 0.1, z = {b:?}")) {
            assert_eq!(largest(&scene(&text), 2000), f64::INFINITY);
        }
        for method in ["method = \"centred\"", "method = \"implicit\"", "method = \"implicit\", theta = 0.25"] {
            for text in both(&format!("k = 0.1, z = {b:?}, {method}")) {
                let scene = scene(&text);
                assert_eq!(scene.certificate.level, Level::Proven);
                let found = largest(&scene, steps);
                assert!(found <= most, "b = {b:e}, {method}: {found}");
            }
        }
    }
}

/// From a = 4/(1 − 4θ) on it is unstable, and the certificate agrees.
#[test]
fn the_limit_moves_with_theta() {
    for theta in [0.0, 1.0 / 12.0, 0.2] {
        let limit = 4.0 / (1.0 - 4.0 * theta);
        for (a, level) in [(0.999 * limit, Level::Proven), (1.001 * limit, Level::Unstable)] {
            for text in both(&format!("k = {a:?}, z = 0, method = \"implicit\", theta = {theta:?}")) {
                let scene = scene(&text);
                assert_eq!(scene.certificate.level, level, "{text}");
                assert_eq!(largest(&scene, 100_000) > 1e3, level == Level::Unstable, "{text}");
            }
        }
    }
}

/// Error over one second of a damped oscillator of 20 Hz against its closed form, at `rate` ticks a second.
fn missed(rate: f64, method: &str) -> f64 {
    let (w, s) = (std::f64::consts::TAU * 20.0, 3.0);
    let text = format!(
        "[rate]\nsound = {rate:?}\ngesture = {rate:?}\n[SOL]\nwall = {{}}\n[MAS]\nbob = {{ m = 1, dx0 = 1 }}\n[REF]\nhold = {{ between = \
         [\"wall\", \"bob\"], k = {:?}, z = {:?}, {method} }}\n[SOX]\nout = {{ from = \"bob\" }}\n",
        w * w,
        2.0 * s
    );
    let scene = scene(&text);
    let (mut state, i) = (scene.state(), mat(&scene, "bob"));
    let damped = (w * w - s * s).sqrt();
    let exact = |t: f64| (-s * t).exp() * ((damped * t).cos() + s / damped * (damped * t).sin());
    // the motion into the first tick comes from the exact solution
    state.d[i] = 1.0 - exact(-1.0 / rate);
    let mut worst = 0.0f64;
    for n in 1..=rate as usize {
        tick(&scene, &mut state);
        worst = worst.max((state.x[i] - exact(n as f64 / rate)).abs());
    }
    worst
}

#[test]
fn orders() {
    let order = |method: &str| (missed(4000.0, method) / missed(16_000.0, method)).log2() / 2.0;
    for (method, want) in
        [("method = \"ca\"", 1.0), ("method = \"centred\"", 2.0), ("method = \"implicit\", theta = 0.25", 2.0)]
    {
        within(&format!("order of {method}"), (order(method) - want).abs(), 0.1);
    }
    // centred differences of fourth order without damping; docs/numerics.md §3.1
    let undamped = |rate: f64, theta: f64| {
        let w = std::f64::consts::TAU * 20.0 / rate;
        let scene = scene(&bob(&format!("k = {:?}, method = \"implicit\", theta = {theta:?}", w * w)));
        let (mut s, i) = (scene.state(), mat(&scene, "bob"));
        (s.x[i], s.d[i]) = (1.0, 1.0 - w.cos());
        (1..=rate as usize).fold(0.0f64, |worst, n| {
            tick(&scene, &mut s);
            worst.max((s.x[i] - (w * n as f64).cos()).abs())
        })
    };
    within(
        "order of theta 1/12",
        ((undamped(500.0, 1.0 / 12.0) / undamped(2000.0, 1.0 / 12.0)).log2() / 2.0 - 4.0).abs(),
        0.1,
    );
}

/// A plate on stiff legs with a damper between, pushed, moved by a port and changed by live parameters. The ledgers
/// balance, link by link and also in document order, and the forces at the outputs are those that act.
#[test]
fn ledgers_balance_and_forces_are_whole() {
    let text = "[rate]\nsound = 1\ngesture = 1\n[param]\nkk = { value = 1e4, live = true, min = 1, max = 1e8 }\n\
                [SOL]\nwall = {}\n[ENX]\nhand = {}\n[MAS]\nfree = { m = 2 }\n[CEL]\ncup = { m = 1, k = 1e3, z = 5e2, method = \"implicit\" }\n\
                [MESH]\np = { nx = 5, ny = 4, m = 1, k = 0.3, z = 0.01 }\n[REF]\n\
                leg = { between = [[\"p[0,0]\", \"p[4,3]\", \"cup\"], \"wall\"], k = \"kk\", z = 3, method = \"implicit\", theta = 0.3 }\n\
                grip = { between = [\"hand\", \"p[2,2]\"], k = 40, z = 7, method = \"implicit\" }\n\
                [FRO]\nrub = { between = [\"p[1,1]\", \"free\"], z = 1e6, method = \"centred\" }\n\
                [RES]\nbar = { between = [\"p[3,1]\", \"cup\"], k = 1e9, method = \"implicit\" }\n\
                [ENF]\npush = { to = \"p[2,1]\" }\n[SOX]\nout = { from = \"p[2,2]\" }\n\
                [SOF]\nheard = { from = \"rub\", dc = 0 }\nfree_f = { from = \"free\", dc = 0 }\ngrip_f = { from = \"grip\", dc = 0 }\nhand_f = { from = \"hand\", dc = 0 }\n";
    let fast = audited(text);
    let plain = with(text, &ca_compile::Options { energy: true, ..reference() });
    assert_eq!(fast.certificate.level, Level::Proven, "{:?}", fast.findings);
    let mut ends = Vec::new();
    for scene in [&fast, &plain] {
        let mut s = scene.state();
        let mut controls = scene.controls();
        let (mut rng, free) = (Random(11), mat(scene, "free"));
        let [hand, push] = ["hand", "push"].map(|n| scene.input(n).expect("a port"));
        for n in 0..4000u32 {
            s.input[push] = if n < 2000 { rng.uniform() } else { 0.0 };
            s.input[hand] = 0.1 * (0.01 * f64::from(n)).sin();
            if n % 500 == 250 {
                let to = 10f64.powf(4.0 + 3.0 * rng.uniform());
                let patch = controls.set("kk", to).expect("in range");
                assert!(s.apply(&patch, 100));
            }
            let d = s.d[free];
            tick(scene, &mut s);
            let heard =
                |name: &str| s.output[scene.names.channel_names.iter().position(|c| c == name).expect("a channel")];
            // only the damper acts on `free`, so the force at its output is the one that moved it
            within("force on a mass", (heard("free_f") - 2.0 * (s.d[free] - d)).abs(), 1e-9);
            within("force of a link", (heard("heard") + heard("free_f")).abs(), 1e-9);
            within("force on a port", (heard("hand_f") - heard("grip_f")).abs(), 1e-12);
        }
        let ledger = s.ledger.as_ref().expect("a ledger");
        let b = ledger.balance();
        within("not explained", b.residual.abs() / b.peak, 1e-11);
        // energy is made only at the port, whose motion no link can predict
        for (name, made) in
            (0..scene.counts.n_lia).map(|l| (scene.audited_name(l).unwrap_or("?".into()), ledger.scheme_error[l]))
        {
            within(&format!("made by {name}"), made.abs() / b.peak, if name == "grip" { 1e-2 } else { 1e-11 });
        }
        ends.push(s);
    }
    let at =
        |scene: &Scene, s: &State| (0..4).map(|k| s.output[k]).chain([s.x[mat(scene, "p[4,3]")]]).collect::<Vec<f64>>();
    let far = apart(&at(&fast, &ends[0]), &at(&plain, &ends[1]));
    within("batches and document order", far, 1e-9);
}

#[test]
fn a_change_is_the_scene_of_that_value() {
    let text = |k: f64| {
        bob("k = \"kk\", z = 2, method = \"implicit\"")
            + &format!("[param]\nkk = {{ value = {k:?}, live = true, min = 1, max = 1e6 }}\n")
    };
    let (old, new) = (scene(&text(10.0)), scene(&text(5e5)));
    let mut s = old.state();
    let patch = old.controls().set("kk", 5e5).expect("in range");
    assert!(s.apply(&patch, 1000));
    tick(&old, &mut s);
    tick(&old, &mut s);
    let coefs = |s: &State| s.coef.iter().map(|c| c.to_bits()).collect::<Vec<_>>();
    assert_eq!(coefs(&s), coefs(&new.state()));
    assert!(old.controls().set("kk", 2e6).is_err());
}

/// In space with a direction, and by the method of the group. `ca modes` gives the poles of the scheme.
#[test]
fn a_group_has_a_method() {
    let text = "[rate]\nsound = 1\ngesture = 1\n[a]\ndim = 3\nmethod = \"implicit\"\ntheta = 0.25\n[a.SOL]\nw = {}\n[a.MAS]\nb = { m = 1, \
                x = [1, 0, 0] }\nc = { m = 3, x = [1, 1, 0] }\n[a.REF]\none = { between = [\"a.w\", \"a.b\"], k = 7, z = 0.02, along = [1, 1, 0] }\n\
                two = { between = [\"a.b\", \"a.c\"], k = 50, z = 0.01, along = \"x\" }\nplain = { between = [\"a.w\", \"a.c\"], k = 0.01, \
                along = \"z\", method = \"ca\" }\n[SOX]\nout = { from = \"a.c\", along = \"x\" }\n";
    let scene = scene(text);
    assert_eq!(scene.certificate.level, Level::Proven);
    let codes: Vec<_> = scene.passes.forces.iter().map(ca_core::internal::op::Op::name).collect();
    assert_eq!(codes, ["RES", "REF implicit", "REF implicit", "implicit"]);
    let network = ca_compile::linear(&crate::play::model(text), &catalog(), &ca_compile::Options::default());
    let network = network.expect("it compiles");
    let modes = ca_compile::analysis::modes::modes(&network).expect("they are found");
    let top = modes.list.last().expect("a mode");
    let mut s = scene.state();
    for (name, shape) in network.names.iter().zip(&top.shape) {
        let (module, axis) = name.rsplit_once('.').expect("an axis");
        s.x[mat(&scene, module) + ["x", "y", "z"].iter().position(|a| *a == axis).expect("an axis")] = *shape;
    }
    let at = mat(&scene, "a.b");
    let x: Vec<f64> = (0..4000)
        .map(|_| {
            tick(&scene, &mut s);
            s.x[at]
        })
        .collect();
    let ups: Vec<f64> =
        (1..x.len()).filter(|i| x[i - 1] < 0.0 && x[*i] >= 0.0).map(|i| i as f64 - x[i] / (x[i] - x[i - 1])).collect();
    let f = (ups.len() - 1) as f64 / (ups[ups.len() - 1] - ups[0]);
    within("heard pitch", off(f, top.heard), 2e-3);
    assert!(top.heard < 0.7 * top.f, "{} of {}", top.heard, top.f);
}

/// A plucked string of 30 masses. Every sixth link is far beyond the explicit limit, and one of them has a damper.
fn mixed(more: &str) -> String {
    let mut t = String::from("[rate]\nsound = 1\ngesture = 1\n[SOL]\nl = {}\nr = {}\n[MAS]\n");
    for i in 0..30 {
        let (m, x) = (1.0 + 0.1 * f64::from(i % 4), 0.01 * f64::from(i.min(8)));
        let _ = writeln!(t, "p{i} = {{ m = {m}, dx0 = {x} }}");
    }
    t += "[REF]\n";
    for i in 0..=30 {
        let a = if i == 0 { "l".into() } else { format!("p{}", i - 1) };
        let b = if i == 30 { "r".into() } else { format!("p{i}") };
        let own = match i {
            12 => "k = 1e6, z = 30, method = \"implicit\"",
            _ if i % 6 == 0 => "k = 1e6, method = \"implicit\", theta = 0.25",
            _ => "k = 0.3",
        };
        let _ = writeln!(t, "t{i} = {{ between = [\"{a}\", \"{b}\"], {own} }}");
    }
    t + more
        + "[SOX]\nout = { from = \"p19\" }\n[SOF]\nstiff = { from = \"t18\", dc = 0 }\nheld = { from = \"l\", dc = 0 }\n"
}

/// Springs and stiff links are in one row; stiff links that share no mass are solved one by one. The result agrees with
/// document order, and with one matrix, forced by a link without effect that ties two of them.
#[test]
fn a_row_stays_whole_and_pairs_need_no_matrix() {
    let tied = "tie = { between = [\"p5\", \"p12\"], k = 1e-200, method = \"implicit\" }\n";
    let (row, solved) = (audited(&mixed("")), audited(&mixed(tied)));
    let plain = with(&mixed(""), &ca_compile::Options { energy: true, ..reference() });
    let passes = |s: &Scene| s.passes.forces.iter().map(|o| (o.name(), o.n)).collect::<Vec<_>>();
    assert_eq!(passes(&row)[..2], [("REF implicit", 31), ("implicit pairs", 6)]);
    assert_eq!(
        passes(&solved)[..4],
        [("REF implicit", 31), ("REF implicit", 1), ("implicit", 4), ("implicit pairs", 4)]
    );
    assert_eq!(row.certificate.level, Level::Proven);
    let run = |scene: &Scene| {
        let mut s = scene.state();
        let mut heard: Vec<f64> = Vec::new();
        for _ in 0..3000 {
            tick(scene, &mut s);
            heard.extend(&s.output);
        }
        let b = s.ledger.as_ref().expect("a ledger").balance();
        within("not explained", b.residual.abs() / b.peak, 1e-10);
        heard
    };
    let ours = run(&row);
    assert!(ours.iter().skip(1).step_by(3).any(|f| f.abs() > 1e-3), "the stiff link pulls");
    within("in document order", apart(&ours, &run(&plain)), 1e-9);
    within("in one matrix", apart(&ours, &run(&solved)), 1e-9);
}

/// Unsupported cases are refused with a message, and a scene without implicit links has none of their passes.
#[test]
fn pay_only_for_what_is_used() {
    let s = scene(&bob("k = 1, z = 0.1"));
    assert!(s.layout.implicit.is_none() && s.state().links.implicit.is_empty());
    assert!(s.passes.forces.iter().all(|o| !o.name().starts_with("implicit")));
    let s = scene(&cell("k = 1e9, method = \"implicit\""));
    assert!(s.layout.implicit.is_none(), "a cell needs no matrix");
}

/// Two masses on a spring 10¹² times their mass in stiffness: their common motion loses no digits.
#[test]
fn stiff_ties_cost_no_digits() {
    let p = Pattern::new(2, [(0, 1)].into_iter(), 10).expect("small");
    let mut f = vec![1.0, 2.0];
    assert!(p.factor(&mut f, &mut Vec::new(), [(0, 1, -1e12)].into_iter()), "positive");
    let mut y = [0.75, 0.75];
    p.solve(&f, &mut y);
    assert!((y[0] - 0.5).abs() < 1e-12 && (y[1] - 0.5).abs() < 1e-12, "{y:?}");
}

/// A mesh of 7 x 5 and one long-range tie: A y = b is solved to rounding, in any numbering.
#[test]
fn a_mesh_is_solved() {
    let (w, h) = (7_u32, 5);
    let n = (w * h) as usize;
    let mut ties: Vec<(u32, u32, f64)> = vec![(0, w * h - 1, 3.0)];
    for i in 0..w * h {
        ties.extend((i % w + 1 < w).then_some((i, i + 1, 1.0 + f64::from(i))));
        ties.extend((i + w < w * h).then_some((i, i + w, 1e4 / (1.0 + f64::from(i)))));
    }
    let p = Pattern::new(n, ties.iter().map(|t| (t.0, t.1)), 10_000).expect("small");
    let mut at = vec![0; n];
    p.order.iter().zip(0_u32..).for_each(|(i, k)| at[*i as usize] = k);
    let ties: Vec<(u32, u32, f64)> = ties.into_iter().map(|(i, j, k)| (at[i as usize], at[j as usize], -k)).collect();
    let mut f = vec![0.01; n];
    assert!(p.factor(&mut f, &mut Vec::new(), ties.iter().copied()), "positive");
    let all: Vec<(u32, u32, f64)> = (0..n as u32)
        .map(|i| (i, i, 0.01))
        .chain(ties.iter().flat_map(|(i, j, k)| [(*i, *i, -k), (*j, *j, -k), (*i, *j, *k)]))
        .collect();
    let b: Vec<f64> = (0..n).map(|i| (i as f64).sin()).collect();
    let mut y = b.clone();
    p.solve(&f, &mut y);
    let mut back = vec![0.0; n];
    for (i, j, k) in all {
        back[i as usize] += k * y[j as usize];
        if i != j {
            back[j as usize] += k * y[i as usize];
        }
    }
    let most = y.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
    for (a, b) in back.iter().zip(&b) {
        assert!((a - b).abs() < 1e-11 * most, "{a} {b} of {most}");
    }
    assert!(!p.factor(&mut vec![-1.0; n], &mut Vec::new(), std::iter::empty()), "not positive");
    assert!(Pattern::new(n, (0..n as u32).flat_map(|i| (0..i).map(move |j| (i, j))), 100).is_none(), "too full");
}
