//! Derivatives of the energy accounts, against closed forms, differences of ledgers of renders in double precision, and
//! the identity of the ledger, which holds for each derivative.

use crate::closed_form::{D, c, oscillator};
use crate::random_models::{Draw, METHODS, drawn};
use crate::reference::{WEIGHTS, apart, links, played, read, with};
use ca_gradient::{ACCOUNTS, Energy, EnergyTangents, Parameter};
use cordis_anima::ca_core::Balance;
use cordis_anima::ca_io::perform::Performance;
use cordis_anima::{Loaded, Options, catalog};

const TICKS: usize = 600;
const INSTANTS: usize = 5;
/// Rounding of an account, relative to all energy that passed through the ledger (docs/numerics.md §2.3).
const ROUNDING: f64 = 1e-14;
/// Tolerance relative to the account, tolerance relative to the largest derivative of all accounts (the start is itself
/// differentiated by differences), and the accuracy that a difference needs to serve as reference.
const CLOSE: f64 = 1e-6;
const OF_ALL: f64 = 1e-9;
const KNOWN: f64 = 1e-4;

/// Returns whether a bow has the smooth curve, which is a table. A difference over several segments has their mean
/// slope, so steps have to be narrow, and still a corner lies between some ticks.
fn has_segments(loaded: &Loaded) -> bool {
    loaded
        .model
        .items
        .iter()
        .any(|i| i.kind.ends_with("BOW") && i.args.iter().all(|e| e.key != "curve" || e.value == "smooth".into()))
}

fn tangents(loaded: &Loaded, ticks: usize, instants: usize, names: &[&str]) -> EnergyTangents {
    let energy = Energy::new(loaded, &Options::default(), names).unwrap_or_else(|e| panic!("{e}"));
    energy.tangents(Some(ticks as f64 / energy.rate()), None, instants, &mut || true).unwrap_or_else(|e| panic!("{e}"))
}

fn plain(b: &Balance) -> [f64; ACCOUNTS.len()] {
    [b.h0, b.h, b.lost, b.scheme_error, b.work, b.changed, b.residual]
}

/// Returns the accounts of a render with the ledger (instants x accounts) and its scale.
fn accounts(loaded: &Loaded, ticks: usize, instants: usize) -> (Vec<f64>, f64) {
    let options = Options { energy: true, ..Options::default() };
    let scene = loaded.compile(&options).unwrap_or_else(|e| panic!("{:?}", e.diags)).scene;
    let mut p = Performance::new(&scene, None).expect("its own gesture");
    let (mut all, mut peak) = (Vec::new(), 0.0);
    for k in 1..=instants {
        let until = k * ticks / instants;
        (((k - 1) * ticks / instants)..until).for_each(|_| p.tick());
        let b = p.state.ledger.as_ref().expect("a ledger").balance();
        all.extend(plain(&b));
        peak = b.peak;
    }
    (all, peak)
}

/// Returns one account at all instants from a table (instants x accounts x `each`).
fn account(all: &[f64], each: usize, j: usize, k: usize) -> Vec<f64> {
    all.iter().skip(j * each + k).step_by(ACCOUNTS.len() * each).copied().collect()
}

/// An undamped cell keeps ½ k x₀² (1 − kT²/4m) for ever: docs/numerics.md §2.1 with the start of §1.1.
#[test]
fn a_cell_that_nothing_damps_keeps_what_it_began_with() {
    let (m, k, x) = (2e-3_f64, 9e3_f64, 1e-3_f64);
    let text =
        format!("[CEL]\nbar = {{ m = {m:?}, k = {k:?}, z = 0, dx0 = {x:?} }}\n[SOX]\nout = {{ from = 'bar' }}\n");
    let t = tangents(&read(&text), 2000, 8, &["bar.k", "bar.m", "bar.dx0"]);
    let a = k / (m * 48_000.0 * 48_000.0);
    let stored = 0.5 * k * x * x * (1.0 - a / 4.0);
    let exact = [0.5 * x * x * (1.0 - a / 2.0), 0.5 * k * x * x * a / (4.0 * m), k * x * (1.0 - a / 4.0)];
    for name in ["h0", "h"] {
        for i in 0..t.instants() {
            let (value, by) = t.account(name, i).expect("an account");
            assert!((value / stored - 1.0).abs() < 1e-11, "{name}: {value:e} {stored:e}");
            for (by, exact) in by.iter().zip(exact) {
                // the derivative by m is at most a part a of the energy, but has the rounding of all of it
                let off = (by - exact).abs() / exact.abs().max(1e-3 * stored / m);
                println!("{name} {i}: {off:.1e}");
                assert!(off < 1e-9, "{name}: {by:e} {exact:e}");
            }
        }
    }
}

/// Energy between two ticks and loss since the start of a damped cell, by the roots of the scheme.
#[test]
fn a_damped_cell_stores_and_loses_by_its_roots() {
    let values = [2e-3, 9e3, 0.02, 1e-3, 0.3];
    let [m, k, z, x, v] = values;
    let text = format!(
        "[CEL]\nbar = {{ m = {m:?}, k = {k:?}, z = {z:?}, dx0 = {x:?}, v = {v:?} }}\n[SOX]\nout = {{ from = 'bar' }}\n"
    );
    let names = ["bar.m", "bar.k", "bar.z", "bar.dx0", "bar.v"];
    let ticks = 2000;
    let t = tangents(&read(&text), ticks, 10, &names);
    for (i, name) in names.iter().enumerate() {
        let mut given = values.map(c);
        given[i].1 = 1.0;
        let [m, k, z, ..] = given;
        let (at, dt) = (oscillator(ticks, given), c(1.0 / 48_000.0));
        let held = |n: usize| {
            let d = at[n] - at[n - 1];
            c(0.5) * (m / (dt * dt) - z / (c(2.0) * dt)) * d * d + c(0.5) * k * at[n] * at[n - 1]
        };
        for j in 1..=10 {
            // a tick is entered when the next one begins
            let end = j * ticks / 10 - 1;
            let exact = held(end);
            let (value, by) = t.account("h", j - 1).expect("an account");
            assert!((value / exact.0 - 1.0).abs() < 1e-9, "{value:e} {:e}", exact.0);
            let off = (by[i] / exact.1 - 1.0).abs();
            println!("{name} {j}: {off:.1e}");
            assert!(off < 1e-9, "{name}: {:e} {:e}", by[i], exact.1);
            let of = |account: &str| t.account(account, j - 1).map(|(v, by)| D(v, by[i])).expect("an account");
            // the loss is the energy at load less the present energy, and the sum of losses by tick
            let (lost, gone) = (of("lost"), of("h0") - exact);
            assert!(
                (lost.0 - gone.0).abs() < 1e-9 * of("h0").0
                    && (lost.1 - gone.1).abs() < 1e-9 * of("h0").1.abs().max(gone.1.abs())
            );
            let ticks = (1..end).map(|n| {
                let moved = at[n + 1] - at[n - 1];
                z / (c(4.0) * dt) * moved * moved
            });
            let (all, first) = (ticks.fold(c(0.0), |sum, v| sum + v), of("h0") - held(1));
            assert!((lost.0 - first.0 - all.0).abs() < 1e-9 * of("h0").0);
            assert!((lost.1 - first.1 - all.1).abs() < 1e-9 * lost.1.abs().max(first.1.abs()), "{name}: {:e}", lost.1);
        }
    }
}

/// Returns the derivatives of all accounts by `p` (instants x accounts), each with the distance of two orders. Steps at
/// which a link acts in other ticks do not count.
fn differences(loaded: &Loaded, p: &Parameter) -> Vec<Option<(Vec<f64>, f64)>> {
    let links = links(loaded);
    let base = played(loaded, &links, TICKS);
    let mut best: Vec<Option<(Vec<f64>, f64)>> = vec![None; ACCOUNTS.len()];
    let steps: &[f64] = if has_segments(loaded) { &[1e-6, 1e-7, 1e-8] } else { &[1e-2, 1e-3, 1e-4, 1e-5, 1e-6] };
    for part in steps {
        let h = part * if p.value == 0.0 { 1e-3 } else { p.value.abs() };
        let mut sums = [vec![0.0; INSTANTS * ACCOUNTS.len()], vec![0.0; INSTANTS * ACCOUNTS.len()]];
        let (mut same, mut rounding) = (true, 0.0_f64);
        for (k, weights) in (1..).zip(WEIGHTS[0].into_iter().zip(WEIGHTS[1])) {
            for (side, sign) in [(f64::from(k), 1.0), (-f64::from(k), -1.0)] {
                let other = with(loaded, p, p.value + side * h);
                same = same && played(&other, &links, TICKS).acts == base.acts;
                if !same {
                    break;
                }
                let (all, peak) = accounts(&other, TICKS, INSTANTS);
                rounding = rounding.max(ROUNDING * peak / h);
                for (sums, w) in sums.iter_mut().zip([weights.0, weights.1]) {
                    sums.iter_mut().zip(&all).for_each(|(sum, v)| *sum += sign * w * v / h);
                }
            }
        }
        if !same {
            continue;
        }
        for (j, best) in best.iter_mut().enumerate() {
            let [high, low] = sums.each_ref().map(|all| account(all, 1, j, 0));
            // both orders have the same rounding
            let largest = high.iter().fold(f64::MIN_POSITIVE, |m, v| m.max(v.abs()));
            let off = apart(&low, &high) + rounding / largest;
            if best.as_ref().is_none_or(|b| off < b.1) {
                *best = Some((high, off));
            }
        }
    }
    best
}

/// Compares values to a plain ledger, derivatives to differences, and checks the identity. Returns counts: derivatives
/// compared, derivatives without a reference, scenes whose values have the same bits, scenes.
fn compare(title: &str, loaded: &Loaded, names: &[String], wrong: &mut Vec<String>) -> [usize; 4] {
    let mut names: Vec<&str> = names.iter().map(String::as_str).collect();
    names.retain(|name| match Energy::new(loaded, &Options::default(), &[name]) {
        Ok(_) => true,
        Err(e) => {
            println!("{title}: {e}");
            false
        }
    });
    if names.is_empty() {
        return [0; 4];
    }
    let t = tangents(loaded, TICKS, INSTANTS, &names);
    let (plain, peak) = accounts(loaded, TICKS, INSTANTS);
    // dual numbers use another memory layout of strings and meshes, which changes the order of summation
    let apart_by = t.values.iter().zip(&plain).fold(0.0, |m: f64, (a, b)| m.max((a - b).abs()));
    wrong.extend((apart_by > 1e-13 * peak).then(|| format!("{title}: values off by {apart_by:e} of {peak:e}")));
    let bits = |all: &[f64]| all.iter().map(|v| v.to_bits()).collect::<Vec<u64>>();
    let same = usize::from(bits(&t.values) == bits(&plain));
    let (mut compared, mut left_out, mut worst, mut residual) = (0, 0, 0.0_f64, 0.0_f64);
    let n = names.len();
    for (k, p) in t.parameters.iter().enumerate() {
        // largest derivative, at least that of an energy proportional to the parameter
        let each = || (0..ACCOUNTS.len()).map(|j| account(&t.tangents, n, j, k));
        let most = each().flatten().fold(peak / p.value.abs().max(1e-3), |m, v| m.max(v.abs()));
        let [h0, h, lost, made, work, changed, rest] = each().collect::<Vec<_>>().try_into().expect("all accounts");
        for i in 0..INSTANTS {
            let off = (h[i] - (h0[i] + work[i] - lost[i] + made[i] + changed[i])).abs() / most;
            residual = residual.max(off).max(rest[i].abs() / most);
        }
        for (j, reference) in differences(loaded, p).into_iter().enumerate().take(ACCOUNTS.len() - 1) {
            let found = account(&t.tangents, n, j, k);
            let largest = found.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
            match reference {
                // 0, or only rounding
                Some((exact, _)) if largest <= 1e-9 * most => {
                    let close = exact.iter().all(|v| v.abs() <= 1e-6 * most);
                    wrong.extend(
                        (!close).then(|| format!("{title}: {} by {}: nothing, and {exact:?}", ACCOUNTS[j], p.name)),
                    );
                }
                Some((exact, doubt)) if doubt < KNOWN => {
                    compared += 1;
                    let off = apart(&found, &exact);
                    worst = worst.max(off);
                    let floor = if has_segments(loaded) { 100.0 * CLOSE } else { CLOSE };
                    let close = off < floor.max(10.0 * doubt) + OF_ALL * most / largest;
                    let said = || {
                        format!("{title}: {} by {} {off:.1e}, of differences known to {doubt:.1e}", ACCOUNTS[j], p.name)
                    };
                    wrong.extend((!close).then(said));
                }
                _ => {
                    println!("{title}: {} by {}: no difference to compare with", ACCOUNTS[j], p.name);
                    left_out += 1;
                }
            }
        }
    }
    println!(
        "{title}: {compared} compared, {left_out} without a reference, worst {worst:.1e}, residual {residual:.1e}"
    );
    let close = residual < 1e-9;
    wrong.extend((!close).then(|| format!("{title}: residual {residual:.1e}")));
    [compared, left_out, same, 1]
}

/// Contacts, friction, links across worlds, bodies in space, generators, ports: each kind's example, with drawn
/// numbers.
#[test]
fn the_energy_of_every_kind_has_the_derivatives_of_its_ledgers() {
    let (mut draw, mut all, mut wrong) = (Draw(11), [0; 4], Vec::new());
    for kind in catalog().iter() {
        let mut loaded = read(kind.example);
        let names = drawn(&mut loaded, &mut draw);
        let found = compare(kind.code, &loaded, &names, &mut wrong);
        all.iter_mut().zip(found).for_each(|(sum, n)| *sum += n);
    }
    println!(
        "{} compared, {} without a reference, {} of {} scenes with the bits of a plain ledger",
        all[0], all[1], all[2], all[3]
    );
    assert!(wrong.is_empty(), "{wrong:#?}");
    assert!(all[0] > 500 && all[1] * 5 <= all[0] && all[2] * 2 > all[3], "{all:?}");
}

#[test]
fn the_energy_of_every_method_has_the_derivatives_of_its_ledgers() {
    let (mut draw, mut all, mut wrong) = (Draw(13), [0; 4], Vec::new());
    for (title, text) in METHODS.iter().chain(MOVED) {
        let mut loaded = read(text);
        let names = drawn(&mut loaded, &mut draw);
        let found = compare(title, &loaded, &names, &mut wrong);
        all.iter_mut().zip(found).for_each(|(sum, n)| *sum += n);
    }
    println!(
        "{} compared, {} without a reference, {} of {} scenes with the bits of a plain ledger",
        all[0], all[1], all[2], all[3]
    );
    assert!(wrong.is_empty(), "{wrong:#?}");
    assert!(all[0] > 300 && all[1] * 5 <= all[0] && all[2] * 2 > all[3], "{all:?}");
}

/// Scenes with entries in the account of changes, besides the first force of mi.lib.
const MOVED: &[(&str, &str)] = &[(
    "a point that a port moves",
    "[STRING]\nlow = { n = 12, f = '220 Hz', t60 = '1 s', m = '1 g' }\n[ENX]\nslide = {}\n[MAS]\nball = { m = '5 g', x = '-1 mm', v = '0.8 m/s' }\n[REF]\ntie = { between = ['ball', 'low@slide'], k = '2 kN/m', z = '0.1 N s/m' }\n[gesture]\nslide = [[0, 0.3], ['20 ms', 0.7]]\n[SOX]\nout = { from = 'low[7]' }\n",
)];

const BAR: &str = "[CEL]\nbar = { m = '2 g', f = '440 Hz', t60 = '0.2 s', dx0 = '1 mm' }\n[MAS]\nball = { m = '5 g', x = '-1 mm', v = '0.8 m/s' }\n[BUT]\nhit = { between = ['ball', 'bar'], k = '9 kN/m', z = '0.2 N s/m' }\n[SOX]\nout = { from = 'bar' }\n";

/// Parameters beyond seven take a second play, and instants do not affect each other.
#[test]
fn instants_and_parameters_are_those_of_each_alone() {
    let loaded = read(BAR);
    let names = ["bar.m", "bar.f", "bar.t60", "bar.dx0", "ball.m", "ball.x", "ball.v", "hit.k", "hit.z"];
    let t = tangents(&loaded, 700, 7, &names);
    assert_eq!((t.instants(), t.values.len(), t.tangents.len()), (7, 7 * 7, 7 * 7 * 9));
    assert!(
        t.seconds.iter().zip(1..).all(|(s, k)| (s - f64::from(100 * k - 1) / 48_000.0).abs() < 1e-12),
        "{:?}",
        t.seconds
    );
    let last = tangents(&loaded, 700, 1, &["hit.z"]);
    for name in ACCOUNTS {
        let ((a, all), (b, one)) =
            (t.account(name, 6).expect("an account"), last.account(name, 0).expect("an account"));
        assert_eq!((a.to_bits(), all[8].to_bits()), (b.to_bits(), one[0].to_bits()), "{name}");
    }
    assert!(t.account("heat", 0).is_none() && t.account("h", 7).is_none());
}

#[test]
fn what_has_no_derivative_of_energy_is_refused() {
    let refused = |text: &str, name: &str| {
        Energy::new(&read(text), &Options::default(), &[name]).err().expect("no derivative").to_string()
    };
    let slow = "[key]\nrate = 'gesture'\n[key.SOL]\nbed = {}\n[key.MAS]\nlever = { m = '50 g', dx0 = '1 mm' }\n[key.REF]\nspring = { between = ['key.bed', 'key.lever'], k = '200 N/m', z = '0.5 N s/m' }\n[CEL]\nbar = { m = '2 g', f = '330 Hz', t60 = '1 s' }\n[RES]\nhit = { between = ['key.lever', 'bar'], k = '4 kN/m' }\n[SOX]\nout = { from = 'bar' }\n";
    assert!(
        refused(slow, "bar.m").contains("groups at the gesture rate are not differentiated"),
        "{}",
        refused(slow, "bar.m")
    );
    let pefrl = "[model]\nmethod = 'pefrl'\n[SOL]\nwall = {}\n[MAS]\na = { m = '1 g', dx0 = '1 mm' }\n[RES]\ns = { between = ['wall', 'a'], k = '8 kN/m' }\n[SOX]\nout = { from = 'a' }\n";
    assert!(refused(pefrl, "a.m").contains("does not support the energy ledger"), "{}", refused(pefrl, "a.m"));
    assert!(refused(BAR, "bar.n").contains("no such parameter"));
    let energy = Energy::new(&read(BAR), &Options::default(), &["bar.f"]).expect("derivatives");
    for instants in [0, 481] {
        let said = energy.tangents(Some(0.01), None, instants, &mut || true).expect_err("no such instants").to_string();
        assert!(said.contains("480 samples"), "{said}");
    }
    assert!(energy.tangents(Some(0.1), None, 1, &mut || false).is_err());
}
