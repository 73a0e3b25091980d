//! Groups at the gesture rate with `border = "compensated"`: any link may cross. The energy made at the border is that
//! of theory, and the ledger counts it.

use crate::play::{audited, mat, model, off, rel_l2, scene, within};
use ca_compile::{Options, compile};
use ca_core::internal::state::Unknown;
use ca_core::{Level, Scene, State, tick};
use ca_tests::catalog;
use faer::c64;

const GESTURE: &str = "rate = \"gesture\"\nborder = \"compensated\"";

fn frame(scene: &Scene, s: &mut State) {
    (0..scene.rates.ratio).for_each(|_| tick(scene, s));
}

/// A mass in a group and one held by a wall, joined by a non-linear kind that is linear in effect.
fn two(kind: &str, link: &str) -> String {
    format!(
        "[slow]\n{GESTURE}\n[slow.MAS]\nbig = {{ m = \"0.2 kg\", dx0 = \"1 mm\" }}\n[MAS]\nsmall = {{ m = \"10 g\" }}\n[SOL]\nwall = \
         {{}}\n[RES]\nground = {{ between = [\"wall\", \"small\"], k = \"20 kN/m\" }}\n[{kind}]\ntie = {{ between = [\"slow.big\", \
         \"small\"], {link} }}\n[SOX]\nout = {{ from = \"small\", gain = 100 }}\n"
    )
}

fn straight() -> String {
    two("CUB", "k = \"5 kN/m\", k3 = 1e-30")
}

/// The two masses in closed form: response of the sound side within a frame to straight lines of the border, and the
/// resulting motion of the group (docs/numerics.md §5.4, eq. 5).
struct TwoMasses {
    /// T²/m per tick
    small: f64,
    /// T²/M per frame
    big: f64,
    ground: f64,
    tie: f64,
    ticks: usize,
}

impl TwoMasses {
    /// Position and motion of the small mass after a frame, and the mean force on the border in that frame: the part of
    /// its first force, known in advance, and the rest.
    fn frame(&self, [mut x, mut d]: [f64; 2], from: f64, to: f64) -> ([f64; 2], [f64; 2]) {
        let mut mean = [0.0; 2];
        let part = 1.0 / self.ticks as f64;
        for j in 0..=self.ticks {
            let p = from + (to - from) * j as f64 / self.ticks as f64;
            let force = self.tie * (x - p);
            let weight = if j == 0 || j == self.ticks { 0.5 * part } else { part };
            mean[usize::from(j > 0)] += weight * force;
            if j < self.ticks {
                d -= self.small * (self.ground * x + force);
                x += d;
            }
        }
        ([x, d], mean)
    }

    /// Characteristic function: zero where z^n is a motion. `weights` belong to the forces of earlier frames.
    fn characteristic(&self, z: c64, weights: &[f64]) -> c64 {
        let real = |v: f64| c64::new(v, 0.0);
        let ([a, c], of_x) = self.frame([1.0, 0.0], 0.0, 0.0);
        let ([b, d], of_d) = self.frame([0.0, 1.0], 0.0, 0.0);
        let (stands, of_place) = self.frame([0.0; 2], 1.0, 1.0);
        let (moves, of_motion) = self.frame([0.0; 2], 0.0, 1.0);
        // the border moves by z − 1 while it is at 1
        let one = real(1.0);
        let [p, q] = [0, 1].map(|i| real(stands[i]) + (z - one) * moves[i]);
        let determinant = (z - real(a)) * (z - real(d)) - real(b * c);
        let (x, motion) = ((z - real(d)) * p + q * b, (z - real(a)) * q + p * c);
        let [known, rest] = [0, 1]
            .map(|i| x * of_x[i] + motion * of_d[i] + determinant * (real(of_place[i]) + (z - one) * of_motion[i]));
        let (mut late, mut expected) = (one, real(0.0));
        for w in weights {
            late /= z;
            expected += late * *w;
        }
        // place of the border at the start of the frame: the mean of two positions of the group
        let place = (one + one / z) * 0.5;
        determinant * (z - one) * (z - one) / z - (known + expected * rest) * place * self.big
    }

    /// Growth \[1/s\] and frequency \[rad/s\] of the mode near `w` \[rad/s\].
    fn mode(&self, w: f64, frame: f64, weights: &[f64]) -> (f64, f64) {
        let mut z = c64::new(0.0, w * frame).exp();
        for _ in 0..50 {
            let h = c64::new(1e-7, 0.0);
            let slope = (self.characteristic(z + h, weights) - self.characteristic(z - h, weights)) / (h * 2.0);
            z -= self.characteristic(z, weights) / slope;
        }
        (z.norm().ln() / frame, z.arg() / frame)
    }
}

/// Growth rate of the mode at `w` over `seconds` \[1/s\]: compares its amplitude in the first and last second, in a
/// window that suppresses other modes.
fn growth(text: &str, name: &str, w: f64, seconds: usize) -> f64 {
    let scene = scene(text);
    let at = mat(&scene, name);
    let mut s = scene.state();
    let rate = scene.rate / f64::from(scene.rates.ratio);
    let n = rate as usize;
    let part = |s: &mut State| {
        let mut sum = c64::new(0.0, 0.0);
        for i in 0..n {
            frame(&scene, s);
            let t = i as f64 / n as f64;
            let window = (std::f64::consts::PI * t).sin().powi(4);
            sum += c64::new(0.0, -w * t).exp() * (window * s.x[at]);
        }
        sum.norm()
    };
    let first = part(&mut s);
    for _ in 0..(seconds - 1) * n {
        frame(&scene, &mut s);
    }
    (part(&mut s) / first).ln() / seconds as f64
}

/// Two masses on a spring that is unknown to the border. Both modes agree with the characteristic equation.
///
/// The lowest mode decays at K²T³/2M², times 1 − 1/2R because half a tick of R is known. It would grow at KT/2M with
/// the force of the frame before, at KT/4M with the force of half a frame before.
#[test]
fn two_masses_are_those_of_the_characteristic_equation() {
    let (t, frame) = (1.0 / 48e3, 1.0 / 3e3);
    let pair = TwoMasses { small: t * t / 0.01, big: frame * frame / 0.2, ground: 2e4, tie: 5e3, ticks: 16 };
    let k = 1.0 / (1.0 / 2e4 + 1.0 / 5e3);
    let low = (k / 0.2_f64).sqrt();
    let high = (25e3 / 0.01_f64).sqrt();
    let weights = [3.0, -3.0, 1.0];
    let (slow, slow_w) = pair.mode(low, frame, &weights);
    let (fast, fast_w) = pair.mode(high, frame, &weights);
    // half a tick of the force is known at the beginning of a frame
    let unknown = 1.0 - 0.5 / 16.0;
    let loses = unknown * k * k * frame.powi(3) / (2.0 * 0.2 * 0.2);
    within("K²T³/2M²", off(slow, -loses), 0.02);
    // growth with the uncorrected force of the frame before
    let late = pair.mode(low, frame, &[1.0]).0;
    within("KT/2M", off(late, unknown * k * frame / 0.4), 0.01);
    assert!(slow.abs() < 0.005 * k * frame / 0.8, "{slow} /s against {late} /s");
    within("the lowest mode", off(growth(&straight(), "slow.big", slow_w, 60), slow), 1e-6);
    within("the other", off(growth(&straight(), "small", fast_w, 10), fast), 1e-6);
}

/// An unknown link gives a certificate that is not proven and a warning. A linear spring stays exact, and the scene has
/// the same identity as without the word.
#[test]
fn only_what_is_unknown_is_not_proven() {
    let unknown = scene(&straight());
    assert_eq!(unknown.certificate.level, Level::NotProven);
    assert!(unknown.findings.list.iter().any(|d| d.code == "W107" && d.title.contains("compensated")));
    assert!(unknown.rates.slow.as_ref().is_some_and(|g| g.compensated));
    let known = two("REF", "k = \"5 kN/m\", z = 1");
    let exact = scene(&known.replace("border = \"compensated\"\n", ""));
    let known = scene(&known);
    assert_eq!((known.certificate.level, known.findings.list.len()), (Level::Proven, 0));
    assert_eq!(known.identity(), exact.identity());
    assert!(known.rates.slow.as_ref().is_some_and(|g| !g.compensated));
    assert!(known.state().slow.is_some_and(|s| s.unknown.is_empty()));
}

/// A body that hits a spring: with shorter frames it converges to the result at the sound rate. Halving the frame
/// divides the error by at least four.
#[test]
fn a_contact_comes_to_what_it_is_at_the_sound_rate() {
    let text = |rate: &str| {
        format!(
            "[slow]\n{rate}\n[slow.MAS]\nbig = {{ m = \"20 g\", x = \"1 mm\", v = -1 }}\n[MAS]\nsmall = {{ m = \"2 g\" }}\n[SOL]\nwall \
             = {{}}\n[REF]\nground = {{ between = [\"wall\", \"small\"], k = \"20 kN/m\", z = 1 }}\n[BUT]\nhit = {{ between = \
             [\"small\", \"slow.big\"], k = \"20 kN/m\", d = 0 }}\n[SOX]\nout = {{ from = \"small\", gain = 100 }}\n"
        )
    };
    let heard = |text: &str| -> (Vec<f64>, f64) {
        let scene = audited(text);
        let mut s = scene.state();
        let mut one = || {
            tick(&scene, &mut s);
            s.output[0]
        };
        let heard = (0..2400).map(|_| one()).collect();
        let ledger = s.ledger.expect("kept");
        (heard, (ledger.groups.border / ledger.balance().peak).abs())
    };
    let (sound, nothing) = heard(&text("rate = \"sound\""));
    assert!(nothing == 0.0 && sound.iter().any(|v| v.abs() > 0.01));
    let found = [3000, 6000, 12_000, 24_000].map(|g| {
        let (x, made) = heard(&format!("[rate]\ngesture = {g}\n{}", text(GESTURE)));
        (rel_l2(&x, &sound), made)
    });
    within("at 3 kHz", found[0].0, 0.03);
    within("energy at 3 kHz", found[0].1, 0.01);
    for pair in found.windows(2) {
        within("what is left at twice the rate", pair[1].0 / pair[0].0, 0.25);
        within("of the energy", pair[1].1 / pair[0].1, 0.25);
    }
    within("at 24 kHz", found[3].0, 3e-4);
    within("energy at 24 kHz", found[3].1, 5e-5);
}

/// Linear links stay exact beside others: a spring too stiff for a frame by 100, a contact that never closes.
#[test]
fn what_is_known_stays_exact() {
    let text = |more: &str| {
        format!(
            "[slow]\n{GESTURE}\n[slow.MAS]\nbig = {{ m = \"1 g\", dx0 = \"1 mm\" }}\n[STRING]\nlow = {{ n = 30, f = \"110 Hz\", m = \
             \"4 g\" }}\n[SOL]\nwall = {{ x = -1 }}\n[RES]\ntie = {{ between = [\"slow.big\", \"low[9]\"], k = \"1000 \
             kN/m\" }}\n{more}[SOX]\nout = {{ from = \"low[3]\", gain = 100 }}\n"
        )
    };
    let exact = scene(&text(""));
    let beside = scene(&text("[BUT]\nfar = { between = [\"wall\", \"low[9]\"], k = \"1 kN/m\", d = \"1 mm\" }\n"));
    assert_eq!((exact.certificate.level, beside.certificate.level), (Level::Proven, Level::NotProven));
    let (mut a, mut b) = (exact.state(), beside.state());
    let heard = |scene: &Scene, s: &mut State| -> Vec<f64> {
        let mut one = || {
            tick(scene, s);
            s.output[0]
        };
        (0..48_000).map(|_| one()).collect()
    };
    let [a, b] = [heard(&exact, &mut a), heard(&beside, &mut b)];
    assert!(a.iter().any(|v| v.abs() > 0.01));
    within("beside a contact", rel_l2(&a, &b), 1e-9);
}

/// Two free bodies that collide across the border keep their momentum, whatever was predicted.
#[test]
fn momentum_is_kept() {
    let scene = scene(&format!(
        "[slow]\n{GESTURE}\n[slow.MAS]\nbig = {{ m = \"20 g\", x = \"1 mm\", v = -1 }}\n[MAS]\nsmall = {{ m = \"5 g\" }}\n[BUT]\nhit = \
         {{ between = [\"small\", \"slow.big\"], k = \"50 kN/m\", d = 0 }}\n[SOX]\nout = {{ from = \"small\" }}\n"
    ));
    let mut s = scene.state();
    for _ in 0..300 {
        frame(&scene, &mut s);
    }
    let frame = f64::from(scene.rates.ratio) / scene.rate;
    let big = s.slow.as_ref().expect("a group").state.d[0] / frame;
    let small = s.d[mat(&scene, "small")] * scene.rate;
    assert!(small < -1.0, "{small} m/s: they met");
    within("momentum", off(0.02 * big + 0.005 * small, -0.02), 1e-12);
}

/// Everything that only this border lets cross, at once.
const ALL: &str = r#"
[param]
slack = { value = 2, unit = "kN/m", live = true, min = 1, max = 3 }
[body]
dim = 3
rate = "gesture"
border = "compensated"
friction = "5 mN s/m"
[body.MAS]
a = { m = "20 g", x = [0, 0, 0] }
b = { m = "20 g", x = ["5 cm", 0, 0], v = [0, 0.2, 0.1] }
[arm]
rate = "gesture"
border = "compensated"
[arm.MAS]
c = { m = "50 g", x = "1 mm", v = -1 }
d = { m = "30 g" }
e = { m = "30 g" }
[space]
dim = 3
[space.MAS]
f = { m = "5 g", x = [0, "4 cm", 0] }
[plate]
method = "modal"
[plate.STRING]
bars = { n = 8, f = "200 Hz", m = "20 g", t60 = "1 s" }
[WAVEGUIDE]
pipe = { f = "150 Hz", t60 = "1 s", tension = "20 N", mu = "5 g/m", at = [0.3] }
[CEL]
bar = { m = "2 g", f = "330 Hz", t60 = "1 s" }
soft = { m = "2 g", f = "250 Hz" }
light = { m = "1 g", f = "250 Hz" }
[STRING]
low = { n = 30, f = "110 Hz", m = "4 g", t60 = "2 s" }
[ENX]
shake = {}
[ENF]
push = { to = "low[4]" }
[BUT]
hit = { between = ["bar", "arm.c"], k = "20 kN/m", z = "0.2 N s/m", d = 0 }
solved = { between = ["soft", "arm.c"], k = "50 kN/m", d = 0, method = "stable" }
[BOW]
rub = { between = ["arm.d", "low[9]"], f = "0.5 N", v0 = "0.1 m/s" }
[REF]
edge = { between = ["body.a", "body.b"], k = "2 kN/m", z = "0.1 N s/m" }
reach = { between = ["body.a", "space.f"], k = "1 kN/m", z = "0.1 N s/m" }
yields = { between = ["arm.d", "bar"], k = "1 kN/m", z = "0.1 N s/m", method = "implicit" }
gives = { between = ["arm.e", "light"], k = "1 kN/m", z = "0.1 N s/m", method = "centred" }
[RES]
tied = { between = ["arm.d", "low[2]"], k = "1 kN/m" }
turned = { between = ["arm.d", "low[4]"], k = "slack" }
held = { between = ["arm.e", "plate.bars[3]"], k = "2 kN/m" }
blown = { between = ["arm.e", "pipe[0]"], k = "1 kN/m" }
shaken = { between = ["arm.e", "shake"], k = "1 kN/m" }
[SOX]
out = { from = "low[5]", gain = 100 }
of_bars = { from = "plate.bars[1]" }
of_far = { from = "space.f", along = "y" }
of_soft = { from = "soft" }
of_bar = { from = "bar" }
of_light = { from = "light" }
of_pipe = { from = "pipe[0]" }
"#;

/// The ledger balances with every kind of link across. The energy made at the border is the force given to the group,
/// less the mean force of each frame, times its motion. At the start of a frame only half a tick of work is left at the
/// border.
#[test]
fn the_ledger_counts_what_the_border_makes() {
    for rate in ["", "oversample = 2", "gesture = \"6 kHz\""] {
        let scene = audited(&format!("[rate]\n{rate}\n{ALL}"));
        let group = scene.rates.slow.as_ref().expect("a group");
        assert!(group.compensated);
        let [shake, push] = ["shake", "push"].map(|n| scene.inputs.iter().position(|i| i.name == n).expect(n));
        let mut s = scene.state();
        let per = scene.rates.ratio as usize;
        let (mut open, mut made, mut least) = (0.0_f64, 0.0, 0.0_f64);
        let mut sums = vec![0.0; group.coupled];
        for n in 0..24_000 {
            let t = n as f64 / scene.rate;
            (s.input[shake], s.input[push]) = (1e-3 * (700.0 * t).sin(), 0.2 * (900.0 * t).sin());
            let before: Vec<f64> = s.slow.as_ref().expect("its state").ports.iter().map(|p| p.force).collect();
            tick(&scene, &mut s);
            let (slow, ledger) = (s.slow.as_ref().expect("its state"), s.ledger.as_ref().expect("kept"));
            if scene.oversample() > 1 {
                continue;
            }
            let ports = || slow.ports.iter().take(group.coupled);
            if n > 0 && (n - 1) % per == 0 {
                within("what the border made", (ledger.groups.border - made).abs(), 1e-12 * ledger.balance().peak);
                let half: f64 =
                    ports().zip(&before).map(|(p, f)| 0.5 * f * (p.to - p.from) / f64::from(scene.rates.frame)).sum();
                if n > 1 {
                    open = open.max((ledger.in_transit() - half).abs());
                }
            }
            for ((sum, p), given) in sums.iter_mut().zip(ports()).zip(&slow.state.input) {
                let ends = n % per == 0;
                *sum += if ends { 0.5 * p.force } else { p.force };
                if ends {
                    if n > 0 {
                        made += (given - *sum / per as f64) * (p.to - p.from);
                    }
                    *sum = 0.5 * p.force;
                }
            }
            least = least.max(made.abs());
        }
        let ledger = s.ledger.as_ref().expect("kept");
        let b = ledger.balance();
        assert!(b.work.abs() > 1e-6 && b.lost > 1e-4 && b.peak > 0.02, "{b:?}: nothing happened");
        assert!(ledger.groups.border.abs() > 1e-9 * b.peak, "{} J is no account", ledger.groups.border);
        assert!(scene.oversample() > 1 || least > 1e-6 * b.peak);
        within("residual", b.residual.abs() / b.peak, 1e-12);
        within("one tick", ledger.extremes.worst / b.peak, 1e-13);
        within("left at the border", open / b.peak, 1e-12);
    }
}

#[test]
fn a_snapshot_goes_on_to_the_bit() {
    let scene = scene(ALL);
    let mut s = scene.state();
    (0..1003).for_each(|_| tick(&scene, &mut s));
    let mut kept = s.clone();
    for s in [&mut s, &mut kept] {
        (0..1000).for_each(|_| tick(&scene, s));
    }
    assert_eq!(s.bits(), kept.bits());
    kept.slow.as_mut().expect("its state").unknown.fill(Unknown::default());
    assert_ne!(s.bits(), kept.bits(), "what is expected decides the next frame");
}

/// Errors name each of these links without the word, and errors within the group and a jumping key with it.
#[test]
fn what_may_cross_is_said() {
    let errors = |text: &str| match compile(&model(text), &catalog(), &Options::default()) {
        Ok(_) => Vec::new(),
        Err(found) => found.list.into_iter().filter(|d| d.code == "E034").collect(),
    };
    let exact = errors(&ALL.replace("border = \"compensated\"\n", ""));
    for name in ["hit", "solved", "yields", "gives", "rub", "reach", "turned", "plate.bars", "pipe", "shake", "low"] {
        let named = |d: &&ca_model::diag::Diag| d.title.starts_with(&format!("`{name}"));
        let d = exact.iter().find(named).unwrap_or_else(|| panic!("nothing of `{name}`"));
        assert!(d.help.as_ref().is_some_and(|h| h.contains("border = \"compensated\"")), "{d:?}");
    }
    assert!(errors(ALL).is_empty());
    let key = "[TGR]\nkey = {}\n[rate]\nborder = \"hold\"\n";
    let held = ALL.replace("[ENX]\nshake = {}\n", key).replace("\"shake\"]", "\"key\"]");
    let found = errors(&held);
    assert!(found.len() == 1 && found[0].title.starts_with("`key` is a key with"), "{found:?}");
    let inner = errors(&ALL.replace("edge = {", "edge = { method = \"implicit\","));
    assert!(inner.len() == 1 && inner[0].title.starts_with("`edge"), "{inner:?}");
}
