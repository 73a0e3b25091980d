//! Files as other editors save them, and values out of range: each gets a clear answer.

use super::import;
use crate::play::scene;
use ca_import::mims::decode;
use ca_model::diag::KEPT;
use ca_model::write::write;
use std::fmt::Write as _;

const WHOLE: &str = "@g ground 0.\n@a mass 1. 0. 0.\n@r springDamper @g @a 0.1 0.001\n@out1 posOutput @a\n";

fn titles(text: &str) -> Vec<String> {
    import(text, "foreign.mdl").1.list.into_iter().map(|d| d.title).collect()
}

/// A value that a module cannot have is refused with its place in the text; all others compile.
#[test]
fn numbers_out_of_range_are_refused_where_they_stand() {
    let lines = [
        ("@x mass # 0 0", "M", "-1", "0.001"),
        ("@x mass # 0 0", "M", "0", "1e-280"),
        ("@x mass # 0 0", "M", "1e-300", "1e-280"),
        ("@x mass 1 # 0", "x0", "1e300", "1e280"),
        ("@x massG # 1 0 0", "M", "-2", "2"),
        ("@x osc 1 # 0 0 0", "K", "-0.1", "0.1"),
        ("@x osc 1 0.1 # 0 0", "Z", "-0.1", "0.1"),
        ("@x spring @g @a #", "K", "-0.1", "0"),
        ("@x damper @g @a #", "Z", "-0.1", "0.1"),
        ("@x springDamper @g @a 1 #", "Z", "-1e-9", "0"),
        ("@x nlSpring2 @g @a 0.1 # 0", "Q", "-0.1", "0.1"),
        ("@x nlSpring3 @g @a 0.1 # 0", "Q", "-0.1", "0.1"),
        ("@x contact @g @a # 0 -1", "K", "-0.1", "0.1"),
        ("@x nlPluck @g @a 0.1 #", "scale", "0", "0.1"),
        ("@x nlPluck @g @a 0.1 #", "scale", "-1", "1"),
        ("@x nlBow @g @a # 0.1", "Z", "-0.1", "0.1"),
        ("@x nlBow @g @a 0.1 #", "scale", "0", "0.1"),
    ];
    for (line, name, bad, good) in lines {
        let with = |x: &str| format!("{WHOLE}{}\n", line.replace('#', x));
        let text = with(bad);
        let (_, diags) = import(&text, "foreign.mdl");
        let [d] = &diags.list[..] else { panic!("{text}{diags}") };
        assert!(d.code == "E009" && d.title.starts_with(&format!("`{name}` of `x` is out of range")), "{}", d.title);
        assert_eq!(&text[d.span().start..d.span().end], bad);
        let text = with(good);
        let (model, diags) = import(&text, "foreign.mdl");
        assert!(!diags.has_errors(), "{text}{diags}");
        scene(&write(&model));
    }
    // behind a name: the place of use and the place of declaration
    let text = format!("@M param -1\n{WHOLE}@x mass M 0 0\n");
    let (_, diags) = import(&text, "foreign.mdl");
    let labels: Vec<_> = diags.list[0].labels.iter().map(|l| &text[l.0.start..l.0.end]).collect();
    assert_eq!((diags.list[0].title.as_str(), labels), ("`M` of `x` is out of range: -1", vec!["M", "M"]));
}

#[test]
fn line_ends_of_all_systems_are_line_ends() {
    let plain = import(WHOLE, "a.mdl").0;
    for ends in ["\r", "\r\n"] {
        let text = format!("# {ends}{WHOLE}").replace('\n', ends).replace("\r\r", "\r");
        let (model, diags) = import(&text, "a.mdl");
        assert!(diags.list.is_empty(), "{ends:?} {diags}");
        assert_eq!(model, plain);
        let wrong = text.replace("@a 0.1", "@b 0.1");
        let d = &import(&wrong, "a.mdl").1.list[0];
        assert_eq!(&wrong[d.span().start..d.span().end], "@b");
    }
    // line numbers in messages count the same line ends
    let strange = |ends: &str| titles(&["# a", "@a ground 0", "what"].join(ends));
    assert_eq!(strange("\n"), strange("\r"));
    assert_eq!(strange("\n"), strange("\r\n"));
    assert_eq!(strange("\n"), ["not a line of a MIMS model: `what`, line 3"]);
}

#[test]
fn comments_in_latin_1_are_comments() {
    let mut bytes = b"# corde fix\xe9e\n".to_vec();
    bytes.extend(WHOLE.as_bytes());
    let text = decode(bytes.clone());
    assert!(text.starts_with("# corde fix\u{e9}e\n@g"));
    assert_eq!(import(&text, "a.mdl").0, import(WHOLE, "a.mdl").0);
    let old: Vec<u8> = bytes.iter().map(|b| if *b == b'\n' { b'\r' } else { *b }).collect();
    assert_eq!(decode(old), text);
    assert_eq!(decode("# \u{e9}\r\n".into()), "# \u{e9}\r\n", "UTF-8 stays as it is");
}

#[test]
fn of_a_hundred_thousand_unknown_names_a_hundred_are_said() {
    let mut text = String::from(WHOLE);
    (0..50_000).for_each(|i| _ = writeln!(text, "@m{i} mass 1 0 0"));
    (0..100_000).for_each(|i| _ = writeln!(text, "@r{i} spring @g @n{i} 0.1"));
    let (model, diags) = import(&text, "a.mdl");
    assert!(model.items.is_empty() && diags.is_full());
    assert_eq!(diags.list.len(), KEPT + 1);
    assert!(diags.list[KEPT].title.contains("more than 100 errors"), "{}", diags.list[KEPT].title);
    // unknown types, each of them a possible sign of the newer dialect
    let mut text = String::from(WHOLE);
    (0..100_000).for_each(|i| _ = writeln!(text, "@r{i} gizmo{i} 0.1"));
    assert_eq!(import(&text, "a.mdl").1.list.len(), KEPT + 1);
    text += "@s stiffString 10 1 0.1 0.1 0 0\n";
    let found = import(&text, "a.mdl").1;
    assert_eq!((found.list.len(), found.list[0].code, found.is_full()), (1, "E028", false));
}

#[test]
fn a_start_that_the_dialects_read_differently_is_said() {
    let with = |line: &str| titles(&format!("{WHOLE}{line}\n@o posOutput @x\n"));
    assert_eq!(with("@x mass 1 0.1 0.1"), ["`x` starts at rest, at 0.1"]);
    assert_eq!(with("@x osc 1 0.1 0 0.1 0.1"), ["`x` starts at rest, at 0.1"]);
    assert_eq!(with("@x mass 1 0.1 0"), ["`x` starts with the velocity 0.1 per sample"]);
    assert!(with("@x mass 1 0 0").is_empty());
    // exists only in the older dialect
    assert!(with("@x massG 1 0 0.1 0.1").is_empty());
    let (_, diags) = import(&format!("{WHOLE}@x mass 1 0.1 0.1\n"), "a.mdl");
    assert!(diags.list[0].help.as_ref().unwrap().contains("MIMS4Max writes a velocity per second here"));
}

/// A first sample that differs from mi.lib is reported at the module that shows it.
#[test]
fn what_of_the_first_sample_is_another_is_said() {
    let with = |lines: &str| titles(&format!("{WHOLE}{lines}"));
    let touches = "`c` touches in the first sample, without the force of its threshold";
    assert_eq!(with("@c contact @g @a 0.1 0.01 0.5\n"), [touches]);
    assert!(with("@c contact @g @a 0.1 0.01 -0.5\n").is_empty());
    assert!(with("@c contact @g @a 0.1 0 0.5\n").is_empty());
    // it comes from above and touches in the first sample
    let falls = |v: &str| with(&format!("@b mass 1 0.6 {v}\n@c contact @g @b 0.1 0.01 0.5\n"));
    assert_eq!(falls("0.75")[1..], [touches]);
    assert_eq!(falls("0.65").len(), 1);
    let placed = "`in1` starts at its first value, without a speed";
    assert_eq!(with("@in1 posInput 0\n@c springDamper @in1 @a 0.1 0.01\n"), [placed]);
    assert_eq!(with("@in1 posInput 0\n@c nlBow @in1 @a 0.1 0.01\n"), [placed]);
    assert!(with("@in1 posInput 0\n@c spring @in1 @a 0.1\n").is_empty());
}
