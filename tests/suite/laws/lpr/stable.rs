//! Contacts across two worlds by `method = "stable"`.

use crate::methods::stable::{made, ran};
use crate::play::{audited, mat, scene};
use ca_core::{Level, tick};

/// A ball in space between two others. The ball knocks on a cell with each of them; the cells also share a contact.
fn chime(k: f64, more: &str) -> String {
    format!(
        "[air]\ndim = 3\n[air.MAS]\nball = {{ m = 0.012, v = [0.4, 0.03, -0.02] }}\nleft = {{ m = 0.04, x = [0.04, 0.001, 0] }}\n\
         right = {{ m = 0.04, x = [-0.03, 0, 0.002] }}\n[SOL]\nrim = {{}}\n[CEL]\na = {{ m = 1e-3, f = 880 }}\nb = {{ m = 1e-3, f = 1046 }}\n\
         [LPR_HRZ]\nknock = {{ between = [\"air.ball\", [\"air.left\", \"air.right\"]], onto = [\"rim\", [\"a\", \"b\"]], k = {k:?}, \
         h = 0.04, d = 0.025, method = \"stable\" }}\n[LPR_BUT]\ntick = {{ between = [\"air.left\", \"air.right\"], onto = [\"a\", \"b\"], \
         k = {k:?}, d = 0.06, method = \"stable\" }}\n{more}[SOX]\no = {{ from = \"a\" }}\n"
    )
}

/// Blows that share masses in both worlds make no energy at any stiffness, also beside contacts that are curves.
#[test]
fn blows_across_two_worlds_make_nothing() {
    let beside = |k: f64| {
        format!(
            "[BUT]\nwall = {{ between = [\"rim\", [\"a\", \"b\"]], k = {k:?}, method = \"stable\", d = -1e-6 }}\n\
             [CUB]\ntie = {{ between = [\"a\", \"b\"], k = 1e3, k3 = 1e10, method = \"stable\" }}\n"
        )
    };
    for (k, most) in [(1e5, 1e-11), (3e7, 1e-11), (1e9, 1e-10), (1e11, 1e-9)] {
        for text in [chime(k, ""), chime(k, &beside(k))] {
            let scene = audited(&text);
            assert_eq!(scene.certificate.level, Level::Proven, "{text}");
            assert!(ran(&scene).contains(&"LPR_HRZ stable"), "{:?}", ran(&scene));
            let mut s = scene.state();
            let (a, mut heard) = (mat(&scene, "a"), 0.0f64);
            for _ in 0..48_000 {
                tick(&scene, &mut s);
                heard = heard.max(s.x[a].abs());
            }
            assert!(heard > 1e-8, "nothing was struck: {heard}");
            let made = made(&s);
            assert!(made <= most, "k = {k:e}: made {made:e} of the peak\n{text}");
        }
    }
}

/// With its second pair of ends held, it is the contact `stable3d` of the core.
#[test]
fn with_a_port_held_it_is_the_plain_contact() {
    for law in ["BUT", "HRZ"] {
        let text = |section: &str| {
            format!(
                "[air]\ndim = 3\n[air.SOL]\nwall = {{}}\n[air.MAS]\nball = {{ m = 0.005, x = [0.012, 0.016, 0], v = [-0.6, -0.8, 0.1] }}\n\
                 [SOL]\np = {{}}\nq = {{}}\n{section}[SOX]\no = {{ from = \"air.ball\", along = \"x\" }}\n"
            )
        };
        let ends = "between = [\"air.wall\", \"air.ball\"], k = 3e6, d = 0.01";
        let plain = scene(&text(&format!("[{law}]\nhit = {{ {ends}, method = \"stable3d\" }}\n"))).scene;
        let two = format!("[LPR_{law}]\nhit = {{ {ends}, onto = [\"p\", \"q\"], method = \"stable\" }}\n");
        let two = scene(&text(&two)).scene;
        let (mut s, mut t) = (plain.state(), two.state());
        for n in 0..4_800 {
            tick(&plain, &mut s);
            tick(&two, &mut t);
            let [x, y] = [(&plain, &s), (&two, &t)].map(|(scene, s)| s.x[mat(scene, "air.ball")]);
            assert!((x - y).abs() <= 1e-14, "{law} at {n}: {x} and {y}");
        }
    }
}

/// Each of its ends may meet other links that are solved with the coming motion; friction that sticks may not.
#[test]
fn auto_takes_it() {
    let text = format!("[model]\nformat = 2\n{}", chime(3e7, "").replace(", method = \"stable\"", ""));
    let scene = audited(&text);
    assert!(ran(&scene).contains(&"LPR_HRZ stable") && ran(&scene).contains(&"LPR_BUT stable"), "{:?}", ran(&scene));
}
