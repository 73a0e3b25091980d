//! Random operations with undo and redo. 500, or 20 000 with `CA_LONG=1`.

mod common;

use ca_edit::{History, Operation};
use common::{check_edits, comments, errors, model, names, syntax_errors};
use cordis_anima::catalog;
use serde_json::json;
use std::collections::BTreeSet;

struct Random(u64);

impl Random {
    fn below(&mut self, n: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 16) as usize % n.max(1)
    }

    fn of<'t, T: ?Sized>(&mut self, all: &[&'t T]) -> &'t T {
        all[self.below(all.len())]
    }
}

/// Makes an operation on a text; some do not fit it.
fn operation(text: &str, r: &mut Random) -> Operation {
    let all = names(text);
    let all: Vec<&str> = all.iter().map(String::as_str).collect();
    let odd =
        ["", "é", "a b", "\"", "x\ny", "low[999999999999]", "part.", "a.b.c.d", "model", "🎻", "[", "tine[*].key"];
    let name = |r: &mut Random| if r.below(12) == 0 || all.is_empty() { r.of(&odd) } else { r.of(&all) }.to_owned();
    let values =
        ["2 N/m", "1e999", "0.5", "A4", "true", "[1, 2]", "{ a = 1 }", "[", "\"x\"", "-3 mm", "1e308", "2 felt"];
    let keys = ["m", "k", "z", "f", "x", "between", "from", "min", "live", "midi.to", "n", "nothing"];
    let kinds = ["MAS", "SOL", "CEL", "STRING", "MESH", "TGR", "ENX", "RES", "BUT", "SOX", "XYZ", "TETRA"];
    let (a, b) = (name(r), name(r));
    let fresh = format!("n{}", r.below(1000));
    let word = if r.below(5) == 0 { r.of(&odd).to_owned() } else { fresh };
    let json = match r.below(13) {
        0 => json!({"type": "add", "kind": r.of(&kinds)}),
        1 => json!({"type": "add", "kind": r.of(&kinds), "name": word, "into": a}),
        2 => {
            json!({"type": "instance", "part": r.of(&["plectrum", "bow", "tine", "wire"]), "with": {"on": "low[3]", "note": "D3"}})
        }
        3 => json!({"type": "join", "kind": r.of(&["RES", "BUT", "FRO", "MAS"]), "from": a, "to": b, "name": word}),
        4 => json!({"type": "set", "name": format!("{a}.{}", r.of(&keys)), "value": r.of(&values)}),
        5 => {
            json!({"type": "set", "name": r.of(&["param.p", "model.title", "gesture.key", "preset.x.p", "rate.sound"]), "value": r.of(&values)})
        }
        6 => json!({"type": "clear", "name": format!("{a}.{}", r.of(&keys))}),
        7 => json!({"type": "rename", "name": a, "to": word}),
        8 => json!({"type": "delete", "names": [a], "dependents": r.below(2) == 0}),
        9 => json!({"type": "duplicate", "names": [a, b]}),
        10 => json!({"type": "group", "names": [a, b], "part": word}),
        11 => json!({"type": "move", "name": a, "x": [1e-3 * r.below(9) as f64]}),
        _ => json!({"type": "midi", "name": a, "source": {"controller": r.below(200)}, "to": "1 mm"}),
    };
    serde_json::from_value(json.clone()).unwrap_or_else(|e| panic!("{json}: {e}"))
}

#[test]
fn random_operations_keep_texts_and_comments() {
    let n = if std::env::var_os("CA_LONG").is_some() { 20_000 } else { 500 };
    let mut r = Random(0x9e37_79b9_7f4a_7c15);
    let starts = ["hammered_string", "kalimba", "snare", "rattle", "plucked_string", "physical_lfo"].map(model);
    let (mut done, mut refused) = (0, 0);
    let mut types = BTreeSet::new();
    for round in 0..n / 50 {
        let start = &starts[round % starts.len()];
        let mut history = History::new(start, 1 << 22);
        let mut versions = vec![start.clone()];
        let mut at = 0;
        for _ in 0..50 {
            match r.below(5) {
                0 if at > 0 => {
                    assert!(history.undo().is_some());
                    at -= 1;
                    assert_eq!(history.text(), versions[at]);
                    continue;
                }
                1 if at + 1 < versions.len() => {
                    assert!(history.redo().is_some());
                    at += 1;
                    assert_eq!(history.text(), versions[at]);
                    continue;
                }
                _ => {}
            }
            let text = history.text().to_owned();
            let operation = operation(&text, &mut r);
            let Ok(e) = operation.apply(&text, &catalog()) else {
                refused += 1;
                continue;
            };
            check_edits(&text, &e);
            assert_eq!(syntax_errors(&e.text), 0, "{operation:?} on\n{text}\n→\n{}", e.text);
            let mut left: Vec<String> = comments(&e.text).into_iter().map(|c| c.1).collect();
            for (place, comment) in comments(&text) {
                let i = left.iter().position(|c| *c == comment);
                i.map(|i| left.swap_remove(i));
                let removed = e.edits.iter().any(|t| t.range.contains(&place));
                let removes = matches!(operation, Operation::Delete { .. } | Operation::Clear { .. });
                assert!(i.is_some() || removes && removed, "{operation:?} lost {comment} of\n{text}\n→\n{}", e.text);
            }
            let keeps = matches!(operation, Operation::Rename { .. } | Operation::Duplicate { .. });
            if keeps && round % 2 == 0 && errors(&text).is_empty() {
                let now = errors(&e.text);
                // a copy of one of two outputs, or of a key, may be too much
                let fits = now.is_empty() || matches!(operation, Operation::Duplicate { .. });
                assert!(fits && !now.contains(&"E013"), "{operation:?} on\n{text}\n→\n{}: {now:?}", e.text);
            }
            if e.text != text {
                done += 1;
                types.insert(serde_json::to_value(&operation).unwrap()["type"].to_string());
                history.push(&operation.title(), &e.text);
                assert_eq!(history.next_undo(), Some(operation.title().as_str()));
                versions.truncate(at + 1);
                versions.push(e.text);
                at += 1;
            }
        }
        for _ in 0..at {
            history.undo();
        }
        assert_eq!((history.text(), history.next_undo()), (start.as_str(), None));
    }
    assert_eq!(types.len(), 11, "{types:?}");
    assert!(done > n / 5 && refused > n / 20, "{done} done, {refused} refused");
}
