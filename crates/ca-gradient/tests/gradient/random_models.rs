//! Scenes with random numbers near the written ones, against differences of renders: one of each kind and law, and one
//! of each method.
//!
//! A new law is covered without a change here: its example comes from its record.

use crate::reference::{apart, column, difference, played, read, tangents};
use crate::reverse::both_ways;
use ca_gradient::Forward;
use cordis_anima::ca_core::Type;
use cordis_anima::ca_model::{Value, quantity};
use cordis_anima::{Loaded, Options, catalog};

const TICKS: usize = 2000;

/// Numbers from 0 to 1, the same on every machine.
pub struct Draw(pub u64);

impl Draw {
    pub fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// Multiplies masses, stiffnesses, speeds and similar numbers of a model by random factors around 1. Returns the names
/// of the parameters to differentiate by.
pub fn drawn(loaded: &mut Loaded, draw: &mut Draw) -> Vec<String> {
    let (kinds, mut names) = (catalog(), Vec::new());
    for item in &mut loaded.model.items {
        let Some(kind) = kinds.get(&item.kind) else { continue };
        for e in &mut item.args {
            let Some(param) = kind.param(&e.key).map(|i| &kind.params[i]) else { continue };
            let exponent = |p: &cordis_anima::ca_core::Param| matches!(p.ty, Type::PowerStiffness { exponent } if exponent == param.name);
            if kind.params.iter().any(exponent) {
                continue;
            }
            let mut number = |v: &mut Value| {
                let factor = 1.0 + 0.04 * (draw.next() - 0.5);
                let (value, unit) = match v {
                    Value::Num(v) => (*v, String::new()),
                    Value::Text(t) => match quantity::parse(t) {
                        Ok(q) if q.has_unit => (q.value, quantity::unit_of(q.dim)),
                        _ => return false,
                    },
                    _ => return false,
                };
                let to = value * factor;
                *v = if unit.is_empty() { Value::Num(to) } else { Value::Text(format!("{to:e} {unit}")) };
                true
            };
            let name = format!("{}.{}", item.name, e.key);
            match (param.ty, &mut e.value) {
                (
                    Type::Number { .. } | Type::PowerStiffness { .. } | Type::Position { .. },
                    v @ (Value::Num(_) | Value::Text(_)),
                ) => names.extend(number(v).then_some(name)),
                (Type::Position { .. }, Value::List(list)) => {
                    for (i, x) in list.iter_mut().enumerate() {
                        if number(&mut x.value) {
                            names.push(format!("{name}[{i}]"));
                        }
                    }
                }
                _ => {}
            }
        }
    }
    names
}

/// Compares all derivatives of a scene. Returns counts: parameters, those without reference, scenes in reverse.
fn compare(title: &str, loaded: &Loaded, names: &[String], tolerance: f64, wrong: &mut Vec<String>) -> [usize; 3] {
    let (mut names, mut refused): (Vec<&str>, usize) = (names.iter().map(String::as_str).collect(), 0);
    names.retain(|name| match Forward::new(loaded, &Options::default(), &[name]) {
        Ok(_) => true,
        Err(e) => {
            println!("{title}: {e}");
            refused += 1;
            false
        }
    });
    if names.is_empty() {
        return [refused, refused, 0];
    }
    let t = tangents(loaded, TICKS, &names);
    let bits = |all: &[f64]| all.iter().map(|v| v.to_bits()).collect::<Vec<u64>>();
    assert_eq!(bits(&t.output), bits(&played(loaded, &[], TICKS).output), "{title}");
    let reversed = usize::from(both_ways(title, loaded, &t, wrong));
    let (mut left_out, mut worst) = (refused, 0.0_f64);
    for (k, p) in t.parameters.iter().enumerate() {
        let Some((exact, doubt)) = difference(loaded, p, TICKS).filter(|d| d.1 < 0.1 * tolerance) else {
            println!("{title} {}: no difference to compare with", p.name);
            left_out += 1;
            continue;
        };
        let off = apart(&column(&t, k), &exact);
        worst = worst.max(off);
        println!("    {} {off:.1e} {doubt:.1e}", p.name);
        wrong.extend(
            (off >= tolerance)
                .then(|| format!("{title}: by {} {off:.1e}, of differences known to {doubt:.1e}", p.name)),
        );
    }
    println!(
        "{title}: {} parameters, {left_out} refused or without a reference, worst {worst:.1e}",
        t.parameters.len()
    );
    [refused + t.parameters.len(), left_out, reversed]
}

/// Example of each kind, links on a line and across two worlds, generators and ports.
#[test]
fn every_kind_has_the_derivatives_of_its_renders() {
    let (mut draw, mut scenes, mut both, mut all, mut wrong) = (Draw(1), 0, 0, [0, 0], Vec::new());
    for kind in catalog().iter() {
        let mut loaded = read(kind.example);
        let names = drawn(&mut loaded, &mut draw);
        if names.is_empty() {
            continue;
        }
        let [n, left_out, reversed] = compare(kind.code, &loaded, &names, 1e-6, &mut wrong);
        all = [all[0] + n, all[1] + left_out];
        scenes += 1;
        both += reversed;
    }
    println!("{scenes} scenes, {both} in reverse, {} parameters, {} without a reference", all[0], all[1]);
    assert!(wrong.is_empty(), "{wrong:#?}");
    // all but waves
    assert!(both + 1 >= scenes, "{both} of {scenes} in reverse");
    assert!(scenes >= 30 && all[1] * 20 <= all[0], "{scenes} {all:?}");
}

/// Scenes with methods other than the explicit one, and with modes, ports, filters or oversampling.
pub const METHODS: &[(&str, &str)] = &[
    (
        "BUT stable",
        "[CEL]\nbar = { m = '2 g', f = '330 Hz', t60 = '1 s' }\n[MAS]\nball = { m = '5 g', x = '-1 mm', v = '0.8 m/s' }\n[BUT]\nlink = { between = ['ball', 'bar'], k = '400 kN/m', z = '0.5 N s/m', method = 'stable' }\n[SOX]\nout = { from = 'bar' }\n",
    ),
    (
        "BUT clipped",
        "[CEL]\nbar = { m = '2 g', f = '330 Hz', t60 = '1 s' }\n[MAS]\nball = { m = '5 g', x = '-1 mm', v = '0.8 m/s' }\n[BUT]\nlink = { between = ['ball', 'bar'], k = '40 kN/m', z = '3 N s/m', sticky = false }\n[SOX]\nout = { from = 'bar' }\n",
    ),
    (
        "HRZ stable",
        "[CEL]\nbar = { m = '2 g', f = '330 Hz', t60 = '1 s' }\n[MAS]\nball = { m = '5 g', x = '-1 mm', v = '0.8 m/s' }\n[HRZ]\nlink = { between = ['ball', 'bar'], k = '1e8 N/m^1.5', h = '0.2 s/m', method = 'stable' }\n[SOX]\nout = { from = 'bar' }\n",
    ),
    (
        "BUT stable3d",
        "[CEL]\nbar = { m = '2 g', f = '330 Hz', t60 = '1 s' }\n[MAS]\nball = { m = '5 g', x = '-1 mm', v = '0.8 m/s' }\n[BUT]\nlink = { between = ['ball', 'bar'], k = '400 kN/m', z = '0.5 N s/m', method = 'stable3d' }\n[SOX]\nout = { from = 'bar' }\n",
    ),
    (
        "HRZ stable3d",
        "[CEL]\nbar = { m = '2 g', f = '330 Hz', t60 = '1 s' }\n[MAS]\nball = { m = '5 g', x = '-1 mm', v = '0.8 m/s' }\n[HRZ]\nlink = { between = ['ball', 'bar'], k = '1e8 N/m^1.5', h = '0.2 s/m', method = 'stable3d' }\n[SOX]\nout = { from = 'bar' }\n",
    ),
    (
        "three contacts at one mass",
        "[CEL]\nbar = { m = '2 g', f = '330 Hz', t60 = '1 s' }\n[MAS]\na = { m = '5 g', x = '-1 mm', v = '0.8 m/s' }\nb = { m = '7 g', x = '-1.03 mm', v = '0.83 m/s' }\nc = { m = '3 g', x = '-1.01 mm', v = '0.78 m/s' }\n[BUT]\none = { between = ['a', 'bar'], k = '400 kN/m', z = '0.5 N s/m', method = 'stable' }\ntwo = { between = ['b', 'bar'], k = '300 kN/m', method = 'stable' }\n[HRZ]\nthree = { between = ['c', 'bar'], k = '1e8 N/m^1.5', method = 'stable' }\n[SOX]\nout = { from = 'bar' }\n",
    ),
    (
        "BOW smooth secant",
        "[CEL]\nbar = { m = '1 g', f = '220 Hz', t60 = '0.5 s' }\n[MAS]\nbow = { m = '1 kg', v = '0.2 m/s' }\n[BOW]\nrub = { between = ['bar', 'bow'], f = '0.3 N', v0 = '50 mm/s', method = 'secant' }\n[SOX]\nout = { from = 'bar' }\n",
    ),
    (
        "BOW smooth newton",
        "[CEL]\nbar = { m = '1 g', f = '220 Hz', t60 = '0.5 s' }\n[MAS]\nbow = { m = '1 kg', v = '0.2 m/s' }\n[BOW]\nrub = { between = ['bar', 'bow'], f = '0.3 N', v0 = '50 mm/s', method = 'newton' }\n[SOX]\nout = { from = 'bar' }\n",
    ),
    (
        "BOW piecewise",
        "[CEL]\nbar = { m = '1 g', f = '220 Hz', t60 = '0.5 s' }\n[MAS]\nbow = { m = '1 kg', v = '0.2 m/s' }\n[BOW]\nrub = { between = ['bar', 'bow'], curve = 'piecewise', f = '0.3 N', v0 = '50 mm/s', v1 = '0.3 m/s', fd = '0.1 N' }\n[SOX]\nout = { from = 'bar' }\n",
    ),
    (
        "BOW piecewise newton",
        "[CEL]\nbar = { m = '1 g', f = '220 Hz', t60 = '0.5 s' }\n[MAS]\nbow = { m = '1 kg', v = '0.2 m/s' }\n[BOW]\nrub = { between = ['bar', 'bow'], curve = 'piecewise', f = '0.3 N', v0 = '50 mm/s', v1 = '0.3 m/s', fd = '0.1 N', method = 'newton' }\n[SOX]\nout = { from = 'bar' }\n",
    ),
    (
        "BOW coulomb",
        "[CEL]\nbar = { m = '1 g', f = '220 Hz', t60 = '0.5 s' }\n[MAS]\nbow = { m = '1 kg', v = '0.2 m/s' }\n[BOW]\nrub = { between = ['bar', 'bow'], curve = 'coulomb', f = '0.3 N', v0 = '50 mm/s' }\n[SOX]\nout = { from = 'bar' }\n",
    ),
    (
        "BOW coulomb newton",
        "[CEL]\nbar = { m = '1 g', f = '220 Hz', t60 = '0.5 s' }\n[MAS]\nbow = { m = '1 kg', v = '0.2 m/s' }\n[BOW]\nrub = { between = ['bar', 'bow'], curve = 'coulomb', f = '0.3 N', v0 = '50 mm/s', method = 'newton' }\n[SOX]\nout = { from = 'bar' }\n",
    ),
    (
        "BOW set-valued",
        "[CEL]\nbar = { m = '1 g', f = '220 Hz', t60 = '0.5 s' }\n[MAS]\nbow = { m = '1 kg', v = '0.2 m/s' }\n[BOW]\nrub = { between = ['bar', 'bow'], curve = 'coulomb', f = '0.3 N', fd = '0.2 N', method = 'set-valued' }\n[SOX]\nout = { from = 'bar' }\n",
    ),
    (
        "BOW and BUT at one mass",
        "[CEL]\nbar = { m = '1 g', f = '220 Hz', t60 = '0.5 s' }\n[MAS]\nbow = { m = '1 kg', v = '0.2 m/s' }\nball = { m = '5 g', x = '-1 mm', v = '0.8 m/s' }\n[BOW]\nrub = { between = ['bar', 'bow'], f = '0.3 N', v0 = '50 mm/s', method = 'secant' }\n[BUT]\nlink = { between = ['ball', 'bar'], k = '400 kN/m', z = '0.5 N s/m', method = 'stable' }\n[SOX]\nout = { from = 'bar' }\n",
    ),
    (
        "REF implicit",
        "[SOL]\nwall = {}\n[MAS]\na = { m = '1 g', dx0 = '1 mm' }\nb = { m = '2 g', v = '0.1 m/s' }\n[REF]\none = { between = ['wall', 'a'], k = '800 kN/m', z = '0.5 N s/m', method = 'implicit' }\ntwo = { between = ['a', 'b'], k = '50 kN/m', z = '0.1 N s/m', method = 'implicit', theta = 0.3 }\n[SOX]\nout = { from = 'b' }\n",
    ),
    (
        "REF centred",
        "[SOL]\nwall = {}\n[MAS]\na = { m = '1 g', dx0 = '1 mm' }\n[REF]\none = { between = ['wall', 'a'], k = '8 kN/m', z = '0.5 N s/m', method = 'centred' }\n[SOX]\nout = { from = 'a' }\n",
    ),
    (
        "a string by its modes, struck",
        "[model]\nmethod = 'modal'\n[STRING]\nlow = { n = 12, f = '110 Hz', t60 = '2 s', m = '1 g' }\n[MAS]\nhammer = { m = '20 g', x = '-0.3 mm', v = '1 m/s' }\n[BUT]\nstrike = { between = ['hammer', 'low[3]'], k = '8 kN/m', z = '0.2 N s/m' }\n[SOX]\nout = { from = 'low[7]' }\n",
    ),
    (
        "pefrl",
        "[model]\nmethod = 'pefrl'\n[SOL]\nwall = {}\n[MAS]\na = { m = '1 g', dx0 = '1 mm' }\nb = { m = '2 g', v = '0.1 m/s' }\n[CUB]\none = { between = ['wall', 'a'], k = '2 kN/m', k3 = '1e9 N/m^3' }\n[RES]\ntwo = { between = ['a', 'b'], k = '3 kN/m' }\n[SOX]\nout = { from = 'b' }\n",
    ),
    (
        "samples of several ticks, motion and a high pass",
        "[rate]\noversample = 3\n[CEL]\nbar = { m = '2 g', f = '330 Hz', t60 = '1 s', dx0 = '1 mm' }\n[SOX]\nout = { from = 'bar', gain = 2, hear = 'speed' }\nhigh = { from = 'bar', gain = 3, dc = '20 Hz' }\n",
    ),
    (
        "numbers that a port drives",
        "[param]\nforce = { port = 'hand', span = [0, '10 mm'], min = '0.1 N', max = '1 N' }\npitch = { port = 'hand', span = [0, '20 mm'], min = '200 Hz', max = '260 Hz' }\n[ENX]\nhand = {}\nbow = {}\n[CEL]\nbar = { m = '1 g', f = 'pitch', t60 = '0.5 s' }\nother = { m = '2 g', f = '300 Hz', t60 = '0.5 s' }\n[RES]\ntie = { between = ['bar', 'other'], k = '1 kN/m' }\n[BOW]\nrub = { between = ['bar', 'bow'], f = 'force', v0 = '50 mm/s' }\n[SOX]\nout = { from = 'other' }\n[gesture]\nbow = [[0, 0], [1, '0.2 m']]\nhand = [[0, '1 mm'], ['10 ms', '7 mm'], ['30 ms', '3 mm']]\n",
    ),
    (
        "the start of mi.lib",
        "[model]\nstart = 'mi.lib'\n[SOL]\nwall = { x = '1 mm' }\n[MAS]\na = { m = '1 g', x = '2 mm', v = '0.1 m/s' }\nb = { m = '2 g', x = '5 mm', dx0 = '0.3 mm' }\n[REF]\none = { between = ['wall', 'a'], k = '8 kN/m', z = '0.5 N s/m' }\ntwo = { between = ['a', 'b'], k = '5 kN/m', z = '0.3 N s/m' }\n[SOX]\nout = { from = 'b' }\n",
    ),
    (
        "a body in space with softened springs and a floor",
        "[air]\ndim = 3\n[air.SOL]\nnail = { x = [0, 0, 0] }\nfloor = { x = [0, 0, '-30 mm'] }\n[air.MAS]\nball = { m = '5 g', x = ['12 mm', '16 mm', '1 mm'], v = ['0.5 m/s', '-0.2 m/s', '-0.3 m/s'] }\n[air.CUB]\nedge = { between = ['air.nail', 'air.ball'], k = '2 kN/m', k3 = '1e7 N/m^3', soften = '3 mm', z = '0.1 N s/m' }\n[air.BUT]\nstop = { between = ['air.floor', 'air.ball'], k = '3 kN/m', d = '33 mm', z = '0.2 N s/m' }\n[SOX]\nout = { from = 'air.ball', along = [1, 0.5, 0.2] }\n",
    ),
    (
        "CUB stable",
        "[SOL]\nwall = {}\n[MAS]\nbob = { m = '1 g', dx0 = '1.3 mm', v = '0.4 m/s' }\n[CUB]\nl = { between = ['wall', 'bob'], k = '15 kN/m', k3 = '1e10 N/m^3', z = '30 mN s/m', method = 'stable' }\n[SOX]\nout = { from = 'bob' }\n",
    ),
    (
        "POW stable",
        "[SOL]\nwall = {}\n[MAS]\nbob = { m = '1 g', dx0 = '1.3 mm', v = '0.4 m/s' }\n[POW]\nl = { between = ['wall', 'bob'], k = '2 kN/m', q = '3e6 N/m^1.75', p = 1.75, z = '30 mN s/m', method = 'stable' }\n[SOX]\nout = { from = 'bob' }\n",
    ),
    (
        "ATT stable",
        "[SOL]\nwall = {}\n[MAS]\nbob = { m = '1 g', dx0 = '1.3 mm', v = '0.4 m/s' }\n[ATT]\nl = { between = ['wall', 'bob'], k = '2 kN/m', d = '3 mm', rho = 0.3, z = '30 mN s/m', method = 'stable' }\n[SOX]\nout = { from = 'bob' }\n",
    ),
    (
        "PLK stable",
        "[SOL]\nwall = {}\n[MAS]\nbob = { m = '1 g', dx0 = '1.3 mm', v = '0.4 m/s' }\n[PLK]\nl = { between = ['wall', 'bob'], k = '2 kN/m', d = '4 mm', z = '30 mN s/m', method = 'stable' }\n[SOX]\nout = { from = 'bob' }\n",
    ),
    (
        "LNL stable",
        "[SOL]\nwall = {}\n[MAS]\nbob = { m = '1 g', dx0 = '1.3 mm', v = '0.4 m/s' }\n[LNL]\nl = { between = ['wall', 'bob'], spring = [['-2 mm', '-9 N'], ['-0.5 mm', '-1 N'], ['0.5 mm', '1 N'], ['2 mm', '9 N']], friction = [['-3 m/s', '-0.4 N'], ['3 m/s', '0.4 N']], method = 'stable' }\n[SOX]\nout = { from = 'bob' }\n",
    ),
    (
        "CUB, POW and PLK at one mass",
        "[SOL]\nwall = {}\n[MAS]\nbob = { m = '1 g', dx0 = '1.3 mm', v = '0.4 m/s' }\nbead = { m = '2 g', v = '-0.3 m/s' }\n[CUB]\nl = { between = ['wall', 'bob'], k = '15 kN/m', k3 = '1e10 N/m^3', method = 'stable' }\n[POW]\nm = { between = ['bob', 'bead'], k = '2 kN/m', q = '3e6 N/m^1.75', p = 1.75, method = 'stable' }\n[PLK]\nn = { between = ['wall', 'bead'], k = '2 kN/m', d = '9 mm', z = '30 mN s/m', method = 'stable' }\n[SOX]\nout = { from = 'bob' }\n",
    ),
    (
        "CUB, POW, PLK and BOW at one mass",
        "[SOL]\nwall = {}\n[MAS]\nbob = { m = '1 g', dx0 = '1.3 mm', v = '0.4 m/s' }\nbow = { m = '1 kg', v = '0.2 m/s' }\nbead = { m = '2 g', v = '-0.3 m/s' }\n[CUB]\nl = { between = ['wall', 'bob'], k = '15 kN/m', k3 = '1e10 N/m^3', method = 'stable' }\n[POW]\nm = { between = ['bob', 'bead'], k = '2 kN/m', q = '3e6 N/m^1.75', p = 1.75, method = 'stable' }\n[PLK]\nn = { between = ['wall', 'bead'], k = '2 kN/m', d = '9 mm', z = '30 mN s/m', method = 'stable' }\n[BOW]\nrub = { between = ['bob', 'bow'], curve = 'piecewise', f = '0.3 N', v0 = '50 mm/s', v1 = '3 m/s', fd = '0.1 N', method = 'secant' }\n[SOX]\nout = { from = 'bob' }\n",
    ),
];

#[test]
fn every_method_has_the_derivatives_of_its_renders() {
    let (mut draw, mut all, mut wrong) = (Draw(7), [0, 0], Vec::new());
    for (title, text) in METHODS {
        let mut loaded = read(text);
        let names = drawn(&mut loaded, &mut draw);
        let [n, left_out, _] = compare(title, &loaded, &names, 1e-6, &mut wrong);
        all = [all[0] + n, all[1] + left_out];
    }
    println!("{} parameters, {} without a reference", all[0], all[1]);
    assert!(wrong.is_empty(), "{wrong:#?}");
    assert!(all[1] * 10 <= all[0], "{all:?}");
}

/// Linear scenes, whose differences are exact.
#[test]
fn linear_scenes_have_their_derivatives_to_a_billionth() {
    let scenes = [
        (
            "a string",
            "[STRING]\nlow = { n = 20, f = '220 Hz', t60 = '1 s', m = '1 g' }\n[MAS]\nbob = { m = '3 g', dx0 = '1 mm', v = '0.2 m/s' }\n[REF]\ntie = { between = ['low[5]', 'bob'], k = '2 kN/m', z = '0.1 N s/m' }\n[SOX]\nout = { from = 'low[11]', gain = 2 }\n",
        ),
        (
            "a mesh",
            "[MESH]\nskin = { nx = 5, ny = 6, f = '200 Hz', t60 = '0.5 s', m = '2 g' }\n[MAS]\nbob = { m = '3 g', dx0 = '1 mm', v = '0.2 m/s' }\n[RES]\ntie = { between = ['skin[7]', 'bob'], k = '2 kN/m' }\n[SOX]\nout = { from = 'skin[13]' }\n",
        ),
        (
            "a string of waves",
            "[WAVEGUIDE]\nlow = { f = '220 Hz', t60 = '1 s', z = '0.5 N s/m', at = [0.3, 0.7] }\n[MAS]\nbob = { m = '3 g', dx0 = '1 mm', v = '0.2 m/s' }\n[REF]\ntie = { between = ['low[0]', 'bob'], k = '2 kN/m', z = '0.1 N s/m' }\n[SOX]\nout = { from = 'low[1]' }\n",
        ),
        (
            "implicit",
            "[model]\nmethod = 'implicit'\n[STRING]\nlow = { n = 20, f = '220 Hz', t60 = '1 s', m = '1 g' }\n[MAS]\nbob = { m = '3 g', dx0 = '1 mm', v = '0.2 m/s' }\n[REF]\ntie = { between = ['low[5]', 'bob'], k = '2 kN/m', z = '0.1 N s/m' }\n[SOX]\nout = { from = 'low[11]' }\n",
        ),
        (
            "modal",
            "[model]\nmethod = 'modal'\n[STRING]\nlow = { n = 20, f = '220 Hz', t60 = '1 s', m = '1 g' }\n[MAS]\nbob = { m = '3 g', dx0 = '1 mm', v = '0.2 m/s' }\n[REF]\ntie = { between = ['low[5]', 'bob'], k = '2 kN/m', z = '0.1 N s/m' }\n[SOX]\nout = { from = 'low[11]' }\n",
        ),
    ];
    let (mut draw, mut wrong) = (Draw(3), Vec::new());
    for (title, text) in scenes {
        let mut loaded = read(text);
        let names = drawn(&mut loaded, &mut draw);
        let [_, left_out, _] = compare(title, &loaded, &names, 1e-9, &mut wrong);
        assert_eq!(left_out, 0, "{title}");
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}
