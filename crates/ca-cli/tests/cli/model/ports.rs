//! Tests the output about the ports of models and parts, and probes of ports.

use crate::sandbox::{Sandbox, peak};

/// Twelve keys that differ only in their notes, a port with a controller, and a port without an input.
const KEYS: &str = r#"
[part.note.param]
note = {}
[part.note.TGR]
key = { x = "-8 mm", midi = { note = "note", from = "-8 mm", to = "1.3 mm", velocity = "none" } }
[part.note.MAS]
hammer = { m = "5 g", x = "-8 mm" }
[part.note.RES]
shank = { between = ["key", "hammer"], k = "1 kN/m" }
[use]
note = { part = "note", n = 12, with = { note = ["C4", "C#4", "D4", "D#4", "E4", "F4", "F#4", "G4", "G#4", "A4", "A#4", "B4"] } }
[ENX]
wheel = { midi = { cc = 1, to = "20 mm" } }
[ENF]
push = {}
[MAS]
bob = { m = "5 g" }
[RES]
rod = { between = ["wheel", "bob"], k = "1 kN/m" }
[SOX]
out = { from = "note[*].hammer", channel = 0 }
low = { from = "bob", channel = 0 }
"#;

#[test]
fn inputs_are_shown_with_rest_and_range_and_alike_ones_in_a_line() {
    let sandbox = Sandbox::new();
    sandbox.put("keys.ca.toml", &KEYS.replace("push = {}", "push = { to = \"bob\" }"));
    let r = sandbox.ca(&["check", "keys.ca.toml"]).is(0);
    for line in [
        "note[0..12].key  rests at -8 mm; MIDI -8 mm to 1.3 mm, notes C4 to B4",
        "wheel  rests at 0 m; MIDI 0 m to 20 mm, controller 1",
        "push  rests at 0 N",
    ] {
        assert!(r.out.contains(line), "{line}\n{}\n{}", r.out, r.err);
    }
    // a port with another rest is listed separately; for many ports only the names remain
    let port = |i: usize| format!("p{i} = {{ x = \"{} mm\" }}\n", i + 1);
    let ports = |n: usize| (0..n).map(port).collect::<Vec<_>>().concat();
    let more = |n: usize| {
        let text =
            KEYS.replace("push = {}", "push = { to = \"bob\" }").replace("[ENX]", &format!("[ENX]\n{}", ports(n)));
        let ends: Vec<String> = (0..n).map(|i| format!("\"p{i}\"")).collect();
        text + &format!("[CUB]\nt = {{ between = [[{}], \"bob\"], k = 1, k3 = 1 }}\n", ends.join(", "))
    };
    sandbox.put("keys.ca.toml", &more(9));
    let many = sandbox.ca(&["check", "keys.ca.toml"]).is(0);
    assert!(many.out.contains("and p6, p7, p8, wheel, push\n"), "{}", many.out);
    sandbox.put("keys.ca.toml", &more(2));
    let r = sandbox.ca(&["check", "keys.ca.toml"]).is(0);
    assert!(r.out.contains("  p0  rests at 1 mm\n") && r.out.contains("  p1  rests at 2 mm\n"), "{}", r.out);
}

#[test]
fn a_silent_model_names_the_notes_that_play_it() {
    let sandbox = Sandbox::new();
    sandbox.put("keys.ca.toml", &KEYS.replace("push = {}", "push = { to = \"bob\" }"));
    let r = sandbox.ca(&["render", "keys.ca.toml", "--seconds", "0.05"]).is(0);
    r.says(&["the sound is silent", "`note[0].key`", "a MIDI file plays it with the notes C4 to B4"]);
}

#[test]
fn a_part_is_listed_with_its_ports_and_a_gesture_that_plays_it() {
    let sandbox = Sandbox::new();
    let r = sandbox.ca(&["list", "mallet"]).is(0);
    let line = r#""mallet.key" = [[0, "-8 mm"], [0.02, "0 m"], [0.1, "-8 mm"]]"#;
    let port = "key  rests at -8 mm; MIDI moves it from -8 mm to 0 m by the note `note`";
    assert!(r.out.contains(port) && r.out.contains(line), "{}", r.out);
    let model = "[STRING]\nlow = { n = 24, f = \"A2\", t60 = \"2 s\", m = \"4 g\" }\n\
                 [use]\nmallet = { part = \"mallet\", with = { on = \"low[8]\", note = \"A2\" } }\n\
                 [SOX]\nout = { from = \"low[3]\", hear = \"speed\", gain = 0.1 }\n[gesture]\n";
    sandbox.put("m.ca.toml", &format!("{model}{line}\n"));
    sandbox.ca(&["render", "m.ca.toml", "--seconds", "0.3"]).is(0);
    assert!(peak(&sandbox.wav("m.wav").1) > 0.01);
    // a port moved by a controller, with a parameter as its rest
    let bow = sandbox.ca(&["list", "bow"]).is(0);
    assert!(bow.out.contains("\"bow.press\" = [[0, \"0 m\"], [1, \"0.25 m\"]]"), "{}", bow.out);
    let json = sandbox.ca(&["list", "mallet", "--json"]).is(0).json();
    assert_eq!((&json["ports"][0]["rest"], &json["ports"][0]["unit"]), (&"-8 mm".into(), &"m".into()));
}

/// A probe gives the displacement from rest; a gesture gives the position.
#[test]
fn a_probe_of_a_port_is_its_displacement() {
    let sandbox = Sandbox::new();
    sandbox.put(
        "k.ca.toml",
        "[TGR]\nkey = { x = \"-2 mm\" }\n[MAS]\nm = { m = \"5 g\", x = \"-1 mm\" }\n[RES]\nr = { between = [\"key\", \"m\"], k = 100 }\n\
         [SOX]\nout = { from = \"m\", gain = 100 }\n[gesture]\nkey = [[0, \"-2 mm\"], [0.03, \"1 mm\"]]\n",
    );
    sandbox
        .ca(&["render", "k.ca.toml", "--seconds", "0.1", "--probe", "key=key.csv", "--probe", "m=m.csv", "-q"])
        .is(0);
    let column = |file: &str| -> Vec<f64> {
        let text = std::fs::read_to_string(sandbox.path(file)).unwrap();
        text.lines().skip(1).map(|l| l.split_once(',').unwrap().1.parse().unwrap()).collect()
    };
    let (key, mass) = (column("key.csv"), column("m.csv"));
    assert_eq!((key[0], mass[0]), (0.0, 0.0));
    assert!((key.last().unwrap() - 3e-3).abs() < 1e-12, "{:?}", key.last());
    sandbox.ca(&["render", "--help"]).is(0).says(&["displacement from rest"]);
}

#[test]
fn modes_name_an_output_of_speed_once() {
    let sandbox = Sandbox::new();
    sandbox.put(
        "b.ca.toml",
        "[BANK]\nbell = { f = [\"440 Hz\", \"881 Hz\", \"1217 Hz\"], t60 = \"3 s\", m = \"5 g\" }\n\
         [SOX]\ncoil = { from = \"bell[*]\", hear = \"speed\", channel = 0 }\nhead = { from = \"bell[*]\", hear = \"force\", channel = 0 }\n",
    );
    let r = sandbox.ca(&["modes", "b.ca.toml"]).is(0);
    assert!(r.out.contains("not included, because they do not measure displacement: `coil`, `head`\n"), "{}", r.out);
}

/// A bank in an instance follows the parameter of its first pitch. A number that is not a variable is reported.
#[test]
fn a_bank_of_an_instance_is_tuned_by_its_first_pitch() {
    let sandbox = Sandbox::new();
    let text = "[part.tine.param]\nf = { unit = \"Hz\" }\n\
                [part.tine.BANK]\ntip = { m = \"2 g\", f = [\"f\", \"6.27 f\"], t60 = \"1 s\" }\nfix = { m = \"2 g\", f = [\"90 Hz\", \"f\"], t60 = \"1 s\" }\n\
                [part.tine.CEL]\nover = { m = \"2 g\", f = \"3 f\", t60 = \"1 s\" }\n\
                [use]\ntine = { part = \"tine\", n = 2, with = { f = [\"250 Hz\", \"300 Hz\"] } }\n\
                [SOX]\nout = { from = [\"tine[*].tip[*]\", \"tine[*].fix[*]\", \"tine[*].over\"], channel = 0 }\n";
    sandbox.put("t.ca.toml", text);
    sandbox.ca(&["tune", "t.ca.toml", "tine[0].tip=C4", "--in-place"]).is(0);
    let tuned = std::fs::read_to_string(sandbox.path("t.ca.toml")).unwrap();
    assert!(tuned.contains("f = [\"261.62556") && tuned.contains("\"300 Hz\"]"), "{tuned}");
    sandbox.ca(&["tune", "t.ca.toml", "tine[0].fix=C4"]).is(2).says(&["a list in the part, shared by all instances"]);
    sandbox.ca(&["tune", "t.ca.toml", "tine[0].over=C4"]).is(2).says(&["a multiple of `tine[0].f`"]);
    sandbox.put(
        "u.ca.toml",
        &text
            .replace("{ unit = \"Hz\" }", "{ value = \"250 Hz\" }")
            .replace(", with = { f = [\"250 Hz\", \"300 Hz\"] }", ""),
    );
    sandbox.ca(&["tune", "u.ca.toml", "tine[0].tip=C4"]).is(2).says(&["is `f` of the part, shared by all instances"]);
}
