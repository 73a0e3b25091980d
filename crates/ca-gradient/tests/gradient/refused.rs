//! Parameters without a derivative are refused by name.

use crate::reference::{played, read, tangents};
use ca_gradient::Forward;
use cordis_anima::Options;

const STRING: &str = "[STRING]\nlow = { n = 20, f = '220 Hz', t60 = '1 s', m = '1 g' }\n[MAS]\nbob = { m = '3 g', x = '-1 mm', v = '0.8 m/s' }\n[HRZ]\nhit = { between = ['bob', 'low[5]'], k = '1e5 N/m^1.5', p = 1.5 }\n[SOX]\nout = { from = 'low[11]' }\n";

fn refused(text: &str, name: &str) -> String {
    Forward::new(&read(text), &Options::default(), &[name]).err().expect("no derivative").to_string()
}

#[test]
fn what_has_no_derivative_is_named() {
    for (name, why) in [
        ("low.n", "no derivative by `low.n`: it is a whole number"),
        ("hit.p", "no derivative by `hit.p`: it is an exponent"),
        ("hit.method", "no derivative by `hit.method`: it is one of several words"),
        ("hit.between", "no derivative by `hit.between`: it is not a number"),
        ("bob.w", "`bob.w`: `MAS` has no such parameter"),
        ("bop.m", "the model has no `bop.m`; did you mean `bob.m`?"),
        ("bob.v[0]", "`bob.v[0]`: `bob.v` is not a list"),
        ("rate.sound", "the model has no `rate.sound`"),
    ] {
        let said = refused(STRING, name);
        assert!(said.starts_with(why), "{name}: {said}");
    }
    let rate = format!("[rate]\nsound = '48 kHz'\n{STRING}");
    assert!(
        refused(&rate, "rate.sound").contains("changes the structure of the scene"),
        "{}",
        refused(&rate, "rate.sound")
    );
}

/// At the end of its range a parameter has a one-sided derivative. A value that is almost 0 needs a step greater than
/// the value, since a smaller one is rounded away.
#[test]
fn at_the_end_of_a_range_the_derivative_is_one_sided() {
    let text = "[CEL]\nbar = { m = '2 g', k = '9 kN/m', z = 0, dx0 = '1 mm' }\n[SOX]\nout = { from = 'bar' }\n";
    let of = |z: &str| tangents(&read(&text.replace("z = 0,", z)), 500, &["bar.z"]).tangents;
    let (zero, next_to_it, near) = (of("z = 0,"), of("z = 1e-9,"), of("z = 1e-6,"));
    let off = |a: &[f64]| a.iter().zip(&zero).fold(0.0, |m: f64, (a, b)| m.max((a - b).abs()));
    let most = zero.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
    assert!(off(&next_to_it) < 1e-7 * most, "{:e} of {most:e}", off(&next_to_it));
    assert!(off(&near) < 1e-5 * most, "{:e} of {most:e}", off(&near));
}

/// The derivative of a curve at load is its slope there; much faster parts of the curve on both sides do not count.
#[test]
fn a_curve_at_load_has_its_own_slope() {
    let text = "[MAS]\na = { m = 0.0022, v = V }\nb = { m = 0.0093, x = 0.004, v = -0.83 }\n[BOW]\nr = { between = ['a', 'b'], f = 0.3, method = 'M', v0 = 0.067 }\n[SOX]\no = { from = 'a', hear = 'speed', gain = 0.1 }\n";
    for method in ["ca", "secant"] {
        for v in [-1.0, -0.9, -0.7, -0.8] {
            let at = |v: f64| read(&text.replace('V', &format!("{v:?}")).replace("'M'", &format!("'{method}'")));
            let t = tangents(&at(v), 50, &["a.v"]);
            let h = 1e-8;
            let [up, down] = [v + h, v - h].map(|v| tangents(&at(v), 50, &["a.v"]).output);
            let most = t.tangents.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
            for (k, (up, down)) in up.iter().zip(&down).enumerate() {
                let difference = (up - down) / (2.0 * h);
                let off = (t.tangents[k] - difference).abs();
                assert!(off < 1e-5 * most, "{method}, {v}, sample {k}: {} and {difference}", t.tangents[k]);
            }
        }
    }
}

/// The outputs have the bits of a render.
#[test]
fn the_sound_is_that_of_a_render() {
    let loaded = read(STRING);
    let t = tangents(&loaded, 1000, &["bob.v", "low.f", "bob.m", "hit.k", "low.m", "low.t60", "bob.x", "out.gain"]);
    let bits = |all: &[f64]| all.iter().map(|v| v.to_bits()).collect::<Vec<u64>>();
    assert_eq!(bits(&t.output), bits(&played(&loaded, &[], 1000).output));
    // eight parameters take two plays; the second gives the same as a play for that parameter alone
    let gain = tangents(&loaded, 1000, &["out.gain"]);
    let last: Vec<f64> = t.tangents.iter().skip(7).step_by(8).copied().collect();
    assert_eq!(bits(&last), bits(&gain.tangents));
}

#[test]
fn a_gradient_is_the_product_of_cotangent_and_derivatives() {
    let loaded = read(STRING);
    let names = ["bob.v", "low.f", "hit.k"];
    let t = tangents(&loaded, 800, &names);
    let forward = Forward::new(&loaded, &Options::default(), &names).expect("derivatives");
    // of the sum of squares
    let cotangent: Vec<f64> = t.output.iter().map(|y| 2.0 * y).collect();
    let gradient = forward.gradient(&cotangent, None, &mut || true).expect("a gradient");
    for (k, g) in gradient.iter().enumerate() {
        let sum: f64 = cotangent.iter().zip(t.tangents.iter().skip(k).step_by(3)).map(|(c, d)| c * d).sum();
        assert!((g - sum).abs() <= 1e-12 * sum.abs(), "{g} {sum}");
    }
    assert_eq!(forward.output(Some(800.0 / 48_000.0), None, &mut || true).expect("a render"), t.output);
    assert!(forward.gradient(&[], None, &mut || true).is_err());
}

#[test]
fn groups_at_the_gesture_rate_are_refused() {
    let slow = "[key]\nrate = 'gesture'\n[key.SOL]\nbed = {}\n[key.MAS]\nlever = { m = '50 g', dx0 = '1 mm' }\n[key.REF]\nspring = { between = ['key.bed', 'key.lever'], k = '200 N/m', z = '0.5 N s/m' }\n[CEL]\nbar = { m = '2 g', f = '330 Hz', t60 = '1 s' }\n[RES]\nhit = { between = ['key.lever', 'bar'], k = '4 kN/m' }\n[SOX]\nout = { from = 'bar' }\n";
    let said = refused(slow, "bar.m");
    assert!(said.contains("groups at the gesture rate are not differentiated"), "{said}");
}

/// A number of a gesture changes port inputs, which are not differentiated; a derivative of 0 would be believed.
#[test]
fn what_moves_a_gesture_is_refused() {
    let text = "[param]\ndeep = '5 mm'\n[CEL]\nbar = { m = '2 g', f = '440 Hz', t60 = '0.2 s' }\n[ENX]\nkey = {}\n[REF]\npress = { between = ['key', 'bar'], k = '100 N/m', z = 0 }\n[gesture]\nkey = { sine = 'deep', f = '5 Hz', to = 4 }\n[SOX]\nout = { from = 'bar', gain = 50 }\n";
    assert_eq!(
        refused(text, "deep"),
        "no derivative by `deep`: it changes a gesture of the model, and gestures are not differentiated"
    );
    assert!(tangents(&read(text), 500, &["press.k"]).tangents.iter().any(|t| *t != 0.0));
}
