//! Refused profiles, and both sides of each limit.

use super::Profile;

fn text(change: &str) -> String {
    let (table, line) = change.split_once('|').unwrap_or(("", change));
    let own = |name: &str| if table == name { format!("{line}\n") } else { String::new() };
    format!(
        "name = \"x\"\ntitle = \"x\"\nsource = \"x\"\ndof = 1\nrange = [-0.01, 0.01]\n{}{}[body]\n{}[guard]\n{}",
        if line.starts_with("force ") { "" } else { "force = 10\n" },
        own(""),
        own("body"),
        own("guard"),
    )
}

#[test]
fn each_bound_has_two_sides() {
    for (name, good, bad) in [
        ("force", 1000.0, 1001.0),
        ("continuous", 10.0, 10.1),
        ("stiffness", 1e7, 1.1e7),
        ("damping", 1e5, 1.1e5),
        ("rate", 1e5, 1.1e5),
        ("body|mass", 1000.0, 1001.0),
        ("body|friction", 1000.0, 1001.0),
        ("body|dry", 1000.0, 1001.0),
        ("body|step", 0.01, 0.011),
        ("body|noise", 0.01, 0.011),
        ("body|force_step", 1000.0, 1001.0),
        ("guard|speed", 20.0, 20.1),
        ("guard|slew", 1e8, 1.1e8),
        ("guard|thermal", 3600.0, 3601.0),
        ("guard|clear", 1.0, 1.01),
        ("guard|clear_time", 60.0, 60.1),
        ("guard|clear_time", 0.01, 0.009),
        ("guard|ramp", 60.0, 60.1),
        ("guard|ramp", 0.01, 0.009),
        ("guard|approach", 60.0, 60.1),
        ("guard|approach", 0.01, 0.009),
        ("guard|zero", 1.0, 1.1),
        ("guard|ttl", 0.5, 0.51),
        ("guard|brake", 1000.0, 1001.0),
        ("guard|stop", 10.0, 10.1),
        ("guard|bad_time", 10.0, 10.1),
        ("guard|edge_stiffness", 1e6, 1.1e6),
        ("guard|oscillation_level", 1.0, 1.01),
        ("guard|oscillation_time", 10.0, 10.1),
        ("guard|passivity_leak", 0.01, 0.011),
    ] {
        let word = name.split_once('|').map_or(name, |n| n.1);
        let read = |v: f64| Profile::read(&text(&format!("{name} = {v:?}")), "x.toml");
        assert!(read(good).is_ok(), "{name} = {good}: {:?}", read(good));
        let e = read(bad).expect_err(name).to_string();
        assert!(e.contains("x.toml") && e.contains(word) && e.contains(&format!("{bad}")), "{e}");
        let absurd = if bad < good { 1e-300 } else { 1e300 };
        assert!(read(absurd).is_err(), "{name} = {absurd}");
    }
    // a longer hold would defeat the watchdog
    let hold = |hold: f64| Profile::read(&text(&format!("guard|hold = {hold:?}\nzero = 0.9")), "x.toml");
    assert!(hold(0.5).is_ok() && hold(0.51).is_err());
}
