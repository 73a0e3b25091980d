//! Independent check of imported models: masses and springs are read from the text and from the model by separate short
//! readers, and simulated side by side. Generators are expanded here as documented, not by the compiler.

use super::shown;
use ca_import::mims::import;
use ca_model::{Model, Value};
use std::collections::BTreeMap;
use std::fmt::Write as _;

/// Masses and springs by name. Non-linear links are left out on both sides.
#[derive(Default)]
struct Bare {
    mass: BTreeMap<String, f64>,
    spring: Vec<(String, String, f64, f64)>,
    push: Vec<String>,
    hear: Vec<String>,
}

impl Bare {
    fn of_text(text: &str) -> Bare {
        let mut bare = Bare::default();
        let mut params = BTreeMap::new();
        for line in text.lines() {
            let words: Vec<&str> = line.split('#').next().unwrap().split_whitespace().collect();
            let num = |i: usize| {
                let w: &str = words.get(i).unwrap_or(&"0");
                w.parse().ok().or_else(|| params.get(w).copied()).unwrap_or(0.0)
            };
            let at = |i: usize| words[i].trim_start_matches('@').to_string();
            match words.get(1).copied().unwrap_or("") {
                "param" => _ = params.insert(words[0].trim_start_matches('@').to_string(), num(2)),
                "mass" => _ = bare.mass.insert(at(0), num(2)),
                "ground" | "posInput" => _ = bare.mass.insert(at(0), f64::INFINITY),
                "spring" | "springDamper" | "springDamperDamper" => {
                    bare.spring.push((at(2), at(3), num(4), num(5)));
                }
                "frcInput" => bare.push.push(at(2)),
                "posOutput" => bare.hear.push(at(2)),
                _ => {}
            }
        }
        bare
    }

    fn of_model(model: &Model) -> Bare {
        let mut bare = Bare::default();
        for item in &model.items {
            let get = |key: &str| item.args.iter().find(|e| e.key == key).map(|e| &e.value);
            let num = |key: &str| match get(key) {
                Some(Value::Num(x)) => *x,
                Some(Value::Text(name)) => {
                    let p = model.params.iter().find(|p| &p.key == name).expect("a parameter that is used");
                    if let Value::Num(x) = p.value { x } else { panic!("{p:?}") }
                }
                _ => 0.0,
            };
            let text = |key: &str| if let Some(Value::Text(t)) = get(key) { t.clone() } else { String::new() };
            let (name, m, k, z) = (&item.name, num("m"), num("k"), num("z"));
            match item.kind.as_str() {
                "MAS" => _ = bare.mass.insert(name.clone(), m),
                "SOL" | "ENX" => _ = bare.mass.insert(name.clone(), f64::INFINITY),
                "RES" | "REF" => {
                    let Some(Value::List(ends)) = get("between") else { panic!("{item:?}") };
                    let end = |i: usize| if let Value::Text(t) = &ends[i].value { t.clone() } else { String::new() };
                    bare.spring.push((end(0), end(1), k, z));
                }
                "ENF" => bare.push.push(text("to")),
                "SOX" => bare.hear.push(text("from")),
                "STRING" | "CHAIN" => {
                    let n = num("n") as usize;
                    let mut row: Vec<String> = (0..n).map(|i| format!("{name}[{i}]")).collect();
                    bare.mass.extend(row.iter().map(|r| (r.clone(), m)));
                    if item.kind == "STRING" {
                        assert_eq!(text("ends"), "fixed");
                        for (i, at) in [0, n + 1].into_iter().enumerate() {
                            row.insert(at, format!("{name}.end[{i}]"));
                            bare.mass.insert(row[at].clone(), f64::INFINITY);
                        }
                    }
                    bare.spring.extend(row.windows(2).map(|w| (w[0].clone(), w[1].clone(), k, z)));
                }
                "MESH" => {
                    let (nx, ny) = (num("nx") as usize, num("ny") as usize);
                    let at = |i: usize, j: usize| format!("{name}[{i},{j}]");
                    for i in 0..nx {
                        for j in 0..ny {
                            let (ei, ej) = (i == 0 || i == nx - 1, j == 0 || j == ny - 1);
                            let fixed = held(item).contains(&[i as f64, j as f64])
                                || match text("edges").as_str() {
                                    "closed" => ei || ej,
                                    "corner" => ei && ej,
                                    _ => false,
                                };
                            bare.mass.insert(at(i, j), if fixed { f64::INFINITY } else { m });
                            if i + 1 < nx {
                                bare.spring.push((at(i, j), at(i + 1, j), k, z));
                            }
                            if j + 1 < ny {
                                bare.spring.push((at(i, j), at(i, j + 1), k, z));
                            }
                        }
                    }
                }
                _ => {}
            }
        }
        bare
    }

    /// Outputs at each of 60 samples after a push at the first.
    fn run(&self) -> Vec<Vec<f64>> {
        let index: BTreeMap<&str, usize> = self.mass.keys().enumerate().map(|(i, n)| (n.as_str(), i)).collect();
        let at = |n: &String| *index.get(n.as_str()).unwrap_or_else(|| panic!("`{n}` is nowhere"));
        let m: Vec<f64> = self.mass.values().copied().collect();
        let springs: Vec<_> = self.spring.iter().map(|(a, b, k, z)| (at(a), at(b), *k, *z)).collect();
        let (mut x, mut d) = (vec![0.0; m.len()], vec![0.0; m.len()]);
        let mut heard = Vec::new();
        for n in 0..60 {
            let mut f = vec![0.0; m.len()];
            for p in self.push.iter().filter(|_| n == 0) {
                f[at(p)] += 1.0;
            }
            for &(a, b, k, z) in &springs {
                let force = k * (x[b] - x[a]) + z * (d[b] - d[a]);
                f[a] += force;
                f[b] -= force;
            }
            for i in 0..m.len() {
                d[i] += f[i] / m[i];
                x[i] += d[i];
            }
            heard.push(self.hear.iter().map(|h| x[at(h)]).collect());
        }
        heard
    }
}

/// Asserts that the import of `text`, with every mass as an output, moves as `text` says.
pub fn same_movement(text: &str) {
    let mut text = text.to_string() + "\n";
    let masses: Vec<String> = Bare::of_text(&text).mass.into_keys().collect();
    for (i, name) in masses.iter().enumerate() {
        _ = writeln!(text, "@heard_{i} posOutput @{name}");
    }
    let (model, diags) = import(&text, "");
    assert!(!diags.has_errors(), "{diags}\n{text}");
    let (theirs, ours) = (Bare::of_text(&text), Bare::of_model(&model));
    assert_eq!(theirs.push.len(), ours.push.len());
    let (theirs, ours) = (theirs.run(), ours.run());
    assert!(theirs.iter().flatten().any(|x| *x != 0.0) || !text.contains("frcInput"), "nothing moves");
    for (n, (a, b)) in theirs.iter().zip(&ours).enumerate() {
        assert_eq!(a.len(), b.len());
        for (i, (a, b)) in a.iter().zip(b).enumerate() {
            assert!((a - b).abs() < 1e-12, "heard {i} at {n}: {a} {b}\n{}\n{text}", shown(&model, &diags, &text));
        }
    }
}

/// Nodes of a mesh that are fixed in addition to its edges.
fn held(item: &ca_model::Item) -> Vec<[f64; 2]> {
    let list = |v: &Value| if let Value::List(l) = v { l.clone() } else { Vec::new() };
    let num = |v: &Value| if let Value::Num(n) = v { *n } else { f64::NAN };
    let fixed = item.args.iter().find(|e| e.key == "fixed").map_or(Vec::new(), |e| list(&e.value));
    fixed.iter().map(|p| list(&p.value)).map(|p| [num(&p[0].value), num(&p[1].value)]).collect()
}
