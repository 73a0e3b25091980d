//! Compiled scenes against mi.lib, the CORDIS-ANIMA modules of Faust.
//!
//! The programs in `peers/` are ours; the modules and the Faust compiler are not. Each program is compiled to C++ in
//! double precision, and the same network is written as a model in per-sample units. Both play one second at 48 kHz.
//! Without Faust or a C++ compiler the test is skipped.
//!
//! The two must agree to 1e-9 of the largest value, which is rounding: mi.lib stores the last two positions, we a
//! position and a step. Differences in the last digits grow in contacts and in springs whose pitch depends on
//! amplitude; with these programs and models they reach about 1e-11. The starts differ. This is handled here, not in
//! the programs:
//!
//! - A module of mi.lib gets its positions one and two samples before the first, x₋₁ and x₋₂, and its first output is
//!   already one step later. In that step the links do not act yet, even if stretched (an oscillator's own spring and
//!   gravity do). Our scenes therefore begin with the result of that step, x₀ and x₀ − x₋₁. By default our text would
//!   subtract half a step of the forces at the start, to be of second order.
//! - A link of mi.lib gets "initial delayed positions" for the speeds of its first sample. They are *added* where they
//!   should be subtracted, so that only −x₋₁ gives the right speed ([`first_samples`]).
//! - A contact ignores its threshold in that same speed; in our scenes nothing touches in the first sample.
//!
//! Two laws differ permanently, see [`a_clipped_spring`] and [`a_pluck`], and the smooth bow in its sixth digit, see
//! [`bows`].

use crate::acoustics::peak;
use crate::play::{apart, mat, off, scene, within};
use ca_core::tick;
use ca_tests::skipped::skipped;
use std::io::Write;
use std::path::PathBuf;
use std::process::{Command, Stdio};

pub const SECOND: usize = 48_000;
const SAME: f64 = 1e-9;

/// Ports and their inputs, one value per tick.
pub type Played<'a> = &'a [(&'a str, Vec<f64>)];

/// Outputs, one row each.
pub type Channels = Vec<Vec<f64>>;

fn run(command: &mut Command) -> Result<(), String> {
    let out = command.output().map_err(|e| format!("{}: {e}", command.get_program().display()))?;
    let said = String::from_utf8_lossy(&out.stderr);
    out.status.success().then_some(()).ok_or_else(|| format!("{command:?}: {said}"))
}

/// A C++ compiler, if there is also a Faust with mi.lib. Otherwise what is missing, and how it was detected.
fn tools() -> Result<&'static str, (&'static str, String)> {
    let faust = |command: &mut Command| run(command).map_err(|why| ("faust", why));
    faust(Command::new("faust").arg("--version"))?;
    let dir = tempfile::tempdir().unwrap();
    let probe = dir.path().join("probe.dsp");
    std::fs::write(&probe, "process = library(\"mi.lib\").ground(0);").unwrap();
    faust(Command::new("faust").arg(probe).arg("-o").arg(dir.path().join("probe.cpp")))?;
    let here = |c: &&str| run(Command::new(c).arg("--version")).is_ok();
    ["c++", "g++", "clang++"].into_iter().find(here).ok_or_else(|| ("c++", "no C++ compiler".into()))
}

/// Output of `peers/NAME.dsp` for one second; `None` if it cannot be compiled here.
#[track_caller]
fn by_peer(name: &str, played: Played) -> Option<Channels> {
    let here = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("peers");
    by_faust(&std::fs::read_to_string(here.join(format!("{name}.dsp"))).unwrap(), played)
}

/// Output of a Faust program for one second; `None` if it cannot be compiled here.
#[track_caller]
pub fn by_faust(text: &str, played: Played) -> Option<Channels> {
    let compiler = match tools() {
        Ok(compiler) => compiler,
        Err((needs, why)) => {
            skipped(needs, &format!("not compared with mi.lib: {why}"));
            return None;
        }
    };
    let here = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("peers");
    let dir = tempfile::tempdir().unwrap();
    let (source, program) = (dir.path().join("program.cpp"), dir.path().join("program"));
    let dsp = dir.path().join("program.dsp");
    std::fs::write(&dsp, text).unwrap();
    let mut faust = Command::new("faust");
    faust.arg("-double").arg("-a").arg(here.join("run.cpp")).arg(dsp);
    run(faust.arg("-o").arg(&source)).unwrap();
    // products and sums are rounded separately, as ours are, even if the processor could fuse them
    run(Command::new(compiler).args(["-O1", "-ffp-contract=off"]).arg(&source).arg("-o").arg(&program)).unwrap();

    let mut program = Command::new(program);
    program.arg(SECOND.to_string()).stdin(Stdio::piped()).stdout(Stdio::piped());
    let mut program = program.spawn().unwrap();
    let mut to = program.stdin.take().unwrap();
    let bytes: Vec<u8> = (0..SECOND).flat_map(|n| played.iter().flat_map(move |p| p.1[n].to_ne_bytes())).collect();
    let feeding = std::thread::spawn(move || to.write_all(&bytes));
    let out = program.wait_with_output().unwrap();
    feeding.join().unwrap().unwrap();
    assert!(out.status.success());
    let values: Vec<f64> = out.stdout.chunks_exact(8).map(|b| f64::from_ne_bytes(b.try_into().unwrap())).collect();
    assert!(!values.is_empty() && values.len().is_multiple_of(SECOND), "{} values", values.len());
    let channels = values.len() / SECOND;
    Some((0..channels).map(|c| values.iter().skip(c).step_by(channels).copied().collect()).collect())
}

/// Output of a model in per-sample units for one second. It begins at rest without displacement, except for the masses
/// in `start`, which are at x after a step d.
fn by_engine(text: &str, start: &[(&str, f64, f64)], played: Played) -> Channels {
    let scene = scene(&format!("[rate]\nsound = {SECOND}\n[model]\nunits = \"alg\"\n{text}"));
    let mut s = scene.state();
    s.x.fill(0.0);
    s.d.fill(0.0);
    for (name, x, d) in start {
        let i = mat(&scene, name);
        (s.x[i], s.d[i]) = (*x, *d);
    }
    let ports: Vec<usize> = played.iter().map(|(name, _)| scene.input(name).expect("a port")).collect();
    let mut channels = vec![Vec::with_capacity(SECOND); scene.counts.channels];
    for n in 0..SECOND {
        for (port, (_, values)) in ports.iter().zip(played) {
            s.input[*port] = values[n];
        }
        tick(&scene, &mut s);
        for (row, value) in channels.iter_mut().zip(&s.output) {
            row.push(*value);
        }
    }
    channels
}

/// Compares one row with the other, to a part of the largest value.
#[track_caller]
pub fn agree(what: &str, ours: &[f64], theirs: &[f64], tolerance: f64) {
    let top = peak(theirs);
    assert!(top > 1e-6, "{what} is silent, which compares nothing");
    within(what, apart(ours, theirs) / top, tolerance);
}

/// Compares all rows, to rounding.
#[track_caller]
fn all_agree(what: &str, ours: &[Vec<f64>], theirs: &[Vec<f64>]) {
    assert_eq!(ours.len(), theirs.len(), "{what}: outputs");
    for (i, (a, b)) in ours.iter().zip(theirs).enumerate() {
        agree(&format!("{what}, output {i}"), a, b, SAME);
    }
}

/// A smooth push, 40 ticks long.
fn push() -> Vec<f64> {
    let bell = |n: usize| 1e-3 * (std::f64::consts::PI * (n as f64 - 10.0) / 40.0).sin().powi(2);
    (0..SECOND).map(|n| if (10..50).contains(&n) { bell(n) } else { 0.0 }).collect()
}

#[test]
fn first_samples() {
    let Some(theirs) = by_peer("first", &[]) else { return };
    let [damper, contact, pluck, tied, cell] = &theirs[..] else { panic!("{} outputs", theirs.len()) };
    // a damper on an end at rest at 10, declared to have been at 3: not the force of 7, but of 10 + 3
    assert_eq!((damper[0], damper[1]), (-13.0, 0.0));
    // a contact 2 deep between ends at rest, by the rule above: its threshold is taken for a speed
    assert_eq!((contact[0], contact[1]), (2.0 + 2.0, 2.0));
    // the second end of a plucked pair is above the first and is pushed up: it is repelled
    assert_eq!(pluck[0], 0.9 * 0.5);
    // a stretched spring does not act in the first sample, an oscillator's own spring does
    assert_eq!((tied[0], tied[1]), (1.0, 0.75));
    assert_eq!((cell[0], cell[1]), (0.75, 0.3125));
    assert_eq!(tied[1..], cell[..SECOND - 1]);
}

#[test]
fn a_string() {
    let played = [("push", push())];
    let Some(theirs) = by_peer("string", &played) else { return };
    let text = "[STRING]\ns = { n = 24, m = 1, k = 0.25, z = 2e-3, zo = 1e-4 }\n[ENF]\npush = { to = \"s[4]\" }\n\
                [SOX]\na = { from = \"s[2]\" }\nb = { from = \"s[18]\" }\n";
    all_agree("a string", &by_engine(text, &[], &played), &theirs);
}

#[test]
fn a_mesh() {
    let played = [("push", push())];
    let Some(theirs) = by_peer("mesh", &played) else { return };
    let text = "[MESH]\ns = { nx = 6, ny = 5, m = 1, k = 0.1, z = 5e-5, edges = \"closed\" }\n\
                [ENF]\npush = { to = \"s[2,1]\" }\n[SOX]\na = { from = \"s[1,3]\" }\nb = { from = \"s[4,2]\" }\n";
    all_agree("a mesh", &by_engine(text, &[], &played), &theirs);
}

#[test]
fn cells_and_linear_links() {
    let Some(theirs) = by_peer("cells", &[]) else { return };
    let g = 1e-6;
    let text = format!(
        "gravity = {g:?}\n[SOL]\nwall = {{ x = 0.3 }}\n[MAS]\nb = {{ m = 0.7 }}\n[CEL]\n\
         a = {{ m = 2, k = 0.02, z = 1e-3 }}\nc = {{ m = 1, k = 5e-3, z = 2e-4 }}\n\
         [RES]\nab = {{ between = [\"wall\", \"a\"], k = 0.01, l0 = 0 }}\n\
         [FRO]\nbc = {{ between = [\"a\", \"b\"], z = 3e-3 }}\n\
         [REF]\ncd = {{ between = [\"b\", \"c\"], k = 4e-3, z = 5e-4 }}\n\
         [SOX]\nx = {{ from = \"a\" }}\ny = {{ from = \"b\" }}\nz = {{ from = \"c\" }}\n"
    );
    // the first step of mi.lib, before the links act
    let first = |k: f64, z: f64, [before, now]: [f64; 2]| {
        let x = (2.0 - k - z) * now + (z - 1.0) * before - g;
        (x, x - now)
    };
    let (a, b, c) = (first(0.01, 5e-4, [0.19, 0.2]), first(0.0, 0.0, [-0.1, -0.1]), first(5e-3, 2e-4, [-0.01, 0.0]));
    let start = [("a", a.0, a.1), ("b", b.0, b.1), ("c", c.0, c.1)];
    all_agree("cells", &by_engine(&text, &start, &[]), &theirs);
}

#[test]
fn springs_that_stiffen() {
    let Some(theirs) = by_peer("springs", &[]) else { return };
    let text = "[SOL]\nwall = {}\n[MAS]\na = { m = 1 }\nb = { m = 1 }\n\
                [CUB]\ncubic = { between = [\"wall\", \"a\"], k = 0.01, k3 = 0.2, z = 3e-4 }\n\
                [POW]\nquadratic = { between = [\"wall\", \"b\"], k = 0.01, q = 0.05, p = 2, z = 3e-4 }\n\
                [SOX]\nx = { from = \"a\" }\ny = { from = \"b\" }\n";
    all_agree("springs", &by_engine(text, &[("a", 0.5, 0.0), ("b", 0.5, 0.0)], &[]), &theirs);
}

/// The clipped cubic spring of mi.lib changes to its linear bound where the forces differ, at √(k − s)/c instead of
/// √((k − s)/c), and damps by 0.3 k beyond. We lack such a law; up to that point it is a CUB.
#[test]
fn a_clipped_spring() {
    let Some(theirs) = by_peer("clipped", &[]) else { return };
    let (s, c, k, z) = (0.01f64, 0.5f64, 0.03f64, 1e-5f64);
    let text = format!(
        "[SOL]\nwall = {{}}\n[MAS]\nsoft = {{ m = 1 }}\nloud = {{ m = 1 }}\n[CUB]\n\
         spring = {{ between = [\"wall\", [\"soft\", \"loud\"]], k = {s:?}, k3 = {c:?}, z = {z:?} }}\n\
         [SOX]\nx = {{ from = \"soft\" }}\ny = {{ from = \"loud\" }}\n"
    );
    let ours = by_engine(&text, &[("soft", 0.01, 0.01), ("loud", 0.06, 0.06)], &[]);
    agree("a clipped spring, softly", &ours[0], &theirs[0], SAME);

    let (right, wrong) = (((k - s) / c).sqrt(), (k - s).sqrt() / c);
    let (ours, theirs) = (&ours[1], &theirs[1]);
    let n = theirs.iter().position(|x| x.abs() > wrong).expect("it goes so far");
    assert!(theirs[..n].iter().any(|x| x.abs() > right), "no sample between the two points");
    agree("a clipped spring, up to the point", &ours[..=n], &theirs[..=n], SAME);
    // beyond, the sounds differ by the difference of the two laws
    let (x, v) = (theirs[n], theirs[n] - theirs[n - 1]);
    let step = (k * x + (z + 0.3 * k) * v) - (s * x + c * x.powi(3) + z * v);
    within("a clipped spring, the step at the point", off(ours[n + 1] - theirs[n + 1], step), SAME);
    assert!(step.abs() > 1e-3, "no step to speak of: {step}");
}

/// The piecewise bow is the same law. Our smooth bow uses a table of 4097 points, within 2e-6 of its peak, and the
/// motion of a bowed cell differs by as little.
#[test]
fn bows() {
    let played = [("bow", (0..SECOND).map(|n| 1.2e-3 * n as f64).collect())];
    let Some(theirs) = by_peer("bow", &played) else { return };
    let (z, scale) = (0.1, 2e-3);
    let v0 = scale / 8f64.sqrt();
    let text = format!(
        "[STRING]\ns = {{ n = 20, m = 1, k = 0.1, z = 5e-3, zo = 1e-4 }}\n\
         [CEL]\nbar = {{ m = 1, k = 2e-3, z = 1e-4 }}\n\
         [ENX]\nbow = {{}}\n[BOW]\n\
         straight = {{ between = [\"s[3]\", \"bow\"], curve = \"piecewise\", f = {:?}, v0 = {:?}, v1 = {scale:?} }}\n\
         smooth = {{ between = [\"bar\", \"bow\"], f = {:?}, v0 = {v0:?} }}\n\
         [SOX]\nx = {{ from = \"s[10]\" }}\ny = {{ from = \"bar\" }}\n",
        2.0 * z * scale / 9.0,
        scale / 3.0,
        0.63 * 0.01 * v0,
    );
    let ours = by_engine(&text, &[], &played);
    agree("a bow of straight pieces", &ours[0], &theirs[0], SAME);
    agree("a smooth bow", &ours[1], &theirs[1], 1e-5);
}

/// A few contacts in the second. Each enlarges differences in the last digits, so there should not be many more, nor
/// long flights between them, in which the positions of mi.lib lose digits.
#[test]
fn contacts() {
    let Some(theirs) = by_peer("contact", &[]) else { return };
    let text = "[CEL]\nx = { m = 3, k = 0.02, z = 1e-3 }\ny = { m = 3, k = 0.02, z = 1e-3 }\n\
                a = { m = 0.5, k = 1e-4, z = 2e-3 }\nb = { m = 0.5, k = 1e-4, z = 2e-3 }\n\
                [BUT]\nhit = { between = [[\"x\", \"y\"], [\"a\", \"b\"]], k = 0.05, z = 5e-3, d = -0.05 }\n\
                [SOX]\no0 = { from = \"x\" }\no1 = { from = \"a\" }\no2 = { from = \"y\" }\no3 = { from = \"b\" }\n";
    // thrown at 0.01, reduced by the hammer's own viscosity in the first step
    let d = (2e-3 / 0.5 - 1.0) * 0.01;
    let ours = by_engine(text, &[("a", d, d), ("b", d, d)], &[]);
    let touching: Vec<bool> = theirs[0].iter().zip(&theirs[1]).map(|(cell, hammer)| hammer - cell < -0.05).collect();
    let blows = touching.windows(2).filter(|t| !t[0] && t[1]).count();
    assert!(!touching[0] && (2..10).contains(&blows), "{blows} contacts");
    all_agree("a contact", &ours, &theirs);
}

/// The pluck of mi.lib *repels*: a plectrum pushes the string ahead until it is closer than a tenth of the reach; then
/// the string slips through and is pushed back from the other side. That is an LNL of four points. An ATT of the same
/// size pulls where this one pushes, and a PLK holds on. The pluck of mi.lib also has a viscosity within reach, which
/// the LNL lacks: it is 0 here.
#[test]
fn a_pluck() {
    let way = |n: usize| 0.6 * n.min(10_000) as f64 / 10_000.0;
    let played = [("pick", (0..SECOND).map(|n| way(n) - way(n.saturating_sub(24_000)) - 0.3).collect())];
    let Some(theirs) = by_peer("pluck", &played) else { return };
    let (k, scale) = (0.02, 0.1);
    let model = |law: &str| {
        format!(
            "[CEL]\nbar = {{ m = 1, k = 2e-3, z = 1e-4 }}\n[ENX]\npick = {{}}\n{law}[SOX]\nx = {{ from = \"bar\" }}\n"
        )
    };
    let (tip, most) = (scale / 10.0, 0.9 * k * scale / 10.0);
    let table = model(&format!(
        "[LNL]\npluck = {{ between = [\"bar\", \"pick\"], l0 = 0, \
         spring = [[{:?}, 0], [{:?}, {most:?}], [{tip:?}, {:?}], [{scale:?}, 0]] }}\n",
        -scale, -tip, -most
    ));
    let pluck = by_engine(&table, &[], &played);
    all_agree("a pluck", &pluck, &theirs);
    // the sign of the first sound shows the direction of the push
    let pulling = model(&format!(
        "[ATT]\npluck = {{ between = [\"bar\", \"pick\"], k = {:?}, d = {scale:?}, rho = 0.1 }}\n",
        0.9 * k
    ));
    let first = |row: &[f64]| row.iter().copied().find(|x| x.abs() > 1e-6).expect("a sound");
    assert!(first(&theirs[0]) > 0.0 && first(&by_engine(&pulling, &[], &played)[0]) < 0.0);
}
