//! `Model::set`, behind `--set`.

use ca_compile::{Options, load::finish};
use ca_model::{Model, Value, read};
use ca_tests::catalog;

const TEXT: &str = r#"
[param]
z = { value = 1.0, unit = "N s/m", live = true }
q = 3
empty = { live = true }
[ball]
[ball.CEL]
bar = { m = "1 g", f = "440 Hz" }
[SOX]
out = { from = "ball.bar", gain = "q" }
"#;

fn model() -> Model {
    read::read(TEXT, "m.ca.toml", &catalog()).0
}

fn arg<'m>(m: &'m Model, item: &str, key: &str) -> Option<&'m Value> {
    let item = m.items.iter().find(|i| i.name == item)?;
    item.args.iter().find(|e| e.key == key).map(|e| &e.value)
}

fn param<'m>(m: &'m Model, key: &str) -> &'m Value {
    let e = m.params.iter().find(|e| e.key == key).expect("declared");
    match &e.value {
        Value::Table(t) => t.iter().find(|x| x.key == "value").map_or(&e.value, |x| &x.value),
        v => v,
    }
}

#[test]
fn a_parameter_of_a_module_is_replaced_or_added() {
    let mut m = model();
    assert!(m.set("ball.bar.m", "2 g") && m.set("ball.bar.t60", " 3 ") && m.set("out.gain", "-0.5e1"));
    assert_eq!(arg(&m, "ball.bar", "m"), Some(&Value::Text("2 g".into())));
    assert_eq!(arg(&m, "ball.bar", "t60"), Some(&Value::Num(3.0)));
    assert_eq!(arg(&m, "out", "gain"), Some(&Value::Num(-5.0)));
    assert_eq!(m.items.len(), 2);
}

#[test]
fn a_named_parameter_keeps_what_else_it_has() {
    let mut m = model();
    assert!(m.set("z", "2 N s/m") && m.set("q", "true") && m.set("empty", "4"));
    assert_eq!(param(&m, "z"), &Value::Text("2 N s/m".into()));
    assert_eq!(param(&m, "q"), &Value::Bool(true));
    assert_eq!(param(&m, "empty"), &Value::Num(4.0));
    let z = m.params.iter().find(|e| e.key == "z").expect("declared");
    assert!(matches!(&z.value, Value::Table(t) if t.len() == 3));
}

#[test]
fn sections_and_names_that_are_not_there() {
    let mut m = model();
    assert!(m.set("rate.sound", "44.1 kHz") && m.set("rate.sound", "96000") && m.set("model.title", "Bell"));
    assert_eq!(m.rate.len(), 1);
    assert_eq!(m.title(), "Bell");
    for name in ["", ".", "bar.m", "nobody.m", "nobody", "ball.m", "ball.bar"] {
        assert!(!m.set(name, "1"), "{name}");
    }
}

#[test]
fn what_is_set_is_checked_like_what_is_written() {
    let compiled = |name: &str, text: &str| {
        let (mut m, found) = read::read(TEXT.replace("empty = { live = true }", "").as_str(), "m", &catalog());
        assert!(m.set(name, text));
        finish(&m, found, &catalog(), &Options::default()).map_err(|d| d.list[0].code)
    };
    assert_eq!(compiled("ball.bar.m", "2 g").map(|s| s.counts.n_mat), Ok(1));
    assert_eq!(compiled("ball.bar.m", "2 Hz").err(), Some("E008"));
    assert_eq!(compiled("ball.bar.mm", "2").err(), Some("E004"));
    assert_eq!(compiled("ball.bar.m", "-1").err(), Some("E009"));
    assert_eq!(compiled("rate.sound", "1").err(), Some("E023"));
    assert_eq!(compiled("q", "inf").err(), Some("E009"));
}

#[test]
fn a_preset_gives_live_parameters_their_values() {
    let text = r#"
[param]
k = { value = "8 kN/m", min = "1 kN/m", max = "90 kN/m", live = true }
z = { value = 4, unit = "mN s/m", live = true }
[preset.felt]
k = "2 kN/m"
z = 9
[preset.wood]
k = 60000
[CEL]
bar = { m = "2 g", k = "k", z = "z" }
[SOX]
out = { from = "bar" }
"#;
    let read = || read::read(text, "m.ca.toml", &catalog());
    let compiled = |m: Model| finish(&m, read().1, &catalog(), &Options::default()).expect("compiles").scene;
    // a bare number is in the unit of the parameter, or else in SI
    let scene = compiled(read().0);
    let felt = [("k".to_string(), 2000.0), ("z".to_string(), 9e-3)];
    assert_eq!(scene.about.presets, [("felt".into(), felt.to_vec()), ("wood".into(), vec![("k".into(), 6e4)])]);
    for (preset, k, z) in [("felt", 2000.0, 9e-3), ("wood", 6e4, 4e-3)] {
        let mut m = read().0;
        assert!(m.set("preset", preset));
        let scene = compiled(m);
        let live: Vec<f64> = scene.live.params.iter().map(|p| p.value).collect();
        assert_eq!(live, [k, z], "{preset}");
    }
    assert!(!read().0.set("preset", "glass"));
}
