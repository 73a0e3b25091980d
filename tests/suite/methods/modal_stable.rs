//! Links with `stable` methods and friction at modal masses: energy is kept, and they move as explicit masses do.

use crate::methods::stable::{made, only_falls, ran};
use crate::play::{apart, audited, rel_l2, scene, within};
use ca_core::{Level, Scene, tick};
use std::collections::BTreeMap;
use std::fmt::Write as _;

const N: usize = 24;

/// Lines by section.
type Lines = Vec<(&'static str, String)>;

/// A lossless string between walls, T = 1, T²k/m = 0.25, in the group `low`, by `method`; and `more`.
fn string(method: &str, more: &Lines) -> String {
    let mut masses = String::new();
    for i in 0..N {
        let _ = writeln!(masses, "s{i} = {{ m = 1 }}");
    }
    let names = |from: usize, to: usize| (from..to).map(|i| format!("\"low.s{i}\"")).collect::<Vec<_>>().join(", ");
    let mut sections: BTreeMap<&str, String> = BTreeMap::new();
    for (section, line) in more {
        *sections.entry(section).or_default() += line;
    }
    let text = |(section, lines): (_, &String)| format!("[{section}]\n{lines}");
    let more: String = sections.iter().map(text).collect();
    format!(
        "[rate]\nsound = 1\ngesture = 1\n[low]\nmethod = \"{method}\"\n[low.SOL]\nl = {{}}\nr = {{}}\n[low.MAS]\n{masses}[low.RES]\n\
         k = {{ between = [[\"low.l\", {}], [{}, \"low.r\"]], k = 0.25 }}\n[SOX]\nout = {{ from = \"low.s7\" }}\n{more}",
        names(0, N),
        names(0, N),
    )
}

/// A heavy mass on a soft spring, displaced by `low`, that falls on the string many times.
fn hammer(name: &str, place: usize, low: f64, law: &'static str, contact: &str) -> Lines {
    vec![
        ("CEL", format!("{name} = {{ m = 3, k = 3e-4, dx0 = {low:?} }}\n")),
        (law, format!("{name}_hit = {{ between = [\"{name}\", \"low.s{place}\"], {contact} }}\n")),
        ("SOF", format!("{name}_f = {{ from = \"{name}_hit\" }}\n")),
    ]
}

/// Largest relative change of energy, and the number of blows at output `channel`.
fn drift(scene: &Scene, ticks: usize, channel: usize) -> (f64, usize) {
    let mut s = scene.state();
    let (mut worst, mut blows, mut pressed) = (0.0f64, 0, false);
    for n in 0..ticks {
        tick(scene, &mut s);
        let ledger = s.ledger.as_ref().expect("a ledger");
        if n > 0 {
            worst = worst.max((ledger.h / ledger.h0 - 1.0).abs());
        }
        let force = s.output[channel] != 0.0;
        blows += usize::from(force && !pressed);
        pressed = force;
    }
    let b = s.ledger.as_ref().expect("a ledger").balance();
    within("not explained", b.residual.abs() / b.peak, 1e-12);
    within("made by a contact", made(&s), 1e-12);
    (worst, blows)
}

/// One contact of any stiffness over many blows: proven, and the energy is kept to rounding.
#[test]
fn a_contact_at_a_string_of_modes_keeps_the_energy() {
    for k in [1e-2, 1.0, 1e2, 1e4, 1e6, 1e8] {
        let scene =
            audited(&string("modal", &hammer("h", 7, -1e-2, "BUT", &format!("k = {k:?}, method = \"stable\""))));
        assert_eq!(scene.certificate.level, Level::Proven, "{:?}", scene.certificate);
        // in closed form, until its depth is small beside the rounding of positions
        let pass = if k > 1e3 { "BUT stable3d" } else { "BUT stable" };
        assert!(ran(&scene).contains(&pass), "{:?}", ran(&scene));
        let (worst, blows) = drift(&scene, 60_000, 1);
        assert!(blows > 100, "{blows} blows at k = {k:e}");
        within(&format!("kT²/m = {k:e}, {blows} blows"), worst, 1e-12);
    }
}

/// Contacts at several masses of one string, and between two of them, are solved together and keep the energy.
#[test]
fn contacts_that_share_a_string_of_modes_keep_the_energy() {
    for k in [1e-2, 1.0, 1e2, 1e4, 1e6, 1e8] {
        let contact = format!("k = {k:?}, method = \"stable\"");
        let mut more = hammer("h", 7, -1e-2, "BUT", &contact);
        more.extend(hammer("g", 15, -1.3e-2, "BUT", &contact));
        more.push(("BUT", format!("rattle = {{ between = [\"low.s3\", \"low.s19\"], d = -1e-3, {contact} }}\n")));
        // one at the same mass, from the other side
        more.push(("SOL", "wall = { x = 2e-3 }\n".into()));
        more.push(("BUT", format!("stop = {{ between = [\"low.s7\", \"wall\"], {contact} }}\n")));
        let scene = audited(&string("modal", &more));
        assert_eq!(scene.certificate.level, Level::Proven, "{:?}", scene.certificate);
        let passes = ran(&scene);
        assert!(passes.contains(&"BUT stable3d") && !passes.contains(&"BUT stable"), "{passes:?}");
        let (worst, blows) = drift(&scene, 40_000, 1);
        assert!(blows > 50, "{blows} blows at k = {k:e}");
        within(&format!("together, kT²/m = {k:e}, {blows} blows"), worst, 1e-12);
    }
}

fn play(scene: &Scene, ticks: usize) -> Vec<f64> {
    let mut s = scene.state();
    (0..ticks)
        .map(|_| {
            tick(scene, &mut s);
            s.output[0]
        })
        .collect()
}

#[test]
fn free_masses_by_their_modes_are_masses() {
    let balls = |method: &str, contact: &str| {
        format!(
            "[rate]\nsound = 1\ngesture = 1\n[b]\nmethod = \"{method}\"\n[b.MAS]\np = {{ m = 2, x = 0.4 }}\nq = {{ m = 3, x = 1.1 }}\n\
             [SOL]\nlow = {{}}\n[CEL]\nlid = {{ m = 5, k = 1e-3, x = 1.4, dx0 = 1 }}\n[BUT]\n{contact}[SOX]\nout = {{ from = \"b.q\" }}\n"
        )
    };
    let one =
        |k: f64, method: &str| format!("hit = {{ between = [\"b.q\", \"lid\"], k = {k:?}, method = \"{method}\" }}\n");
    let three = |k: f64| {
        one(k, "stable3d")
            + &format!(
                "floor = {{ between = [\"low\", \"b.p\"], k = {k:?}, method = \"stable3d\" }}\n\
                 meet = {{ between = [\"b.p\", \"b.q\"], k = {k:?}, method = \"stable3d\" }}\n"
            )
    };
    for k in [1e-2, 1.0, 1e4, 1e8] {
        for (contact, what) in
            [(one(k, if k > 1e3 { "stable3d" } else { "stable" }), "one contact"), (three(k), "three")]
        {
            let [modal, plain] = ["modal", "ca"].map(|method| scene(&balls(method, &contact)));
            let ticks = 400;
            let [modal, plain] = [modal, plain].map(|s| play(&s, ticks));
            let flies = plain.windows(2).all(|x| x[0] == x[1]);
            assert!(!flies, "{what}: nothing hits");
            within(&format!("{what}, k = {k:e}"), apart(&modal, &plain), 1e-12);
        }
    }
}

/// Against the string of masses at 64 times the rate: modes are nearer to it than masses at the rate itself.
#[test]
fn a_blow_on_modes_is_that_on_a_string_of_masses_at_a_higher_rate() {
    let text = |method: &str, law: &'static str, contact: &str| string(method, &hammer("h", 7, -1e-2, law, contact));
    for (law, contact) in [("BUT", "k = 0.02"), ("HRZ", "k = 0.3, p = 1.5")] {
        let stable = format!("{contact}, method = \"stable\"");
        let ticks = 2500;
        let fine = crate::play::with(
            &text("ca", law, &stable),
            &ca_compile::Options { rate: Some(64.0), ..ca_compile::Options::default() },
        );
        let truth: Vec<f64> = play(&fine, ticks * 64).into_iter().step_by(64).collect();
        let [modal, plain] = ["modal", "ca"].map(|method| play(&scene(&text(method, law, &stable)), ticks));
        let [modal, plain] = [modal, plain].map(|x| rel_l2(&x, &truth));
        within(&format!("{law} by modes, masses {plain:.1e}"), modal, 0.02);
        assert!(modal < 0.5 * plain, "{law}: {modal} {plain}");
    }
}

/// With losses, friction and contacts that never pull, alone and together, energy only falls and ledgers balance.
#[test]
fn what_loses_only_loses() {
    let rub = |method: &str| {
        let (curve, v0) = if method == "set-valued" { ("coulomb", "") } else { ("smooth", ", v0 = 1e-6") };
        let law = format!("curve = \"{curve}\", f = 1e-4{v0}, method = \"{method}\"");
        let lines: Lines = vec![
            ("SOL", "felt = {}\n".into()),
            ("BOW", format!("rub = {{ between = [\"felt\", \"low.s12\"], {law} }}\n")),
        ];
        lines
    };
    let start = |more: &Lines| string("modal", more).replace("s12 = { m = 1 }", "s12 = { m = 1, dx0 = 5e-3 }");
    let hit = |law: &'static str, more: &str| hammer("h", 7, -1e-2, law, &format!("{more}, method = \"stable\""));
    let falls = |more: &Lines| {
        let text = start(more);
        let end = only_falls(&audited(&text), 8000, 1e-12, &text, |_| ());
        let ledger = end.ledger.as_ref().expect("a ledger");
        assert!(ledger.h < 0.999 * ledger.h0, "{} of {} is left\n{text}", ledger.h, ledger.h0);
    };
    for contact in [
        hit("BUT", "k = 1e5, z = 30"),
        hit("BUT", "k = 10, z = 3, sticky = false"),
        hit("HRZ", "k = 1e7, p = 2.5, h = 5"),
    ] {
        falls(&contact);
        for method in ["secant", "newton", "set-valued"] {
            falls(&rub(method));
            falls(&[contact.clone(), rub(method)].concat());
        }
    }
}

#[test]
fn nothing_is_paid_without() {
    let with = |contact: &str| scene(&string("modal", &hammer("h", 7, -1e-2, "BUT", contact)));
    let explicit = with("k = 0.01");
    assert!(explicit.places.solved_modal.is_empty() && explicit.hand.couplings.is_empty());
    assert!(!ran(&explicit).iter().any(|name| name.starts_with("modes ")), "{:?}", ran(&explicit));
    let elsewhere: Lines = vec![
        ("SOL", "w = {}\n".into()),
        ("MAS", "m = { m = 1, x = 1, v = -0.1 }\n".into()),
        ("BUT", "hit = { between = [\"w\", \"m\"], k = 1, method = \"stable\" }\n".into()),
    ];
    let elsewhere = scene(&string("modal", &elsewhere));
    assert!(elsewhere.places.solved_modal.is_empty(), "{:?}", elsewhere.places.solved_modal);
    let single = with("k = 0.01, method = \"stable\"");
    assert!(single.places.solved_modal.len() == 1 && single.hand.couplings.is_empty());
}
