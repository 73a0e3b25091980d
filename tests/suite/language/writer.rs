//! The writer: a written model reads back as the same model.

use ca_model::{Entry, Group, Item, Model, Span, Value, read, render, write};
use ca_tests::catalog;
use proptest::prelude::*;

/// A model without spans, text and file, with modules sorted by group and kind, and groups by name.
fn bare(m: &Model) -> Model {
    fn entry(e: &Entry) -> Entry {
        let value = match &e.value {
            Value::List(l) => Value::List(l.iter().map(entry).collect()),
            Value::Table(t) => Value::Table(t.iter().map(entry).collect()),
            other => other.clone(),
        };
        Entry { key: e.key.clone(), key_span: Span::NONE, value, span: Span::NONE }
    }
    let entries = |l: &[Entry]| l.iter().map(entry).collect::<Vec<_>>();
    let item = |i: &Item| Item {
        kind_span: Span::NONE,
        name_span: Span::NONE,
        span: Span::NONE,
        group: None,
        args: entries(&i.args),
        ..i.clone()
    };
    let mut items: Vec<Item> = m.items.iter().map(item).collect();
    let section = |i: &Item| (i.name.split_once('.').map(|n| n.0.to_string()), i.kind.clone());
    items.sort_by_key(section);
    let mut groups: Vec<Group> =
        m.groups.iter().map(|g| Group { span: Span::NONE, props: entries(&g.props), ..g.clone() }).collect();
    groups.sort_by(|a, b| a.name.cmp(&b.name));
    Model {
        header: m.header.trim_end().into(),
        meta: entries(&m.meta),
        rate: entries(&m.rate),
        params: entries(&m.params),
        gestures: entries(&m.gestures),
        presets: entries(&m.presets),
        equivalence: entries(&m.equivalence),
        groups,
        items,
        ..Model::default()
    }
}

fn back(m: &Model) -> (String, Model) {
    let text = write::write(m);
    let (again, diags) = read::read(&text, "", &catalog());
    assert!(diags.list.is_empty(), "{text}\n{}", render::text(&diags, &again, false));
    (text, again)
}

#[test]
fn written_as_a_person_would() {
    let mut m = Model { header: "A bell.\n\nPlay it softly.".into(), ..Model::default() };
    m.meta.push(Entry::new("title", "Bell"));
    m.rate.push(Entry::new("sound", "48 kHz"));
    let z = vec![Entry::new("value", 1.0), Entry::new("unit", "N s/m"), Entry::new("live", true)];
    m.params.push(Entry::new("z", Value::Table(z)));
    m.add("MAS", "hammer", [Entry::new("m", "20 g"), Entry::new("dx0", "-5 mm")]);
    m.add("SOL", "frame", []);
    m.add("MAS", "b", [Entry::new("m", 0.5)]);
    m.groups.push(Group { name: "ball".into(), span: Span::NONE, props: vec![Entry::new("gravity", "9.81 m/s^2")] });
    m.add("CEL", "ball.a", [Entry::new("m", 1e-7), Entry::new("k", 40.0)]);
    m.gestures.push(Entry::new("ball.hand", vec![Value::from(vec![0.0, 0.0]), Value::from(vec![0.5, 1.0])]));
    let text = write::write(&m);
    let expected = r#"# A bell.
#
# Play it softly.

[model]
title = "Bell"

[rate]
sound = "48 kHz"

[param]
z = { value = 1, unit = "N s/m", live = true }

[MAS]
hammer = { m = "20 g", dx0 = "-5 mm" }
b      = { m = 0.5 }

[SOL]
frame = {}

[ball]
gravity = "9.81 m/s^2"

[ball.CEL]
a = { m = 1e-7, k = 40 }

[gesture]
"ball.hand" = [[0, 0], [0.5, 1]]
"#;
    assert_eq!(text, expected);
    let again = back(&m).1;
    assert_eq!(bare(&again), bare(&m));
    assert_eq!(again.items.last().unwrap().group, Some(0));
}

#[test]
fn long_modules_and_lists_are_broken_over_lines() {
    let mut m = Model::default();
    let doc = "x".repeat(150);
    m.add("MAS", "a", [Entry::new("m", doc.as_str()), Entry::new("x", "1 mm")]);
    m.gestures.push(Entry::new("h", (0..60).map(f64::from).collect::<Vec<_>>()));
    let (text, again) = back(&m);
    assert_eq!(bare(&again), bare(&m));
    assert!(text.contains("a.x = \"1 mm\"\n"), "{text}");
    assert!(text.lines().filter(|l| !l.contains("xxx")).all(|l| l.chars().count() <= 120), "{text}");
}

fn number() -> impl Strategy<Value = f64> {
    prop_oneof![
        any::<f64>().prop_filter("nan differs from itself", |v| !v.is_nan()),
        -9.0..9.0f64,
        Just(-0.0),
        Just(1e15)
    ]
}

fn value() -> impl Strategy<Value = Value> {
    let leaf = prop_oneof![
        number().prop_map(Value::Num),
        any::<String>().prop_map(Value::Text),
        any::<bool>().prop_map(Value::Bool),
        "-?[0-9]{1,3} (g|mm|kN/m)".prop_map(Value::Text),
    ];
    leaf.prop_recursive(3, 24, 5, |inner| {
        let member = |v: Value| Entry::new("", v);
        prop_oneof![
            prop::collection::vec(inner.clone().prop_map(member), 0..5).prop_map(Value::List),
            prop::collection::btree_map(any::<String>(), inner, 0..4)
                .prop_map(|m| Value::Table(m.into_iter().map(|(k, v)| Entry::new(&k, v)).collect())),
        ]
    })
}

fn entries(keys: &'static [&'static str]) -> impl Strategy<Value = Vec<Entry>> {
    let shuffled = Just(keys.to_vec()).prop_shuffle();
    (shuffled, prop::collection::vec(value(), 0..=keys.len()))
        .prop_map(|(k, v)| k.into_iter().zip(v).map(|(k, v)| Entry::new(k, v)).collect())
}

fn free() -> impl Strategy<Value = Vec<Entry>> {
    prop::collection::btree_map("[a-z_][a-zA-Z0-9_]{0,20}", value(), 0..4)
        .prop_map(|m| m.into_iter().map(|(k, v)| Entry::new(&k, v)).collect())
}

/// Gestures are lists, because a table would be a path.
fn gestures() -> impl Strategy<Value = Vec<Entry>> {
    let list = prop::collection::vec(value().prop_map(|v| Entry::new("", v)), 0..4).prop_map(Value::List);
    prop::collection::btree_map("[a-z]{1,3}(\\.[a-z]{1,3})?", list, 0..4)
        .prop_map(|m| m.into_iter().map(|(k, v)| Entry::new(&k, v)).collect())
}

/// Each preset is a table of numbers.
fn presets() -> impl Strategy<Value = Vec<Entry>> {
    let values = prop::collection::btree_map("[a-z]{1,3}(\\.[a-z]{1,3})?", -1e9..1e9, 0..4)
        .prop_map(|m| Value::Table(m.into_iter().map(|(k, v)| Entry::new(&k, v)).collect()));
    prop::collection::btree_map("[a-z]{1,3}", values, 0..4)
        .prop_map(|m| m.into_iter().map(|(k, v)| Entry::new(&k, v)).collect())
}

fn model() -> impl Strategy<Value = Model> {
    let items = prop::collection::vec((0..3usize, 0..3usize, entries(&["x", "dx0"])), 0..12);
    let sections = (entries(read::META), entries(read::RATES), free(), gestures(), presets(), free());
    let groups = (entries(read::GROUP), entries(read::GROUP));
    ("[ -~é\\n]{0,40}", sections, groups, items).prop_map(|(header, sections, groups, items)| {
        let (meta, rate, params, gestures, presets, equivalence) = sections;
        let lines: Vec<&str> = header.lines().map(str::trim_end).collect();
        let mut m = Model {
            header: lines.join("\n").trim().into(),
            meta,
            rate,
            params,
            gestures,
            presets,
            equivalence,
            ..Model::default()
        };
        for (name, props) in [("ball", groups.0), ("sphere", groups.1)] {
            m.groups.push(Group { name: name.into(), span: Span::NONE, props });
        }
        for (n, (kind, group, args)) in items.into_iter().enumerate() {
            let kind = ["MAS", "SOL", "CEL"][kind];
            let name = format!("{}a{n}", ["", "ball.", "sphere."][group]);
            m.add(kind, &name, args);
            m.items[n].group = group.checked_sub(1);
        }
        m
    })
}

proptest! {
    #[test]
    fn reads_back_to_the_same_model(m in model()) {
        let (text, again) = back(&m);
        prop_assert_eq!(bare(&again), bare(&m), "{}", text);
        for item in &again.items {
            let group = item.group.map(|g| again.groups[g].name.as_str());
            prop_assert_eq!(group, item.name.split_once('.').map(|n| n.0));
        }
        prop_assert_eq!(write::write(&again), text);
    }

    #[test]
    fn any_model_is_written(name in any::<String>(), kind in any::<String>(), group in any::<Option<usize>>(), v in value(), header in any::<String>()) {
        let mut m = Model { header, ..Model::default() };
        m.add(&kind, &name, [Entry::new(&name, v)]);
        m.items[0].group = group;
        write::write(&m);
    }
}
