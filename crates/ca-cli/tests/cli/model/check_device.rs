//! Tests `ca check --device`: each limit of a device from 0.1 % below and 0.1 % above.

use crate::sandbox::Sandbox;
use serde_json::Value as Json;

/// A key on a spring of stiffness `k` \[N/m\], and a device with degrees of freedom, stiffness \[N/m\], force \[N\],
/// friction \[N s/m\] and frame rate \[Hz\]. `asked` returns the exit code, the JSON and the text.
struct Key {
    k: f64,
    of: u32,
    dof: u32,
    stiffness: f64,
    force: f64,
    friction: f64,
    rate: f64,
}

/// A device that renders the key without complaint.
const EASY: Key = Key { k: 1000.0, of: 0, dof: 1, stiffness: 40e3, force: 100.0, friction: 50.0, rate: 3000.0 };

impl Key {
    fn asked(&self) -> (i32, Json, String) {
        let sandbox = Sandbox::new();
        let (k, dof) = (self.k, self.of);
        sandbox.put(
            "key.ca.toml",
            &format!(
                "[TGR]\nkey = {{ device = \"one\", dof = {dof} }}\n[SOL]\nwall = {{}}\n[RES]\nspring = {{ between = [\"key\", \
                 \"wall\"], k = {k:?} }}\n[SOX]\nout = {{ from = \"key\" }}\n"
            ),
        );
        let Key { dof, stiffness, force, friction, rate, .. } = *self;
        sandbox.put(
            "one.toml",
            &format!(
                "name = \"one\"\ntitle = \"One key\"\nsource = \"a test\"\ndof = {dof}\nrange = [-0.01, 0.01]\nforce = \
                 {force:?}\nstiffness = {stiffness:?}\nrate = {rate:?}\n[body]\nmass = 0.2\nfriction = {friction:?}\nstep = \
                 0.000001\nnoise = 0.000001\n"
            ),
        );
        let args = ["check", "key.ca.toml", "--device", "one.toml"];
        let reported = sandbox.ca(&args);
        let all = sandbox.ca(&[&args[..], &["--json"]].concat()).json()["device"].clone();
        (reported.code, all, reported.out)
    }
}

/// Checks that `above` exceeds the limit at `at` in the JSON and `below` does not, and that the text agrees.
#[track_caller]
fn between(below: &Key, above: &Key, at: &str, words: &str) {
    let passed = |j: &Json| !matches!(j.pointer(at).unwrap(), Json::Null | Json::Bool(false));
    let ((quiet, first, said), (loud, second, reported)) = (below.asked(), above.asked());
    assert!(!passed(&first) && passed(&second), "{at}: {first:#}\n{second:#}");
    assert!(!said.contains(words) && reported.contains(words), "`{words}`:\n{said}\n{reported}");
    assert!(quiet == 0 && (loud == 3) == (second["too_much"] == true), "{quiet} {loud}");
}

#[test]
fn what_a_device_renders_ends_at_its_stiffness() {
    let at = |k: f64| Key { k, friction: 500.0, force: 1000.0, ..EASY };
    between(&at(40e3 * 0.999), &at(40e3 * 1.001), "/keys/0/beyond_stiffness", "what it can render");
}

#[test]
fn what_stays_passive_ends_where_the_page_says() {
    let thin = Key { friction: 10.0, ..EASY };
    let passive = thin.asked().1["passive"].as_f64().unwrap();
    let at = |k: f64| Key { k, stiffness: 10.0 * passive, force: 1000.0, ..thin };
    between(&at(passive * 0.999), &at(passive * 1.001), "/keys/0/beyond_passive", "the passive limit");
}

#[test]
fn a_key_beyond_what_stays_passive_is_softened_to_it() {
    // 2 N s/m, 3 kHz, and forces one frame later
    let wall = |k: f64| Key { k, friction: 2.0, ..EASY };
    let (code, soft, said) = wall(20e3).asked();
    let felt = soft["keys"][0]["felt"].as_f64().unwrap();
    assert!((felt - 1500.0).abs() < 1e-6 && code == 3, "{felt} N/m, {code}");
    assert!(said.contains("6.67 × the passive limit, softened to 1.5 kN/m"), "{said}");
    // softening begins at 0.9 of the limit
    let (code, passive, said) = wall(2.9e3).asked();
    assert_eq!((passive["keys"][0]["felt"].as_f64(), code), (Some(felt), 0));
    assert!(said.contains("softened to 1.5 kN/m") && !said.contains("× "), "{said}");
    let (_, held, said) = wall(2.69e3).asked();
    assert!(held["keys"][0]["felt"].is_null() && !said.contains("softened to"), "{said}");
}

#[test]
fn a_force_within_the_travel_passes_that_of_the_device_from_its_limit_on() {
    // 10 mm in each direction
    let at = |k: f64| Key { k, force: 10.0, ..EASY };
    between(&at(1000.0 * 0.999), &at(1000.0 * 1.001), "/keys/0/saturates", "the force reaches 10 N");
}

#[test]
fn a_device_is_slow_from_the_first_frame_it_lacks() {
    between(&EASY, &Key { rate: 2999.0, ..EASY }, "/slow", "a frame without a new position repeats the last");
}

#[test]
fn degrees_of_freedom_end_at_their_number() {
    let (_, last, _) = Key { of: 2, dof: 3, ..EASY }.asked();
    let (code, beyond, said) = Key { of: 3, dof: 3, ..EASY }.asked();
    assert_eq!((&last["keys"][0]["there"], &beyond["keys"][0]["there"], code), (&true.into(), &false.into(), 3));
    assert!(said.contains("a degree of freedom beyond the 3"), "{said}");
}

/// Only a power law holds this key, so the line names no link.
#[test]
fn a_law_that_stiffens_begins_a_line_by_itself() {
    let sandbox = Sandbox::new();
    let text = "[TGR]\nkey = { device = \"tgr12\", dof = 0 }\n[SOL]\nwall = { dx0 = \"-1 mm\" }\n[MAS]\nbob = { m = \"10 g\", dx0 = \"1 mm\" }\n\
                [REF]\nspring = { between = [\"wall\", \"bob\"], k = 20000, z = 0.1 }\n\
                [HRZ]\nhit = { between = [\"key\", \"bob\"], k = 1e9 }\n[SOX]\nout = { from = \"bob\", gain = 100 }\n";
    sandbox.put("key.ca.toml", text);
    let r = sandbox.ca(&["check", "key.ca.toml", "--device", "tgr12"]);
    assert!(r.out.lines().any(|l| l.trim_start().starts_with("it stiffens within the travel")), "{}\n{}", r.out, r.err);
    assert!(r.out.lines().all(|l| !l.trim_start().starts_with(';')), "{}", r.out);
}
