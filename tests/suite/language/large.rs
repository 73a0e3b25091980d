//! Texts long enough to be read in parts, and more findings than are kept.

use ca_model::diag::{Diag, Diags, KEPT, Severity};
use ca_model::read::read;
use ca_model::{Item, Model, Span, render};
use ca_tests::catalog;
use std::fmt::Write as _;

/// 60 000 masses and as many links, 6 MB; the reader splits it several times.
fn long() -> String {
    let mut text = String::from("# long\n[model]\ntitle = \"[MAS]\"\n\n  [ MAS ] # masses\n");
    for i in 0..60_000 {
        _ = writeln!(text, "m{i} = {{ m = \"1 g\",   # {i}\n  dx0 = \"1 mm\" }}");
    }
    text += "[bells]\ngravity = 1\n[bells.MAS]\nb = { m = 1 }\n[REF]\n";
    for i in 1..60_000 {
        _ = writeln!(text, "r{i} = {{ between = [\"m{}\", \"m{i}\"], k = 1e4, z = 5e-3 }}", i - 1);
    }
    text + "[SOX]\nout = { from = \"m0\" }\n"
}

fn part(text: &str, span: Span) -> &str {
    &text[span.start..span.end]
}

#[test]
fn a_text_in_parts_says_what_the_whole_says() {
    let text = long();
    let (model, diags) = read(&text, "long.ca.toml", &catalog());
    // its tables span lines, which is TOML 1.1
    assert_eq!(diags.list.iter().map(|d| d.code).collect::<Vec<_>>(), ["N205"], "{diags}");
    assert_eq!((model.items.len(), model.groups.len(), model.title()), (120_001, 1, "[MAS]"));
    // names are in text order, and every span is right
    for (i, item) in model.items.iter().enumerate() {
        let name = item.name.rsplit('.').next().unwrap();
        assert_eq!(part(&text, item.name_span), name);
        assert_eq!(part(&text, item.kind_span), item.kind);
        assert!(part(&text, item.span).starts_with('{') && part(&text, item.span).ends_with('}'), "{name}");
        for e in &item.args {
            assert_eq!(part(&text, e.key_span), e.key);
        }
        let expected = match i {
            0..60_000 => format!("m{i}"),
            60_000 => "b".into(),
            120_000 => "out".into(),
            _ => format!("r{}", i - 60_000),
        };
        assert_eq!(name, expected);
    }
    let last: &Item = &model.items[59_999];
    assert_eq!(part(&text, last.args[1].span), "\"1 mm\"");
}

#[test]
fn mistakes_in_later_parts_stand_where_they_are() {
    let text = long()
        .replace("m59990 = { m = \"1 g\",", "m59990 = { m = \"1 g\", mm = 1,")
        .replace("r59000 = {", "r10 = {")
        .replace("r59001 = {", "r59001 = ")
        .replace("[SOX]", "[MAS]\nm = { m = 1 }\n[SOX]");
    let (_, diags) = read(&text, "long.ca.toml", &catalog());
    let codes: Vec<_> = diags.list.iter().map(|d| (d.code, part(&text, d.span()))).collect();
    assert!(codes.contains(&("E004", "mm")), "{codes:?}");
    assert!(codes.contains(&("E012", "r10")), "{codes:?}");
    assert!(codes.iter().any(|c| c.0 == "E001"), "{codes:?}");
    assert!(diags.list.iter().any(|d| d.title == "the section `[MAS]` is written twice"), "{diags}");
}

/// The report of a finding in a long text shows the lines around it, with their numbers.
#[test]
fn a_finding_in_a_long_text_looks_as_in_a_short_one() {
    let report = |lines: usize| {
        let text =
            format!("{}[MAS]\nb = {{ m = 1,\n mm = 2 }}\nc = {{ m = 1 }}\nb = {{ m = 2 }}\n", "#\n".repeat(lines));
        let (model, diags) = read(&text, "m.ca.toml", &catalog());
        assert_eq!(diags.list.len(), 3);
        render::text(&diags, &model, false)
    };
    // both numbers have five digits, so the rest of the report is equal
    let (short, long) = (report(20_000), report(40_000));
    assert_eq!(short.replace("2000", "4000"), long);
    assert!(long.contains("m.ca.toml:40003:2") && long.contains("40003 |  mm = 2 }"), "{long}");
}

#[test]
fn of_errors_a_hundred_are_kept_and_the_limit_is_named() {
    assert_eq!(KEPT, 100);
    let model = Model::default();
    let mut diags = Diags::new();
    (0..100).for_each(|i| diags.push(Diag::error("E013", format!("error {i}"))));
    assert!(!diags.is_full() && render::summary(&diags) == "100 errors");
    diags.push(Diag::error("E013", "one more"));
    assert!(diags.is_full());
    (0..1000).for_each(|_| diags.push(Diag::error("E013", "and more")));
    assert_eq!(diags.list.len(), 101);
    let limit = "more than 100 errors: the search stopped there";
    assert_eq!(diags.list[100].title, limit);
    assert!(render::text(&diags, &model, false).ends_with(&format!("{limit}\n")));
    assert_eq!(render::json(&diags, &model).as_array().unwrap().len(), 101);
}

#[test]
fn of_warnings_a_hundred_are_kept_and_all_are_counted() {
    let mut diags = Diags::new();
    (0..250).for_each(|i| diags.push(Diag::warning("W106", format!("warning {i}"))));
    diags.push(Diag::error("E013", "an error"));
    let mut other = Diags::new();
    (0..250).for_each(|i| other.push(Diag::note("N201", format!("note {i}"))));
    diags.extend(other);
    assert_eq!(diags.list.len(), 201);
    assert_eq!((diags.count(Severity::Warning), diags.count(Severity::Note)), (250, 250));
    let text = render::text(&diags, &Model::default(), false);
    assert!(text.ends_with("… and 481 more\n1 error, 250 warnings, 250 notes\n"), "{text}");
}
