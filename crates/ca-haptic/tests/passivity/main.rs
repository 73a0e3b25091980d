//! H12 and H13 in the loop of an engine and a hand: injected force, energy given out, oscillations that end.
//!
//! Sensors have noise and steps, and forces are delayed by frames (docs/numerics.md §5.2, §5.3). All times count
//! frames. `CA_LONG=1` plays every case of the grid, otherwise every 41st.

use ca_compile::{Compiled, Options as Compile, compile};
use ca_core::Scene;
use ca_core::internal::border::{Delays, delays};
use ca_haptic::calibration::Calibration;
use ca_haptic::coupling::couple;
use ca_haptic::engine::{Engine, EngineCommand, Options, Port, Setup};
use ca_haptic::equivalence::gains;
use ca_haptic::frame::{DeviceFrame, ForceFrame, Mode, flag};
use ca_haptic::guard::Order;
use ca_haptic::profile::{Profile, SHIPPED};
use ca_haptic::simulated::{Device, Hand, Script};
use ca_io::gesture::{Gesture, Track};
use ca_model::read::read;
use long_form::long_form;
use std::fmt::Write as _;
use std::sync::Arc;

mod coupling;
#[path = "../../../../tests/src/long_form.rs"]
mod long_form;
#[path = "../../../../tests/src/skipped.rs"]
mod skipped;

/// Length of a gesture frame \[s\].
const FRAME_DT: f64 = 1.0 / 3000.0;

fn scene(text: &str) -> Arc<Scene> {
    Arc::new(compiled(text, &Compile::default()).scene)
}

fn compiled(text: &str, options: &Compile) -> Compiled {
    let catalog = ca_model::catalog();
    let (model, findings) = read(text, "loop.ca.toml", &catalog);
    assert!(!findings.has_errors(), "{text}");
    compile(&model, &catalog, options).expect("a scene")
}

/// Returns the setup of the device `key` with this profile for a scene.
fn setup(scene: &Scene, profile: &Profile) -> Setup {
    let (profile, gains) = (profile.clone(), gains(scene, "key"));
    Setup { device: "key".into(), profile, calibration: Calibration::default(), gains }
}

/// Compiles a scene for the device `key`, with a coupling if it needs one.
fn met(text: &str, profile: &Profile) -> Arc<Scene> {
    let (mut options, first) = (Compile::default(), compiled(text, &Compile::default()));
    let setups = [setup(&first.scene, profile)];
    let met = couple(first, &setups, &mut options, |options| Ok::<_, ()>(compiled(text, options)));
    assert!(met.too_stiff.is_empty(), "{:?}", met.messages());
    Arc::new(met.compiled.scene)
}

/// Height of a key above its wall while forces fade in, so that noise does not push \[m\].
const GAP: f64 = 1e-4;

/// A key in the middle of the travel of its device, and a lossless one-sided wall below it.
fn wall(k: f64, middle: f64) -> String {
    format!(
        "[TGR]\nkey = {{ device = \"key\", dof = 0, x = {middle:e} }}\n[SOL]\nwall = {{ x = {:e} }}\n\
         [BUT]\nstop = {{ between = [\"wall\", \"key\"], k = {k:e}, d = 0 }}\n",
        middle - GAP
    )
}

/// The same at `gesture` frames a second.
fn wall_at(gesture: u32, k: f64, middle: f64) -> String {
    format!("[rate]\ngesture = {gesture}\n{}", wall(k, middle))
}

struct Rig {
    engine: Engine,
    next: DeviceFrame,
}

impl Rig {
    fn new(scene: &Arc<Scene>, device: &str, profile: Profile) -> Rig {
        let next = DeviceFrame::new(device, profile.dof as usize);
        let (gains, calibration) = (gains(scene, device), Calibration::default());
        let port = Port::new(scene, Setup { device: device.into(), profile, calibration, gains });
        assert!(!port.links.is_empty());
        let mut engine = Engine::new(scene.clone(), vec![port], Options::default());
        engine.command(EngineCommand::Order(None, Order::Arm));
        Rig { engine, next }
    }

    /// Runs a gesture frame, with a device frame at `x` if given, whose motors held force number `ack`.
    fn go(&mut self, x: Option<&[f64]>, ack: u64) -> ForceFrame {
        if let Some(x) = x {
            self.next.seq += 1;
            self.next.ack = ack;
            self.next.t_device_ns = (self.engine.due() as f64 / 48e3 * 1e9) as u64;
            self.next.pos[..x.len()].copy_from_slice(x);
            let mut f = self.next;
            self.engine.take(0, &mut f);
        }
        let out = *self.engine.answer().next().expect("a device");
        self.engine.finish();
        out
    }

    fn injected(&self) -> [f64; 32] {
        self.engine.ports[0].hand.injected
    }
}

struct Random(u64);

impl Random {
    fn even(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        ((self.0 >> 12) as f64 + 0.5) / (1_u64 << 52) as f64
    }

    fn normal(&mut self) -> f64 {
        (-2.0 * self.even().ln()).sqrt() * (std::f64::consts::TAU * self.even()).cos()
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Move {
    /// The device is pushed onto the wall with a fifth of its force, and yields.
    Lean,
    /// Prescribed: 20 µm to and fro from frame to frame, 0.5 mm inside the wall.
    Tremble,
    /// Prescribed: slowly 1 mm into the wall, out of it at 0.3 m/s, once a second.
    Release,
    /// Prescribed: 10 Hz, 0.3 mm, 0.5 mm inside the wall.
    Tremor,
    /// Prescribed: 400 Hz, 20 µm, 0.5 mm inside the wall.
    Fast,
}

const MOVES: [Move; 5] = [Move::Lean, Move::Tremble, Move::Release, Move::Tremor, Move::Fast];

#[derive(Clone, Debug)]
struct Case {
    profile: &'static str,
    noise: f64,
    step: f64,
    /// True if the profile has this noise and step.
    known: bool,
    delay: u64,
    motion: Move,
    k: f64,
    /// Gesture frames a second.
    gesture: u32,
    /// True if the scene may be coupled to the device.
    coupling: bool,
}

struct Seen {
    /// R.m.s. force that the stage added \[N\].
    rms: f64,
    most: f64,
    /// Largest energy given to the hand by that force at any time \[J\].
    paid: f64,
    flags: u32,
    /// K κ T over the friction of the device; below 1 the loop is passive by itself.
    share: f64,
    /// Largest energy given by the whole force at any time, beyond what the friction of the device dissipated \[J\].
    out: f64,
    /// True if the key feels softer than in the model.
    softened: bool,
}

fn play(case: &Case, seconds: f64) -> Seen {
    let mut p = Profile::shipped(case.profile).expect("shipped");
    p.dof = p.axes;
    let (low, high) = (p.range[0], p.range[1]);
    let middle = 0.5 * (low + high);
    let mut real = p.clone();
    (real.body.noise, real.body.step) = (case.noise, case.step);
    if case.known {
        p = real.clone();
    }
    let n = p.dof as usize;
    p.guard.coupling = case.coupling;
    let text = wall_at(case.gesture, case.k, middle);
    let scene = if case.coupling { met(&text, &p) } else { scene(&text) };
    let frame_dt = 1.0 / f64::from(case.gesture);
    let every = (f64::from(case.gesture) / p.rate).round().max(1.0) as u64;
    let longer = every as f64;
    let own = delays(&scene);
    let d = Delays {
        spring: longer * (own.spring + (case.delay - 1) as f64 * own.frame),
        frame: own.frame * longer,
        ..own
    };
    let share = case.k / d.stiffest(p.body.friction);
    // the push acts on the first axis alone
    let push = if case.motion == Move::Lean { -0.2 * p.force } else { 0.0 };
    real.range = [low - middle, high - middle];
    let mut device = Device::new(&real, Hand::NONE, Script::Push { force: 0.0 }, 0, 5);
    let mut rig = Rig::new(&scene, "key", p.clone());
    let mut rng = Random(77);
    let (mut x, mut measured) = ([middle; 3], [middle; 3]);
    let (mut at, mut mode) = ([middle; 3], Mode::Off);
    // sent and injected forces by the number of their frame
    let mut sent = vec![[[0.0; 3]; 2]];
    let (mut begun, mut seen) = (
        None,
        Seen { rms: 0.0, most: 0.0, paid: 0.0, flags: 0, share, out: 0.0, softened: !scene.hand.couplings.is_empty() },
    );
    let (mut work, mut out) = (0.0f64, 0.0f64);
    let frames = (seconds / frame_dt) as u64;
    for frame in 0..(frames + 9000) {
        let now = begun.map_or(0, |b| frame - b);
        if now >= frames {
            break;
        }
        // a slower device sends once in `every` frames
        let comes = frame % every == 0;
        let ack = (sent.len() as u64 - 1).saturating_sub((case.delay - 1) * every);
        if comes {
            let held = sent[ack as usize];
            let t = now as f64 * frame_dt;
            if case.motion == Move::Lean {
                if begun.is_some() {
                    let force = held[0];
                    let mut all = [force[0] + push, force[1], force[2]];
                    if now == 0 {
                        all = [0.0; 3];
                    }
                    device.step(&all[..n], every as f64 * frame_dt);
                }
                for (k, x) in x.iter_mut().enumerate().take(n) {
                    *x = device.truth(k)[0] + middle;
                }
            } else if begun.is_some() {
                let turn = std::f64::consts::TAU;
                let begin = (t / 0.25).min(1.0);
                x[0] = middle
                    - begin * GAP
                    - match case.motion {
                        Move::Tremble => {
                            0.5e-3 * begin
                                + 20e-6 * rng.even() * if (frame / every).is_multiple_of(2) { 1.0 } else { -1.0 }
                        }
                        Move::Release => {
                            let phase = t.fract();
                            if phase < 0.8 { 1e-3 * phase / 0.8 } else { (1e-3 - 0.3 * (phase - 0.8)).max(0.0) }
                        }
                        Move::Tremor => begin * (0.5e-3 + 0.3e-3 * (10.0 * turn * t).sin()),
                        _ => begin * (0.5e-3 + 20e-6 * (400.0 * turn * t).sin()),
                    };
            }
            for k in 0..n {
                if begun.is_some() {
                    let moved = x[k] - at[k];
                    work += held[1][k] * moved;
                    out += held[0][k] * moved - p.body.friction * moved * moved / (every as f64 * frame_dt);
                }
                at[k] = x[k];
                let noisy = x[k] - middle + case.noise * rng.normal();
                measured[k] = middle + if case.step > 0.0 { (noisy / case.step).round() * case.step } else { noisy };
            }
            (seen.paid, seen.out) = (seen.paid.max(work), seen.out.max(out));
        }
        let f = rig.go(comes.then_some(&measured[..n]), ack);
        mode = Mode::read(f.mode);
        let injected = rig.injected();
        sent.push([[0, 1, 2].map(|k| f64::from(f.force[k])), [injected[0], injected[1], injected[2]]]);
        if begun.is_none() && mode == Mode::On {
            begun = Some(frame + 1);
        } else if begun.is_some() {
            if mode != Mode::On {
                // a wall that cannot be held passively throws the device, and forces end
                assert!(share > 1.0, "{case:?}: {mode:?} at {now}: {}", f.cause);
                break;
            }
            let size = injected[..n].iter().map(|f| f * f).sum::<f64>();
            seen.rms += size / frames as f64;
            seen.most = seen.most.max(size.sqrt());
            seen.flags |= f.flags;
        }
    }
    assert!(begun.is_some(), "{case:?}: forces are not on: {mode:?}");
    seen.rms = seen.rms.sqrt();
    seen
}

#[test]
fn h12_adds_next_to_nothing_under_noise_and_pays_nothing_out() {
    let mut cases = Vec::new();
    for (profile, _) in SHIPPED.iter().filter(|s| s.0 != "mouse") {
        for noise in [0.0, 1e-6, 5e-6] {
            for step in [1e-6, 1e-5, 6e-5] {
                for (delay, known) in [(1, true), (1, false), (2, true), (2, false)] {
                    for motion in MOVES {
                        for k in [5e2, 2e3, 6e3, 2e4] {
                            let (gesture, coupling) = (3000, false);
                            cases.push(Case { profile, noise, step, known, delay, motion, k, gesture, coupling });
                        }
                    }
                }
            }
        }
    }
    let each = if long_form("40 of 41 cases of the grid") { 1 } else { 41 };
    let (mut rms, mut paid, mut passive, mut active) = (0.0f64, 0.0f64, 0, 0);
    for case in cases.iter().step_by(each) {
        let seen = play(case, 10.0);
        if seen.share < 1.0 {
            passive += 1;
            rms = rms.max(seen.rms);
            assert!(seen.rms < 0.05, "{case:?}: {} N r.m.s.", seen.rms);
        } else {
            active += 1;
        }
        paid = paid.max(seen.paid);
        assert!(seen.paid < 1e-4, "{case:?}: {} J", seen.paid);
    }
    println!("{passive} passive, {active} not: at most {rms:.4} N r.m.s. where passive, {:.1} uJ paid out", 1e6 * paid);
    assert!(passive > 20 && active > 20);
}

/// Returns the device of docs/numerics.md §5.3, 0.2 kg and 2 N s/m, with forces on at once and no other limits.
fn e02(passivity: bool) -> Profile {
    let mut p = Profile::shipped("tgr12").expect("shipped");
    (p.dof, p.force, p.range) = (1, 100.0, [-1e3, 1e3]);
    (p.body.step, p.body.noise) = (0.0, 0.0);
    let l = &mut p.guard;
    (l.speed, l.slew, l.edge, l.passivity, l.oscillation) = (1e4, Some(1e15), 0.0, passivity, false);
    (l.clear_time, l.ramp) = (FRAME_DT, FRAME_DT);
    p
}

/// A simulated device without a hand in a loop with an engine, `delay` frames late.
struct Loop {
    rig: Rig,
    device: Device,
    sent: Vec<f64>,
    delay: usize,
    frame_dt: f64,
}

impl Loop {
    fn new(scene: &Arc<Scene>, p: &Profile, delay: usize) -> Loop {
        let frame_dt = f64::from(scene.rates.ratio) * scene.rates.sample_dt;
        let mut rig = Rig::new(scene, "key", p.clone());
        let on = (0..9000).find(|n| Mode::read(rig.go(Some(&[0.0]), *n).mode) == Mode::On);
        let sent = vec![0.0; on.expect("forces on") as usize + 2];
        Loop { rig, device: Device::new(p, Hand::NONE, Script::Push { force: 0.0 }, 0, 1), sent, delay, frame_dt }
    }

    /// Runs a frame under a push \[N\]. Returns the position of the device \[m\] and the force frame.
    fn step(&mut self, push: f64) -> (f64, ForceFrame) {
        let ack = self.sent.len() - self.delay;
        self.device.step(&[self.sent[ack] + push], self.frame_dt);
        let f = self.rig.go(Some(&[self.device.measured()[0]]), ack as u64);
        self.sent.push(f64::from(f.force[0]));
        (self.device.truth(0)[0], f)
    }
}

/// Returns the peak-to-peak motion over the last second of ten, under a push of 2 N \[m\].
fn swing(scene: &Arc<Scene>, passivity: bool, delay: usize) -> f64 {
    let mut l = Loop::new(scene, &e02(passivity), delay);
    let (mut low, mut high) = (f64::MAX, f64::MIN);
    for n in 0..30_000 {
        let (x, _) = l.step(-2.0);
        if n >= 27_000 {
            (low, high) = (low.min(x), high.max(x));
        }
    }
    high - low
}

#[test]
fn h12_a_pressed_wall_swings_nowhere_more_than_without_the_stage() {
    let mut table = String::from(
        "| wall (kN/m) | without (µm) | stage (µm) | coupling (µm) | a frame later: without | stage | coupling |\n\
         |---|---|---|---|---|---|---|\n",
    );
    let micro = |x: f64| if x < 5e-7 { "< 0.5".into() } else { format!("{:.0}", 1e6 * x) };
    for k in [3.0, 5.5, 8.0, 12.0, 20.0, 40.0] {
        let text = wall(1e3 * k, 0.0);
        let (stiff, soft) = (scene(&text), met(&text, &e02(true)));
        assert!(!soft.hand.couplings.is_empty(), "2.7 kN/m are held");
        let mut row = format!("| {k} |");
        for delay in [1, 2] {
            let s = [(&stiff, false), (&stiff, true), (&soft, true)].map(|(scene, stage)| swing(scene, stage, delay));
            assert!(s[1] <= s[0] * (1.0 + 1e-4) + 1e-9, "{k} kN/m: {s:?}");
            assert!(s[2] < 5e-7, "{k} kN/m: {s:?}");
            let _ = write!(row, " {} | {} | {} |", micro(s[0]), micro(s[1]), micro(s[2]));
        }
        table += &row;
        table.push('\n');
    }
    let page = include_str!("../../../../docs/safety.md");
    assert!(page.contains(&table), "docs/safety.md has another table than\n{table}");
}

#[test]
fn h12_a_quick_release_is_not_held_back() {
    for (k, delay) in [(5e2, 1), (5e2, 2), (2e3, 1), (2e3, 2)] {
        let case = Case {
            profile: "tgr12",
            noise: 1e-6,
            step: 1e-6,
            known: true,
            delay,
            motion: Move::Release,
            k,
            gesture: 3000,
            coupling: false,
        };
        let seen = play(&case, 5.0);
        assert!(seen.share < 1.0 && seen.most < 0.1, "{k} N/m, {delay}: {} N", seen.most);
    }
}

#[test]
fn h12_an_injection_that_gives_energy_stops_and_says_so() {
    // 400 Hz over a wall that cannot be held passively: the injection is too late to damp it
    let case = Case {
        profile: "tgr12",
        noise: 0.0,
        step: 0.0,
        known: true,
        delay: 2,
        motion: Move::Fast,
        k: 2e4,
        gesture: 3000,
        coupling: false,
    };
    let seen = play(&case, 10.0);
    assert!(seen.flags & flag::PASSIVITY != 0 && seen.flags & flag::PASSIVITY_OFF != 0, "{:b}", seen.flags);
    assert!(seen.paid > 1e-5 && seen.paid < 1e-4, "{} J", seen.paid);
}

#[test]
fn h13_a_growing_oscillation_of_400_hz_ends_within_a_fifth_of_a_second() {
    // a light device with high friction, on a spring of twice its limit b/T: cut to the largest force, the spring acts
    // as one at that limit, so that it oscillates at √(b/T/m)/2π = 421 Hz
    let spring = "[TGR]\nkey = { device = \"key\", dof = 0 }\n[SOL]\nwall = {}\n[RES]\nk = { between = [\"wall\", \"key\"], k = 120e3 }\n";
    for passivity in [true, false] {
        let mut p = e02(passivity);
        (p.body.mass, p.body.friction, p.force, p.guard.oscillation) = (0.00857, 20.0, 10.0, true);
        let mut l = Loop::new(&scene(spring), &p, 1);
        let (mut begun, mut force, mut moved) = (None, vec![], vec![]);
        for n in 0..3000 {
            let (x, f) = l.step(if n == 0 { 0.05 } else { 0.0 });
            let f = f64::from(f.force[0]);
            // the onset is a tenth of the largest force
            if begun.is_none() && f.abs() > 1.0 {
                begun = Some(n);
            }
            force.push(f);
            moved.push(x);
        }
        let begun = begun.expect("it grows");
        assert!(begun < 300, "it grows from {begun}");
        let most = |v: &[f64]| v.iter().fold(0.0, |m: f64, f| m.max(f.abs()));
        assert!(most(&force[begun..begun + 150]) > 9.9, "up to the largest force");
        let turns = force[begun..begun + 150].windows(2).filter(|w| w[0] * w[1] < 0.0).count();
        let hertz = turns as f64 / (2.0 * 150.0 * FRAME_DT);
        assert!((hertz - 400.0).abs() < 60.0, "{hertz} Hz");
        let after = begun + 600;
        let (f, x) = (most(&force[after..after + 600]), most(&moved[after..after + 600]));
        assert!(f < 0.1 && x < 1e-5, "after 0.2 s still {f} N, {x} m");
    }
}

#[test]
fn h12_twelve_keys_under_noise_are_left_alone() {
    let text = include_str!("../../../../models/hammer_piano.ca.toml");
    let scene = scene(text);
    let p = Profile::shipped("tgr12").expect("shipped");
    // one finger presses its key into the bed; eleven keys are not touched
    let track = |k: usize| {
        let to = if k == 0 { 2e-3 } else { -8e-3 };
        Track::points(format!("key {k}"), vec![(0.0, -8e-3), (1.5, -8e-3), (1.7, to)]).expect("a track")
    };
    let hands = Gesture::new((0..12).map(track).collect()).expect("a gesture");
    let mut device = Device::new(&p, Hand::finger(p.force, &p), Script::File(hands), 0, 9);
    let mut rig = Rig::new(&scene, "tgr12", p);
    let mut sent = vec![[0.0; 12]];
    let (mut sum, mut worst, mut on) = ([0.0; 12], [0.0f64; 12], 0);
    // least and largest force felt on each key
    let mut felt = [[f64::INFINITY, f64::NEG_INFINITY]; 12];
    for _ in 0..21_000 {
        let ack = sent.len().saturating_sub(2);
        let x: [f64; 12] = device.step(&sent[ack], FRAME_DT).try_into().expect("twelve keys");
        let f = rig.go(Some(&x), ack as u64);
        sent.push(core::array::from_fn(|k| f64::from(f.force[k])));
        if Mode::read(f.mode) == Mode::On && device.time() > 2.0 {
            on += 1;
            for (k, added) in rig.injected()[..12].iter().enumerate() {
                sum[k] += added * added;
                worst[k] = worst[k].max(added.abs());
                let f = -sent[sent.len() - 1][k];
                felt[k] = [felt[k][0].min(f), felt[k][1].max(f)];
            }
        }
    }
    assert!(on > 14_000, "{on} frames with forces");
    // the pressed key feels 1.5 N of the bed
    let held = -sent.last().expect("frames")[0];
    assert!(held > 1.0, "{held} N");
    for k in 0..12 {
        let rms = (sum[k] / f64::from(on)).sqrt();
        assert!(rms < 1e-3 && worst[k] < 1e-2, "key {k}: {rms} N r.m.s., {} N", worst[k]);
        // the weight of the key, and five deviations of the noise on 1.1 kN/m to each side
        let [least, most] = felt[k];
        assert!(k == 0 || (least > 0.1 && most - least < 1.1e-2), "key {k}, at rest: {least} N to {most} N");
    }
}
