//! Rows of linear links that one pass sums and integrates have the bits of the list of passes, with the energy ledger
//! too, and are used only where the result is the same.

use crate::play::{mat, scene, with};
use ca_compile::{KernelClass, Options};
use ca_core::internal::op::{Band, Hub, Integrate, Vectors};
use ca_core::internal::scene::{lia_name, same_since};
use ca_core::internal::state::shape;
use ca_core::{Location, Scene, tick};
use proptest::prelude::*;
use std::fmt::Write as _;

/// The fused rows: law, and class of masses they integrate.
fn fused(s: &Scene) -> Vec<(&'static str, Integrate)> {
    let rows = s.passes.moves.iter().filter(|op| op.form.integrate != Integrate::No);
    rows.map(|op| (op.name(), op.form.integrate)).collect()
}

/// Plays `text` fused and as a list, and compares every bit of position and motion.
fn same(text: &str, ticks: usize) -> Vec<(&'static str, Integrate)> {
    let listed = with(text, &Options { kernel: KernelClass::Listed, ..Options::default() });
    // the ledger does not depend on the storage order
    for energy in [true, false] {
        same_as(text, &with(text, &Options { energy, ..Options::default() }), &listed, ticks);
    }
    same_by_all_vectors(text);
    fused(&scene(text))
}

fn same_as(text: &str, fast: &Scene, listed: &Scene, ticks: usize) {
    assert_eq!(fused(listed), [], "{text}");
    let (mut a, mut b) = (fast.state(), listed.state());
    // the same modules in document order, whatever their places
    let slots = |s: &Scene| -> Vec<usize> {
        let mats = s.symbols.iter().filter_map(|m| if let Location::Mat(at) = m.location { Some(at) } else { None });
        mats.map(|at| at as usize).collect()
    };
    let slots: Vec<(usize, usize)> = slots(fast).into_iter().zip(slots(listed)).collect();
    let mut heard = 0.0f64;
    for n in 0..ticks {
        for (scene, s) in [(fast, &mut a), (listed, &mut b)] {
            // changes the live parameter, if any, over 100 ticks and back at once
            let turn = [(ticks / 3, 0.15, 100), (ticks / 2, 0.1, 1)].into_iter().find(|t| t.0 == n);
            if let Some((change, (_, v, ticks))) = turn.and_then(|t| Some((scene.controls().set("dial", t.1).ok()?, t)))
            {
                assert!(s.apply(&change, ticks), "{v}");
            }
            s.input.iter_mut().for_each(|v| *v = 1e-3 * (0.01 * n as f64).sin());
        }
        tick(fast, &mut a);
        tick(listed, &mut b);
        let motion =
            |(i, j): &(usize, usize)| a.x[*i].to_bits() == b.x[*j].to_bits() && a.d[*i].to_bits() == b.d[*j].to_bits();
        let sound = a.output.iter().zip(&b.output).all(|(a, b)| a.to_bits() == b.to_bits());
        assert!(slots.iter().all(motion) && sound, "{text}\ntick {n}");
        heard = heard.max(a.output[0].abs());
    }
    assert!(heard > 0.0 && heard < 1e6, "{heard} in\n{text}");
    assert_eq!(a.bits(), b.bits(), "the hash sees what is folded: {text}");
    assert_eq!(shape(&a), shape(&b), "a take sees what is folded: {text}");
    assert_eq!((fast.mats(), fast.lias()), (listed.mats(), listed.lias()), "what fills up a row is counted: {text}");
}

/// Plays a scene with all vector widths of this processor.
fn same_by_all_vectors(text: &str) {
    let [portable, others @ ..] = Vectors::all().map(|vectors| {
        let mut scene = scene(text).scene;
        scene.layout.vectors = vectors;
        let mut state = scene.state();
        (0..300).for_each(|_| tick(&scene, &mut state));
        state.bits()
    });
    assert_eq!(others, [portable; 2], "{text}");
}

/// A string of `n` masses struck by a hammer.
fn struck(n: u32, of: &str) -> String {
    format!(
        "[STRING]\ns = {{ n = {n}, m = \"2 g\", {of} }}\n[MAS]\nh = {{ m = \"5 g\", x = \"-0.1 mm\", v = 1 }}\n[BUT]\nb = {{ \
         between = [\"h\", \"s[4]\"], k = \"20 kN/m\", z = 0.2 }}\n[SOX]\nout = {{ from = \"s[7]\" }}\n"
    )
}

proptest! {
    /// Row lengths around the vector widths, three laws, masses with and without own dampers, a moving point.
    #[test]
    fn a_row_has_the_bits_of_its_list(
        n in 11u32..150, k in 1e2f64..1e5, z in 1e-4f64..0.3, law in 0..3, own: bool, point: bool, times in 1..3
    ) {
        let of = match law {
            0 => format!("k = {k:?}"),
            1 => format!("k = {k:?}, z = {z:?}"),
            _ => format!("k = 0, z = {z:?}"),
        };
        let own = if own { ", zo = 0.01" } else { "" };
        let point = if point {
            "[ENX]\nspot = {}\n[SOL]\ntop = {}\n[REF]\nslide = { between = [\"top\", \"s@spot\"], k = \"1 kN/m\" }\n"
        } else {
            ""
        };
        let text = format!("{}{point}[rate]\noversample = {times}\n", struck(n, &(of + own)));
        same(&text, 1500);
    }
}

#[test]
fn a_row_is_fused_where_one_number_comes_behind_it() {
    let string = struck(24, "k = \"40 kN/m\", z = 0.1");
    assert_eq!(same(&string, 3000), [("REF", Integrate::Mas)]);
    assert_eq!(same(&struck(24, "k = \"40 kN/m\""), 3000), [("RES", Integrate::Mas)]);
    assert_eq!(same(&struck(24, "k = \"40 kN/m\", z = 0.1, zo = 0.01"), 3000), [("REF", Integrate::Cel)]);
    // a force by a port is one such extra number
    let pushed = format!("{string}[ENF]\npush = {{ to = \"s[2]\" }}\n");
    assert_eq!(same(&pushed, 3000), [("REF", Integrate::Mas)]);
    // it rounds differently from a force that is added first
    assert_eq!((same_since(&scene(&pushed)), same_since(&scene(&string))), (2, 0));
    // refused: two extra forces on one mass, one before the row, one that is read, one that a solver needs
    for more in [
        "[SOL]\ng = {}\n[CUB]\nc = { between = [\"g\", \"s[4]\"], k = 1e4, k3 = 1e9 }\n",
        "[ENF]\npush = { to = [\"s[2]\", \"s[4]\"] }\n[SOL]\ng = {}\n[CUB]\nc = { between = [\"g\", \"s[4]\"], k = 1e4, k3 = 1e9 }\n",
        "[SOF]\nforce = { from = \"s[3]\" }\n",
        "[SOL]\ng = {}\n[BOW]\nc = { between = [\"s[9]\", \"g\"], f = 0.3, v0 = \"50 mm/s\", method = \"newton\" }\n",
        "[model]\ngravity = 9.81\n",
    ] {
        assert_eq!(same(&format!("{string}{more}"), 1500), [], "{more}");
    }
}

/// A link from the last MAT to a moving point stored behind it is not in an integrating row.
#[test]
fn a_link_to_the_slot_behind_the_last_mass_is_no_row() {
    for place in ["0.3,0.4", "place,0.4"] {
        same(
            &format!(
                "[param]\nplace = {{ value = 0.3, live = true, min = 0.05, max = 0.95 }}\n[MESH]\nskin = {{ nx = 4, ny = 4, m = \"1 g\", k \
                 = \"38 kN/m\", z = 0.01 }}\n[SOL]\nwall = {{}}\n[REF]\ntie = {{ between = [\"wall\", \"skin@{place}\"], k = 100, z = \
                 0.01 }}\n[ENF]\npush = {{ to = \"skin[1,2]\" }}\n[SOX]\no = {{ from = \"skin[1,1]\" }}\n"
            ),
            500,
        );
    }
}

/// Links with their own rest lengths, in a row written by hand.
#[test]
fn a_row_under_tension_has_the_bits_of_its_list() {
    let mut text = String::from("[SOL]\nl = {}\nr = { x = \"2.4 cm\" }\n[MAS]\n");
    for i in 1..24 {
        let v = if i == 5 { ", v = 0.1" } else { "" };
        let _ = writeln!(text, "m{i} = {{ m = \"2 g\", x = \"{i} mm\"{v} }}");
    }
    text += "[REF]\n";
    for i in 0..24 {
        let [a, b] = [i, i + 1].map(|i| match i {
            0 => "l".into(),
            24 => "r".into(),
            _ => format!("m{i}"),
        });
        let _ = writeln!(text, "r{i} = {{ between = [\"{a}\", \"{b}\"], k = 4e4, z = 0.1, l0 = \"0.9 mm\" }}");
    }
    text += "[SOX]\nout = { from = \"m7\" }\n";
    assert_eq!(same(&text, 3000), [("REF", Integrate::Mas)]);
    assert!(scene(&text).passes.moves.iter().any(|op| op.form.offset));
}

/// Consecutive strings, and the rows of a mesh, run as one row; long rows are folded, also with live parameters.
#[test]
fn rows_that_are_joined_have_the_bits_of_their_list() {
    let dial = "[param]\ndial = { value = 0.1, unit = \"N s/m\", live = true, min = 0.05, max = 0.2 }\n";
    let strings = "[STRING]\ns = { n = 24, m = \"2 g\", k = \"40 kN/m\", z = 0.1 }\n\
                   t = { n = 40, m = \"2 g\", k = \"30 kN/m\", z = 0.1 }\n\
                   u = { n = 90, m = \"2 g\", k = \"40 kN/m\" }\n\
                   v = { n = 30, m = \"2 g\", k = \"40 kN/m\", z = \"dial\" }\n\
                   [MESH]\nmesh = { nx = 13, ny = 14, m = \"2 g\", k = \"10 kN/m\", z = \"dial\", edges = \"closed\" }\n";
    let more = "[MAS]\nh = { m = \"5 g\", x = \"-0.1 mm\", v = 1 }\ni = { m = \"5 g\", x = \"-0.1 mm\", v = 1 }\n[BUT]\n\
                b = { between = [\"h\", \"s[4]\"], k = \"20 kN/m\", z = 0.2 }\n\
                c = { between = [\"i\", \"t[7]\"], k = \"20 kN/m\", z = 0.2 }\n\
                d = { between = [\"i\", \"u[30]\"], k = \"20 kN/m\", z = 0.2 }\n[REF]\n\
                bridge = { between = [\"t[20]\", \"mesh[6,7]\"], k = \"1 kN/m\", z = 0.1 }\n\
                other = { between = [\"s[20]\", \"v[20]\"], k = \"1 kN/m\", z = 0.1 }\n\
                [SOX]\nout = { from = \"s[7]\" }\nskin = { from = \"mesh[6,6]\", channel = 1 }\nlong = { from = \"u[9]\" }\n";
    let text = format!("{dial}{strings}{more}");
    let rows = [("REF", Integrate::Mas), ("RES", Integrate::Mas), ("REF", Integrate::Cel), ("REF", Integrate::Cel)];
    assert_eq!(same(&text, 3000), rows);
    let s = scene(&text);
    let rows: Vec<usize> = s.passes.moves.iter().filter(|op| op.form.folded).map(|op| op.n).collect();
    // of the mesh, all but the links missing behind the last mass
    let filled = [26 + 42, 92, 32, 13 * 14].map(|masses: usize| masses.next_multiple_of(8));
    assert_eq!(rows, filled, "s and t are one row, with a joint");
    let changed = |scene: &Scene| {
        let mut state = scene.state();
        assert!(state.apply(&scene.controls().set("dial", 0.15).expect("in range"), 1));
        tick(scene, &mut state);
        (scene.state().bits(), state.bits())
    };
    let list = with(&text, &Options { kernel: KernelClass::Listed, ..Options::default() });
    let ((a, b), listed) = (changed(&s), changed(&list));
    assert_eq!((a, b), listed);
    assert_ne!(a, b, "the hash sees a changed coefficient");
}

proptest! {
    /// Meshes of every width and height around the vector widths: links in both directions, their masses and a hammer
    /// in one pass. With outputs of forces that no pass keeps, a moving point and a live parameter.
    #[test]
    fn a_mesh_has_the_bits_of_its_list(
        nx in 12u32..40, ny in 11u32..22, viscous: bool, own: bool, point: bool, times in 1..3, heard: bool, behind: bool,
        edges in prop::sample::select(vec!["open", "corner", "closed"])
    ) {
        let of = if viscous { "k = \"10 kN/m\", z = \"dial\"" } else { "k = \"10 kN/m\"" };
        let own = if own { ", zo = 0.01" } else { "" };
        let more = if heard { "[SOF]\nstress = { from = \"m.link[40]\", channel = 1 }\nrow = { from = \"m.link[2]\" }\n" } else { "" };
        let (point, at) = if point { ("[ENX]\nspot = {}\n", "m@spot,0.4") } else { ("", "m[4,5]") };
        let mesh = format!("[MESH]\nm = {{ nx = {nx}, ny = {ny}, m = \"2 g\", {of}{own}, edges = \"{edges}\" }}\n");
        let mass = "[MAS]\nh = { m = \"5 g\", x = \"-0.1 mm\", v = 1 }\n".to_owned();
        let mats = if behind { mass + &mesh } else { mesh + &mass };
        let text = format!(
            "[param]\ndial = {{ value = 0.1, unit = \"N s/m\", live = true, min = 0.05, max = 0.2 }}\n{mats}[BUT]\nb = {{ between = \
             [\"h\", \"{at}\"], k = \"20 kN/m\", z = 0.2 }}\n[SOX]\nout = {{ from = \"m[7,2]\" }}\n{more}{point}[rate]\noversample = {times}\n"
        );
        // the live parameter may change every number of the mesh
        let class = if own.is_empty() && !viscous { Integrate::Mas } else { Integrate::Cel };
        let rows = same(&text, 600);
        if edges != "open" {
            return Ok(());
        }
        prop_assert_eq!(rows, [(if viscous { "REF" } else { "RES" }, class)]);
        let s = scene(&text);
        prop_assert!(s.passes.moves.iter().any(|op| matches!(op.form.band, Band::Along(_))), "{}", text);
        prop_assert!(s.passes.summed().iter().all(|op| op.form.stride == 0), "{}", text);
    }
}

/// Meshes that do not fold: too few rows for the width, rows summed in another order, or mixed kinds.
#[test]
fn a_mesh_that_does_not_fold_has_the_bits_of_its_list() {
    let mesh = |of: &str| {
        format!(
            "[MESH]\nm = {{ {of}, m = \"2 g\", k = \"10 kN/m\", z = 0.1 }}\n[MAS]\nh = {{ m = \"5 g\", x = \"-0.1 mm\", v = 1 }}\n[BUT]\nb = {{ between = \
             [\"h\", \"m[2,2]\"], k = \"20 kN/m\", z = 0.2 }}\n[SOX]\nout = {{ from = \"m[3,2]\" }}\n"
        )
    };
    for of in [
        "nx = 5, ny = 40",
        "nx = 40, ny = 5",
        "nx = 13, ny = 14, edges = \"closed\"",
        "nx = 13, ny = 14, edges = \"corner\"",
        "nx = 13, ny = 14, fixed = [[0, 0], [4, 4]]",
    ] {
        same(&mesh(of), 1500);
    }
    let again = |name: &str, step: [usize; 2]| {
        let mut text = mesh("nx = 16, ny = 14") + "[REF]\n";
        for i in 1..12 {
            let [a, b] = if step[0] == 1 { [[i, 5], [i + 1, 5]] } else { [[5, i], [5, i + 1]] };
            let [[ax, ay], [bx, by]] = [a, b];
            let _ =
                writeln!(text, "{name}{i} = {{ between = [\"m[{ax},{ay}]\", \"m[{bx},{by}]\"], k = 5e3, z = 0.02 }}");
        }
        text
    };
    same(&again("along", [1, 0]), 1500);
    same(&again("across", [0, 1]), 1500);
    for more in [
        "[SOL]\ng = {}\n[CUB]\nc = { between = [\"g\", \"m[2,2]\"], k = 1e4, k3 = 1e9 }\n",
        "[SOF]\nforce = { from = \"m[5,5]\" }\n",
    ] {
        let banded = |text: &str| scene(text).passes.moves.iter().any(|op| op.form.band != Band::None);
        let text = mesh("nx = 16, ny = 12");
        assert!(banded(&text) && !banded(&format!("{text}{more}")), "{more}");
        same(&format!("{text}{more}"), 1500);
    }
}

/// Parallel strings coupled mass by mass: a row of links over the masses of two rows.
#[test]
fn rows_under_another_row_have_the_bits_of_their_list() {
    let strings = "[STRING]\ns = { n = 24, m = \"2 g\", k = \"40 kN/m\", z = 0.1 }\n\
                   t = { n = 24, m = \"2 g\", k = \"30 kN/m\", z = 0.1 }\n[MAS]\nh = { m = \"5 g\", x = \"-0.1 mm\", v = 1 }\n\
                   [BUT]\nb = { between = [\"h\", \"s[4]\"], k = \"20 kN/m\", z = 0.2 }\n[SOX]\nout = { from = \"t[7]\" }\n";
    for (law, k) in [("RES", "k = \"100 N/m\""), ("CUB", "k = \"100 N/m\", k3 = 1e9")] {
        let mut text = format!("{strings}[{law}]\n");
        for i in 6..22 {
            let _ = writeln!(text, "c{i} = {{ between = [\"s[{i}]\", \"t[{i}]\"], {k} }}");
        }
        same(&text, 1500);
    }
}

/// Rows of masses before and behind a folded string, coupled mass by mass. Folding takes more places, so the masses
/// behind it are further away.
#[test]
fn rows_across_a_folded_one_have_the_bits_of_their_list() {
    for (n, law, of) in [(41, "REF", "k = 300, z = 0.01"), (17, "BUT", "k = 300"), (30, "CUB", "k = 300, k3 = 1e6")] {
        let names = |of: &str, range: std::ops::Range<u32>| {
            range.map(|i| format!("\"{of}.m{i}\"")).collect::<Vec<_>>().join(", ")
        };
        let masses = |of: &str| {
            let each = (0..12).map(|i| format!("m{i} = {{ m = \"1 g\", v = {} }}\n", 0.1 * f64::from(i % 3)));
            format!("[{of}.MAS]\n{}", each.collect::<String>())
        };
        let row =
            |of: &str| format!("r{of} = {{ between = [[{}], [{}]], k = 4000 }}\n", names(of, 0..11), names(of, 1..12));
        let text = format!(
            "{}[s.CHAIN]\nlow = {{ n = {n}, m = \"1 g\", k = 8000, zo = 0.001 }}\n{}[RES]\n\
             u = {{ between = [\"a.m1\", \"s.low[3]\"], k = 100 }}\n{}{}\
             [{law}]\nl = {{ between = [[{}], [{}]], {of} }}\n[SOX]\no = {{ from = \"b.m3\" }}\n",
            masses("a"),
            masses("b"),
            row("a"),
            row("b"),
            names("a", 0..12),
            names("b", 0..12)
        );
        same(&text, 800);
        assert!(scene(&text).passes.moves.iter().any(|op| op.form.folded), "{text}");
    }
}

/// A row of links: law, start as row and place in that row, reach of its links, and their number.
fn any_row(width: usize) -> impl Strategy<Value = (bool, usize, usize, usize)> {
    let reach =
        prop_oneof![3 => Just(1), 3 => Just(width), 1 => Just(width - 1), 1 => Just(width + 1), 2 => 1..4 * width];
    let long = prop_oneof![2 => Just(width), 2 => Just(width - 1), 3 => 1..6 * width];
    (any::<bool>(), (0usize..12, prop_oneof![Just(0), 0..width]), reach, long)
        .prop_map(move |(viscous, (row, at), reach, long)| (viscous, row * width + at, reach, long))
}

proptest! {
    /// Rows of any reach over each other, in any order, without the structure of a string or a mesh.
    #[test]
    fn any_rows_have_the_bits_of_their_list(
        (rows, held) in (6usize..20).prop_flat_map(|w| {
            (prop::collection::vec(any_row(w), 1..12), prop::collection::vec(0usize..12 * w, 0..3))
        }),
        mesh in prop::option::of((6usize..20, 8usize..14)), own: bool
    ) {
        let mut rows = rows;
        if let Some((width, high)) = mesh {
            rows.extend((0..high).map(|j| (true, j * width, 1, width - 1)));
            rows.push((true, 0, width, (high - 1) * width));
        }
        let last = rows.iter().map(|(_, at, reach, long)| at + reach + long).max().unwrap_or(0);
        let mut sections = std::collections::BTreeMap::<&str, String>::new();
        sections.insert("MAS", "clock = { m = 1, v = 1 }\n".into());
        for i in 0..last {
            let v = if i % 7 == 3 { ", v = 0.1" } else { "" };
            let (section, of) = match (held.contains(&i), own && i % 5 == 0) {
                (true, _) => ("SOL", String::new()),
                (_, true) => ("CEL", format!("m = \"2 g\", k = 10, z = 0.01{v}")),
                _ => ("MAS", format!("m = \"2 g\"{v}")),
            };
            let _ = writeln!(sections.entry(section).or_default(), "m{i} = {{ {of} }}");
        }
        for (r, (viscous, at, reach, long)) in rows.iter().enumerate() {
            let (law, z) = if *viscous { ("REF", ", z = 0.01") } else { ("RES", "") };
            let links = sections.entry(law).or_default();
            for i in *at..at + long {
                let _ = writeln!(links, "r{r}_{i} = {{ between = [\"m{i}\", \"m{}\"], k = 2e3{z} }}", i + reach);
            }
        }
        let mut text = String::new();
        for (name, modules) in &sections {
            let _ = writeln!(text, "[{name}]\n{modules}");
        }
        let _ = writeln!(text, "[SOX]\nout = {{ from = \"clock\" }}\nrow = {{ from = \"m{}\", channel = 1 }}", rows[0].1);
        same(&text, 200);
    }
}

/// Keys, hammers and notes written as lists, as in a piano: links from one to many and from list to list, with and
/// without offsets, the note behind its hammer in storage order. A live parameter changes, and a string is struck too.
#[test]
fn lists_have_the_bits_of_their_list() {
    for (n, z, l0) in
        [(9, "0.1", ""), (12, "0.1", ""), (17, "\"dial\"", ", l0 = \"1 mm\""), (40, "0", ", l0 = \"1 mm\"")]
    {
        let all = |name: &str| (0..n).map(|i| format!("\"{name}{i}\"")).collect::<Vec<_>>().join(", ");
        let (hammers, notes) = (all("h"), all("n"));
        let mut text = String::from(
            "[param]\ndial = { value = 0.1, unit = \"N s/m\", live = true, min = 0.05, max = 0.2 }\n[MAS]\n",
        );
        for i in 0..n {
            let _ = writeln!(text, "h{i} = {{ m = \"5 g\", x = \"-0.1 mm\", v = {} }}", 0.1 * (i % 5) as f64);
        }
        text += "[CEL]\n";
        for i in 0..n {
            let _ = writeln!(text, "n{i} = {{ m = \"2 g\", f = \"{} Hz\", t60 = \"1 s\" }}", 200 + 7 * i);
        }
        text += "bridge = { m = \"50 g\", f = \"120 Hz\" }\n[SOL]\nframe = {}\nrail = { x = \"-2 mm\" }\n";
        let _ = writeln!(
            text,
            "[REF]\nshank = {{ between = [[{hammers}], [{notes}]], k = 50, z = {z} }}\n\
             lift = {{ between = [\"rail\", [{hammers}]], k = 60, z = {z}{l0} }}\n\
             ties = {{ between = [[{notes}], \"bridge\"], k = 300, z = {z}{l0} }}\n\
             [FRO]\ncalm = {{ between = [\"frame\", [{hammers}]], z = 0.2 }}\nboard = {{ between = [\"frame\", \"bridge\"], z = 4 }}\n\
             [STRING]\ns = {{ n = 24, m = \"2 g\", k = \"40 kN/m\", z = 0.1 }}\n\
             [BUT]\nb = {{ between = [\"h3\", \"s[4]\"], k = \"20 kN/m\", z = 0.2 }}\n\
             [SOX]\nout = {{ from = \"bridge\" }}\nstring = {{ from = \"s[7]\" }}"
        );
        same(&text, 1500);
        let s = scene(&text);
        let fans = s.passes.summed().iter().filter(|op| op.form.hub != Hub::None);
        let fans: Vec<_> = fans.map(|op| (op.n, op.form.hub)).collect();
        let each = [(n, Hub::First), (n, Hub::Second), (n, Hub::First)];
        // a short fan is worth it only if no links with looked-up places precede it
        assert_eq!(fans, if n < 12 { &each[..1] } else { &each }, "{text}");
    }
}

/// The sum that a pass of forces leaves out is computed on request, and links keep their names.
#[test]
fn fused_links_keep_their_place() {
    let s = scene(&struck(24, "k = \"40 kN/m\", z = 0.1"));
    assert_eq!((s.passes.fused, s.passes.summed().len(), s.passes.forces.len()), (1, 1, 2));
    assert_eq!((s.passes.forces[0].name(), s.passes.forces[1].name()), ("BUT", "REF"));
    assert_eq!(lia_name(&s, 0, 0), "b");
    assert!(lia_name(&s, 1, 3).starts_with("s."), "{}", lia_name(&s, 1, 3));
    assert!(s.mat_name(mat(&s, "s[3]")).starts_with("s["));
}
