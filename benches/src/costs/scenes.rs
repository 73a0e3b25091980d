//! Costs in the tick: the energy ledger, checks, filters, live parameters, measures, contacts, methods, LPR, waves and
//! ports, each in a scene with many of them.

use super::{Also, CostRow, Played, Run, Without};
use crate::{grains, string};
use ca_core::State;
use std::fmt::Write as _;

/// Number of cells, and of links of each kind.
const N: usize = 40;
const KEYS: usize = 12;

fn list(name: &str, n: usize) -> String {
    format!("[{}]", (0..n).map(|i| format!("\"{name}{i}\"")).collect::<Vec<_>>().join(", "))
}

/// `n` cells in motion, all in one output channel.
fn cells(n: usize, also: &str) -> String {
    let (mut t, mut out) = (String::from("[CEL]\n"), String::from("[SOX]\n"));
    for i in 0..n {
        let k = 400 + 100 * i;
        let _ = writeln!(t, "c{i} = {{ m = \"1 g\", k = {k}, z = 0.001, v = 0.1{also} }}");
        let _ = writeln!(out, "o{i} = {{ from = \"c{i}\", channel = 0 }}");
    }
    t + "[SOL]\nwall = {}\n" + &out
}

/// A link of this kind, with these parameters, between a wall and each of `N` cells.
fn walled(kind: &str, params: &str) -> String {
    format!("{}[{kind}]\nlink = {{ between = [\"wall\", {}], {params} }}\n", cells(N, ""), list("c", N))
}

/// `N` links of this kind, with these parameters, between the same two masses.
fn bundle(kind: &str, params: &str) -> String {
    let mut t = String::from("[SOL]\nwall = {}\n[CEL]\nbob = { m = \"1 g\", k = 8000, z = 0.001, v = 0.1 }\n");
    let _ = write!(t, "[SOX]\nout = {{ from = \"bob\" }}\n[{kind}]\n");
    for i in 0..N {
        let _ = writeln!(t, "l{i} = {{ between = [\"wall\", \"bob\"], {params} }}");
    }
    t
}

/// Heavy grains in space beside a fixed point, each tied to it by a link of this kind, or free if `kind` is empty.
fn space(kind: &str, params: &str) -> String {
    let mut t = format!(
        "[room]\ndim = 3\n[room.SOL]\nmiddle = {{}}\n[room.GRAINS]\ng = {{ n = {N}, m = 1, gap = \"5 mm\", \
         x = [\"10 cm\", 0, 0] }}\n[SOX]\nout = {{ from = \"room.g[*]\", along = \"x\", channel = 0 }}\n"
    );
    if !kind.is_empty() {
        let _ = writeln!(t, "[{kind}]\nlink = {{ between = [\"room.middle\", \"room.g[*]\"], {params} }}");
    }
    t
}

/// Fixed points or ports of this kind, each tied to a cell with an output.
fn keys(kind: &str, rate: &str) -> String {
    let mut t = format!("{rate}{}[{kind}]\n", cells(KEYS, "").replace("[SOL]\nwall = {}\n", ""));
    for i in 0..KEYS {
        let dof = if kind == "TGR" { format!("dof = {i}") } else { String::new() };
        let _ = writeln!(t, "k{i} = {{ {dof} }}");
    }
    let _ = writeln!(t, "[RES]\ntie = {{ between = [{}, {}], k = 100 }}", list("k", KEYS), list("c", KEYS));
    t
}

/// A model in which the number `from` is a parameter `k` of this value, live or not.
fn named(model: &str, from: &str, value: f64, live: bool) -> String {
    let range =
        if live { format!(", live = true, min = {}, max = {}", 0.5 * value, 2.0 * value) } else { String::new() };
    let k = format!("[param]\nk = {{ value = {value}, unit = \"N/m\"{range} }}\n");
    k + &model.replace(from, "k = \"k\"")
}

/// A string with an output on every mass, each in its own channel.
fn all_heard(more: &str) -> String {
    string(100).replace("\"s[3]\"", &format!("\"s[*]\"{more}"))
}

fn by(method: &str) -> String {
    format!("[model]\nmethod = \"{method}\"\n{}", string(100))
}

/// A string and, separate from it, a tetrahedron in space and a small mesh, all with outputs.
fn worlds() -> String {
    let heard =
        "far = { from = \"room.p[*]\", along = \"x\", dc = 0, channel = 1 }\nnear = { from = \"sheet[1,1]\" }\n";
    string(100) + heard + BODY
}

const BODY: &str = "[room]\ndim = 3\n[room.TETRA]\np = { edge = 0.02, m = 1e-3 }\n[MESH]\nsheet = { nx = 4, ny = 4, \
                    m = 1e-3, k = 1e5, edges = \"closed\" }\n[SOL]\nrim = {}\n";
const LPR: &str =
    "[LPR]\nedges = { between = [\"room.p[*]\", \"room.p[*]\"], onto = [\"rim\", \"sheet[1,1]\"], k = 2e4 }\n";
const FAR: &str = "[q]\ndim = 3\n[q.TETRA]\np = { edge = 0.02, m = 1e-3 }\n[r.SOL]\nrim = {}\n[r.MAS]\nm = { m = 1 }\n\
                   [LPR]\nlost = { between = [\"q.p[*]\", \"q.p[*]\"], onto = [\"r.rim\", \"r.m\"], k = 2e4 }\n";
const WAVES: &str = "[WAVEGUIDE]\nlow = { f = \"110 Hz\", t60 = \"4 s\", z = 1, at = [0.3] }\n";

/// A cell without an output, with a link of this kind and with these parameters to its own wall.
fn apart(kind: &str, params: &str) -> String {
    format!(
        "[q.CEL]\na = {{ m = 1e-3, k = 100 }}\n[q.SOL]\nw = {{}}\n[q.{kind}]\n\
         l = {{ between = [\"q.w\", \"q.a\"], {params} }}\n"
    )
}

/// A string of 200 masses at this rate, tied to a cell with an output.
fn slow(rate: &str) -> String {
    format!(
        "[g]\nrate = \"{rate}\"\n[g.STRING]\nlow = {{ n = 200, f = \"2 Hz\", m = \"1 g\" }}\n[CEL]\nbob = {{ m = 1e-3, k = 100, dx0 = 1e-3 }}\n\
         [RES]\ntie = {{ between = [\"g.low[99]\", \"bob\"], k = 10 }}\n[SOX]\nout = {{ from = \"bob\" }}\n"
    )
}

/// As [`apart`], in space.
fn adrift(kind: &str, params: &str) -> String {
    format!("[q]\ndim = 3\n{}", apart(kind, params).replace("k = 100", "x = [1, 0, 0]").replace("CEL", "MAS"))
}

fn run(text: impl Into<String>) -> Run {
    Run::Scene(Played::new(text))
}

fn audited(text: impl Into<String>) -> Run {
    Run::Scene(Played { energy: true, ..Played::new(text) })
}

fn doing(also: Also, text: impl Into<String>) -> Run {
    Run::Scene(Played { also, ..Played::new(text) })
}

fn row(thing: &'static str, with: &'static str, modules: usize, runs: [Run; 2], without: Without) -> CostRow {
    let [plain, used] = runs;
    CostRow { thing, with, modules: modules as f64, plain, used, without }
}

/// A row for something that can also be added without reaching an output.
fn beside(
    thing: &'static str,
    with: &'static str,
    modules: usize,
    [plain, used]: [String; 2],
    unheard: &str,
) -> CostRow {
    let without = Without::Unheard(format!("{plain}{unheard}"));
    row(thing, with, modules, [run(plain), run(used)], without)
}

/// A row for the energy ledger of a model.
fn ledger(with: &'static str, modules: usize, text: String) -> CostRow {
    let kept = Without::Absent(&["ledger", "ledger of forces"], |s| usize::from(s.ledger.is_some()));
    row("energy ledger", with, modules, [run(text.clone()), audited(text)], kept)
}

const PRESSED: &str = "k = 100, d = \"1 mm\"";
const OPEN: &str = "k = 100, d = \"-1 mm\"";
const RUBS: &str = "f = \"0.1 mN\", v0 = \"20 mm/s\"";
const DRY: &str = "curve = \"coulomb\", f = \"0.1 mN\", v0 = \"20 mm/s\"";

pub(super) fn rows() -> Vec<CostRow> {
    let mut all = checks();
    all.extend(links());
    all.extend(methods());
    all.extend(ports());
    let flush = [doing(Also::Omits("flush"), string(100)), run(string(100))];
    all.push(row("what is too small becomes 0", "a place of a string of 100", 102, flush, Without::Always));
    all
}

fn checks() -> Vec<CostRow> {
    let springs = walled("REF", "k = 7.5, z = 0.001");
    let by_name = |live: bool| named(&springs, "k = 7.5", 7.5, live);
    let idle = |text: &str| text.replace("[param]\n", "[param]\nidle = { value = 1, live = true, min = 0, max = 2 }\n");
    let live = |thing, also| {
        let runs = [run(by_name(false)), doing(also, by_name(true))];
        row(thing, "the stiffness of a spring with damper", N, runs, Without::Unheard(idle(&by_name(false))))
    };
    let watch = [run(string(100)), doing(Also::Watches, string(100))];
    let hash = [run(string(100)), doing(Also::Hashes, string(100))];
    let low_pass = ["", "[rate]\nfilter = \"18 kHz\"\n"].map(|filter| run(format!("{filter}{}", string(100))));
    vec![
        ledger("a cell", N, cells(N, "")),
        ledger("a spring with damper", N, bundle("REF", "k = 100, z = 0.001")),
        ledger("a contact that presses", N, bundle("BUT", PRESSED)),
        ledger("a waveguide of 110 Hz", 1, format!("{WAVES}[SOX]\nwave = {{ from = \"low[0]\" }}\n")),
        ledger("a device key on a spring to a cell", KEYS, keys("TGR", "")),
        row("is the state sound? (H15)", "a place of a string of 100, once a frame", 102, watch, Without::Outside),
        row("hash of the state", "a place of a string of 100, once a frame", 102, hash, Without::Outside),
        row(
            "high pass, `dc`",
            "an output",
            100,
            [run(all_heard("")), run(all_heard(", dc = \"7 Hz\""))],
            Without::Unheard(all_heard(", dc = 0")),
        ),
        row(
            "low-pass, `filter`",
            "a channel, 18 kHz",
            1,
            low_pass,
            Without::Absent(&["low pass"], |s| s.ports.lowpass.len()),
        ),
        live("live parameter, at rest", Also::Nothing),
        live("live parameter, on its way", Also::Ramps),
        row(
            "live parameter, at rest",
            "all of a string of 100, for each mass",
            100,
            [false, true].map(|live| run(named(&string(100), "k = \"100 kN/m\"", 1e5, live))),
            Without::Unheard(idle(&named(&string(100), "k = \"100 kN/m\"", 1e5, false))),
        ),
    ]
}

fn links() -> Vec<CostRow> {
    let line = || space("RES", "k = 1, along = \"x\"");
    let skew = space("RES", "k = 1, along = [0, 0.6, 0.8]");
    let flying =
        grains(64, 0.1, 0.001).replace("[SOX]", "[SOF]").replace("from = \"room.g0\"", "from = \"room.middle\"");
    let alone: String = flying.lines().filter(|l| !l.starts_with("hits")).fold(String::new(), |t, l| t + l + "\n");
    let swarm = "[q]\ndim = 3\n[q.GRAINS]\ng = { n = 20, m = 1, gap = \"5 mm\" }\n[q.BUT]\n\
                 h = { between = [\"q.g[*]\", \"q.g[*]\"], k = 1, d = \"5 mm\" }\n";
    let (inside, outside) = ("sense = \"inside\", k = 1, d = 1", "sense = \"inside\", k = 1, d = \"1 mm\"");
    let still = "k = 1, d = \"1 mm\"";
    vec![
        beside("contact on a line", "BUT, open", N, [cells(N, ""), walled("BUT", OPEN)], &apart("BUT", OPEN)),
        beside("contact on a line", "BUT that presses", N, [cells(N, ""), walled("BUT", PRESSED)], &apart("BUT", OPEN)),
        beside("contact in space", "BUT, open", N, [space("", ""), space("BUT", inside)], &adrift("BUT", still)),
        beside(
            "contact in space",
            "BUT that presses",
            N,
            [space("", ""), space("BUT", outside)],
            &adrift("BUT", still),
        ),
        beside("neighbour list", "one of 64 grains that fill a tenth", 64, [alone, flying], swarm),
        beside(
            "measure along a direction",
            "a spring in space, beside one along an axis",
            N,
            [line(), skew],
            &adrift("RES", "k = 1, along = [0, 0.6, 0.8]"),
        ),
        beside(
            "measure of a distance",
            "a spring in space, beside one along an axis",
            N,
            [line(), space("RES", "k = 1")],
            &adrift("RES", "k = 1"),
        ),
        beside("LPR", "an edge of a tetrahedron, onto a mesh", 6, [worlds(), worlds() + LPR], FAR),
        beside(
            "waveguide",
            "a string of 110 Hz with its junction, heard",
            1,
            [string(100), format!("{}wave = {{ from = \"low[0]\" }}\n{WAVES}", string(100))],
            &WAVES.replace("[WAVE", "[q.WAVE"),
        ),
    ]
}

fn methods() -> Vec<CostRow> {
    let implicit = |method: &str| apart("REF", &format!("k = 1, z = 0.001, method = \"{method}\""));
    let also = |params: &str, method: &str| format!("{params}, method = \"{method}\"");
    let cell = |method: &str| cells(N, &also("", method));
    let unheard = |method: &str| format!("[q.CEL]\na = {{ m = 1e-3, k = 100, method = \"{method}\" }}\n");
    let pressing = |kind: &str, params: &str, method: &str| {
        let plain = walled(kind, params);
        [plain.clone(), plain.replace(params, &also(params, method))]
    };
    let hertz = "k = \"1e3 N/m^1.5\", d = \"1 mm\"";
    let apart = |kind: &str, params: &str, method: &str| apart(kind, &also(params, method));
    let free = |text: String| text.replace("z = \"1 mN s/m\"", "z = 0");
    let modes = format!(
        "[low]\nmethod = \"modal\"\n{}",
        string(100).replace("STRING", "low.STRING").replace("s[3]", "low.s[3]")
    );
    let hidden = "[q]\nmethod = \"modal\"\n[q.STRING]\nt = { n = 10, m = 1e-3, k = 1e3 }\n";
    let idle = "[q]\nrate = \"gesture\"\n[q.MAS]\nm = { m = 1 }\n[q.SOL]\nw = {}\n[q.RES]\nr = { between = [\"q.w\", \"q.m\"], k = 1 }\n";
    vec![
        beside(
            "method `centred`",
            "a link of a string of 100",
            101,
            [string(100), by("centred")],
            &implicit("centred"),
        ),
        beside("method `centred`", "a cell", N, [cells(N, ""), cell("centred")], &unheard("centred")),
        beside(
            "method `implicit`",
            "a link of a string of 100",
            101,
            [string(100), by("implicit")],
            &implicit("implicit"),
        ),
        beside("method `implicit`", "a cell", N, [cells(N, ""), cell("implicit")], &unheard("implicit")),
        beside("method `modal`", "a mass of a string of 100, heard in one place", 100, [string(100), modes], hidden),
        row(
            "method `pefrl`",
            "a mass of a string of 100 and its spring",
            100,
            [run(free(string(100))), run(free(by("pefrl")))],
            Without::Absent(&["drift", "kick"], |_| 0),
        ),
        beside("method `stable`", "BUT, open", N, pressing("BUT", OPEN, "stable"), &apart("BUT", OPEN, "stable")),
        beside(
            "method `stable`",
            "BUT that presses",
            N,
            pressing("BUT", PRESSED, "stable"),
            &apart("BUT", OPEN, "stable"),
        ),
        beside(
            "method `stable`",
            "HRZ that presses",
            N,
            pressing("HRZ", hertz, "stable"),
            &apart("HRZ", hertz, "stable"),
        ),
        beside("method `stable3d`", "BUT, open", N, pressing("BUT", OPEN, "stable3d"), &apart("BUT", OPEN, "stable3d")),
        beside(
            "method `stable3d`",
            "BUT that presses",
            N,
            pressing("BUT", PRESSED, "stable3d"),
            &apart("BUT", OPEN, "stable3d"),
        ),
        beside(
            "method `stable3d`",
            "HRZ that presses",
            N,
            pressing("HRZ", hertz, "stable3d"),
            &apart("HRZ", hertz, "stable3d"),
        ),
        beside("method `secant`", "BOW", N, pressing("BOW", RUBS, "secant"), &apart("BOW", RUBS, "secant")),
        beside("method `newton`", "BOW", N, pressing("BOW", RUBS, "newton"), &apart("BOW", RUBS, "newton")),
        beside("method `set-valued`", "BOW", N, pressing("BOW", DRY, "set-valued"), &apart("BOW", DRY, "set-valued")),
        beside("group at the gesture rate", "a mass of a string of 200", 200, ["sound", "gesture"].map(slow), idle),
    ]
}

fn ports() -> Vec<CostRow> {
    let fixed = || keys("SOL", "");
    let key = |with: &'static str, rate: &str| {
        let border: fn(&State) -> usize = |s| s.ports.border.len() + s.ports.late.len();
        let without = Without::Absent(&["TGR in", "TGR out"], border);
        row("device key", with, KEYS, [run(fixed()), run(keys("TGR", rate))], without)
    };
    let mut pushed = cells(N, "") + "[ENF]\n";
    for i in 0..N {
        let _ = writeln!(pushed, "p{i} = {{ to = \"c{i}\" }}");
    }
    let moved = "[q.ENX]\np = {}\n[q.MAS]\nm = { m = 1 }\n[q.RES]\nr = { between = [\"q.p\", \"q.m\"], k = 1 }\n";
    vec![
        beside("position port", "ENX, beside a fixed point", KEYS, [fixed(), keys("ENX", "")], moved),
        beside(
            "force port",
            "ENF",
            N,
            [cells(N, ""), pushed],
            "[q.MAS]\nm = { m = 1 }\n[q.ENF]\np = { to = \"q.m\" }\n",
        ),
        key("TGR, beside a fixed point", ""),
        key("TGR, `border = \"hold\"`", "[rate]\nborder = \"hold\"\n"),
        key("TGR, `latency = 5`", "[rate]\nlatency = 5\n"),
        key("TGR, `feedback = false`", "[rate]\nfeedback = false\n"),
    ]
}
