//! Generators in space: places, starts, masses and modes.

use crate::play::{case, list, mats, num, off, reference, scene, with, within};
use ca_compile::{Options, compile};
use ca_core::internal::kind::cloud::Cloud;
use ca_core::{Scene, compute_forces};
use ca_io::cloud::{of_model, open};

/// A body in a room. A tie from the origin to every mass comes first, so the reach of the ties gives the rest places.
fn in_space(body: &str) -> String {
    format!(
        "[room]\ndim = 3\n[room.SOL]\no = {{}}\n[room.RES]\ntie = {{ between = [\"room.o\", \"room.p[*]\"], k = 1e-9 }}\n\
         {body}\n[SOX]\nout = {{ from = \"room.p[*]\", along = \"x\" }}\n"
    )
}

/// Rest places of `p[0] …`, from the origin.
fn places(body: &str, n: usize) -> Vec<[f64; 3]> {
    let scene = with(&in_space(body), &reference());
    assert_eq!(mats(&scene, "room.p").len(), n);
    (0..n).map(|i| [0, 1, 2].map(|k| scene.layout.links.reach[i][k])).collect()
}

fn norm(v: [f64; 3]) -> f64 {
    v.iter().map(|v| v * v).sum::<f64>().sqrt()
}

fn minus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|k| a[k] - b[k])
}

fn tetra(args: &str) -> String {
    format!("[room.TETRA]\np = {{ edge = \"2 cm\", m = \"1 g\", {args} }}\n")
}

#[test]
fn a_tetrahedron_is_regular_and_centred() {
    for turn in ["", ", turn = [0.3, -0.1, 0.07]", ", turn = [0, \"25 %\", 0]"] {
        let p = places(&tetra(&format!("x = [0.5, -0.25, 0.125]{turn}")), 4);
        for (i, j) in (0..4).flat_map(|i| (0..i).map(move |j| (i, j))) {
            // rest places near 0.5 m round at 1e-16
            within("an edge", off(norm(minus(p[i], p[j])), 0.02), 1e-14);
        }
        for (k, c) in [0.5, -0.25, 0.125].into_iter().enumerate() {
            within("the centre", (p.iter().map(|p| p[k]).sum::<f64>() / 4.0 - c).abs(), 1e-16);
        }
    }
    let s = 0.02 / 8f64.sqrt();
    let p = places(&tetra(""), 4);
    assert_eq!(p, [[s, s, s], [s, -s, -s], [-s, s, -s], [-s, -s, s]]);
    for (i, j) in (0..4).flat_map(|i| (0..i).map(move |j| (i, j))) {
        within("an edge around the origin", off(norm(minus(p[i], p[j])), 0.02), 1e-15);
    }
    // a quarter turn about z takes x to y exactly, and so do five
    for turns in ["25 %", "125 %", "-75 %"] {
        let q = places(&tetra(&format!("turn = [0, 0, \"{turns}\"]")), 4);
        assert!(p.iter().zip(&q).all(|(p, q)| [-p[1], p[0], p[2]] == *q), "{turns}: {q:?}");
    }
    let third = 1.0 / 3.0 / 3f64.sqrt();
    let q = places(&tetra(&format!("turn = [{third:?}, {third:?}, {third:?}]")), 4);
    for (p, q) in p.iter().zip(&q) {
        within("a third of a turn", norm(minus([p[2], p[0], p[1]], *q)), 1e-17);
    }
}

#[test]
fn a_tetrahedron_starts_as_a_rigid_body() {
    let text = in_space(&tetra("v = [1, 2, -3], spin = [\"3 Hz\", \"-1 Hz\", 2], turn = [0.1, 0.2, 0.3]"));
    let scene = with(&text, &reference());
    let (s, tau) = (scene.state(), std::f64::consts::TAU);
    let [wx, wy, wz] = [3.0 * tau, -tau, 2.0 * tau];
    for (i, at) in mats(&scene, "room.p").into_iter().enumerate() {
        let [x, y, z, _] = scene.layout.links.reach[i];
        let v = [1.0 + wy * z - wz * y, 2.0 + wz * x - wx * z, -3.0 + wx * y - wy * x];
        let d = [0, 1, 2].map(|k| s.d[at + k] / scene.rates.sample_dt);
        within("v = v₀ + ω × r", norm(minus(d, v)), 1e-14);
    }
}

#[test]
fn a_tetrahedron_weighs_what_is_asked() {
    let mobility = |body: &str| {
        let scene = scene(&in_space(body));
        let places = mats(&scene, "room.p");
        places
            .iter()
            .map(|p| scene.rates.sample_dt * scene.rates.sample_dt / scene.state().coef[2 * scene.counts.n_mat + p])
            .collect::<Vec<f64>>()
    };
    let each = mobility(&tetra(""));
    let shared = mobility("[room.TETRA]\np = { edge = 0.1, m_total = \"2 g\" }\n");
    assert_eq!(each.len(), 4);
    for (a, b) in each.iter().zip(&shared) {
        within("1 g each", off(*a, 1e-3), 1e-15);
        within("2 g together", off(*b, 0.5e-3), 1e-15);
    }
}

/// Force on the masses of `p` per metre of the small displacements `u`.
fn stiffness(scene: &Scene, u: &[[f64; 3]], by: f64) -> Vec<[f64; 3]> {
    let at = mats(scene, "room.p");
    let force = |by: f64| {
        let mut s = scene.state();
        for (at, u) in at.iter().zip(u) {
            (0..3).for_each(|k| s.x[at + k] = by * u[k]);
        }
        compute_forces(scene, &mut s);
        at.iter().map(|at| [0, 1, 2].map(|k| s.f[at + k])).collect::<Vec<_>>()
    };
    let (plus, minus) = (force(by), force(-by));
    plus.iter().zip(&minus).map(|(p, m)| [0, 1, 2].map(|k| (p[k] - m[k]) / (2.0 * by))).collect()
}

#[test]
fn d05_modes_of_a_tetrahedron() {
    let scene = with(
        "[room]\ndim = 3\n[room.TETRA]\np = { edge = 1, m = 1, k = 1 }\n[SOX]\nout = { from = \"room.p[*]\", along = \"x\" }\n",
        &reference(),
    );
    let s = 1.0 / 8f64.sqrt();
    let corners = [[s, s, s], [s, -s, -s], [-s, s, -s], [-s, -s, s]];
    // strains: breathing, shears of the cube's faces, stretches of the cube at constant volume
    let strains: [fn([f64; 3]) -> [f64; 3]; 6] = [
        |[x, y, z]| [x, y, z],
        |[x, y, _]| [y, x, 0.0],
        |[x, _, z]| [z, 0.0, x],
        |[_, y, z]| [0.0, z, y],
        |[x, y, z]| [2.0 * x, -y, -z],
        |[_, y, z]| [0.0, y, -z],
    ];
    for (strain, lambda) in strains.into_iter().zip(list(case("D05"), "values/lam")) {
        let u = corners.map(strain);
        for (f, u) in stiffness(&scene, &u, 3e-6).into_iter().zip(u) {
            within("D05 F = −λ u", norm(minus(f, u.map(|u| -lambda * u))), num(case("D05"), "tolerance/abs"));
        }
    }
    for rigid in [|_: [f64; 3]| [1.0, 2.0, -1.0], |[x, y, _]: [f64; 3]| [-y, x, 0.0]] {
        within(
            "D05 zero",
            stiffness(&scene, &corners.map(rigid), 3e-6).into_iter().map(norm).fold(0.0, f64::max),
            1e-10,
        );
    }
}

/// Corners of a square pyramid, with the top twice. The faces are its sides and base, and one without area.
const CORNERS: [[f64; 3]; 6] =
    [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0], [0.5, 0.5, 0.75], [0.5, 0.5, 0.75]];
const FACES: [&[u32]; 6] = [&[0, 1, 2, 3], &[0, 1, 4], &[1, 2, 5], &[2, 3, 4], &[3, 0, 5], &[4, 5, 0]];

fn pyramid() -> Cloud {
    let edges = vec![[0, 1], [0, 3], [0, 4], [1, 2], [1, 4], [2, 3], [2, 4], [3, 4]];
    Cloud { points: CORNERS[..5].to_vec(), edges, merged: 1, flat: 1 }
}

fn words(f: &[u32], word: impl Fn(u32) -> String) -> String {
    f.iter().map(|i| word(*i)).collect()
}

/// The pyramid as PLY: a header, then text, or binary with numbers encoded by `number` and `index`.
fn ply(format: &str, number: fn(f32) -> [u8; 4], index: fn(u32) -> [u8; 4]) -> Vec<u8> {
    let mut out = format!(
        "ply\nformat {format} 1.0\ncomment a pyramid\nelement vertex 6\nproperty float x\nproperty float y\n\
         property float z\nproperty uchar red\nelement face 6\nproperty list uchar uint vertex_indices\nend_header\n"
    )
    .into_bytes();
    let text = format == "ascii";
    for p in CORNERS {
        if text {
            out.extend(format!("{} {} {} 255\n", p[0], p[1], p[2]).bytes());
        } else {
            out.extend(p.into_iter().flat_map(|v| number(v as f32)));
            out.push(255);
        }
    }
    for f in FACES {
        if text {
            out.extend(format!("{}{}\n", f.len(), words(f, |i| format!(" {i}"))).bytes());
        } else {
            out.push(f.len() as u8);
            out.extend(f.iter().flat_map(|i| index(*i)));
        }
    }
    out
}

fn obj() -> String {
    let v = CORNERS.map(|[x, y, z]| format!("v {x} {y} {z}\n")).concat();
    // indices from 1 with texture and normal indices, or backwards from −1
    let face = |f: &[u32]| format!("f{}\n", words(f, |i| format!(" {}/1/7", i + 1)));
    let back = |f: &[u32]| format!("f{}\n", words(f, |i| format!(" {}", i64::from(i) - 6)));
    let (head, tail) = FACES.split_at(3);
    let f: String = head.iter().map(|f| face(f)).chain(tail.iter().map(|f| back(f))).collect();
    format!("# a pyramid\no pyramid\n{v}vn 0 0 1\nusemtl stone\n{f}")
}

#[test]
fn every_format_gives_the_same_cloud() {
    let dir = tempfile::tempdir().unwrap();
    let put = |name: &str, bytes: &[u8]| {
        let path = dir.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        open(&path).unwrap_or_else(|e| panic!("{e}"))
    };
    assert_eq!(put("a.ply", &ply("ascii", f32::to_le_bytes, u32::to_le_bytes)), pyramid());
    assert_eq!(put("l.PLY", &ply("binary_little_endian", f32::to_le_bytes, u32::to_le_bytes)), pyramid());
    assert_eq!(put("b.ply", &ply("binary_big_endian", f32::to_be_bytes, u32::to_be_bytes)), pyramid());
    assert_eq!(put("a.obj", obj().as_bytes()), pyramid());
    // lines join consecutive points and are not closed
    let lines = put("l.obj", b"v 0 0 0\nv 1 0 0\nv 2 0 0\nv -0 0 0\nl 1 2 3\nl 3 2\n");
    assert_eq!((lines.points.len(), lines.edges, lines.merged), (3, vec![[0, 1], [1, 2]], 1));
    let edges = "ply\nformat ascii 1.0\nelement vertex 2\nproperty double x\nproperty double y\nproperty double z\n\
                 element edge 1\nproperty int vertex1\nproperty int vertex2\nend_header\n0 0 0\n0.1 0 0\n1 0\n";
    let edges = put("e.ply", edges.as_bytes());
    assert_eq!((edges.points, edges.edges), (vec![[0.0; 3], [0.1, 0.0, 0.0]], vec![[0, 1]]));
    // strips of triangles, separated by −1; a triangle without area still flips the orientation
    let strips = "ply\nformat ascii 1.0\nelement vertex 6\nproperty float x\nproperty float y\nproperty float z\n\
                  element tristrips 1\nproperty list int int vertex_indices\nend_header\n\
                  0 0 0\n1 0 0\n0 1 0\n1 1 0\n0 2 0\n1 2 0\n9 0 1 2 2 -1 3 4 5 5\n";
    let strips = put("s.ply", strips.as_bytes());
    assert_eq!((strips.edges, strips.flat), (vec![[0, 1], [0, 2], [1, 2], [3, 4], [3, 5], [4, 5]], 0));
    // line ends `\r` and `\r\n`, in text and before binary data
    let text = ply("ascii", f32::to_le_bytes, u32::to_le_bytes);
    for end in ["\r", "\r\n"] {
        let ended = String::from_utf8(text.clone()).unwrap().replace('\n', end);
        assert_eq!(put("r.ply", ended.as_bytes()), pyramid());
        assert_eq!(put("r.obj", obj().replace('\n', end).as_bytes()), pyramid());
        let binary = ply("binary_little_endian", f32::to_le_bytes, u32::to_le_bytes);
        let at = binary.windows(11).position(|w| w == b"end_header\n").unwrap() + 11;
        let head = String::from_utf8(binary[..at].to_vec()).unwrap().replace('\n', end);
        assert_eq!(put("rb.ply", &[head.as_bytes(), &binary[at..]].concat()), pyramid());
    }
    // a continuation over several lines, and one at the end of the file
    let long = put("c.obj", b"v 0 \\\n 0 \\\r\n0\nv 1 0 0\nv 0 1 0 # \\\nf 1 2 \\\n\\\n3 \\");
    assert_eq!((long.points.len(), long.edges.len()), (3, 3));
    let rows = CORNERS.map(|[x, y, z]| format!("7,{z},{x},{y}\n")).concat();
    let plain = CORNERS.map(|[x, y, z]| format!("{x}, {y}, {z}\n")).concat();
    let points = Cloud { edges: Vec::new(), flat: 0, ..pyramid() };
    assert_eq!(put("h.csv", format!("id,Z,x,y\n{rows}").as_bytes()), points);
    assert_eq!(put("p.csv", format!("# plain\n{plain}").as_bytes()), points);
    assert_eq!(put("t.csv", format!(" \n{}", plain.replace('\n', ",\n \n,,\n")).as_bytes()), points);
    assert_eq!(put("u.csv", format!("x,y,z,\n{}", plain.replace('\n', ",\n")).as_bytes()), points);
}

#[test]
fn files_that_are_no_clouds_say_why() {
    let dir = tempfile::tempdir().unwrap();
    let said = |name: &str, bytes: &[u8]| {
        let path = dir.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        let text = open(&path).expect_err(name).to_string();
        text.replace(&format!("`{}`", path.display()), "it")
    };
    let header = "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\n";
    let list = "element face 1\nproperty list uchar int vertex_indices\nend_header\n";
    assert!(said("a.ply", b"solid\n").starts_with("it, line 1: "), "{}", said("a.ply", b"solid\n"));
    assert_eq!(
        said("b.ply", format!("{header}end_header\n0 0\n1 1\n").as_bytes()),
        "it: its points lack `z`; export x, y and z"
    );
    let short = said("c.ply", format!("{header}property float z\n{list}0 0 0\n1 1 1\n").as_bytes());
    assert!(short.starts_with("it"), "{short}");
    let face = said("d.ply", format!("{header}property float z\n{list}0 0 0\n1 1 1\n3 0 1 2\n").as_bytes());
    assert_eq!(face, "it: a face uses point 2, which does not exist; the points are counted from 0, and there are 2");
    let nan = said("e.ply", format!("{header}property float z\nend_header\n0 0 0\n1 nan 1\n").as_bytes());
    assert!(nan.contains("not finite") || nan.contains("line 9"), "{nan}");
    let huge = header.replace("vertex 2", "vertex 4000000000");
    let huge = said("f.ply", format!("{huge}property float z\nend_header\n").as_bytes());
    assert_eq!(huge, "it: it has 4000000000 points, but a model can have at most 1000000; reduce its number of points");
    assert_eq!(
        said("a.obj", b"v 0 0 0\nf 1 2 3\n"),
        "it, line 2: `2` is not the number of a point; points are counted from 1 and defined before they are used"
    );
    assert_eq!(said("b.obj", b"v 0 zero 0\n"), "it, line 1: `zero` is not a number; write a point as `v x y z`");
    assert_eq!(said("c.obj", b"v 0 0\n"), "it, line 1: a number is missing; write a point as `v x y z`");
    assert_eq!(said("d.obj", b"f 1 2 3\n").split(';').next(), Some("it, line 1: `1` is not the number of a point"));
    assert_eq!(said("e.obj", b""), "it: it contains no points");
    let number = "write it like `-1.5e-3`, without a unit";
    assert_eq!(said("a.csv", b"x,y,z\n0,0,1 cm\n"), format!("it, line 2, column 3: `1 cm` is not a number; {number}"));
    assert_eq!(said("b.csv", b"x,y,z\n0,inf,1\n"), format!("it, line 2, column 2: `inf` is not a number; {number}"));
    assert_eq!(said("c.csv", b"0,0,0\n0,0\n"), format!("it, line 2, column 3: the number is missing; {number}"));
    assert!(said("d.csv", b"x;y;z\n").contains("neither three numbers nor a header"));
    let columns = "separate columns by commas and write decimals with a point";
    for (text, line) in [("x,y,z\n0,1,0,0\n", 2), ("0,0,0\n\n0,1,0,0\n", 3), ("0,0,0\n0,1,0,1,0,1\n", 2)] {
        let n = text.lines().last().unwrap().split(',').count();
        let want = format!("it, line {line}: the row has {n} cells, but the first row has 3; {columns}");
        assert_eq!(said("comma.csv", text.as_bytes()), want);
    }
    assert!(said("comma.csv", b"0,1,0,0\n").ends_with(columns));
    assert_eq!(
        said("comma.obj", b"v 0 0 0\nv 0,1 0 0\n"),
        "it, line 2: `0,1` is not a number; write decimals with a point, as in `0.1`"
    );
    let body = format!("{header}property float z\nend_header\n");
    let comma = said("comma.ply", format!("{body}\n0 0 0\n1 0,5 1\n").as_bytes());
    assert_eq!(comma, "it, line 10: `0,5` is not a number; write decimals with a point, as in `0.1`");
    let anew = "export it again, as text or binary PLY";
    let short = said("short.ply", format!("{body}0 0 0\n1 \u{1b}[2J\n").as_bytes());
    assert_eq!(short, format!("it, line 9: `1 \\u{{1b}}[2J` is not a `vertex` with the properties x, y, z; {anew}"));
    let early = said("early.ply", format!("{body}0 0 0\n").as_bytes());
    assert_eq!(early, format!("it: it ends before the last of its 2 elements `vertex`; {anew}"));
    let endless = said("endless.ply", header.as_bytes());
    assert_eq!(endless, format!("it: its header lacks `end_header`; {anew}"));
    let odd = said("odd.ply", b"ply\nformat ascii 1.0\n\nelement\nend_header\n");
    assert_eq!(odd, format!("it, line 4: `element` is not a header line; {anew}"));
    assert_eq!(
        said("a.stl", b""),
        "it: points cannot be read from a file with this extension; use `.ply`, `.obj` or `.csv`"
    );
    assert!(open(dir.path().join("none.ply")).unwrap_err().to_string().contains("cannot be read"));
}

#[test]
fn a_cloud_becomes_masses_and_springs() {
    let dir = tempfile::tempdir().unwrap();
    std::fs::write(dir.path().join("pyramid.obj"), obj()).unwrap();
    let build = |body: &str| {
        let model = crate::play::model(&in_space(body));
        let clouds = of_model(&model, &ca_tests::catalog(), dir.path());
        compile(&model, &ca_tests::catalog(), &Options { clouds, ..reference() })
    };
    let args = "file = \"pyramid.obj\", scale = \"20 %\", m_total = \"10 g\", k = 100, x = [1, 0, 0], v = [0, 3, 0]";
    let scene = build(&format!("[room.CLOUD]\np = {{ {args}, turn = [0, 0, \"25 %\"] }}\n")).unwrap();
    let at = mats(&scene, "room.p");
    assert_eq!((at.len(), scene.counts.n_lia), (5, 5 + 8));
    let s = scene.state();
    // the springs of the cloud come first, then the ties to the origin
    for (i, [x, y, z]) in CORNERS[..5].iter().enumerate() {
        let rest = [0, 1, 2].map(|k| scene.layout.links.reach[8 + i][k]);
        within("at its place", norm(minus(rest, [1.0 - 0.2 * y, 0.2 * x, 0.2 * z])), 1e-15);
        within("thrown", (s.d[at[i] + 1] / scene.rates.sample_dt - 3.0).abs(), 1e-14);
        within(
            "a fifth of the whole",
            off(scene.rates.sample_dt * scene.rates.sample_dt / s.coef[2 * scene.counts.n_mat + at[i]], 2e-3),
            1e-15,
        );
    }
    assert!(scene.findings.list.iter().any(|d| d.code == "N202"), "{}", scene.findings);
    // with `reach`: the sides of the square, but not its diagonals nor the slanting edges of 1.03
    let near = build(&format!("[room.CLOUD]\np = {{ {args}, reach = 0.2001 }}\n")).unwrap();
    assert_eq!(near.counts.n_lia, 5 + 4);
    assert_eq!(build("[room.CLOUD]\np = { file = \"pyramid.obj\", m = 1 }\n").unwrap().counts.n_lia, 5);
    let missing = build("[room.CLOUD]\np = { file = \"cone.obj\", m = 1 }\n").unwrap_err();
    assert!(missing.list.iter().any(|d| d.code == "E031" && d.title.contains("cone.obj") && d.span().is_some()));
    std::fs::write(dir.path().join("empty.ply"), "ply\n").unwrap();
    for (name, path) in [("cone.obj", true), ("empty.ply", false)] {
        let found = build(&format!("[room.CLOUD]\np = {{ file = \"{name}\", m = 1 }}\n")).unwrap_err();
        let help = found.list.iter().find(|d| d.code == "E031").and_then(|d| d.help.clone()).expect("help");
        assert_eq!(help.contains("paths are relative to"), path, "{help}");
    }
}

#[test]
fn neighbours_are_all_pairs_that_are_near() {
    let mut rng = crate::play::Random(5);
    let points: Vec<[f64; 3]> = (0..200).map(|_| [0; 3].map(|_| rng.uniform())).collect();
    let cloud = Cloud { points: points.clone(), ..Cloud::default() };
    let pairs = (0..200u32).flat_map(|i| (i + 1..200).map(move |j| [i, j]));
    let near: Vec<[u32; 2]> =
        pairs.filter(|[i, j]| norm(minus(points[*i as usize], points[*j as usize])) <= 0.4).collect();
    assert!(near.len() > 100);
    assert_eq!(cloud.pairs_within(0.4, near.len()).as_ref(), Some(&near));
    assert_eq!(cloud.pairs_within(0.4, near.len() - 1), None);
}

/// Displaces a mesh in its lowest mode along `axis`. Returns the stiffness, the deviation from the mode, and the scene.
fn across(body: &str, nx: usize, ny: usize, axis: usize) -> (f64, f64, Scene) {
    let text = format!(
        "[room]\ndim = 3\n[room.MESH]\np = {{ nx = {nx}, ny = {ny}, edges = \"closed\", {body} }}\n[SOX]\nout = {{ from = \"room.p[1,1]\", along = \"z\" }}\n"
    );
    let scene = scene(&text);
    let name = |i: usize, j: usize| crate::play::mat(&scene, &format!("room.p[{i},{j}]"));
    let shape = |i: usize, j: usize| {
        let pi = std::f64::consts::PI;
        (pi * i as f64 / (nx - 1) as f64).sin() * (pi * j as f64 / (ny - 1) as f64).sin()
    };
    let inner: Vec<(usize, usize)> = (1..nx - 1).flat_map(|i| (1..ny - 1).map(move |j| (i, j))).collect();
    let mut s = scene.state();
    let by = 1e-7;
    for (i, j) in &inner {
        s.x[name(*i, *j) + axis] = by * shape(*i, *j);
    }
    compute_forces(&scene, &mut s);
    let (mut projected, mut square) = (0.0, 0.0);
    for (i, j) in &inner {
        projected -= s.f[name(*i, *j) + axis] * shape(*i, *j) / by;
        square += shape(*i, *j) * shape(*i, *j);
    }
    let stiffness = projected / square;
    let stray = inner.iter().map(|(i, j)| (s.f[name(*i, *j) + axis] / by + stiffness * shape(*i, *j)).abs());
    (stiffness, stray.fold(0.0, f64::max) / stiffness, scene.scene)
}

#[test]
fn a_stretched_mesh_sounds_across_as_asked() {
    let pi = std::f64::consts::PI;
    for (stretch, shear) in [(0.1, ""), (0.5, ", shear = 300"), (1.0, "")] {
        let (stiffness, stray, _) =
            across(&format!("m = 1e-3, k = 2e4, dx = 0.01, stretch = {stretch}{shear}"), 7, 5, 2);
        let want = 4.0 * 2e4 * stretch * ((pi / 12.0).sin().powi(2) + (pi / 8.0).sin().powi(2));
        within("stiffness across", off(stiffness, want), 1e-7);
        within("it is a mode", stray, 1e-7);
        let (stiffness, _, scene) =
            across(&format!("m = 1e-3, f = 220, dx = 0.01, stretch = {stretch}{shear}"), 7, 5, 2);
        let half = 0.5 * scene.rates.sample_dt * (stiffness / 1e-3).sqrt();
        within("f", off(half.asin() / (pi * scene.rates.sample_dt), 220.0), 1e-7);
    }
    // turned up, it moves along y; and a period of the lowest mode returns to its start
    let (stiffness, _, scene) =
        across("m = 1e-3, f = 220, dx = 0.01, stretch = 0.5, turn = [\"-25 %\", 0, 0]", 7, 5, 1);
    within(
        "turned",
        off((0.5 * scene.rates.sample_dt * (stiffness / 1e-3).sqrt()).asin() / (pi * scene.rates.sample_dt), 220.0),
        1e-7,
    );
}

#[test]
fn probes_are_called_by_the_modules_they_hear() {
    let probe = |text: &str, probes: &[&str]| {
        let options = Options { probes: probes.iter().map(|p| (*p).into()).collect(), ..Options::default() };
        let scene = with(text, &options);
        (scene.names.probe_names.clone(), scene.names.probe_of.clone())
    };
    let (names, of) = probe(&in_space(&tetra("k = 1000")), &["room.p[*]", "room.p[2]", "room.p.link[1..3]"]);
    let want: Vec<String> = (0..4).flat_map(|i| ["x", "y", "z"].map(|a| format!("room.p[{i}].{a}"))).collect();
    assert_eq!(names[..12], want);
    assert_eq!(names[12..], ["room.p[2].x", "room.p[2].y", "room.p[2].z", "room.p.link[1]", "room.p.link[2]"]);
    assert_eq!(of[11..], [0, 1, 1, 1, 2, 2]);
    let string = "[STRING]\nlow = { n = 5, f = 100, m = 1e-3 }\n[RES]\nnone = { between = [\"low[0]\", \"low[1]\"], k = 0 }\n\
                  [SOX]\nout = { from = \"low[0]\" }\n";
    let (names, of) = probe(string, &["low[1..3]", "low.link[*]", "none", "low[-1]"]);
    assert_eq!(names[..3], ["low[1]", "low[2]", "low.link[0]"]);
    // a module without effect gets neither a column nor a gap
    assert_eq!((names.last().map(String::as_str), of.last(), of.contains(&2)), (Some("low[-1]"), Some(&3), false));
    let options = Options { probes: vec!["none".into(), "low[1]".into()], ..Options::default() };
    let scene = with(string, &options);
    assert_eq!(scene.counts.n_out, 2);
    let mut s = scene.state();
    s.x[crate::play::mat(&scene, "low[1]")] = 0.25;
    ca_core::tick(&scene, &mut s);
    assert_eq!(s.output[1], 0.25);
}
