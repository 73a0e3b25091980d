//! Instances of parts equal modules written by hand, and an error in a part is reported once.

use crate::play::{scene, within};
use ca_compile::{Options, load};
use ca_core::internal::io::midi::MidiSource;
use ca_core::internal::kind::cloud::Unread;
use ca_core::{Scene, tick};
use ca_model::diag::Diags;
use ca_model::{Model, Value, part, read, render, write};
use ca_tests::{catalog, gesture};
use std::collections::BTreeMap;
use std::fmt::Write as _;

const NOTES: &str = r#"
[part.note.param]
f = { unit = "Hz" }
felt = { value = "20 kN/m", live = true, min = 0, max = "50 kN/m" }
at = "s[5]"

[part.note.TGR]
key = { x = "-2 mm" }

[part.note.MAS]
hammer = { m = "5 g", x = "-1 mm" }

[part.note.RES]
shank = { between = ["key", "hammer"], k = "2 kN/m" }

[part.note.STRING]
s = { n = 20, f = "f", t60 = "2 s", m = "4 g" }

[part.note.BUT]
strike = { between = ["hammer", "at"], k = "felt", z = "0.5 N s/m" }

[part.note.gesture]
key = [[0.1, "-2 mm"], [0.13, 0], [0.16, "-2 mm"]]

[use]
note = { part = "note", n = 3, with = { f = ["C3", "E3 -14 c", 196], felt = ["20 kN/m", "10 kN/m", "5 kN/m"] } }

[SOX]
out = { from = "note[*].s[8]", gain = 100 }
"#;

fn played(scene: &Scene, n: usize) -> Vec<f64> {
    let mut s = scene.state();
    let mut all = Vec::new();
    for _ in 0..n {
        gesture(scene, &mut s);
        tick(scene, &mut s);
        all.extend_from_slice(&s.output);
    }
    all
}

/// Findings of a model, given the files of its parts.
pub fn found(text: &str, files: &[(&str, &str)]) -> (Model, Diags) {
    let files: BTreeMap<&str, &str> = files.iter().copied().collect();
    let (model, diags) = read::read_with(text, "m.ca.toml", &catalog(), &mut |name| {
        let missing = || Unread { what: format!("`{name}` is missing"), help: "write it".into() };
        files.get(name).map(|t| (*t).to_owned()).ok_or_else(missing)
    });
    let all = match load::finish(&model, diags, &catalog(), &Options::default()) {
        Ok(compiled) => compiled.findings,
        Err(diags) => diags,
    };
    (model, all)
}

pub fn errors(text: &str, files: &[(&str, &str)]) -> String {
    let (model, diags) = found(text, files);
    assert!(diags.has_errors(), "no error in {text}");
    render::text(&diags, &model, false)
}

fn by_hand() -> String {
    let notes = [(130.812_782_650_299_3, 20e3), (0.0, 10e3), (196.0, 5e3)];
    let each = |line: &dyn Fn(usize) -> String| (0..3).map(|i| line(i) + "\n").collect::<String>();
    let f = |i: usize| if i == 1 { "\"E3 -14 c\"".into() } else { format!("{:?}", notes[i].0) };
    [
        "[TGR]\n".to_owned() + &each(&|i| format!("key{i} = {{ x = \"-2 mm\" }}")),
        "[MAS]\n".to_owned() + &each(&|i| format!("hammer{i} = {{ m = \"5 g\", x = \"-1 mm\" }}")),
        "[RES]\n".to_owned()
            + &each(&|i| format!("shank{i} = {{ between = [\"key{i}\", \"hammer{i}\"], k = \"2 kN/m\" }}")),
        "[STRING]\n".to_owned() + &each(&|i| format!("s{i} = {{ n = 20, f = {}, t60 = \"2 s\", m = \"4 g\" }}", f(i))),
        "[BUT]\n".to_owned()
            + &each(&|i| {
                format!(
                    "strike{i} = {{ between = [\"hammer{i}\", \"s{i}[5]\"], k = {:?}, z = \"0.5 N s/m\" }}",
                    notes[i].1
                )
            }),
        "[SOX]\n".to_owned() + &each(&|i| format!("out{i} = {{ from = \"s{i}[8]\", gain = 100 }}")),
        "[gesture]\n".to_owned() + &each(&|i| format!("key{i} = [[0.1, \"-2 mm\"], [0.13, 0], [0.16, \"-2 mm\"]]")),
    ]
    .concat()
}

#[test]
fn instances_play_what_is_written_by_hand() {
    let parts = scene(NOTES).scene;
    let hand = scene(&by_hand()).scene;
    let (a, b) = (played(&parts, 12_000), played(&hand, 12_000));
    assert!(a.iter().any(|v| v.abs() > 1e-4), "nothing sounds");
    assert_eq!(a.len(), b.len());
    let apart = a.iter().zip(&b).filter(|(a, b)| a.to_bits() != b.to_bits()).count();
    assert_eq!(apart, 0, "other bits");
    assert_eq!(parts.counts.n_lia, hand.counts.n_lia);
}

#[test]
fn an_instance_is_named_set_and_played_like_any_module() {
    let (mut model, diags) = read::read(NOTES, "m.ca.toml", &catalog());
    assert!(diags.list.is_empty(), "{}", render::text(&diags, &model, false));
    assert!(model.set("note[1].hammer.m", "20 g") && model.set("note[2].f", "A3") && !model.set("note[3].f", "A3"));
    let options = Options { probes: vec!["note[1].hammer".into(), "note[0].s[3]".into()], ..Options::default() };
    let scene = load::finish(&model, diags, &catalog(), &options).expect("it compiles").scene;
    let live: Vec<&str> = scene.live.params.iter().map(|p| p.name.as_str()).collect();
    assert_eq!(live, ["note[0].felt", "note[1].felt", "note[2].felt"]);
    assert_eq!(
        scene.inputs.iter().map(|i| i.name.as_str()).collect::<Vec<_>>(),
        ["note[0].key", "note[1].key", "note[2].key"]
    );
    let mut controls = scene.controls();
    assert!(controls.set("note[1].felt", 1000.0).is_ok());
}

#[test]
fn a_name_means_a_module_of_the_part_first_and_a_gesture_of_the_model_counts() {
    let text = r#"
[part.tine.CEL]
bar = { m = "1 g", f = "A4", t60 = "1 s" }
[part.tine.RES]
tie = { between = ["bar", "frame"], k = "10 N/m" }
[part.tine.ENF]
blow = { to = "bar" }
[part.tine.gesture]
blow = [[0, 0], [0.001, 1], [0.002, 0]]
[part.pair.use]
tine = { part = "tine", n = 2 }
[part.pair.RES]
bridge = { between = ["tine[0].bar", "tine[1].bar"], k = "5 N/m" }
[use]
pair = { part = "pair", n = 2 }
alone = { part = "tine" }
[SOL]
frame = {}
[CEL]
bar = { m = "9 g", f = "A2", t60 = "1 s" }
[SOX]
all = { from = "pair[*].tine[*].bar", channel = 0 }
one = { from = ["pair[-1].tine[0..1].bar", "alone.bar", "bar"], channel = 1 }
[gesture]
"pair[*].tine[0].blow" = [[0, 0]]
"#;
    let (model, diags) = found(text, &[]);
    assert!(!diags.has_errors(), "{}", render::text(&diags, &model, false));
    let names: Vec<&str> = model.items.iter().filter(|i| i.kind == "CEL").map(|i| i.name.as_str()).collect();
    let pairs = ["pair[0].tine[0].bar", "pair[0].tine[1].bar", "pair[1].tine[0].bar", "pair[1].tine[1].bar"];
    assert_eq!(names, [&pairs[..], &["alone.bar", "bar"]].concat());
    let between = |name: &str| model.items.iter().find(|i| i.name == name).map(|i| i.args[0].value.clone());
    let tie = Value::from(vec!["alone.bar", "frame"]);
    let same = |a: Option<Value>, b: &Value| {
        let text = |v: &Value| match v {
            Value::List(l) => l.iter().map(|e| format!("{:?}", e.value)).collect::<Vec<_>>(),
            v => vec![format!("{v:?}")],
        };
        assert_eq!(a.as_ref().map(text), Some(text(b)));
    };
    same(between("alone.tie"), &tie);
    same(between("pair[1].bridge"), &Value::from(vec!["pair[1].tine[0].bar", "pair[1].tine[1].bar"]));
    same(between("all"), &Value::from(pairs.to_vec()));
    // gestures of the model take precedence over gestures of the part
    let points = |name: &str| match &model.gestures.iter().find(|g| g.key == name)?.value {
        Value::List(l) => Some(l.len()),
        _ => None,
    };
    let blows = ["pair[0].tine[0].blow", "pair[1].tine[0].blow", "pair[1].tine[1].blow", "alone.blow"];
    assert_eq!(blows.map(points), [Some(1), Some(1), Some(3), Some(3)]);
}

#[test]
fn a_part_of_another_file_points_into_that_file() {
    let bow = "[part.bow.param]\nstring = {}\nf = '0.3 N'\n[part.bow.ENX]\nhand = {}\n[part.bow.BOW]\n\
               hair = { between = ['string', 'hand'], f = 'f', v0 = 'slow' }\n";
    let text = "[CEL]\nreed = { m = '1 g', f = 'A4', t60 = 1 }\n[SOX]\nout = { from = 'reed' }\n[use]\n\
                bow = { file = 'parts/bow.ca.toml', part = 'bow', with = { string = 'reed' } }\n";
    let all = errors(text, &[("parts/bow.ca.toml", bow)]);
    assert!(all.contains("--> parts/bow.ca.toml:7:54") && all.contains("`v0` of `bow.hair`"), "{all}");
    let good = bow.replace("'slow'", "0.1");
    let (model, diags) = found(text, &[("parts/bow.ca.toml", &good)]);
    assert!(!diags.has_errors(), "{}", render::text(&diags, &model, false));
    assert_eq!(model.files[0].text, good);
    let all = errors("[use]\nx = 'bow.ca.toml'\n", &[("bow.ca.toml", &good)]);
    assert!(all.contains("contains only parts") && all.contains("add `part = \"bow\"`"), "{all}");
    // a file that is a part as a whole, and uses another beside it
    let chain = "[use]\nbow = { file = 'bow.ca.toml', part = 'bow', with = { string = 'reed' } }\n[CEL]\nreed = { m = 1, f = 9 }";
    let (model, diags) = found(
        "[use]\nx = 'parts/chain.ca.toml'\n[SOX]\no = { from = 'x.reed' }",
        &[("parts/chain.ca.toml", chain), ("parts/bow.ca.toml", &good)],
    );
    assert!(!diags.has_errors(), "{}", render::text(&diags, &model, false));
    assert!(model.items.iter().any(|i| i.name == "x.bow.hair"), "{:?}", model.items);
    assert_eq!(
        model.files.iter().map(|f| f.name.as_str()).collect::<Vec<_>>(),
        ["parts/chain.ca.toml", "parts/bow.ca.toml"]
    );
    for path in ["../bow.ca.toml", "/etc/passwd", "parts/../bow.ca.toml", "C:\\bow", ""] {
        let all = errors(&text.replace("parts/bow.ca.toml", path), &[]);
        assert!(all.contains("E031") && all.contains("inside the folder"), "{path}: {all}");
    }
}

#[test]
fn what_is_wrong_is_said_once_and_where_it_stands() {
    let (head, tail) = (
        "[part.p.param]\nf = { unit = 'Hz' }\non = 'bar'\n[part.p.CEL]\nbar = { m = 'm', f = 'f' }\n",
        "[SOX]\no = { from = 'p[*].bar', channel = 0 }\n",
    );
    let with = |uses: &str, more: &str| errors(&format!("{head}{more}{tail}[use]\n{uses}"), &[]);
    for (uses, more, code, says) in [
        ("p = { part = 'p', n = 3, with = { f = 9 } }", "", "E013", "(the same in 2 other instances)"),
        ("p = { part = 'p', n = 3, with = { f = [9, 9] } }", "", "E018", "2 values for 3 instances"),
        ("p = { part = 'p', n = 3 }", "", "E005", "`p[0]` needs `f`"),
        ("p = { part = 'p', n = 3, with = { g = 9, f = 9 } }", "", "E004", "has no parameter `g`"),
        ("p = { part = 'q', n = 3 }", "", "E013", "available parts: `p`, `bow`"),
        ("p = { part = 'p', n = 1.5, with = { f = 9 } }", "", "E006", "a whole number"),
        ("p = { n = 1 }", "", "E005", "names neither a part nor a file"),
        ("p = 3", "", "E003", "must name a part or a file"),
        ("p = { part = 'p', many = 3 }", "", "E004", "unknown key of `[use]`"),
        ("p = { part = 'p', n = 2, with = { f = 9 } }", "[part.p.use]\nq = { part = 'p' }\n", "E033", "uses itself"),
        ("p = { part = 'p', n = 2, with = { f = 9 } }", "[part.p.rate]\nsound = 9\n", "E002", "only at the root"),
        ("p = { part = 'p', n = 2, with = { f = 9 } }", "[part.p]\ngravty = 9\n", "E004", "did you mean `gravity`?"),
        (
            "p = { part = 'p', n = 2, with = { f = 9 } }",
            "[SOF]\nx = { from = 'p[2].bar' }\n",
            "E016",
            "`p` has the instances [0] to [1]",
        ),
        ("p = { part = 'p', n = 2, with = { f = 9 } }", "[SOF]\nx = { from = 'p[1]' }\n", "E013", "that is a group"),
        ("p = { part = 'p', n = 2, with = { f = 'H4' } }", "", "E013", "did you mean `B4`?"),
        (
            "p = { part = 'p', n = 2, with = { f = 9 } }",
            "[SOF]\nx = { from = 'p.bar' }\n",
            "E013",
            "`p[*].bar` for all",
        ),
        (
            "p = { part = 'p', n = 2, with = { f = 9 } }",
            "[SOF]\nx = { from = 'p[*].baar' }\n",
            "E013",
            "did you mean `p[0].bar`?",
        ),
        ("p = { part = 'p', n = 2, with = { f = 'bor' } }", "", "E013", "`bor` is neither a number nor a name"),
        (
            "p = { part = 'p', n = 1e6, with = { f = 9 } }\nq = { part = 'p', n = 1e6, with = { f = 9 } }",
            "",
            "E027",
            "`p` would make 1000000 instances with 1000000 modules",
        ),
    ] {
        let all = with(uses, more);
        assert!(all.contains(&format!("error[{code}]")) && all.contains(says), "{uses}\n{more}\n{all}");
    }
    // consequences of a list that is too short, or of a list for a single instance, are not reported
    let midi = "[part.p.param]\nnote = {}\n[part.p.TGR]\nkey = { midi = { note = 'note', to = '1 mm' } }\n";
    let short = midi.to_owned() + "[part.p.CEL]\nbar = { m = 1, f = 9 }\n";
    let of =
        |uses: &str| format!("{short}[part.p.REF]\nr = {{ between = ['key', 'bar'], k = 1 }}\n{tail}[use]\n{uses}");
    let all = errors(&of("p = { part = 'p', n = 3, with = { note = ['C4', 'D4'] } }"), &[]);
    assert!(all.contains("E018") && all.matches("error[").count() == 1, "{all}");
    let all = with("p = { part = 'p', with = { f = [9, 8, 7] } }", "").replace("p[*]", "p");
    assert!(all.contains("[E006]: `f` of `p` must be a number, not a list") && all.contains("add `n = 3`"), "{all}");
    assert_eq!(all.matches("E006").count(), 1, "{all}");
    let twice = format!(
        "{}{tail}[use]\np = {{ part = 'p', with = {{ f = [9, 8, 7] }} }}",
        head.replace("f = 'f' }", "f = '2 f' }")
    );
    let all = errors(&twice, &[]);
    assert!(all.contains("add `n = 3`") && !all.contains("E007"), "{all}");
    let all = with("p = { part = 'p', n = 2, with = { f = 9 } }", "[CEL]\np = { m = 1, f = 9 }\n");
    assert!(all.contains("E012"), "{all}");
}

#[test]
fn a_model_of_parts_is_written_flat_and_reads_back() {
    let (model, _) = read::read(NOTES, "", &catalog());
    let text = write::write(&model);
    let (again, diags) = read::read(&text, "", &catalog());
    assert!(diags.list.is_empty(), "{text}\n{}", render::text(&diags, &again, false));
    let names = |m: &Model| {
        let mut all: Vec<String> = m.items.iter().map(|i| format!("{} {}", i.kind, i.name)).collect();
        all.sort();
        all
    };
    assert_eq!(names(&again), names(&model));
    let (a, b) = (scene(NOTES).scene, scene(&text).scene);
    let far = played(&a, 8_000).iter().zip(&played(&b, 8_000)).fold(0.0, |m: f64, (a, b)| m.max((a - b).abs()));
    within("a model written flat", far, 1e-12);
}

#[test]
fn a_program_adds_instances_and_lists_them() {
    let (mut model, _) = read::read(NOTES, "", &catalog());
    let note = model.parts[0].clone();
    let mut u = part::Use::new("more");
    u.n = Some(ca_model::Entry::new("n", 2.0));
    u.with.push(ca_model::Entry::new("f", "A4"));
    assert!(!part::add(&mut model, &note, &u, &catalog()).has_errors());
    model.add("SOX", "sum", [ca_model::Entry::new("from", "more[*].s[3]"), ca_model::Entry::new("channel", 9.0)]);
    assert!(!part::lists(&mut model, &catalog()).has_errors());
    let last = &model.items.last().unwrap().args[0].value;
    assert!(matches!(last, Value::List(l) if l.len() == 2), "{last:?}");
    assert!(part::add(&mut model, &note, &part::Use::new("bare"), &catalog()).has_errors(), "without its pitch");
}

#[test]
fn small_files_take_neither_time_nor_memory_without_end() {
    // fifteen nested levels of a thousand instances each, with empty parts
    let mut deep = String::new();
    for i in 0..15 {
        let _ = writeln!(deep, "[part.p{i}.use]\nx = {{ part = 'p{}', n = 1000 }}", i + 1);
    }
    deep += "[part.p15]\ndoc = 'e'\n[use]\na = { part = 'p0', n = 1000 }\n";
    assert!(errors(&deep, &[]).contains("E027"));
    let deeper = deep.replace("n = 1000", "n = 1").replace(
        "[part.p15]\n",
        "[part.p15.use]\nx = { part = 'p16' }\n[part.p16.use]\nx = { part = 'p17' }\n[part.p17]\n",
    );
    assert!(errors(&deeper, &[]).contains("is nested more than 16 deep"));
    let fans = "[part.c.ENX]\nz = {}\n[part.b.use]\nc = { part = 'c', n = 10 }\n[part.a.use]\nb = { part = 'b', n = 100 }\n[use]\na = { part = 'a', n = 100 }\n\
                [SOX]\no = { from = 'a[0].b[0].c[0].z' }\n[gesture]\n";
    let points: Vec<String> = (0..1000).map(|i| format!("[{i}, 0]")).collect();
    let all = errors(&format!("{fans}\"a[*].b[*].c[*].z\" = [{}]\n", points.join(", ")), &[]);
    assert!(all.contains("E027") && all.contains("too many points"), "{all}");
    // gestures that follow each other in every combination
    let mut follow = String::from(
        "[model]\nseconds = 1\n[ENX]\np = {}\n[SOX]\no = { from = 'p' }\n[gesture]\np = { follow = 'x0' }\n",
    );
    for i in 0..14 {
        let next = vec![format!("{{ follow = 'x{}' }}", i + 1); 30].join(", ");
        let _ = writeln!(follow, "x{i} = {{ sum = [{next}] }}");
    }
    assert!(errors(&(follow + "x14 = [[0, 1]]\n"), &[]).contains("E021"));
    let many = "[part.q.param]\nm = '1 g'\n[part.q.MAS]\na = { m = 'm' }\n[use]\nq = { part = 'q', n = 30000 }\n[SOX]\no = { from = 'q[*].a', channel = 0 }\n";
    assert!(!found(many, &[]).1.has_errors());
}

#[test]
fn a_parameter_that_is_called_like_a_note_is_no_note() {
    let text = "[part.p.param]\nf0 = { unit = 'Hz' }\ng = { value = 'f0' }\n[part.p.CEL]\nc = { m = 1e-3, f = 'g', t60 = 1 }\n[use]\nk = { part = 'p', with = { f0 = '300 Hz' } }\n\
                [SOX]\no = { from = 'k.c' }\n";
    let (model, diags) = found(text, &[]);
    assert!(!diags.has_errors(), "{}", render::text(&diags, &model, false));
    let of = |model: &Model| model.items[0].args.iter().find(|e| e.key == "f").map(|e| e.value.clone());
    assert_eq!(of(&model), Some(Value::from("k.f0")));
    let all =
        errors("[param]\nf0 = '300 Hz'\ng = 'f0'\n[CEL]\nc = { m = 1, f = 'g' }\n[SOX]\no = { from = 'c' }\n", &[]);
    assert!(all.contains("a parameter cannot refer to other parameters"), "{all}");
}

#[test]
fn a_number_is_handed_on_to_where_no_reference_stands() {
    let text = "[part.in.param]\nf = {}\nwhich = {}\ncount = {}\n\
        [part.in.TGR]\nkey = { dof = \"which\", midi = { note = \"f\", to = \"1 mm\" } }\n\
        [part.in.CHAIN]\nc = { n = \"count\", m = \"1 g\", k = \"1 N/m\" }\n\
        [part.in.CEL]\nbar = { m = \"1 g\", f = \"f\" }\n[part.in.RES]\nr = { between = [\"key\", \"bar\"], k = 1 }\n\
        [part.mid.param]\nf = {}\nd = 0\n[part.mid.use]\ni = { part = \"in\", with = { f = \"f\", which = \"d\", count = 3 } }\n\
        [part.out.param]\nf = {}\nd = 0\n[part.out.use]\nm = { part = \"mid\", with = { f = \"f\", d = \"d\" } }\n\
        [use]\no = { part = \"out\", n = 2, with = { f = [\"C4\", \"E4\"], d = [4, 5] } }\n\
        [SOX]\nout = { from = \"o[*].m.i.bar\", gain = 1, channel = 0 }\n";
    let (model, diags) = found(text, &[]);
    assert!(!diags.has_errors(), "{}", render::text(&diags, &model, false));
    let scene = ca_compile::compile(&model, &catalog(), &Options::default()).expect("a scene").scene;
    let port = |name: &str| scene.inputs.iter().find(|p| p.name == name).expect(name);
    let source: Vec<MidiSource> = port("o[1].m.i.key").midi.iter().map(|m| m.source).collect();
    assert_eq!(source, [MidiSource::Note { low: 64, high: 64 }]);
    let hz = |name: &str| model.params.iter().any(|p| p.key == name);
    assert!(hz("o[0].f") && hz("o[1].f"), "one parameter for each, changed at the outermost");
}

#[test]
fn a_probe_of_many_instances_is_one_of_each() {
    let (model, _) = found(NOTES, &[]);
    let options = Options { probes: vec!["note[*].hammer".into(), "note[1..3].s[2]".into()], ..Options::default() };
    let scene = ca_compile::compile(&model, &catalog(), &options).expect("a scene").scene;
    let names: Vec<&str> = scene.names.probe_names.iter().map(|n| &**n).collect();
    let want = ["note[0].hammer", "note[1].hammer", "note[2].hammer", "note[1].s[2]", "note[2].s[2]"];
    assert_eq!((names, &*scene.names.probe_of), (want.to_vec(), &[0, 0, 0, 1, 1][..]));
}
