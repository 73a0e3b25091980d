//! Laws that act on both sides, by their potential: CUB, POW, LNL, ATT and PLK with `method = "stable"`.

use super::stable::{heat, made, only_falls, ran};
use crate::laws::references::duffing;
use crate::play::{audited, model, scene, within};
use ca_compile::Options;
use ca_core::Level;
use ca_io::perform::Performance;
use ca_tests::catalog;

/// Each law with a slope of about `k` \[N/m\] at 1 mm. The last two are rising tables, alone and with friction.
fn laws(k: f64) -> [(&'static str, String); 6] {
    let table = |points: &[[f64; 2]]| {
        let points: Vec<String> = points.iter().map(|[x, y]| format!("[{:?}, {:?}]", x * 1e-3, y * 1e-3 * k)).collect();
        format!("[{}]", points.join(", "))
    };
    let rising = table(&[[-3.0, -5.0], [-1.0, -1.0], [-0.4, -0.1], [0.5, 0.2], [1.1, 1.0], [2.0, 3.5]]);
    [
        ("CUB", format!("k = {:?}, k3 = {:?}", 0.3 * k, 0.3e6 * k)),
        ("POW", format!("k = {:?}, q = {:?}, p = 1.75", 0.1 * k, k / 1e-3f64.powf(0.75) / 1.75)),
        ("PLK", format!("k = {k:?}, d = 1e-3")),
        ("ATT", format!("k = {k:?}, d = 2e-3, rho = 0.4")),
        ("LNL", format!("spring = {rising}")),
        ("LNL", format!("spring = {rising}, friction = [[-2, -0.5], [-0.1, -0.3], [0.2, 0.4], [3, 0.2]]")),
    ]
}

/// Largest energy that rounding of positions makes, relative to the peak.
fn tolerance(a: f64) -> f64 {
    (1e-14 * a).max(1e-11)
}

/// A mass on one such link to a wall passes through rest at several speeds.
#[test]
fn nothing_is_made_at_any_stiffness() {
    for a in [0.26, 0.9, 10.0, 1e3, 1e4, 1e8] {
        for (kind, law) in laws(a * 1e-3 * 48e3 * 48e3) {
            for (x, v, z) in [(0.3e-3, 0.0, ""), (-1.4e-3, 2.7, ""), (0.2e-3, 31.0, ", z = 0.4")] {
                let z = if kind == "LNL" { "" } else { z };
                let text = format!(
                    "[SOL]\nwall = {{}}\n[MAS]\nbob = {{ m = 1e-3, dx0 = {x:?}, v = {v:?} }}\n[{kind}]\n\
                     l = {{ between = [\"wall\", \"bob\"], {law}{z}, method = \"stable\" }}\n[SOX]\nout = {{ from = \"bob\" }}\n"
                );
                let scene = audited(&text);
                assert_eq!(scene.certificate.level, Level::Proven, "{text}");
                let s = only_falls(&scene, 20_000, tolerance(a), &text, |_| {});
                let made = made(&s);
                assert!(made <= tolerance(a), "kT²/m = {a:e}: made {made:e} of the peak\n{text}");
            }
        }
    }
}

/// Rows of such links between different masses, beside a contact and friction, make no energy together.
#[test]
fn nothing_is_made_where_masses_are_shared() {
    for (a, tolerance) in [(0.26, 1e-11), (10.0, 1e-11), (1e3, 1e-9), (1e4, 1e-8)] {
        let mut most = 0.0f64;
        let all = laws(a * 1e-3 * 48e3 * 48e3);
        let rising: Vec<&(&str, String)> = all.iter().filter(|(kind, _)| *kind != "ATT").collect();
        for first in 0..rising.len() {
            for more in ["", "[BOW]\nrub = { between = [\"wall\", \"b\"], f = 0.2, v0 = 0.05, method = \"secant\" }\n"]
            {
                let link = |at: usize, name: &str, ends: &str| {
                    let (kind, law) = rising[(first + at) % rising.len()];
                    format!("[{kind}]\n{name} = {{ between = [{ends}], {law}, method = \"stable\" }}\n")
                };
                let links =
                    [link(0, "p", "\"wall\", \"a\""), link(1, "q", "\"a\", \"b\""), link(2, "r", "\"b\", \"c\"")];
                let mut sections: Vec<(String, String)> = Vec::new();
                for link in &links {
                    let (head, body) = link.split_once('\n').expect("a head");
                    match sections.iter_mut().find(|(known, _)| known == head) {
                        Some((_, all)) => all.push_str(body),
                        None => sections.push((head.into(), body.into())),
                    }
                }
                let links = sections.iter().fold(String::new(), |all, (head, body)| all + head + "\n" + body);
                let text = format!(
                    "[SOL]\nwall = {{}}\n[MAS]\na = {{ m = 1e-3, dx0 = 0.4e-3 }}\nb = {{ m = 4e-4, v = 1.3 }}\n\
                     c = {{ m = 2e-3, v = -0.8 }}\n{links}[BUT]\nt = {{ between = [\"wall\", \"c\"], k = {:?}, d = -2e-3, \
                     method = \"stable\" }}\n{more}[SOX]\nout = {{ from = \"c\" }}\n",
                    a * 48e3 * 48e3 * 1e-3
                );
                let scene = audited(&text);
                assert_eq!(scene.certificate.level, Level::Proven, "{text}");
                assert!(ran(&scene).iter().any(|law| law.ends_with("stable, shared")), "{:?}", ran(&scene));
                // beside friction, contacts use energy quadratisation
                let contact = if more.is_empty() { "BUT stable, shared" } else { "BUT stable3d" };
                assert!(ran(&scene).contains(&contact), "{:?}", ran(&scene));
                let s = only_falls(&scene, 20_000, tolerance, &text, |_| {});
                let made = made(&s);
                most = most.max(made);
                assert!(made <= tolerance, "kT²/m = {a:e}: made {made:e} of the peak\n{text}");
                assert_eq!(s.links.touches.unsolved, 0, "{text}");
            }
        }
        println!("kT²/m = {a:e}: made at most {most:e} of the peak");
    }
}

#[test]
fn what_a_moving_port_gives_is_stored_or_lost() {
    for (kind, law) in laws(2e5) {
        let text = format!(
            "[ENX]\nh = {{}}\n[CEL]\nb = {{ m = 5e-3, f = 200, t60 = 1 }}\n[{kind}]\nl = {{ between = [\"h\", \"b\"], {law}, \
             method = \"stable\" }}\n[SOX]\nout = {{ from = \"b\" }}\n[gesture]\nh = {{ sine = 3e-3, f = 30, to = 1 }}\n"
        );
        let scene = audited(&text);
        assert_eq!(scene.certificate.level, Level::Proven, "{text}");
        let mut p = Performance::new(&scene, None).expect("it plays");
        (0..48_000).for_each(|_| p.tick());
        let l = p.state.ledger.as_ref().expect("a ledger");
        assert!(l.work.iter().sum::<f64>() > 1e-6, "{:?}\n{text}", l.work);
        let made = made(&p.state);
        assert!(made <= 1e-11, "made {made:e} of the peak\n{text}");
    }
}

#[test]
fn a_hardening_spring_is_of_second_order() {
    let [coarse, fine] = [96e3, 192e3].map(|fs| duffing("ca", ", method = \"stable\"", fs));
    within("order", ((coarse / fine).log2() - 2.0).abs(), 0.05);
    // the force is a mean over two ticks
    within("error beside the explicit method", (fine / duffing("ca", "", 192e3) - 19.6).abs(), 0.2);
}

/// A plectrum lets go once per passage, as by the explicit method. The stored energy then becomes heat: k d²/2, within
/// the slack of the tick in which it engaged.
#[test]
fn a_plectrum_lets_go_once_per_passage_and_loses_what_it_held() {
    let text = |method: &str| {
        format!(
            "[SOL]\nwall = {{}}\n[ENX]\np = {{}}\n[PLK]\nl = {{ between = [\"wall\", \"p\"], k = 2e3, d = 1e-3, method = \"{method}\" }}\n\
             [SOF]\nout = {{ from = \"l\" }}\n[gesture]\np = {{ sine = 2e-3, f = 5, to = 1 }}\n"
        )
    };
    let releases = ["ca", "stable"].map(|method| {
        let scene = audited(&text(method));
        let mut p = Performance::new(&scene, None).expect("it plays");
        let (mut count, mut heats, mut pulled) = (0, Vec::new(), 0.0);
        let mut before = 0.0;
        for _ in 0..48_000 {
            p.tick();
            let force = p.state.links.tap[0];
            if before != 0.0 && force == 0.0 && f64::abs(before) > 1.0 {
                count += 1;
            }
            pulled = f64::max(pulled, force.abs());
            before = force;
            heats.push(heat(&scene, &p.state));
        }
        let lost = heats.last().copied().expect("ticks");
        (count, lost / f64::from(count), pulled)
    });
    assert_eq!(releases[0].0, releases[1].0);
    for (_, each, pulled) in releases {
        // the port moves by about 1 µm a tick when the plectrum lets go at 1 mm
        within("heat of a release", (each / (0.5 * 2e3 * 1e-6) - 1.0).abs(), 0.01);
        within("force at the release", (pulled / 2.0 - 1.0).abs(), 0.01);
    }
}

/// Tables with kinks between which plain Newton steps alternate forever, and an attractor with a steep fall.
#[test]
fn kinks_are_crossed_without_energy() {
    let tables =
        [("30", "[[-1e-3, -100], [0, 0], [1e-4, 1e4]]"), ("10", "[[-1.2e-3, -1e4], [-7e-4, -1e4], [-2e-4, 5e4]]")];
    for (v, table) in tables {
        let text = format!(
            "[SOL]\nw = {{}}\n[MAS]\na = {{ m = 1e-3, v = {v} }}\n[LNL]\nl = {{ between = [\"w\", \"a\"], spring = {table}, \
             method = \"stable\" }}\n[SOX]\no = {{ from = \"a\" }}\n"
        );
        let s = only_falls(&audited(&text), 20_000, 1e-11, &text, |_| {});
        assert!(made(&s) <= 1e-11, "made {:e}\n{text}", made(&s));
    }
    let text = "[ENX]\nw = {}\n[MAS]\na = { m = 1e-3, v = 0.0992003 }\n[ATT]\nl = { between = [\"w\", \"a\"], k = 3.70348e7, \
                d = 7.15194e-3, rho = 0.01, z = 0.048, method = \"stable\" }\n[SOX]\no = { from = \"a\" }\n[gesture]\n\
                w = { noise = 0.0143039, f = 113.859, to = 1 }\n";
    let scene = audited(text);
    let mut p = Performance::new(&scene, None).expect("it plays");
    (0..48_000).for_each(|_| p.tick());
    assert!(made(&p.state) <= 1e-11, "made {:e}", made(&p.state));
}

/// Solved together, friction that drops out loses force and heat, and a released plectrum's energy becomes heat.
#[test]
fn what_drops_out_of_links_solved_together_is_entered() {
    let drops = "[SOL]\nw = {}\n[MAS]\na = { m = 1e-3, v = 1 }\nb = { m = 1e-3, v = -1 }\n[CUB]\ns = { between = [\"w\", \"b\"], \
                 k = 1e3, k3 = 0, method = \"stable\" }\n[BUT]\nc = { between = [\"w\", \"a\"], k = 1e3, d = -10, method = \"stable\" }\n[LNL]\n\
                 l = { between = [\"a\", \"b\"], friction = [[-3, 0], [-1, -1], [0, 0], [3, 0]], method = \"stable\" }\n[SOX]\n\
                 o = { from = \"a\" }\n[SOF]\nf = { from = \"l\" }\n";
    let plectrum = "[SOL]\nw = {}\n[MAS]\na = { m = 1e-3, v = 1 }\n[PLK]\np = { between = [\"w\", \"a\"], k = 1e3, d = 5e-4, \
                    method = \"stable\" }\n[CUB]\ns = { between = [\"w\", \"a\"], k = 1e3, k3 = 0, method = \"stable\" }\n[SOX]\no = { from = \"a\" }\n";
    for text in [drops, plectrum] {
        let scene = audited(text);
        let s = only_falls(&scene, 12_000, 1e-11, text, |_| {});
        assert!(made(&s) <= 1e-11, "made {:e}\n{text}", made(&s));
        assert!(heat(&scene, &s) > 1e-5, "{:e}", heat(&scene, &s));
    }
}

/// The message names another method where this one is not supported.
#[test]
fn where_it_does_not_serve_is_said() {
    let falls = "[SOL]\nw = {}\n[MAS]\na = { m = 1e-3 }\n[ATT]\nl = { between = [\"w\", \"a\"], k = 10, d = 1e-3, method = \"stable\" }\n\
                 m = { between = [\"a\", \"w\"], k = 10, d = 2e-3, method = \"stable\" }\n[SOX]\no = { from = \"a\" }\n";
    let space = "[r]\ndim = 3\n[r.SOL]\nw = { x = [0, 0, 0] }\n[r.MAS]\na = { m = 1e-3, x = [1, 0, 0] }\n[CUB]\n\
                 l = { between = [\"r.w\", \"r.a\"], k3 = 10, method = \"stable\" }\n[SOX]\no = { from = \"r.a\", along = [1, 0, 0] }\n";
    for (text, title) in [
        (falls, "the force of `l` falls, and other links that are solved implicitly move its masses"),
        (space, "the method of `l` is only for links on a line"),
    ] {
        let failed = ca_compile::compile(&model(text), &catalog(), &Options::default()).expect_err("it does not serve");
        assert!(failed.list.iter().any(|d| d.code == "E028" && d.title == title), "{failed}");
    }
}

#[test]
fn the_explicit_method_is_the_default() {
    let text = "[SOL]\nw = {}\n[MAS]\na = { m = 1e-3, dx0 = 1e-3 }\n[CUB]\nl = { between = [\"w\", \"a\"], k3 = 1e9 }\n[SOX]\no = { from = \"a\" }\n";
    for text in [text.into(), text.replace("k3 = 1e9", "k3 = 1e9, method = \"ca\"")] {
        assert!(ran(&scene(&text)).contains(&"CUB"));
    }
}
