//! Parameters driven by ports, against the same live parameter set once per gesture frame.

use crate::play::{audited, mat, scene, within};
use ca_core::{Controls, Patch, Refused, Scene, State, compute_forces, integrate, tick};

const STRING: &str = "[STRING]\ns = { n = 24, f = \"110 Hz\", t60 = \"3 s\", m = \"2 g\" }\n[ENX]\nbow = {}\npress = {}\n\
                      [BOW]\nhair = { between = [\"bow\", \"s[3]\"], f = \"pressure\", v0 = \"0.1 m/s\" }\n[FRO]\nfelt = { between = [\"s[0]\", \"s[9]\"], z = \"felt_z\" }\n\
                      [SOX]\nout = { from = \"s[20]\", gain = 300 }\n";
const FELT: &str = "[param]\nfelt_z = { value = 0, unit = \"N s/m\", live = true, min = 0, max = 0.1 }\n";
const DRIVEN: &str = "pressure = { port = \"press\", span = [0, \"20 mm\"], min = 0, max = \"1 N\" }\n";
const LIVE: &str = "pressure = { value = 0, unit = \"N\", live = true, min = 0, max = 1 }\n";

/// Position of the hand at a tick, from 0 to 1.
fn pressed(tick: u64) -> f64 {
    (tick as f64 / 9000.0).sin().abs()
}

fn input(scene: &Scene, name: &str) -> usize {
    scene.inputs.iter().position(|i| i.name == name).expect(name)
}

/// Plays `ticks` ticks and calls `frame` at the first tick of each gesture frame.
fn play(scene: &Scene, ticks: u64, mut frame: impl FnMut(&mut State, u64)) -> (State, Vec<f64>) {
    let (mut s, mut out) = (scene.state(), Vec::new());
    let bow = input(scene, "bow");
    for tick in 0..ticks {
        s.input[bow] = 0.2 * tick as f64 / scene.rate;
        if tick == 0 || (tick - 1).is_multiple_of(u64::from(scene.rates.ratio)) {
            frame(&mut s, tick);
        }
        compute_forces(scene, &mut s);
        out.push(s.output[0]);
        integrate(scene, &mut s);
    }
    (s, out)
}

/// The same model with a parameter set at each frame; the other parameter stays live.
#[test]
fn a_port_does_what_a_live_parameter_does() {
    let by_port = audited(&format!("{FELT}{DRIVEN}{STRING}"));
    let by_name = scene(&format!("{FELT}{LIVE}{STRING}"));
    assert_eq!(by_port.live.params.iter().map(|p| p.name.as_str()).collect::<Vec<_>>(), ["felt_z"]);
    assert_eq!((by_port.live.driven[0].port.as_str(), by_port.layout.ports.driven[0].rows), ("press", 2));
    let press = input(&by_port, "press");
    let damp = |controls: &mut Controls, s: &mut State, frame: u32, tick: u64| {
        if tick == 8001 {
            let patch = controls.set("felt_z", 0.05).expect("in range");
            assert!(s.apply(&patch, frame));
        }
    };
    let mut controls = by_port.controls();
    let (s, sound) = play(&by_port, 48_000, |s, tick| {
        s.input[press] = 0.02 * pressed(tick);
        damp(&mut controls, s, by_port.rates.frame, tick);
    });
    let (mut controls, mut patch) = (by_name.controls(), Patch::default());
    let pressure = controls.params().iter().position(|p| p.name == "pressure").expect("live");
    let (_, set) = play(&by_name, 48_000, |s, tick| {
        controls.set_indexed(pressure, pressed(tick), &mut patch).expect("in range");
        assert!(s.apply(&patch, if tick == 0 { 1 } else { by_name.rates.frame }));
        damp(&mut controls, s, by_name.rates.frame, tick);
    });
    let peak = set.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
    let apart = sound.iter().zip(&set).fold(0.0_f64, |m, (a, b)| m.max((a - b).abs()));
    assert!(peak > 0.01 && apart < 1e-9 * peak, "{apart:e} of {peak}");
    let balance = s.ledger.expect("kept").balance();
    assert!(balance.work.abs() > 0.0 && balance.residual.abs() < 1e-9 * balance.peak, "{balance:?}");
}

/// Non-linear dependences use a table of many rows: the pitch agrees with a constant one to 0.01 cents.
#[test]
fn a_pitch_by_a_port_is_in_tune() {
    let text = |f: &str, param: &str| {
        format!(
            "{param}[ENX]\nbow = {{}}\nslide = {{}}\n[CEL]\nc = {{ m = \"1 g\", f = {f}, t60 = \"100 s\", dx0 = \"1 mm\" }}\n\
             [SOX]\nout = {{ from = \"c\", gain = 300 }}\n"
        )
    };
    let pitch = "[param]\npitch = { port = \"slide\", span = [\"0.1 m\", 0], min = \"80 Hz\", max = \"160 Hz\" }\n";
    let by_port = scene(&text("\"pitch\"", pitch));
    assert_eq!(by_port.layout.ports.driven[0].rows, 257);
    let (slide, place) = (input(&by_port, "slide"), mat(&by_port, "c"));
    for at in [0.0, 0.0437, 0.0613, 0.1] {
        let (s, _) = play(&by_port, 100, |s, _| s.input[slide] = at);
        assert!(!s.ramps.is_moving(), "a port that stands changes nothing");
        let fixed = scene(&text(&format!("\"{} Hz\"", 160.0 - 800.0 * at), ""));
        // x' = (2 − a − b) x + …: the angle per tick, for equal b
        let angle = |s: &State, place: usize, n: usize| {
            let (p, q) = (s.coef[place], s.coef[n + place]);
            ((1.0 + p + q) / (2.0 * p.sqrt())).acos()
        };
        let (is, wanted) =
            (angle(&s, place, by_port.counts.n_mat), angle(&fixed.initial, mat(&fixed, "c"), fixed.counts.n_mat));
        let cents = 1200.0 * (is / wanted).log2();
        assert!(cents.abs() < 0.01, "{cents} cents at {at}");
    }
}

#[test]
fn what_a_port_drives_nobody_else_sets() {
    let by_port = scene(&format!("{FELT}{DRIVEN}{STRING}"));
    let refused = by_port.controls().set("pressure", 0.5);
    assert_eq!(refused, Err(Refused::Driven("pressure".into(), "press".into())));
    let press = input(&by_port, "press");
    let at = by_port.layout.ports.driven[0].places[0] as usize;
    for (x, force) in [(-1.0, 0.0), (1.0, 1.0), (f64::NAN, 0.0), (0.01, 0.5)] {
        let (s, _) = play(&by_port, 40, |s, _| s.input[press] = x);
        let coef = |s: &State| s.coef[by_port.live.coefs[at] as usize];
        let (full, _) = play(&by_port, 40, |s, _| s.input[press] = 0.02);
        assert_eq!(coef(&s), force * coef(&full), "at {x}");
    }
}

/// The ledger includes the energy that a port adds through a parameter it drives, from the first tick of each frame on.
#[test]
fn the_ledger_balances_while_a_port_drives() {
    for (kind, number, unit, max) in [("FRO", "z", "N s/m", 1.0), ("RES", "k", "N/m", 1000.0)] {
        let scene = audited(&format!(
            "[param]\nby_hand = {{ port = \"press\", span = [0, \"10 mm\"], unit = \"{unit}\", min = 0, max = {max} }}\n[CEL]\nb = {{ m = \"1 g\", f = 220, t60 = 3, dx0 = \"1 mm\" }}\n\
             [ENX]\npress = {{}}\n[SOL]\nw = {{}}\n[{kind}]\npad = {{ between = [\"w\", \"b\"], {number} = \"by_hand\" }}\n[SOX]\no = {{ from = \"b\" }}\n"
        ));
        let mut s = scene.state();
        for n in 0..24_000u32 {
            s.input[0] = 8e-3 * f64::from(n.saturating_sub(4800).min(2400)) / 2400.0;
            tick(&scene, &mut s);
        }
        let b = s.ledger.as_ref().expect("a ledger").balance();
        within(&format!("ledger of a driven {number}"), b.residual.abs() / b.peak, 1e-12);
        assert!(b.changed.abs() > 1e-9 * b.peak, "the port brought something: {}", b.changed);
    }
}
