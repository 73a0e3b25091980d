//! Links whose slope depends on elongation are judged within reach of the energy at load or of a port's stroke.

use crate::play::{off, scene, within};
use ca_core::{Level, tick};

/// A gram with initial speed `v` on a spring.
fn bob(v: f64, spring: &str) -> String {
    format!("[SOL]\nw = {{}}\n[MAS]\nb = {{ m = 1e-3, v = {v:?} }}\n{spring}\n[SOX]\no = {{ from = \"b\" }}\n")
}

/// Soft up to a millimetre, steep beyond.
const TABLE: &str =
    "[LNL]\nc = { between = [\"w\", \"b\"], spring = [[-0.01, -1e5], [-0.001, -1], [0.001, 1], [0.01, 1e5]] }";

/// True if any finding has this code and these words.
fn found(s: &ca_compile::Compiled, code: &str, words: &str) -> bool {
    s.findings.list.iter().any(|d| {
        let labels = format!("{d:?}");
        d.code == code && labels.contains(words)
    })
}

/// The steep part counts from the speed at which a tick can carry the mass past the soft part.
#[test]
fn a_table_is_judged_where_it_is_reached() {
    let soft = scene(&bob(0.01, TABLE));
    assert_eq!((soft.certificate.level, soft.findings.list.len()), (Level::RuleOfThumb, 0));
    assert_eq!(soft.certificate.rules.decides, "c");
    within("the slope of the soft part", off(soft.certificate.bound, 1e3 / 1e-3 / 48e3 / 48e3), 1e-9);
    // all of ½ m v² is stored at the bend for v = √(k x²/m) = 1; one tick before, some is still motion
    let a = 1e3 / 1e-3 / 48e3 / 48e3;
    let bend = 1.0 / (1.0_f64 + a).sqrt();
    for (v, level) in [(bend * (1.0 - 1e-6), Level::RuleOfThumb), (bend * (1.0 + 1e-6), Level::NotProven)] {
        let s = scene(&bob(v, TABLE));
        assert_eq!(s.certificate.level, level, "{v}");
        assert_eq!(found(&s, "W107", "decisive: a slope of up to"), level == Level::NotProven, "{:?}", s.findings.list);
    }
}

/// A scene that is called stable within its reach keeps its energy.
#[test]
fn what_is_not_reached_does_not_matter() {
    let s = scene(&bob(0.01, TABLE));
    let mut state = s.state();
    let mut fastest = 0.0_f64;
    for _ in 0..96_000 {
        tick(&s, &mut state);
        fastest = fastest.max(state.d.iter().fold(0.0, |m: f64, d| m.max(d.abs())) * s.rate);
    }
    within("the largest speed", off(fastest, 0.01), 1e-3);
}

/// F = k e + k3 e³ and F = q |e|^p: slope at the elongation that stores the energy, plus the step of a tick.
#[test]
fn a_spring_that_hardens_is_judged_at_its_energy() {
    for (spring, held, slope) in [
        (
            "[CUB]\nc = { between = [\"w\", \"b\"], k3 = 1e12 }",
            (|u: f64| (4.0 * u / 1e12).sqrt().sqrt()) as fn(f64) -> f64,
            (|e: f64| 3e12 * e * e) as fn(f64) -> f64,
        ),
        (
            "[POW]\nc = { between = [\"w\", \"b\"], q = 1e8, p = 2 }",
            |u: f64| (3.0 * u / 1e8).cbrt(),
            |e: f64| 2e8 * e.abs(),
        ),
    ] {
        for v in [0.01, 0.1, 1.0] {
            let s = scene(&bob(v, spring));
            let e = held(0.5e-3 * v * v);
            let (least, most) = (slope(e), slope(e + v / 48e3));
            let bound = s.certificate.bound * 1e-3 * 48e3 * 48e3;
            assert!(bound >= least * (1.0 - 1e-9) && bound <= most, "{spring}, {v}: {bound}, {least} … {most}");
            assert!(s.certificate.rules.open.is_empty() && s.certificate.rules.decides == "c");
        }
    }
    let steep = scene(&bob(10.0, "[CUB]\nc = { between = [\"w\", \"b\"], k = 1000, k3 = 1e14 }"));
    assert_eq!(steep.certificate.level, Level::NotProven);
    assert!(steep.certificate.margin() < 1.0 && found(&steep, "W107", "energy at load"), "{:?}", steep.findings.list);
}

/// A spring at a port is judged at the stroke of its built-in gesture; without a gesture it is listed as open.
#[test]
fn a_spring_at_a_port_is_judged_at_its_stroke() {
    let text = |gesture: &str| {
        format!(
            "[ENX]\nh = {{}}\n[MAS]\nb = {{ m = 1e-3 }}\n[CUB]\nc = {{ between = [\"h\", \"b\"], k = 1000, k3 = 1e10 }}\n[SOX]\n\
             o = {{ from = \"b\" }}\n{gesture}"
        )
    };
    let s = scene(&text("[gesture]\nh = { sine = 5e-3, f = 30, to = 2 }\n"));
    within("at the stroke", off(s.certificate.bound * 1e-3 * 48e3 * 48e3, 1e3 + 3e10 * 25e-6), 1e-3);
    let s = scene(&text(""));
    assert_eq!(s.certificate.rules.open, ["c"]);
    within("at rest", off(s.certificate.bound * 1e-3 * 48e3 * 48e3, 1e3), 1e-9);
    let s = scene(
        "[g]\ngravity = 9.81\n[g.SOL]\nw = {}\n[g.MAS]\nb = { m = 1e-3 }\n[CUB]\nc = { between = [\"g.w\", \"g.b\"], k3 = 1e10 }\n[SOX]\no = { from = \"g.b\" }\n",
    );
    assert_eq!(s.certificate.rules.open, ["c"]);
}

#[test]
fn a_hertz_contact_is_judged_at_its_depth() {
    let text = |v: f64| {
        format!(
            "[SOL]\nw = {{}}\n[MAS]\nb = {{ m = 1e-3, x = 1e-3, v = {v:?} }}\n[HRZ]\nc = {{ between = [\"w\", \"b\"], k = 1e10 }}\n[SOX]\no = {{ \
             from = \"b\" }}\n"
        )
    };
    let s = scene(&text(-1.0));
    let deep = (2.5 * 0.5e-3 / 1e10_f64).powf(0.4);
    let [least, most] = [deep, deep + 1.0 / 48e3].map(|eta| 1.5e10 * eta.sqrt() / 1e-3 / 48e3 / 48e3);
    let is = s.certificate.rules.contact;
    assert!(is >= least * (1.0 - 1e-9) && is <= most, "{is}, {least} … {most}");
    assert!(found(&s, "W117", "energy at load"), "{:?}", s.findings.list);
    // the advised softer contact is pressed deeper, and stays below the limit all the same
    let help = s.findings.list.iter().find(|d| d.code == "W117").and_then(|d| d.help.as_deref()).unwrap_or_default();
    let share: f64 = help.split("at most ").nth(1).and_then(|t| t.split(' ').next()?.parse().ok()).expect("a share");
    let softer = scene(&text(-1.0).replace("k = 1e10", &format!("k = {:e}", 1e8 * share)));
    assert!(softer.certificate.rules.closed < 4.0, "{help}");
    let s = scene(&text(-1e-5));
    assert!(s.certificate.rules.closed < 1.0 && s.findings.list.is_empty(), "{:?}", s.certificate);
}

/// Contacts are judged with their viscosity: beyond the limit such a scene diverges, below it does not.
#[test]
fn a_contact_that_is_unstable_while_it_presses_is_reported() {
    let link = |kind: &str, args: &str| {
        format!(
            "[SOL]\nl = {{ x = -0.01 }}\nr = {{ x = 0.0137 }}\n[MAS]\nb = {{ m = 1e-3, v = 0.731 }}\n[{kind}]\nc = {{ between = [\"l\", \"b\"], {args} }}\nd = \
             {{ between = [\"b\", \"r\"], {args} }}\n[SOX]\no = {{ from = \"b\" }}\n"
        )
    };
    for (kind, more) in [("BUT", ""), ("PLK", ", d = 5e-3")] {
        let text = |z: f64| link(kind, &format!("k = 1e3, z = {z:?}{more}"));
        let z = 0.5 * (4.0 - 1e3 / 1e-3 / 48e3 / 48e3) * 1e-3 * 48e3;
        let [below, above] = [0.999 * z, 1.001 * z].map(|z| scene(&text(z)));
        assert!(!found(&below, "W117", "`c`"), "{kind}: {:?}", below.findings.list);
        assert!(found(&above, "W117", "the limit is 4"), "{kind}: {:?}", above.findings.list);
        assert!(found(&above, "W117", "keep `z` below 95"), "{kind}: {:?}", above.findings.list);
        assert!(found(&above, "W117", "use `method ="), "{kind}: {:?}", above.findings.list);
        assert_eq!(above.certificate.level, Level::RuleOfThumb, "the permanent part is stable");
        assert!(above.certificate.margin() < 1.0 && below.certificate.margin() > 1.0);
        let s = scene(&text(110.0));
        assert!(found(&s, "W117", "`c`"));
    }
}
