//! Numbers nobody can count are shown with an exponent, wherever they come from.

use crate::desk::{Desk, Ran};

/// Digits and points in a row, at most.
fn longest(r: &Ran) -> usize {
    let all = format!("{} {}", r.out, r.err);
    all.split(|c: char| !c.is_ascii_digit() && c != '.').map(str::len).max().unwrap_or(0)
}

#[test]
fn no_number_has_more_digits_than_a_float_has() {
    let desk = Desk::new();
    for k in ["1e99", "1e-99"] {
        let text = format!(
            "[param]\np = {{ value = {k}, live = true, max = {k}, unit = \"N/m\" }}\n\
             [TGR]\nkey = {{ device = \"tgr12\", dof = 0 }}\n\
             [MAS]\nbob = {{ m = \"10 g\", v = \"1 m/s\" }}\n[SOL]\nwall = {{}}\n\
             [RES]\na = {{ between = [\"key\", \"bob\"], k = {k} }}\nc = {{ between = [\"wall\", \"bob\"], k = \"p\" }}\n\
             [BUT]\nb = {{ between = [\"wall\", \"bob\"], k = {k} }}\n[SOX]\nout = {{ from = \"bob\" }}\n"
        );
        desk.put("far.ca.toml", &text);
        let [low, high] = [format!("a.k=-{k}"), format!("wall.x={k}")];
        for args in [
            &["check", "far.ca.toml"][..],
            &["check", "far.ca.toml", "--device", "tgr12"],
            &["render", "far.ca.toml", "--seconds", "0.01"],
            &["render", "far.ca.toml", "--seconds", k],
            &["render", "far.ca.toml", "--seconds", "0.01", "--set", &low],
            &["render", "far.ca.toml", "--seconds", "0.01", "--set", &high],
            &["render", "far.ca.toml", "--seconds", "0.01", "--rate", k],
            &["equiv", "far.ca.toml", "--set", "mass=20g:1.0"],
            &["equiv", "far.ca.toml", "--set", &format!("mass={k}:1.0")],
            &["equiv", "far.ca.toml", "--set", &format!("mass=1.0:{k}")],
        ] {
            let r = desk.ca(args);
            assert!(!r.out.is_empty() || !r.err.is_empty(), "{args:?} says nothing");
            assert!(longest(&r) <= 18, "{args:?}\n{}\n{}", r.out, r.err);
        }
        desk.put("far.ca.toml", &text);
    }
    // and it is not because nothing is said
    desk.ca(&["equiv", "far.ca.toml", "--set", "mass=1e99:1.0"]).is(1).says(&["[1e99, 1.0]"]);
    desk.ca(&["render", "far.ca.toml", "--set", "a.k=1e99"]).says(&["too stiff for its mass", "e91"]);
}
