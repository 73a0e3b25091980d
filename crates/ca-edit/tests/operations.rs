//! Each operation on bundled models: what it writes, and what the model then is.

mod common;

use ca_edit::Edited;
use common::{apply, comments, edited, errors, model, models, names, sound};

fn refused(text: &str, json: &str) -> String {
    apply(text, json).map_or_else(|e| e.to_string(), |e| panic!("{json} was done:\n{}", e.text))
}

#[test]
fn a_struck_string_is_built_from_nothing() {
    let steps = [
        r#"{"type": "set", "name": "model.title", "value": "Mine"}"#,
        r#"{"type": "add", "kind": "STRING", "name": "low", "values": {"n": "40", "f": "A2", "t60": "4 s", "m": "1 g"}}"#,
        r#"{"type": "add", "kind": "MAS", "name": "hammer", "values": {"m": "20 g", "x": "-5 mm", "v": "1 m/s"}}"#,
        r#"{"type": "join", "kind": "BUT", "from": "hammer", "to": "low[8]", "name": "strike", "values": {"k": "8 kN/m"}}"#,
        r#"{"type": "add", "kind": "SOX", "values": {"from": "\"low[3]\"", "gain": "800"}}"#,
        r#"{"type": "set", "name": "param.felt", "value": "8 kN/m"}"#,
        r#"{"type": "set", "name": "felt.live", "value": "true"}"#,
        r#"{"type": "set", "name": "strike.k", "value": "felt"}"#,
        r#"{"type": "set", "name": "preset.hard.felt", "value": "40 kN/m"}"#,
        r#"{"type": "instance", "part": "plectrum", "name": "pick", "with": {"on": "low[6]", "note": "A2"}}"#,
        r#"{"type": "set", "name": "gesture.pick.key", "value": "[[0, \"-4 mm\"], [0.01, \"4 mm\"]]"}"#,
    ];
    let text = steps.iter().fold(String::new(), |text, json| edited(&text, json));
    let want = r#"[model]
title = "Mine"

[param]
felt = { value = "8 kN/m", live = true }

[STRING]
low = { n = 40, m = "1 g", f = "A2", t60 = "4 s" }

[MAS]
hammer = { m = "20 g", x = "-5 mm", v = "1 m/s" }

[use]
pick = { part = "plectrum", with = { on = "low[6]", note = "A2" } }

[BUT]
strike = { between = ["hammer", "low[8]"], k = "felt" }

[SOX]
sox = { from = "low[3]", gain = 800 }

[gesture]
pick.key = [[0, "-4 mm"], [0.01, "4 mm"]]
"#;
    let parts = |t: &str| {
        let mut all: Vec<String> = t.split("\n\n").map(|p| p.trim().to_owned()).collect();
        all.sort();
        all
    };
    let without_preset = text.replace("[preset.hard]\nfelt = \"40 kN/m\"\n\n", "");
    assert_eq!(parts(&without_preset), parts(want), "{text}");
    assert!(without_preset.len() < text.len());
    assert_eq!(errors(&text), [""; 0]);
    assert!(sound(&text, 0.05).iter().any(|s| *s != 0));
}

/// Each kind that needs no other module is added with the values of its example, and compiles.
#[test]
fn every_kind_has_values_to_begin_with() {
    let mut added = 0;
    for kind in cordis_anima::catalog().iter() {
        let base = "[CEL]\nbar = { m = \"1 g\", f = \"220 Hz\", t60 = \"1 s\" }\n[SOX]\nout = { from = \"bar\" }\n";
        match apply(base, &format!(r#"{{"type": "add", "kind": "{}", "name": "new"}}"#, kind.code)) {
            Ok(e) => {
                added += 1;
                let known = ["E029", "E024"];
                assert!(errors(&e.text).iter().all(|c| known.contains(c)), "{}: {:?}", e.text, errors(&e.text));
            }
            Err(e) => assert!(e.what.contains("needs `"), "{e}"),
        }
    }
    assert!(added > 8, "{added}");
}

#[test]
fn links_join_what_is_there() {
    let text = model("hammered_string");
    let join = |kind: &str, from: &str, to: &str| {
        format!(r#"{{"type": "join", "kind": "{kind}", "from": "{from}", "to": "{to}", "values": {{"k": "2 N/m"}}}}"#)
    };
    let new = edited(&text, &join("RES", "arm", "low[4]"));
    let line = "\nres = { between = [\"arm\", \"low[4]\"], k = \"2 N/m\" }\n";
    assert!(new.contains(line) && errors(&new).is_empty(), "{new}");
    assert!(new.contains(&format!("l0 = 0 }}{line}")), "behind the other springs");
    assert!(refused(&text, &join("RES", "arm", "low")).contains("`low[0]`"));
    assert!(refused(&text, &join("RES", "arm", "arm")).contains("itself"));
    assert!(refused(&text, &join("RES", "arm", "hamer")).contains("did you mean `hammer`?"));
    assert!(refused(&text, &join("RES", "arm", "shank")).contains("is a link"));
    assert!(refused(&text, &join("MAS", "arm", "hammer")).contains("does not join"));
    assert!(refused(&text, &join("RESS", "arm", "hammer")).contains("did you mean `RES`?"));
    assert!(refused(&text, &join("RES", "arm", "low[")).contains("not the name of a mass"));
    let in_part = r#"{"type": "join", "kind": "FRO", "from": "thumb", "to": "bar", "into": "part.tine", "values": {"z": "1 N s/m"}}"#;
    let new = edited(&model("kalimba"), in_part);
    assert!(
        new.contains("[part.tine.FRO]\ncalm = { between = [\"frame\", \"thumb\"], z = \"2 N s/m\" }\nfro = {"),
        "{new}"
    );
    assert_eq!(errors(&new), [""; 0]);
}

#[test]
fn values_are_written_as_typed() {
    let text = model("snare");
    let set = |name: &str, value: &str| {
        edited(&text, &serde_json::json!({"type": "set", "name": name, "value": value}).to_string())
    };
    assert_eq!(set("skin.f", "120 Hz"), text.replace("f = \"180 Hz\"", "f = \"120 Hz\""));
    assert_eq!(set("skin.z", "0.01"), text.replace("z = \"4 mN s/m\"", "z = 0.01"));
    assert_eq!(set("tight", "300 N/m"), text.replace("value = \"200 N/m\"", "value = \"300 N/m\""));
    assert_eq!(
        set("tight.min", "1 N/m"),
        text.replace("min = 0, max = \"1 kN/m\", doc", "min = \"1 N/m\", max = \"1 kN/m\", doc")
    );
    assert_eq!(set("preset.loose.tight", "50 N/m"), text.replace("60 N/m", "50 N/m"));
    assert_eq!(set("centre.m", "8 g"), text.replacen("m = \"3 g\"", "m = \"8 g\"", 1));
}

#[test]
fn values_of_lists_parts_and_gestures() {
    let text = model("kalimba");
    let set = |name: &str, value: &str| {
        edited(&text, &serde_json::json!({"type": "set", "name": name, "value": value}).to_string())
    };
    assert_eq!(set("tine.note[1]", "E4"), text.replacen("[\"C4\", \"D4\", \"E4\"", "[\"C4\", \"E4\", \"E4\"", 1));
    assert_eq!(set("part.tine.bar.t60", "3 s"), text.replacen("t60 = \"2.5 s\"", "t60 = \"3 s\"", 1));
    assert_eq!(set("part.tine.nail", "1 kN/m"), text.replacen("value = \"3 kN/m\"", "value = \"1 kN/m\"", 1));
    assert_eq!(set("use.tine.n", "3"), text.replace("\nn = 7\n", "\nn = 3\n"));
    let list = "with.side = [0, 1, 0, 1, 0, 1, 0]\n";
    assert_eq!(set("tine.nail", "2 kN/m"), text.replace(list, &format!("{list}with.nail = \"2 kN/m\"\n")));
    let gesture = set("gesture.tine[1].key", "[[0, 0]]");
    assert!(gesture.contains("\"tine[1].key\" = [[0, 0]]\n\"tine[2].key\""), "{gesture}");
    assert_eq!(set("depth.midi.to", "9 mm"), text.replacen("to = \"8 mm\", release", "to = \"9 mm\", release", 1));
    let clear = edited(&text, r#"{"type": "clear", "name": "depth.midi.release"}"#);
    assert_eq!(clear, text.replace(", release = \"200 ms\" }", " }"));
    assert!(refused(&text, r#"{"type": "clear", "name": "box.k"}"#).contains("not written"));
    for (name, help) in [
        ("box.mm", "choose one of `m`"),
        ("bax.m", "did you mean `box`?"),
        ("tine[0].note", "tine.PARAMETER[0]"),
        ("tine.note[7]", "not in a list"),
        ("tine.note[99999999999999999999]", "parameter"),
        ("box", "`box.m`"),
        ("model.titel", "did you mean `title`?"),
        ("", "name a module"),
        ("..", "name a module"),
        ("drawn.size", "choose one of"),
    ] {
        let why = refused(&text, &serde_json::json!({"type": "set", "name": name, "value": "1"}).to_string());
        assert!(why.contains(help), "{name}: {why}");
    }
}

/// All names of a model are changed; the model makes the same sound, bit for bit.
#[test]
fn a_renamed_model_sounds_the_same() {
    let mut renamed = 0;
    for (file, text) in models() {
        let mut new = text.clone();
        let all = names(&text);
        for i in 0..all.len() {
            // names change on the way, their order does not
            let name = &names(&new)[i];
            let json = serde_json::json!({"type": "rename", "name": name, "to": format!("q{i}_x")}).to_string();
            new = edited(&new, &json);
            renamed += 1;
        }
        assert_eq!(comments(&text).len(), comments(&new).len());
        assert_eq!(sound(&text, 0.13), sound(&new, 0.13), "{file}");
        assert!(names(&new).iter().all(|n| n.rsplit('.').next().unwrap().starts_with('q')), "{file}");
    }
    assert!(renamed > 400, "{renamed}");
}

#[test]
fn what_refers_to_a_deleted_module_is_listed_first() {
    let text = model("hammered_string");
    let refusal = apply(&text, r#"{"type": "delete", "names": ["key"]}"#).unwrap_err();
    assert_eq!(refusal.dependents, ["gesture.key", "shank"]);
    let new = edited(&text, r#"{"type": "delete", "names": ["key"], "dependents": true}"#);
    assert!(!new.contains("shank") && !new.contains("[TGR]") && !new.contains("[gesture]"), "{new}");
    assert_eq!(comments(&new).len(), comments(&text).len() - 1, "the comment behind `shank`");
    assert_eq!(errors(&new), [""; 0]);
    // a parameter gives its value to what names it
    let refusal = apply(&text, r#"{"type": "delete", "names": ["rest"]}"#).unwrap_err();
    assert_eq!(refusal.dependents, ["calm.z"]);
    let new = edited(&text, r#"{"type": "delete", "names": ["param.rest"], "dependents": true}"#);
    assert!(!new.contains("[param]") && new.contains("z = \"6 N s/m\" }           # the arm"), "{new}");
    assert_eq!(sound(&text, 0.2), sound(&new, 0.2));
}

#[test]
fn parts_groups_and_presets_are_deleted_with_what_needs_them() {
    let text = model("snare");
    let new = edited(&text, r#"{"type": "delete", "names": ["param.tight"], "dependents": true}"#);
    assert!(!new.contains("[preset") && new.contains("k = \"200 N/m\", l0 = 0"), "{new}");
    assert_eq!(errors(&new), [""; 0]);
    let refusal = apply(&text, r#"{"type": "delete", "names": ["part.wire"]}"#).unwrap_err();
    assert_eq!(refusal.dependents, ["wire", "wires_left", "wires_right"]);
    let new = edited(&text, r#"{"type": "delete", "names": ["part.wire"], "dependents": true}"#);
    assert!(!new.contains("wire =") && !new.contains("[part.wire"), "{new}");
    // the two presets of a parameter that nothing uses any more
    assert_eq!(errors(&new), ["E008", "E008"]);
    let new = edited(&text, r#"{"type": "delete", "names": ["preset.loose"]}"#);
    assert_eq!(new, text.replace("[preset.loose]\ntight = \"60 N/m\"\n\n", ""));
    let new = edited(&model("rattle"), r#"{"type": "delete", "names": ["toy"], "dependents": true}"#);
    assert!(!new.contains("toy.") && !new.contains("[toy"), "{new}");
    // each module of each model, one at a time
    for (file, text) in models() {
        for name in names(&text).iter().step_by(3) {
            let json = serde_json::json!({"type": "delete", "names": [name], "dependents": true}).to_string();
            match apply(&text, &json) {
                Ok(e) => {
                    common::check_edits(&text, &e);
                    assert_eq!(common::syntax_errors(&e.text), 0, "{file} {name}");
                    let unknown = errors(&e.text).iter().filter(|c| matches!(**c, "E013" | "E021")).count();
                    assert_eq!(unknown, 0, "{file} without {name}:\n{}", e.text);
                }
                Err(e) => assert!(e.what.contains("cannot be written at"), "{file} {name}: {e}"),
            }
        }
    }
}

#[test]
fn copies_are_joined_as_their_originals() {
    let text = model("hammered_string");
    let new = edited(&text, r#"{"type": "duplicate", "names": ["arm", "hammer", "shank", "strike"]}"#);
    for line in [
        "arm = { m = \"4 g\", x = \"-8 mm\" }\narm2 = { m = \"4 g\", x = \"-8 mm\" }\nhammer = ",
        "shank2 = { between = [\"key\", \"arm2\"], k = \"1.5 kN/m\" }\n",
        "strike2 = { between = [\"hammer2\", \"low[8]\"]",
    ] {
        assert!(new.contains(line), "{line} in {new}");
    }
    assert_eq!(comments(&new).len(), comments(&text).len());
    assert_eq!(errors(&new), [""; 0]);
    let new = edited(&model("kalimba"), r#"{"type": "duplicate", "names": ["tine", "box"]}"#);
    assert!(new.contains("\n\n[use.tine2]\npart = \"tine\"\nn = 7\nwith.f") && new.contains("\nbox2 = "), "{new}");
    assert_eq!(errors(&new), [""; 0]);
    let new = edited(&model("rattle"), r#"{"type": "duplicate", "names": ["toy", "keep"]}"#);
    assert!(new.contains("[toy2.TETRA]") && new.contains("between = [\"toy2.ball\", [\"toy2.low[*]\""), "{new}");
    assert_eq!(errors(&new), [""; 0]);
}

#[test]
fn modules_become_a_part() {
    let text = model("hammered_string");
    let names = r#"["key", "arm", "hammer", "frame", "bed", "floor", "shank", "weight", "calm", "stop", "carry"]"#;
    let new = edited(&text, &format!(r#"{{"type": "group", "names": {names}, "part": "action"}}"#));
    for line in [
        "[part.action.MAS]\narm = { m",
        "[part.action.RES]\nshank = { between = [\"key\", \"arm\"], k = \"1.5 kN/m\" }        # no viscosity",
        "[use]\naction = { part = \"action\" }\n",
        "strike = { between = [\"action.hammer\", \"low[8]\"]",
        "\naction.key = [\n",
    ] {
        assert!(new.contains(line), "{line} in {new}");
    }
    assert_eq!(comments(&new).len(), comments(&text).len());
    assert_eq!(errors(&new), [""; 0]);
    // only the order of the sums may differ
    let float = |bits: Vec<u64>| bits.into_iter().map(f64::from_bits).collect::<Vec<_>>();
    let (a, b) = (float(sound(&text, 0.3)), float(sound(&new, 0.3)));
    let peak = a.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
    assert!(peak > 0.01 && a.iter().zip(&b).all(|(a, b)| (a - b).abs() < 1e-3 * peak), "{peak}");
    let why = refused(&text, r#"{"type": "group", "names": ["left"], "part": "x"}"#);
    assert!(why.contains("`channel`"), "{why}");
    let toy = r#"{"type": "group", "names": ["toy", "keep", "low_mid", "low_high", "mid_high", "key_x", "key_y", "hold_x", "hold_y"], "part": "shaker", "instance": "it"}"#;
    let rattle = model("rattle");
    let new = edited(&rattle, toy);
    assert!(new.contains("[part.shaker.toy.TETRA]") && new.contains("\"it.toy.low[*]\""), "{new}");
    assert_eq!(errors(&new), [""; 0]);
    let why = refused(&rattle, r#"{"type": "group", "names": ["toy.ball"], "part": "x"}"#);
    assert!(why.contains("choose `toy` as a whole"), "{why}");
    let kalimba = model("kalimba");
    let new = edited(&kalimba, r#"{"type": "group", "names": ["tine", "frame", "box"], "part": "body"}"#);
    assert!(new.contains("[part.body.use.tine]") && new.contains("\"body.tine[0].key\" = "), "{new}");
    assert!(!errors(&new).contains(&"E001"), "{new}");
}

#[test]
fn modules_move_and_keep_their_units() {
    let text = model("hammered_string");
    let moved = edited(&text, r#"{"type": "move", "name": "arm", "x": [-0.0035]}"#);
    assert_eq!(moved, text.replace("arm = { m = \"4 g\", x = \"-8 mm\" }", "arm = { m = \"4 g\", x = \"-3.5 mm\" }"));
    let moved = edited(&text, r#"{"type": "move", "name": "frame", "x": [0.001]}"#);
    assert_eq!(moved, text.replace("frame = {}", "frame = { x = \"1 mm\" }"));
    let rattle = edited(&model("rattle"), r#"{"type": "move", "name": "toy.high", "x": [0.001, 0.02, -1]}"#);
    assert!(rattle.contains("x = [0.001, \"20.0 mm\", -1.0], turn = [\"5 %\""), "{rattle}");
    assert!(refused(&text, r#"{"type": "move", "name": "shank", "x": [0]}"#).contains("between its ends"));
    assert!(refused(&text, r#"{"type": "move", "name": "arm", "x": [0, 1]}"#).contains("1 finite coordinate"));
}

#[test]
fn keys_and_controllers_are_mapped() {
    let text = model("hammered_string");
    let cc = r#"{"type": "midi", "name": "key", "source": {"controller": 7}}"#;
    let new = edited(&text, cc);
    assert!(new.contains("midi = { cc = 7, from = \"-8 mm\", to = 0, attack = \"7 ms\" }"), "{new}");
    assert_eq!(errors(&new), [""; 0]);
    let range = r#"{"type": "midi", "name": "key", "source": {"note": {"first": "C3", "last": "B3"}}, "to": "1 mm"}"#;
    let new = edited(&text, range);
    assert!(new.contains("midi = { note = [\"C3\", \"B3\"], from = \"-8 mm\", to = \"1 mm\", velocity"), "{new}");
    assert_eq!(errors(&new), [""; 0]);
    let bend =
        edited("[ENX]\nbow = {}\n", r#"{"type": "midi", "name": "bow", "source": "bend", "from": "0", "to": "1 m"}"#);
    assert_eq!(bend, "[ENX]\nbow = { midi = { bend = true, from = 0, to = \"1 m\" } }\n");
    let new = edited(&text, r#"{"type": "device", "name": "key", "device": "falcon", "dof": [2]}"#);
    assert_eq!(new, text.replace("device = \"tgr12\", dof = 0", "device = \"falcon\", dof = 2"));
    assert!(refused("[ENX]\nbow = {}\n", r#"{"type": "midi", "name": "bow", "source": "bend"}"#).contains("`to`"));
    assert!(refused(&text, r#"{"type": "midi", "name": "arm", "source": "bend", "to": "1"}"#).contains("`TGR`"));
    assert!(refused(&text, r#"{"type": "midi", "name": "key", "source": {"controller": 200}}"#).contains("127"));
}

#[test]
fn the_scale_is_set() {
    let text = model("physical_lfo");
    let new = edited(&text, r#"{"type": "equivalence", "rows": {"position": "10 mm:0.6 m", "force": "1 N:18 N"}}"#);
    assert_eq!(new, text.replace("[\"20 mm\", \"0.6 m\"]", "[\"10 mm\", \"0.6 m\"]"));
    let new = edited(&text, r#"{"type": "equivalence", "key": "key", "lever": 2}"#);
    assert_eq!(new, format!("{text}\n[equivalence.key]\nlever = 2.0\n"));
    assert_eq!(errors(&new), [""; 0]);
    // the only row gives way to another one
    let one = text.replace("force = [\"1 N\", \"18 N\"]\n", "");
    let new = edited(&one, r#"{"type": "equivalence", "rows": {"mass": "1 g:1"}, "anchor": "energy"}"#);
    assert!(new.contains("[equivalence]\nmass = [\"1 g\", 1.0]\n") && errors(&new).is_empty(), "{new}");
    let why = refused(&text, r#"{"type": "equivalence", "rows": {"time": "1:1"}}"#);
    assert!(why.contains("clock") && !why.contains("--"), "{why}");
}

/// Line ends of Windows and a byte order mark stay.
#[test]
fn other_line_ends_and_marks_stay() {
    let text = model("hammered_string").replace('\n', "\r\n");
    let new = edited(&text, r#"{"type": "rename", "name": "low", "to": "deep"}"#);
    assert_eq!(new.matches("\r\n").count(), new.matches('\n').count());
    let new = edited(&new, r#"{"type": "add", "kind": "MAS", "name": "bob"}"#);
    assert_eq!(new.matches("\r\n").count(), new.matches('\n').count());
    let marked = format!("\u{feff}{}", model("hammered_string"));
    let new = edited(&marked, r#"{"type": "rename", "name": "low", "to": "deep"}"#);
    assert_eq!(
        new,
        edited(&model("hammered_string"), r#"{"type": "rename", "name": "low", "to": "deep"}"#).replacen(
            '#',
            "\u{feff}#",
            1
        )
    );
    assert_eq!(Edited::between("a", "a").edits, []);
}
