//! Tests every number in a finding of the compiler from both sides: a thousandth below it nothing is found, a
//! thousandth above it the finding is there. A limit that moves in either direction is detected.

use ca_compile::{Options, compile};
use ca_conformance::random_parameters::catalog;
use ca_core::{Kind, Role, Type, Unit};
use ca_model::diag::Diags;
use ca_model::{Entry, Value, read};
use std::f64::consts::PI;
use std::fmt::Write as _;

/// Findings of a model: code, title and help, one line each.
fn found(text: &str) -> String {
    let (model, mut diags) = read::read(text, "test.ca.toml", &catalog());
    diags.list.extend(match compile(&model, &catalog(), &Options::default()) {
        Ok(scene) => scene.findings.list,
        Err(diags) => diags.list,
    });
    messages(&diags)
}

fn messages(diags: &Diags) -> String {
    let mut all = String::new();
    for d in &diags.list {
        let _ = writeln!(all, "{}: {} ({})", d.code, d.title, d.help.as_deref().unwrap_or(""));
    }
    all
}

/// The stiffness at which kT²/m of a gram is `a` at 48 kHz.
pub fn k(a: f64) -> f64 {
    a * 1e-3 * 48e3 * 48e3
}

/// The viscosity at which zT/m of a gram is `a` at 48 kHz.
pub fn z(a: f64) -> f64 {
    a * 1e-3 * 48e3
}

fn bob(more: &str) -> String {
    format!("[SOL]\nwall = {{}}\n[MAS]\nbob = {{ m = \"1 g\" }}\n[SOX]\nout = {{ from = \"bob\" }}\n{more}")
}

/// The same with one link to the wall.
pub fn link(code: &str, args: &str) -> String {
    bob(&format!("[{code}]\nl = {{ between = [\"wall\", \"bob\"], {args} }}\n"))
}

/// The gram between two contacts of kT²/m = `a` with these ends.
fn sides(a: f64, ends: [&str; 2]) -> String {
    let [one, other] = ends;
    let k = k(a);
    bob(&format!(
        "[BUT]\none = {{ between = [\"{one}\"], k = {k:?} }}\nother = {{ between = [\"{other}\"], k = {k:?} }}\n"
    ))
}

#[test]
fn contacts_on_two_sides_do_not_press_at_once() {
    let between = found(&sides(2.5, ["wall\", \"bob", "bob\", \"wall"]));
    assert!(!between.contains("W117"), "{between}");
    assert!(found(&sides(2.5, ["wall\", \"bob", "wall\", \"bob"])).contains("W117"));
    // one of them acts from inside, so both press from one side
    let held = sides(2.5, ["wall\", \"bob", "bob\", \"wall"]).replace("other = {", "other = { sense = \"inside\",");
    assert!(found(&held).contains("press at once"), "{}", found(&held));
}

/// A string of a gram each, kT²/m = 0.9, with a non-linear spring in its middle.
fn held(a: f64) -> String {
    format!(
        "[STRING]\ns = {{ n = 20, m = \"1 g\", k = {:?} }}\n[SOL]\nwall = {{}}\n[CUB]\nc = {{ between = [\"wall\", \"s[9]\"], \
         k = {:?}, k3 = 1 }}\n[SOX]\nout = {{ from = \"s[3]\" }}\n",
        k(0.9),
        k(a)
    )
}

/// A body with one edge supported by a spring of 100 N/m.
fn lpr(k: f64) -> String {
    format!(
        "[room]\ndim = 3\n[room.MAS]\na = {{ m = 1 }}\nb = {{ m = 1, x = [1, 0, 0] }}\n[SOL]\nwall = {{}}\n[MAS]\nbob = {{ m = 1 \
         }}\n[RES]\nhold = {{ between = [\"wall\", \"bob\"], k = 100 }}\n[LPR]\nedge = {{ between = [\"room.a\", \"room.b\"], \
         onto = [\"wall\", \"bob\"], k = {k:?} }}\n[SOX]\nout = {{ from = \"bob\" }}\n"
    )
}

fn rate(words: &str) -> String {
    format!("[rate]\n{words}\n{}", bob(""))
}

/// A limit: code and words of the finding beyond it, the number, and the model for a number.
type Limit = (&'static str, &'static str, f64, fn(f64) -> String);

fn limits() -> Vec<Limit> {
    vec![
        ("W103", "the limit is", 4.0, |a| link("RES", &format!("k = {:?}", k(a)))),
        ("W103", "the limit is", 2.0, |a| link("FRO", &format!("z = {:?}", z(a)))),
        // the method has its own limit, 8.9368, slightly more than twice the explicit one
        ("W103", "the limit is", 8.936_808, |a| {
            format!("[model]\nmethod = \"pefrl\"\n{}", link("RES", &format!("k = {:?}", k(a))))
        }),
        ("W104", "may add energy", 1.0, |a| link("BUT", &format!("k = {:?}", k(a)))),
        ("W104", "adds energy at most impacts", 2.0, |a| link("BUT", &format!("k = {:?}", k(a)))),
        // a + 2b, by stiffness, by viscosity, and by both
        ("W117", "the limit is 4", 4.0, |a| link("BUT", &format!("k = {:?}", k(a)))),
        ("W117", "the limit is 4", 2.0, |b| link("BUT", &format!("k = 1e-3, z = {:?}", z(b)))),
        ("W117", "the limit is 4", 3.0, |a| link("BUT", &format!("k = {:?}, z = {:?}", k(a), z(0.5)))),
        ("W117", "the limit is 4", 4.0, |a| link("PLK", &format!("k = {:?}, d = 1", k(a)))),
        // contacts on one side of a mass press at once, those on two sides do not
        ("W117", "press at once", 2.0, |a| sides(a, ["wall\", \"bob", "wall\", \"bob"])),
        ("W117", "press at once", 1.0, |b| {
            link("BUT", &format!("k = 1e-3, z = {:?}", z(b)))
                .replace("[\"wall\", \"bob\"]", "[[\"wall\", \"wall\"], \"bob\"]")
        }),
        // a chain of 0.9 with b more at one mass has the largest eigenvalue 1.8 + sqrt(1.8² + b²)
        ("W107", "the limit is 4", 1.264_911, held),
        ("W112", "is softer than", 100.0, lpr),
        ("W113", "the limit is 1.5", 1.5, |a| {
            link("BOW", &format!("curve = \"coulomb\", f = {:?}, v0 = \"1 m/s\"", z(a)))
        }),
        ("N206", "below 4", 4.0, |b| {
            link("BOW", &format!("curve = \"coulomb\", f = {:?}, v0 = \"1 m/s\", method = \"newton\"", z(b)))
        }),
        ("W119", "the limit is 1e9", 1e9, |a| link("BUT", &format!("k = {:?}, method = \"stable\"", k(a)))),
        ("W119", "the limit is 1e3", 1e3, |b| link("BUT", &format!("k = 1e-3, z = {:?}, method = \"stable\"", z(b)))),
        ("W119", "the limit is 1e9", 1e9, |a| link("CUB", &format!("k = {:?}, k3 = 1, method = \"stable\"", k(a)))),
        // 1 % of half the sound rate is left to the filter
        ("E023", "stay below 23760 Hz", 23_760.0, |f| rate(&format!("filter = {f:?}"))),
        ("E023", "stay below 24000 Hz", 24_000.0, |f| {
            format!("[CEL]\nbar = {{ m = 1, f = {f:?} }}\n[SOX]\nout = {{ from = \"bar\" }}\n")
        }),
        ("E023", "is not below half the sound rate", 24_000.0, |f| {
            bob("").replace("from = \"bob\"", &format!("from = \"bob\", dc = {f:?}"))
        }),
        // the corner frequency Z/πm of a junction at a quarter of the sound rate
        ("N203", "the mass of a junction of", 0.8 / (PI * 12e3), |m| {
            waveguide(&format!("f = 110, z = 0.8, at = 0.3, m = {m:?}"))
        }),
        // modes of 1 and 3 times a stiffness; half of the damping of one mass couples them, by 1e-9 of their distance
        ("W115", "damping couples the modes", 2e-9 * 0.02, tied),
        ("E023", "is not below half the sound rate", 24_000.0, |f| {
            generator("STRING", &format!("n = 3, m = 1, f = {f:?}"))
        }),
        ("E023", "cannot reach", closed_mesh(), |f| {
            generator("MESH", &format!("nx = 6, ny = 5, m = 1, edges = \"closed\", f = {f:?}"))
        }),
        ("E023", "is longer than the", 2.0, |t| {
            waveguide(&format!("f = 110, z = 1, at = 0.3, t60 = 2, t60_high = {t:?}"))
        }),
        ("E023", "is not between `f` and half the sound rate", 24_000.0, |f| {
            waveguide(&format!("f = 110, z = 1, at = 0.3, t60 = 2, t60_high = 1, f_high = {f:?}"))
        }),
        ("E009", "sound", 1e7, |f| rate(&format!("sound = {f:?}\ngesture = {f:?}"))),
        ("E009", "seconds", 86_400.0, |s| format!("[model]\nseconds = {s:?}\n{}", bob(""))),
    ]
}

/// A waveguide with its first junction as the output.
fn waveguide(args: &str) -> String {
    generator("WAVEGUIDE", args)
}

fn generator(code: &str, args: &str) -> String {
    let first = if code == "MESH" { "g[1,1]" } else { "g[0]" };
    format!("[{code}]\ng = {{ {args} }}\n[SOX]\nout = {{ from = \"{first}\" }}\n")
}

/// Two equal cells on a spring, by their modes, one of them damped by zT/m = `d`.
fn tied(d: f64) -> String {
    format!(
        "[model]\nmethod = \"modal\"\n[CEL]\na = {{ m = \"1 g\", k = {0:?}, z = {1:?} }}\nb = {{ m = \"1 g\", k = {0:?} }}\n[RES]\nl = \
         {{ between = [\"a\", \"b\"], k = {0:?} }}\n[SOX]\nout = {{ from = \"a\" }}\n",
        k(0.01),
        z(d)
    )
}

/// Pitch \[Hz\] of a closed 6 x 5 mesh with kT²/m = 1/2: sin²(πfT) = (sin²(π/10) + sin²(π/8))/2.
fn closed_mesh() -> f64 {
    let shape = (PI / 10.0).sin().powi(2) + (PI / 8.0).sin().powi(2);
    (0.5 * shape).sqrt().asin() / PI * 48e3
}

#[test]
fn a_limit_that_is_stated_is_where_it_is_stated() {
    let mut wrong = String::new();
    for (code, words, at, text) in limits() {
        for (v, is) in [(at * (1.0 - 1e-3), false), (at * (1.0 + 1e-3), true)] {
            let all = found(&text(v));
            if all.lines().any(|l| l.starts_with(code) && l.contains(words)) != is {
                let _ = writeln!(wrong, "{code} ({words}) is {}reported at {v}:\n{all}", if is { "not " } else { "" });
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong}");
}

/// Findings about a zero, a count or a sign appear exactly there.
#[test]
fn a_limit_at_nothing_or_at_a_count_is_there_too() {
    let key = |z: f64| {
        let tgr = "[TGR]\nkey = { device = \"d\", dof = 0 }\n[REF]\nr = { between = [\"key\", \"bob\"], k = 10, ";
        bob(&format!("{tgr}z = {z:?} }}\n"))
    };
    let table = |y: f64| link("LNL", &format!("friction = [[-1, -1], [0, 0], [1, {y:?}]]"));
    let dim = |n: i32| format!("[room]\ndim = {n}\n{}", bob(""));
    let oversample = |n: i32| rate(&format!("oversample = {n}"));
    let latency = |n: i32| rate(&format!("latency = {n}"));
    let slow = |more: &str| {
        format!(
            "[rate]\ngesture = 48\n[slow]\nrate = \"gesture\"\n[slow.MAS]\n{}",
            bob(more)
                .replacen("[MAS]\n", "", 1)
                .replacen("[SOL]\nwall = {}\n", "", 1)
                .replace("\"bob\"", "\"slow.bob\"")
        )
    };
    let across = |n: i32| {
        let names: Vec<String> = (0..n).map(|i| format!("\"m{i}\"")).collect();
        let mut text = String::from("[slow]\nrate = \"gesture\"\n[slow.MAS]\n");
        for m in &names {
            let _ = writeln!(text, "{} = {{ m = 1 }}", m.trim_matches('"'));
        }
        let all: Vec<String> = names.iter().map(|m| format!("\"slow.{}", &m[1..])).collect();
        bob(&format!("[RES]\nr = {{ between = [[{}], \"bob\"], k = 1 }}\n{text}", all.join(", ")))
    };
    let behind = |n: i32| {
        slow(&format!(
            "[STRING]\ns = {{ n = {n}, m = 1, k = 1 }}\n[RES]\nr = {{ between = [\"slow.bob\", \"s[0]\"], k = 1 }}\n"
        ))
    };
    for (code, words, quiet, reported) in [
        ("E034", "the limit is 48", across(48), across(49)),
        ("E034", "with this number of ticks, the limit is 65", behind(65), behind(66)),
        ("W105", "viscosity directly to a device key", key(0.0), key(1e-9)),
        ("W110", "may add energy: its table is not passive", table(0.0), table(-1e-9)),
        ("E009", "dim", dim(3), dim(4)),
        ("E009", "dim", dim(1), dim(0)),
        ("E009", "oversample", oversample(64), oversample(65)),
        ("E009", "oversample", oversample(1), oversample(0)),
        ("E009", "latency", latency(10_000), latency(10_001)),
        ("E009", "latency", latency(0), latency(-1)),
        ("E009", "sound", rate("sound = 1\ngesture = 1"), rate("sound = 0.999\ngesture = 0.999")),
    ] {
        let is = |text: &str| found(text).lines().any(|l| l.starts_with(code) && l.contains(words));
        assert!(!is(&quiet), "{code} ({words}) is reported\n{quiet}\n{}", found(&quiet));
        assert!(is(&reported), "{code} ({words}) is not reported\n{reported}\n{}", found(&reported));
    }
}

#[test]
fn a_contact_that_presses_at_load_is_reported_from_its_threshold_on() {
    let text = |x: f64| {
        format!(
            "[MAS]\nbob = {{ m = 1 }}\nend = {{ m = 1, x = {x:?} }}\n[BUT]\nb = {{ between = [\"bob\", \"end\"], k = 10, d = \
             0.1 }}\n[SOX]\nout = {{ from = \"bob\" }}\n"
        )
    };
    assert!(!found(&text(0.1 + 1e-9)).contains("W102"));
    assert!(found(&text(0.1 - 1e-9)).contains("W102"));
}

/// Puts one argument into the example of a kind and returns the findings.
fn with(kind: &Kind, key: &str, value: Value) -> String {
    let (mut model, _) = read::read(kind.example, "test.ca.toml", &catalog());
    let item = model.items.iter_mut().find(|i| i.kind == kind.code).expect("an example of itself");
    item.args.retain(|e| e.key != key);
    item.args.push(Entry::new(key, value));
    match compile(&model, &catalog(), &Options::default()) {
        Ok(scene) => messages(&scene.findings),
        Err(diags) => messages(&diags),
    }
}

/// The range of every parameter of every kind: its ends are accepted, values just beyond are refused by name.
#[test]
fn every_range_of_a_parameter_ends_where_its_record_says() {
    let mut seen = 0;
    for kind in catalog().iter() {
        for p in kind.params {
            let (ends, beyond): (Vec<f64>, Vec<f64>) = match p.ty {
                Type::Number { unit, min, max } => {
                    let near = |v: f64, to: f64| if v == 0.0 { to } else { v + to * v.abs() };
                    let plain = unit == Unit::NONE;
                    let ends = [min, max].into_iter().filter(|v| v.abs() < 1e6 && *v != f64::MIN_POSITIVE);
                    let low = (min > f64::MIN).then(|| if min == f64::MIN_POSITIVE { 0.0 } else { near(min, -1e-6) });
                    let high = (max < f64::MAX).then(|| near(max, 1e-6));
                    // an exponent is in quarters: values between them are refused for that reason
                    let ends = ends.filter(|_| plain || min == 0.0).collect();
                    (ends, low.into_iter().chain(high).collect())
                }
                Type::Count { min, max } => {
                    let low = (min > 0).then(|| f64::from(min) - 1.0);
                    (vec![], low.into_iter().chain([f64::from(max) + 1.0]).collect())
                }
                _ => continue,
            };
            let refused = |v: f64| {
                let all = with(kind, p.name, v.into());
                let is = |l: &str| l.starts_with("E009") && l.contains(&format!("`{}", p.name));
                (all.lines().any(is) || all.lines().any(|l| l.starts_with("E009") && l.contains(p.name)), all)
            };
            for v in ends {
                let (no, all) = refused(v);
                assert!(!no, "{}.{} = {v} is refused:\n{all}", kind.code, p.name);
                seen += 1;
            }
            for v in beyond {
                let (no, all) = refused(v);
                assert!(no, "{}.{} = {v} is not refused:\n{all}", kind.code, p.name);
                seen += 1;
            }
        }
    }
    assert!(seen > 150, "{seen} ends were tried");
}

/// The advised number of masses for a pitch that is too high is the largest that can sound it, for every generator with
/// a number of masses and a pitch.
#[test]
fn as_many_masses_as_are_advised_can_sound() {
    let catalog = catalog();
    let rows = catalog.iter().filter(|k| matches!(k.role, Role::Generator(_)) && k.param("n").is_some());
    let rows: Vec<_> = rows.filter(|k| k.param("f").is_some()).map(|k| k.code).collect();
    assert!(["STRING", "CHAIN", "STIFFSTRING", "RING"].iter().all(|code| rows.contains(code)), "{rows:?}");
    let plain = rows.into_iter().flat_map(|code| [(code, "", "ca"), (code, ", t60 = 1", "ca"), (code, "", "centred")]);
    let more = [("STRING", ", ends = \"free\"", "ca"), ("STIFFSTRING", ", b = 1e-3", "ca")];
    for (code, more, method) in plain.chain(more) {
        let of = |n: usize| {
            let text = generator(code, &format!("n = {n}, m = 1, f = 1000{more}"));
            found(&format!("[model]\nmethod = \"{method}\"\n{text}"))
        };
        let all = of(400);
        let advised = all.split("use at most ").nth(1).and_then(|s| s.split(' ').next());
        let n: usize = advised.and_then(|n| n.parse().ok()).unwrap_or_else(|| panic!("{code}{more}: {all}"));
        assert!(n > 10, "{code}{more}: {n}");
        assert!(!of(n).contains("E023"), "{code}{more}: {n}: {}", of(n));
        assert!(of(n + 1).contains("E023"), "{code}{more}: {} can", n + 1);
    }
}

/// Every remedy offered for twelve masses at the highest piano notes works; smaller numbers in it do not.
#[test]
fn each_way_that_is_offered_to_the_highest_strings_works() {
    let mut seen = 0;
    for key in 60..=88 {
        let f = 440.0 * (f64::from(key - 49) / 12.0).exp2();
        for (code, more) in
            [("STRING", ""), ("STRING", ", t60 = 1"), ("CHAIN", ""), ("STIFFSTRING", ", b = 1e-4"), ("RING", "")]
        {
            let of = |top: &str, n: u32| {
                found(&format!("{top}\n{}", generator(code, &format!("n = {n}, m = 1, f = {f:?}{more}"))))
            };
            let all = of("", 12);
            let number = |before: &str| -> Option<u32> {
                let text = all.split(before).nth(1)?;
                text.split(|c: char| !c.is_ascii_digit()).next()?.parse().ok()
            };
            if !all.contains("cannot reach") {
                continue;
            }
            seen += 1;
            let is_fine = |all: &str| !all.lines().any(|l| l.starts_with('E'));
            let ticks = number("`oversample = ").unwrap_or_else(|| panic!("{code} {key}: {all}"));
            let rate = |ticks: u32| format!("[rate]\noversample = {ticks}");
            assert!(is_fine(&of(&rate(ticks), 12)), "{code} {key}: {ticks} ticks: {}", of(&rate(ticks), 12));
            assert!(
                of(&rate(ticks - 1), 12).contains("cannot reach"),
                "{code} {key}: {ticks} ticks are more than enough"
            );
            if let Some(n) = number("use at most ") {
                assert!(is_fine(&of("", n)) && of("", n + 1).contains("cannot reach"), "{code} {key}: {n} masses");
            }
            assert!(all.contains("`method = \"modal\"` in its group or `[model]`"), "{code} {key}: {all}");
            let modal = of("[model]\nmethod = \"modal\"", 12);
            assert!(is_fine(&modal), "{code} {key}: {modal}");
        }
    }
    assert!(seen > 16, "{seen}");
    // with several ticks per sample already, the advice is a higher number
    let text = format!("[rate]\noversample = 2\n{}", generator("STRING", "n = 100, m = 1, f = 2000"));
    let more = found(&text);
    assert!(more.contains("`oversample = 9`"), "{more}");
    assert!(!found(&text.replace("= 2\n", "= 9\n")).contains("E023"));
    assert!(found(&text.replace("= 2\n", "= 8\n")).contains("E023"));
    assert!(!found(&generator("STRING", "n = 3, m = 1, f = 30000")).contains("oversample"));
}

/// Limits of a waveguide of a hundred samples: junction positions, length, shortest decay.
#[test]
fn junctions_of_a_waveguide_have_room_from_there_on() {
    let by = |t: f64| (t * (1.0 - 1e-3), t * (1.0 + 1e-3));
    let at = |at: f64| waveguide(&format!("f = 480, z = 1, t60 = 1, at = {at:?}"));
    let two = |at: f64| waveguide(&format!("f = 480, z = 1, t60 = 1, at = [0.2, {at:?}]"));
    let long = |f: f64| waveguide(&format!("f = {f:?}, z = 1, at = 0.3"));
    let dies = |t: f64| waveguide(&format!("f = 480, z = 1, at = 0.3, t60 = {t:?}"));
    for (words, quiet, reported) in [
        // half a sample of the way there and back
        ("is less than", at(by(0.005).1), at(by(0.005).0)),
        // beyond, each direction has its own delay: a whole sample of the round trip
        ("is less than", two(0.21 * (1.0 + 1e-4)), two(0.21 * (1.0 - 1e-4))),
        ("leaves no samples behind", at(0.975 * (1.0 - 1e-4)), at(0.975 * (1.0 + 1e-4))),
        ("needs a string of more than 1e6 samples", long(by(0.048).1), long(by(0.048).0)),
        ("decays before it has oscillated once", dies(1.0), dies(by(0.25 / 480.0).0)),
    ] {
        let is = |text: &str| found(text).lines().any(|l| l.starts_with("E023") && l.contains(words));
        assert!(!is(&quiet), "{words} is reported\n{quiet}\n{}", found(&quiet));
        assert!(is(&reported), "{words} is not reported\n{reported}\n{}", found(&reported));
    }
}

fn lines(n: usize, line: impl Fn(usize) -> String) -> String {
    (0..n).map(line).collect::<Vec<_>>().concat()
}

/// A million masses and links from any source: that many pass, one more is refused where it is one too many. Passing
/// models have another error, so that they need not be compiled.
#[test]
fn a_model_holds_a_million_modules() {
    // written one by one: the reader counts them and stops at the hundredth error
    let written = |n: usize| {
        let mut text = String::from("[MAS]\n");
        (0..n).for_each(|i| _ = writeln!(text, "m{i}={{w=1}}"));
        text
    };
    // a string adds at most two modules per mass
    let strings = |beside: usize| {
        let more = lines(beside, |i| format!("m{i} = {{ m = 1 }}\n"));
        format!("[MAS]\n{more}[STRING]\ns = {{ m = 1, n = 499990, f = 23999 }}\n")
    };
    // 1000 x 996 links with their 3990 masses and links, and some more
    let joined = |beside: usize| {
        let more = lines(beside, |i| format!("m{i} = {{ m = 1 }}\n"));
        let row = |n: &str, m: usize| format!("{n} = {{ n = {m}, m = 1, k = 1 }}\n");
        let rows = row("a", 1000) + &row("b", 996);
        format!(
            "[CHAIN]\n{rows}[MAS]\n{more}[RES]\nr = {{ between = [\"a[*]\", \"b[*]\"], k = 1, pairs = \"all\" }}\n[SOX]\no = {{ \
             from = \"nothing\" }}\n"
        )
    };
    // a list that names the same thousand repeatedly, as ends
    let list = |n: usize, more: usize| {
        let all = vec!["\"a[*]\""; n].join(", ");
        let rest = vec!["\"a[0]\""; more].join(", ");
        if more > 0 { format!("[{all}, {rest}]") } else { format!("[{all}]") }
    };
    let chain = "[CHAIN]\na = { n = 1000, m = 1, k = 1 }\n[SOL]\nw = {}\n";
    let ends = |more: usize| format!("{chain}[RES]\nr = {{ between = [\"w\", {}], k = 1 }}\n", list(1000, more));
    // the same thousand repeatedly, as targets of a force, as outputs, and as links to a moving point
    let again = |kind: &str, n: usize, args: &str| {
        let all = lines(n, |i| format!("o{i} = {{ {args} }}\n"));
        format!("{chain}[{kind}]\n{all}[SOF]\nn = {{ from = \"nothing\" }}\n")
    };
    let pushed = |n: usize| again("ENF", n, "to = \"a[*]\"");
    let heard = |n: usize| again("SOX", n, "from = \"a[*]\", channel = 0");
    let linked = |n: usize| again("RES", n, "between = [\"a@0.5\", \"a[*]\"], k = 1");
    let points = |n: usize| {
        let all = lines(n, |i| format!("o{i} = {{ from = \"a@{}\", channel = 0 }}\n", i as f64 / 1e4));
        format!("{chain}[SOX]\n{all}n = {{ from = \"nothing\" }}\n")
    };
    for (words, quiet, reported) in [
        ("more than 1000000 masses and links are written", written(1_000_000), written(1_000_001)),
        ("would make 999980 modules in addition", strings(20), strings(21)),
        ("has too many links", joined(10), joined(11)),
        ("has too many ends", ends(0), ends(1)),
        ("has too many forces", pushed(1000), pushed(1001)),
        ("has too many outputs", heard(1000), heard(1001)),
        ("has too many links to moving points", linked(39), linked(40)),
        ("too many moving points", points(4000), points(4001)),
    ] {
        let is = |text: &str| found(text).lines().any(|l| l.starts_with("E027") && l.contains(words));
        let head = |text: &str| text.chars().take(300).collect::<String>();
        assert!(!is(&quiet), "{words} is reported\n{}\n{}", head(&quiet), found(&quiet));
        assert!(is(&reported), "{words} is not reported\n{}\n{}", head(&reported), found(&reported));
    }
}

#[test]
fn a_factor_holds_as_many_entries_as_are_allowed() {
    let pairs = || (0..20_u32).flat_map(|i| (0..i).map(move |j| (i, j)));
    assert!(ca_core::internal::numeric::ldl::Pattern::new(20, pairs(), 190).is_some());
    assert!(ca_core::internal::numeric::ldl::Pattern::new(20, pairs(), 189).is_none());
}

/// Modes are computed up to 4000 places. Computing 4000 takes minutes and is left to the long form.
#[test]
fn modes_are_computed_up_to_4000_places() {
    let found = |n: usize| {
        found(&format!("[model]\nmethod = \"modal\"\n{}", generator("CHAIN", &format!("n = {n}, m = 1, k = 1"))))
    };
    let refused = |all: &str| all.lines().any(|l| l.starts_with("E027") && l.contains("up to 4000 degrees of freedom"));
    assert!(refused(&found(4001)));
    if ca_tests::long_form::long_form("the modes of 4000 places") {
        assert!(!refused(&found(4000)));
    }
}
