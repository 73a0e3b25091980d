//! Discrete gradients of links that share masses, and ports that run a tick late.

use super::stable::{made, ran};
use crate::play::{Random, audited, mat, with};
use ca_compile::Options;
use ca_core::internal::scene::same_since;
use ca_core::{ARITHMETIC, Level, Scene, State, tick};
use ca_io::perform::Performance;

/// Plays an audited scene for `seconds` under its own gesture.
fn played(scene: &Scene, seconds: f64) -> State {
    let mut p = Performance::new(scene, None).expect("it plays");
    (0..(seconds * scene.rate) as u64).for_each(|_| p.tick());
    p.state.clone()
}

/// A stack of three masses of 10 g under gravity, each a millimetre above the one below at load.
fn stack(k: f64) -> String {
    format!(
        "[r]\ngravity = 9.81\n[r.SOL]\nf = {{}}\n[r.MAS]\na = {{ m = 0.01, x = 1e-3 }}\nb = {{ m = 0.01, x = 2e-3 }}\n\
         c = {{ m = 0.01, x = 3e-3 }}\n[BUT]\ns = {{ between = [[\"r.f\", \"r.a\", \"r.b\"], [\"r.a\", \"r.b\", \"r.c\"]], \
         k = {k:?}, z = 2, method = \"stable\" }}\n[SOX]\no = {{ from = \"r.c\" }}\n"
    )
}

/// A stack settles at the sag given by statics, and no energy is made meanwhile.
#[test]
fn a_stack_stands_where_statics_has_it() {
    for k in [1e4, 1e6, 1e8] {
        let scene = audited(&stack(k));
        assert_eq!(scene.certificate.level, Level::Proven);
        assert!(ran(&scene).contains(&"BUT stable, shared"), "{:?}", ran(&scene));
        assert_eq!(same_since(&scene), 7);
        let s = played(&scene, 10.0);
        let weight = 0.01 * 9.81;
        let top = mat(&scene, "r.c");
        let sag = -s.x[top] - 3e-3;
        let right = 6.0 * weight / k;
        assert!((sag - right).abs() <= 1e-6 * right, "k = {k:e}: {sag:e} in place of {right:e}");
        let made = made(&s);
        assert!(made <= 1e-11, "k = {k:e}: made {made:e} of the peak");
        assert_eq!(s.links.touches.unsolved, 0, "k = {k:e}");
    }
}

/// A mass between two walls, and a row of balls with a power law, make no energy at any stiffness.
#[test]
fn blows_that_are_shared_make_nothing() {
    for (a, most) in [(0.26, 1e-11), (10.0, 1e-11), (1e3, 1e-10), (1e4, 1e-10), (1e8, 1e-6)] {
        let k = a * 1e-3 * 48e3 * 48e3;
        let walls = format!(
            "[SOL]\nl = {{ x = -0.01 }}\nr = {{ x = 0.0137 }}\n[MAS]\nb = {{ m = 1e-3, v = 0.731 }}\n[BUT]\n\
             c = {{ between = [\"l\", \"b\"], k = {k:?}, z = Z, method = \"stable\" }}\n\
             d = {{ between = [\"b\", \"r\"], k = {k:?}, z = Z, method = \"stable\" }}\n[SOX]\no = {{ from = \"b\" }}\n"
        );
        let row = format!(
            "[SOL]\nl = {{}}\nr = {{ x = 5e-3 }}\n[MAS]\na = {{ m = 1e-3, x = 1e-3, v = -0.5 }}\nb = {{ m = 2e-3, x = 2e-3 }}\n\
             c = {{ m = 1e-3, x = 3e-3, v = -1 }}\nd = {{ m = 5e-4, x = 4e-3, v = -2 }}\n[HRZ]\n\
             s = {{ between = [[\"l\", \"a\", \"b\", \"c\", \"d\"], [\"a\", \"b\", \"c\", \"d\", \"r\"]], k = {:?}, method = \"stable\" }}\n\
             [SOX]\no = {{ from = \"a\" }}\n",
            30.0 * k
        );
        for text in [walls.replace('Z', "0"), walls.replace('Z', "110"), row] {
            let scene = audited(&text);
            assert_eq!(scene.certificate.level, Level::Proven, "{text}");
            let s = played(&scene, 4.0);
            let made = made(&s);
            assert!(made <= most, "kT²/m = {a:e}: made {made:e} of the peak\n{text}");
        }
    }
}

/// Contacts that may not pull lose energy where the pull is left out, and make none.
#[test]
fn a_shared_contact_that_never_pulls_only_loses() {
    let text = stack(1e6).replace("z = 2", "z = 200, sticky = false");
    let scene = audited(&text);
    let mut s = scene.state();
    let (mut last, mut pulled) = (f64::INFINITY, 0.0f64);
    for n in 0..48_000 {
        tick(&scene, &mut s);
        let l = s.ledger.as_ref().expect("a ledger");
        assert!(n == 0 || l.h <= last + 1e-12 * l.extremes.peak, "tick {n}: {} after {last}", l.h);
        last = l.h;
        pulled = s.links.tap.iter().fold(pulled, |most, f| most.max(*f));
    }
    assert_eq!(pulled, 0.0);
}

/// A contact that would pull is left out while a curve at the same mass is solved. Noise of ±1 N at the mass.
#[test]
fn a_contact_left_out_beside_a_curve_makes_nothing() {
    let text = "[rate]\nsound = 1\ngesture = 1\n[SOL]\nwall = {}\n[MAS]\na = { m = 7.3e-3 }\nb = { m = 74 }\n\
                [RES]\nheld = { between = [\"a\", \"wall\"], k = 6e-3 }\n\
                [HRZ]\nblow = { between = [\"b\", \"a\"], k = 0.276, method = \"stable3d\" }\n\
                [CUB]\ncurve = { between = [\"a\", \"b\"], k = 4e-4, k3 = 4e-4, method = \"stable\" }\n\
                [SOX]\no = { from = \"a\" }\n[ENF]\nhand = { to = \"a\" }\n";
    let scene = audited(text);
    assert_eq!(scene.certificate.level, Level::Proven);
    for seed in 1..=20 {
        let (mut s, mut noise) = (scene.state(), Random(seed));
        for _ in 0..2_000 {
            s.input[0] = noise.uniform();
            tick(&scene, &mut s);
        }
        let made = made(&s);
        assert!(made <= 1e-11, "seed {seed}: made {made:e} of the peak");
        assert_eq!(s.links.touches.unsolved, 0, "seed {seed}");
    }
}

/// Sweeps find what Newton's method alone finds, as takes of arithmetic 6 have it: soft and stiff contacts and springs
/// with common masses.
#[test]
fn sweeps_find_the_solution_of_newtons_method() {
    let row = |stiff: f64| {
        format!(
            "[SOL]\nl = {{}}\n[MAS]\na = {{ m = 1e-3, x = 1e-3, v = -0.5 }}\nb = {{ m = 2e-3, x = 2e-3 }}\nc = {{ m = 1e-3, x = 3e-3, v = -1 }}\n\
             [HRZ]\ns = {{ between = [[\"l\", \"a\", \"b\"], [\"a\", \"b\", \"c\"]], k = {:?}, method = \"stable\" }}\n\
             [CUB]\nr = {{ between = [[\"l\", \"a\"], [\"b\", \"c\"]], k = {:?}, k3 = {:?}, z = 0.01, method = \"stable\" }}\n\
             [SOX]\no = {{ from = \"a\" }}\n",
            30.0 * stiff,
            stiff,
            1e4 * stiff
        )
    };
    for text in [row(1e2), row(1e4), row(1e6), stack(1e4), stack(1e8)] {
        let now = with(&text, &Options::default());
        let old = with(&text, &Options { arithmetic: Some(6), ..Options::default() });
        assert_eq!(same_since(&now), 7, "{text}");
        let [mut a, mut b] = [now.state(), old.state()];
        for n in 0..400 {
            tick(&now, &mut a);
            tick(&old, &mut b);
            for (i, (x, y)) in a.x.iter().zip(b.x.iter()).enumerate() {
                assert!((x - y).abs() <= 1e-12 * y.abs().max(1e-3), "tick {n}, slot {i}: {x:e} and {y:e}\n{text}");
            }
        }
    }
}

/// Links that share no mass form separate clusters, and each plays the same bits as alone. The two stacks stand on
/// one fixed point. Takes of arithmetic 7 are solved as one cluster.
#[test]
fn each_cluster_plays_as_if_alone() {
    let second = |text: &str| {
        let named =
            ["r.a", "r.b", "r.c"].iter().fold(text.to_owned(), |t, name| t.replace(name, &name.replace("r.", "r.u")));
        named
            .replace("\na = {", "\nua = {")
            .replace("\nb = {", "\nub = {")
            .replace("\nc = {", "\nuc = {")
            .replace("s = {", "t = {")
    };
    let (soft, hard) = (stack(1e4), second(&stack(1e7)));
    let part = |text: &str, from: &str, to: &str| {
        let begin = text.find(from).expect("it is there");
        text[begin + from.len()..begin + text[begin..].find(to).expect("it ends")].to_owned()
    };
    let masses = part(&hard, "[r.MAS]\n", "[BUT]");
    let links = part(&hard, "[BUT]\n", "[SOX]");
    let both = soft.replace("[BUT]\n", &format!("{masses}[BUT]\n{links}")) + "p = { from = \"r.uc\" }\n";
    let [one, two, both, old] = [(&soft, None), (&hard, None), (&both, None), (&both, Some(7))]
        .map(|(text, arithmetic)| with(text, &Options { arithmetic, ..Options::default() }));
    assert_eq!([same_since(&one), same_since(&both), same_since(&old)], [7, ARITHMETIC, 7]);
    let [mut a, mut b, mut s, mut t] = [&one, &two, &both, &old].map(|scene| scene.state());
    let mut other = false;
    for n in 0..20_000 {
        for (scene, s) in [(&one, &mut a), (&two, &mut b), (&both, &mut s), (&old, &mut t)] {
            tick(scene, s);
        }
        for name in ["r.a", "r.b", "r.c"] {
            assert_eq!(a.x[mat(&one, name)], s.x[mat(&both, name)], "{name} at {n}");
            let name = name.replace("r.", "r.u");
            assert_eq!(b.x[mat(&two, &name)], s.x[mat(&both, &name)], "{name} at {n}");
            other |= s.x[mat(&both, &name)] != t.x[mat(&old, &name)];
        }
    }
    assert!(other, "the bits of arithmetic 7 differ");
}

/// Energy gathered in 10 s by the rounding of positions: of masses that drift, and of a mass between two contacts that
/// leave no gap. docs/numerics.md §3.3 has these figures.
#[test]
fn rounding_of_positions_is_gathered() {
    let drift = "[MAS]\na = { m = 0.01, v = 1 }\nb = { m = 0.01, v = 1.1 }\n[CUB]\n\
                 l = { between = [\"a\", \"b\"], k = 1e6, k3 = 1, method = \"stable\" }\n[SOX]\no = { from = \"a\" }\n";
    let held = "[MAS]\na = { m = 0.01, v = 1 }\n[SOL]\nf = { x = -0.01 }\ng = { x = -0.01 }\n[BUT]\n\
                l1 = { between = [\"f\", \"a\"], k = 1e7, method = \"stable\" }\n\
                l2 = { between = [\"a\", \"g\"], k = 1e7, method = \"stable\" }\n[SOX]\no = { from = \"a\" }\n";
    for (text, figure) in [(drift, 1.7e-10), (held, 1.3e-9)] {
        let scene = audited(text);
        assert_eq!(scene.certificate.level, Level::Proven);
        let made = made(&played(&scene, 10.0));
        assert!((0.5 * figure..2.0 * figure).contains(&made), "{made:e}\n{text}");
    }
}

const PULSES: &str = "[gesture]\nh = { pulse = \"3 mm\", every = 0.2, rise = 0.006, hold = 0.01, fall = 0.02, offset = \"-2 mm\", to = 2 }\n";

/// The energy given by a moving port is stored or lost: a contact by both methods, friction by Newton's method, and an
/// implicit spring; at ports in every sample, across the rate boundary, and with several ticks in a sample.
#[test]
fn what_a_moving_port_gives_is_stored_or_lost() {
    let bell = "[CEL]\nb = { m = 5e-3, f = 200, t60 = 1 }\n[SOX]\no = { from = \"b\" }\n";
    let contact = |method: &str| {
        format!("{bell}[BUT]\nc = {{ between = [\"h\", \"b\"], k = 2e5, method = \"{method}\" }}\n{PULSES}")
    };
    let bow = "[CEL]\nb = { m = 2e-3, k = 2000 }\n[SOX]\no = { from = \"b\" }\n[BOW]\n\
               c = { between = [\"h\", \"b\"], f = 0.5, v0 = 0.01, method = \"newton\" }\n[gesture]\nh = { sine = 5e-3, f = 30, to = 2 }\n";
    let spring =
        format!("[model]\nmethod = \"implicit\"\n{bell}[RES]\nc = {{ between = [\"h\", \"b\"], k = 2e7 }}\n{PULSES}");
    for link in [contact("stable"), contact("stable3d"), bow.to_string(), spring] {
        for port in ["[ENX]\nh = { x = \"-2 mm\" }\n", "[TGR]\nh = { x = \"-2 mm\" }\n"] {
            for rate in ["", "[rate]\noversample = 2\n", "[rate]\nborder = \"hold\"\n", "[rate]\ngesture = 48000\n"] {
                let text = format!("{rate}{port}{link}");
                let scene = audited(&text);
                assert_eq!(scene.certificate.level, Level::Proven, "{text}");
                assert_eq!(scene.layout.ports.ahead.len(), 1, "{text}");
                let s = played(&scene, 2.0);
                let l = s.ledger.as_ref().expect("a ledger");
                let work: f64 = l.work.iter().sum();
                // a belt that is held and jumps is too fast for the bow to grip
                let least = if rate.contains("hold") { 0.0 } else { 1e-6 };
                assert!(work > least, "the port gives {work} J\n{text}");
                let made = made(&s);
                assert!(made <= 1e-11, "made {made:e} of the peak\n{text}");
            }
        }
    }
}

/// Only ports at links that use the coming motion run a tick late. Takes of an older arithmetic are compiled as before.
#[test]
fn only_such_ports_run_a_tick_late() {
    let text = "[ENX]\nh = {}\nfree = {}\n[CEL]\nb = { m = 5e-3, f = 200 }\nc = { m = 5e-3, f = 200 }\n[BUT]\n\
                s = { between = [\"h\", \"b\"], k = 2e5, method = \"stable\" }\ne = { between = [\"free\", \"c\"], k = 2e5 }\n\
                [SOX]\no = { from = \"b\" }\np = { from = \"c\" }\n";
    let now = with(text, &Options::default());
    let old = with(text, &Options { arithmetic: Some(5), ..Options::default() });
    assert_eq!((now.layout.ports.ahead.len(), old.layout.ports.ahead.len()), (1, 0));
    let (h, free) = (mat(&now, "h"), mat(&now, "free"));
    let [mut a, mut b] = [now.state(), old.state()];
    let mut before = 0.0;
    for n in 0..100 {
        let at = 1e-4 * f64::from(n);
        for s in [&mut a, &mut b] {
            s.input.fill(at);
        }
        tick(&now, &mut a);
        tick(&old, &mut b);
        assert_eq!([a.x[h], a.x[free]], [before, at], "tick {n}");
        assert_eq!([b.x[h], b.x[free]], [at, at], "tick {n}");
        before = at;
    }
}
