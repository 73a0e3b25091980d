//! Limits of parts: surrounding settings of their file, too many modules, and terminal control characters.

use crate::language::parts::{errors, found};
use crate::play::scene;
use ca_model::{read, render};
use ca_tests::catalog;
use std::fmt::Write as _;

#[test]
fn what_is_too_large_is_refused_before_it_is_made() {
    let part = "[part.p0.CEL]\nc = { m = '1 g', f = 300 }\n";
    let mut deep = part.to_owned();
    for i in 1..10 {
        let _ = writeln!(deep, "[part.p{i}.use]\nx = {{ part = 'p{}', n = 10 }}", i - 1);
    }
    for (text, says) in [
        (format!("{part}[use]\ni = {{ part = 'p0', n = 1000000 }}\n"), "1000000 instances with 1000000 modules"),
        (format!("{part}[use]\ni = {{ part = 'p0', n = 1000000000 }}\n"), "`n` of `i` is above 1000000"),
        (format!("{deep}[use]\ni = {{ part = 'p9' }}\n"), "1111111111 instances with 1000000000 modules"),
    ] {
        let (model, diags) = found(&text, &[]);
        let all = render::text(&diags, &model, false);
        assert!(all.contains("E027") && all.contains(says), "{all}");
        assert!(model.items.is_empty() && model.groups.is_empty(), "{}", model.items.len());
    }
    let below = "[part.p.CEL]\nc = { m = '1 g', f = 300 }\n[use]\ni = { part = 'p', n = 999 }\n[SOX]\no = { from = 'i[*].c', channel = 0 }\n";
    assert_eq!(found(below, &[]).0.groups.len(), 999);
}

#[test]
fn what_stands_beside_a_part_does_not_come_with_it_in_silence() {
    let part = "[part.p.SOL]\ng = {}\n[part.p.MAS]\nb = { m = '1 g', dx0 = '1 mm' }\n[part.p.RES]\ns = { between = ['g', 'b'], k = 'hz' }\n[part.p.param]\nhz = 5\n";
    let of = "[use]\ni = { file = 'p.ca.toml', part = 'p' }\n[SOX]\no = { from = 'i.b' }\n";
    let file = |head: &str| format!("{head}{part}");
    let all = errors(of, &[("p.ca.toml", &file("[model]\nunits = 'alg'\n"))]);
    assert!(all.contains("E028") && all.contains("p.ca.toml:2:9"), "{all}");
    let both = format!("[model]\nunits = 'alg'\n{of}");
    assert!(!found(&both, &[("p.ca.toml", &file("[model]\nunits = 'alg'\n"))]).1.has_errors());
    assert!(found(&both, &[("p.ca.toml", &file("[model]\nunits = 'si'\n"))]).1.has_errors());
    // a parameter of its file is not one of the part, whatever parameters the model has
    let lent = part.replace("[part.p.param]\nhz = 5\n", "[param]\nhz = 5\n");
    for text in [of.to_owned(), format!("[param]\nhz = 7\n{of}")] {
        let all = errors(&text, &[("p.ca.toml", &lent)]);
        assert!(all.contains("E013") && all.contains("a part cannot use `hz`, a parameter of `p.ca.toml`"), "{all}");
        assert_eq!(all.matches("error[").count(), 1, "{all}");
    }
    let with = lent.replace(
        "[param]\nhz = 5\n",
        "[part.p.param]\nhz = {}\n[part.q.use]\nx = { part = 'p', with = { hz = 'far' } }\n[param]\nfar = 5\n",
    );
    let all = errors(
        "[use]\ni = { file = 'p.ca.toml', part = 'q' }\n[SOX]\no = { from = 'i.x.b' }\n",
        &[("p.ca.toml", &with)],
    );
    assert!(all.contains("a part cannot use `far`"), "{all}");
    // used as a whole, a file lends its parameters to the part, but not its settings
    let whole = "[model]\ngravity = 3\nmethod = 'modal'\n[rate]\nsound = '96 kHz'\n[param]\nhz = '300 Hz'\n[CEL]\nb = { m = '1 g', f = 'hz' }\n";
    let used = "[use]\ni = 'w.ca.toml'\n[SOX]\no = { from = 'i.b' }\n";
    let (model, diags) = found(used, &[("w.ca.toml", whole)]);
    let all = render::text(&diags, &model, false);
    assert!(all.contains("note[N202]") && all.contains("without its `gravity`, `method`, `sound`"), "{all}");
    let same = format!("[model]\ngravity = 3\nmethod = 'modal'\n[rate]\nsound = '96 kHz'\n{used}");
    assert!(!found(&same, &[("w.ca.toml", whole)]).1.list.iter().any(|d| d.code == "N202"));
}

#[test]
fn a_number_in_quotes_has_its_unit_in_a_part_too() {
    let text = "[part.p.param]\nf = { unit = 'Hz' }\n[part.p.CEL]\nc = { m = '1 g', f = 'f' }\n[use]\ni = { part = 'p', with = { f = '300' } }\n[SOX]\no = { from = 'i.c' }\n";
    let all = errors(text, &[]);
    assert!(all.contains("E008") && all.contains("has no unit: `300`"), "{all}");
    for right in ["300", "'300 Hz'", "'D4'"] {
        assert!(!found(&text.replace("'300'", right), &[]).1.has_errors(), "{right}");
    }
}

#[test]
fn findings_move_no_cursor() {
    let (mut model, diags) = read::read("[MAS]\nbob = 3\n", "a\u{1b}[2J.ca.toml", &catalog());
    model.file = "a\u{1b}[2J.ca.toml".into();
    let all = render::text(&diags, &model, false);
    assert!(all.contains("E003") && !all.contains('\u{1b}'), "{all:?}");
    let titled = scene("[model]\ntitle = \"a\\u001b[2J\"\n[CEL]\nb = { m = 1, f = 9 }\n[SOX]\no = { from = 'b' }\n");
    assert_eq!(titled.scene.about.title, "a\u{fffd}[2J");
}
