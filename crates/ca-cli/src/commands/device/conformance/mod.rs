//! `ca device conformance`: whether a device process keeps what the engine relies on.
//!
//! Decides to look only at what the device says on its lines, since that is all an engine has: no driver is opened, no
//! code of the device is linked. The script plays a whole life: silence, an engine at rest, small forces, an engine that
//! dies, another one, one that was never at rest, frames that are not for it. Forces go through the real guard, with the
//! device's own numbers as limits. What the device does not tell (measured forces are optional) is not held against it.

mod bench;

use crate::args::ConformanceArgs;
use crate::term::short;
use crate::{Ended, Failure, Outcome, store, term};
use bench::{Bench, Player};
use ca_haptic::frame::{About, Cause, DOF, DeviceFrame, ForceFrame, Mode, status, text};
use ca_haptic::guard::Order;
use ca_haptic::guard::wait::Wait;
use ca_haptic::host::Site;
use ca_haptic::profile::Profile;
use ca_haptic::rt::{self, Wish};
use ca_model::quantity::Plain;
use serde_json::json;
use std::io::Write as _;

/// Frames of the device that are looked at in a phase.
const LOOK: usize = 200;
/// Engine frames of a phase at rest.
const REST: u32 = 600;
/// How long a device may take for its first word, and for a phase \[ns\].
const PATIENCE: u64 = 5_000_000_000;
/// What is wrong with a force frame, and how it is made so.
type Wrong = (&'static str, fn(&mut ForceFrame));

/// How often forces are tried to be on: a machine that is busy trips watchdogs, which is not the device's fault.
const TRIES: u32 = 8;
/// The most that a force may live \[s\], in tries after a watchdog; what no device outlives is 0.1 s.
const PATIENT: f64 = 0.08;
/// Frames of the device until a spring that is new has its stiffness.
const RISE: usize = 10;
/// How much more than the force of the stretched spring a device may come to feel, which swings about its rest.
const BEYOND: f64 = 1.5;
/// ... and how much the guard may add, as part of the largest force of the device.
const GUARD: f64 = 0.1;
/// Added to the number of a frame that must not be used, so that it is known again.
const FAR: u64 = 1_000_000;

/// One thing that is asked of a device.
struct Row {
    name: &'static str,
    pass: bool,
    found: String,
}

/// The table.
#[derive(Default)]
struct Table(Vec<Row>);

impl Table {
    fn row(&mut self, name: &'static str, pass: bool, found: impl Into<String>) {
        self.0.push(Row { name, pass, found: found.into() });
    }
}

/// Runs the command.
pub fn run(args: &ConformanceArgs) -> Outcome {
    if !(args.force >= 0.0 && args.force.is_finite()) {
        return Err(Failure::Usage("--force is 0 or more newtons".into()));
    }
    let calibration = store::calibration_of(&args.name, &[])?;
    let mut bench = Bench::open(&Site::of_user()?, &args.name, calibration)?;
    rt::ask(Wish { priority: Some(70), ..Wish::default() });
    let mut table = Table::default();
    if let Some(about) = presented(&mut bench, &mut table)? {
        let mut profile = profile(&about);
        let force = args.force.min(0.05 * profile.force) / f64::from(profile.axes);
        // nothing of the guard's own is stronger: no edge, and a brake that is as weak as the pull
        profile.guard.edge = 0.0;
        profile.guard.brake = force / profile.guard.speed;
        if force > 0.0 && !args.json {
            term::note(&format!("`{}` is given forces of up to {} N", args.name, short(force)));
        }
        alive(&mut bench, &about, &mut table);
        served(&mut bench, &args.name, &about, &mut table)?;
        let mut player = bench.player(&profile)?;
        rest(&mut bench, &mut player, &mut table);
        let on = forces(&mut bench, &mut player, &mut profile, force, &mut table)?;
        if on {
            felt(&mut bench, &mut player, &mut profile, force, &mut table)?;
            silence(&mut bench, &about, &mut table);
        }
        another(&mut bench, &mut profile, force, &mut table)?;
        strangers(&mut bench, &mut table);
    }
    print(&table, args)
}

fn print(table: &Table, args: &ConformanceArgs) -> Outcome {
    let failed = table.0.iter().filter(|r| !r.pass).count();
    let mut out = std::io::stdout().lock();
    if args.json {
        let rows: Vec<_> = table.0.iter().map(|r| json!({"name": r.name, "pass": r.pass, "found": r.found})).collect();
        writeln!(out, "{:#}", json!({"device": args.name, "pass": failed == 0, "rows": rows}))?;
    } else {
        for r in &table.0 {
            writeln!(out, "{:<5}{:<10}{}", if r.pass { "pass" } else { "FAIL" }, r.name, r.found)?;
        }
    }
    if failed > 0 {
        let what = format!("`{}` fails {failed} of {}", args.name, table.0.len());
        return Err(Failure::Failed(format!("{what}; an engine may hurt a hand through it, or be blind to it")));
    }
    Ok(Ended::Well)
}

/// Who it is. `None` where nothing more can be asked.
fn presented(b: &mut Bench, t: &mut Table) -> Result<Option<About>, Failure> {
    b.forget();
    b.listen(1, PATIENCE);
    if b.frames.is_empty() {
        if b.foreign > 0 {
            t.row("frames", false, "of another version or for another device; build it anew");
            return Ok(None);
        }
        return Err(Failure::Failed(
            "no device of that name speaks; start it, `ca device list` shows those that do".into(),
        ));
    }
    // it says who it is once a second
    for _ in 0..20 {
        if b.about().is_some() {
            break;
        }
        b.listen(usize::MAX, 100_000_000);
    }
    let Some(a) = b.about() else {
        t.row("about", false, "never says who it is");
        return Ok(None);
    };
    let n = (a.n as usize).min(DOF);
    let axes_fit = (1..=3).contains(&a.axes) && a.n % a.axes == 0;
    let ranges = (0..n).all(|k| a.low[k].is_finite() && a.high[k].is_finite() && a.low[k] < a.high[k]);
    let forces = (0..n).all(|k| a.force[k].is_finite() && a.force[k] >= 0.0);
    let fine = n > 0 && axes_fit && ranges && forces && a.rate > 0;
    t.row("about", fine, format!("{}, {} degrees of freedom, {} frames a second", text(&a.model), a.n, a.rate));
    Ok(fine.then_some(a))
}

/// Limits of the guard: the device's own words.
fn profile(a: &About) -> Profile {
    let n = a.n as usize;
    let fold = |v: &[f32], f: fn(f64, f64) -> f64, from: f64| v[..n].iter().fold(from, |m, x| f(m, f64::from(*x)));
    let mut p = Profile::shipped("unknown").unwrap_or_else(|| unreachable!());
    (p.dof, p.axes, p.rate) = (u32::from(a.n), u32::from(a.axes), f64::from(a.rate));
    p.range = [fold(&a.low, f64::min, f64::INFINITY), fold(&a.high, f64::max, f64::NEG_INFINITY)];
    p.force = fold(&a.force, f64::min, f64::INFINITY);
    p.stiffness = Some(fold(&a.stiffness, f64::max, 0.0)).filter(|k| *k > 0.0).or(p.stiffness);
    p.title = text(&a.model);
    p.guard.zero = p.guard.zero.max(2.0 * p.hold());
    p
}

/// What it sends, unasked.
fn alive(b: &mut Bench, a: &About, t: &mut Table) {
    b.forget();
    b.listen((a.rate as usize / 2).max(LOOK), PATIENCE);
    let (frames, n) = (&b.frames, a.n as usize);
    let last = frames.len().saturating_sub(1);
    t.row("frames", b.foreign == 0 && last > 0, format!("{} of this version, {} others", frames.len(), b.foreign));
    let same = frames.iter().all(|f| f.session == a.session && f.session != 0 && f.n == a.n);
    t.row("session", same, format!("{:x}, as said of itself", a.session));
    let grows = last > 0 && frames.windows(2).all(|w| w[1].seq > w[0].seq);
    let lost = frames.last().map_or(0, |f| f.seq.saturating_sub(frames[0].seq).saturating_sub(last as u64));
    t.row(
        "numbers",
        grows,
        format!("{} the frames, {lost} not seen", if grows { "grow with" } else { "do not grow with" }),
    );
    let clocks = frames.windows(2).all(|w| w[1].t_host_ns > w[0].t_host_ns && w[1].t_device_ns >= w[0].t_device_ns);
    t.row("clocks", clocks, "of host and device run forward");
    // of neighbours only, and their median: what the machine delayed says nothing of the device
    let mut gaps: Vec<u64> = frames
        .windows(2)
        .filter(|w| w[1].seq == w[0].seq.wrapping_add(1))
        .map(|w| w[1].t_host_ns.saturating_sub(w[0].t_host_ns))
        .collect();
    gaps.sort_unstable();
    let rate = gaps.get(gaps.len() / 2).filter(|g| **g > 0).map_or(0.0, |g| 1e9 / *g as f64);
    let near = (rate / f64::from(a.rate) - 1.0).abs() <= 0.05;
    t.row("rate", near, format!("{rate:.1} a second, {} were said", a.rate));
    let finite = frames.iter().all(|f| f.pos[..n].iter().all(|x| x.is_finite()));
    let outside = frames.iter().flat_map(|f| (0..n).map(move |k| (k, f.pos[k]))).find(|(k, x)| {
        let [low, high] = [a.low[*k], a.high[*k]].map(f64::from);
        let slack = 0.01 * (high - low);
        !(low - slack..=high + slack).contains(x)
    });
    let found = match outside {
        Some((k, x)) => format!("axis {k} is at {} m, its range is {} to {} m", Plain(x), a.low[k], a.high[k]),
        None => "inside the range".into(),
    };
    t.row("positions", finite && outside.is_none(), found);
    let ready = frames.iter().all(|f| f.status & (status::CONNECTED | status::POWERED) == 3);
    t.row("status", ready, "connected and powered");
}

/// Whether `ca serve` would use its frames, with the profile it would take, and give it forces.
fn served(b: &mut Bench, name: &str, a: &About, t: &mut Table) -> Result<(), Failure> {
    let own = store::profile_of(name, &[])?;
    let profile = if own.is_unknown() {
        match own.described(a) {
            Ok(p) => p,
            Err(why) => {
                t.row("serve", false, why);
                return Ok(());
            }
        }
    } else {
        own
    };
    let by = format!("profile `{}`, at most {} N", profile.name, profile.force);
    if u32::from(a.n) < profile.dof {
        let what = format!("{by}: it has {} degrees of freedom, the profile {}: no frame is used", a.n, profile.dof);
        t.row("serve", false, what);
        return Ok(());
    }
    b.forget();
    b.listen(1, PATIENCE);
    let (mut taken, mut dropped, mut wait) = (0, 0, Wait::Nothing);
    for _ in 0..TRIES {
        let mut p = b.player(&profile)?;
        p.order(Order::Arm);
        b.play(&mut p, REST);
        (taken, dropped, wait) = (p.engine.counts.taken, p.engine.counts.dropped, p.engine.ports[0].chain.wait());
        p.order(Order::Disarm);
        b.play(&mut p, 10);
        // a machine that stood still at this moment
        if wait != Wait::Stale {
            break;
        }
    }
    let used = taken > 0 && dropped * 100 <= taken;
    let mut found = format!("{by}: {taken} of {} frames used", taken + dropped);
    if wait != Wait::Nothing {
        found = format!("{found}; forces stay off once armed: {wait}");
    }
    t.row("serve", used && wait == Wait::Nothing, found);
    Ok(())
}

/// What went wrong with frames that should have no force.
fn gives(frames: &[DeviceFrame]) -> Option<String> {
    let none = |f: &&DeviceFrame| Cause::read(f.cause) == Cause::None;
    let pushes = |f: &DeviceFrame| f.force_measured[..(f.n as usize).min(DOF)].iter().any(|x| *x != 0.0);
    let (silent, pushing) = (frames.iter().filter(none).count(), frames.iter().filter(|f| pushes(f)).count());
    (silent + pushing > 0)
        .then(|| format!("of {} frames {silent} give no reason and {pushing} give a force", frames.len()))
}

/// The frames of a phase after the device must have heard: those that ack what we sent first, and a few.
fn late(b: &Bench) -> &[DeviceFrame] {
    &b.frames[b.frames.len() / 2..]
}

/// An engine at rest.
fn rest(b: &mut Bench, p: &mut Player, t: &mut Table) {
    b.forget();
    b.play(p, REST);
    let (sent, frames) = (b.sent.last().map_or(0, |f| f.seq), late(b));
    let (first, last) = (frames.first().map_or(0, |f| f.ack), frames.last().map_or(0, |f| f.ack));
    let follows = last > first && last <= sent && frames.windows(2).all(|w| w[1].ack >= w[0].ack);
    t.row("ack", follows, format!("{sent} forces were sent, it says it used number {last}"));
    let bad = gives(frames);
    t.row("rest", !frames.is_empty() && bad.is_none(), bad.unwrap_or_else(|| "no force from an engine at rest".into()));
}

/// Another engine after a watchdog, whose frames live twice as long: what stands still for milliseconds is this machine,
/// and how long a force lives is no matter of the device, as long as it ends then.
fn patient(b: &mut Bench, p: &mut Player, profile: &mut Profile) -> Result<(), Failure> {
    let late = matches!(b.mode(), (Mode::Fault, Cause::WatchdogOut | Cause::WatchdogIn));
    if late && profile.guard.ttl < PATIENT {
        let hold = 2.0 * profile.hold();
        let guard = &mut profile.guard;
        (guard.hold, guard.zero, guard.ttl) = (Some(hold), 2.0 * guard.zero, (2.0 * guard.ttl).min(PATIENT));
        *p = b.player(profile)?;
        b.play(p, REST);
    }
    Ok(())
}

/// Forces on; false where they cannot be.
fn on(b: &mut Bench, p: &mut Player, profile: &mut Profile) -> Result<bool, Failure> {
    for _ in 0..TRIES {
        patient(b, p, profile)?;
        p.pull(0.0)?;
        p.order(Order::Arm);
        for _ in 0..60 {
            let before = b.frames.len();
            b.play(p, 100);
            if b.frames.len() == before {
                // it has left
                return Ok(false);
            }
            match b.mode() {
                (Mode::On, _) => return Ok(true),
                (Mode::Fault, _) => break,
                _ => {}
            }
        }
    }
    Ok(false)
}

/// Small forces. True where the device was left with them.
fn forces(b: &mut Bench, p: &mut Player, profile: &mut Profile, force: f64, t: &mut Table) -> Result<bool, Failure> {
    for attempt in 1..=TRIES {
        if !on(b, p, profile)? {
            let (mode, cause) = b.mode();
            let waits =
                if mode == Mode::Off { ", which waits until it is calibrated, fresh and nothing pushes" } else { "" };
            t.row("arms", false, format!("mode {}{waits}, {}", mode.name(), cause.name()));
            return Ok(false);
        }
        p.pull(force)?;
        b.play(p, 100);
        b.forget();
        b.play(p, REST);
        if b.mode().0 != Mode::On && attempt < TRIES {
            continue;
        }
        let (mode, cause) = b.mode();
        t.row("arms", mode == Mode::On, format!("mode {}, {}", mode.name(), cause.name()));
        let held = b.frames.iter().filter(|f| Cause::read(f.cause) == Cause::None).count();
        let most = held * 10 >= b.frames.len() * 9 && held > 0;
        t.row("forces", most, format!("of {} frames {held} have them", b.frames.len()));
        let reported = measured(b);
        match reported {
            Some((is, want)) => {
                let near = is.iter().zip(&want).all(|(a, b)| (a - b).abs() <= 0.1 * force.max(1e-9));
                t.row(
                    "measured",
                    near,
                    format!("{} N, {} N were asked of the first axis", short(is[0]), short(want[0])),
                );
            }
            None => t.row("measured", true, "not reported"),
        }
        return Ok(mode == Mode::On);
    }
    Ok(false)
}

/// A known spring to either side of where the device is: forces are those of the spring at the positions they answer, and
/// none is much larger than where it began.
fn felt(b: &mut Bench, p: &mut Player, profile: &mut Profile, force: f64, t: &mut Table) -> Result<(), Failure> {
    for attempt in 1..=TRIES {
        // from where it is now, which pulls before may have changed
        *p = b.player(profile)?;
        b.play(p, REST);
        if !on(b, p, profile)? {
            let (mode, cause) = b.mode();
            t.row("spring", false, format!("mode {}, {}", mode.name(), cause.name()));
            return Ok(());
        }
        let k = force / p.stretch;
        let (mut most, mut offs) = (0.0_f64, Vec::new());
        for side in 0..2 {
            b.forget();
            p.springs([[k, 0.0], [0.0, k]][side])?;
            b.play(p, REST);
            for s in &b.sent {
                // the first frames are on their way to the spring
                let Some(f) = b.frames.iter().skip(RISE).find(|f| f.seq == s.ack) else { continue };
                for (d, sent) in s.force.iter().enumerate().take((f.n as usize).min(DOF)) {
                    let (sent, spring) = (f64::from(*sent), k * (p.rest[side][d] - f.pos[d]));
                    most = most.max(sent.abs());
                    offs.push((sent - spring).abs());
                }
            }
        }
        if b.mode().0 != Mode::On && attempt < TRIES {
            continue;
        }
        p.springs([0.0; 2])?;
        b.play(p, 100);
        // the guard may add to it for a moment, and not for half of the time
        offs.sort_by(f64::total_cmp);
        let off = offs.get(offs.len() / 2).copied().unwrap_or(f64::INFINITY);
        // one that followed the first spring begins the second as far away again
        let limit = 2.0 * BEYOND * force + GUARD * profile.force;
        let pass = most <= limit && off <= 0.1 * force;
        let what = format!(
            "{} N/m, stretched by {} mm, is {} N: at most {} N, of {}; half of all within {} N of the spring",
            short(k),
            short(1e3 * p.stretch),
            short(force),
            short(most),
            short(limit),
            short(off)
        );
        let hint = if most > limit { "; do positions and forces have the same sign?" } else { "" };
        t.row("spring", pass, what + hint);
        return Ok(());
    }
    Ok(())
}

/// Forces it measured and those it was given, of the last frame whose force is known; `None` where it measures none.
fn measured(b: &Bench) -> Option<(Vec<f64>, Vec<f64>)> {
    let n = |f: &DeviceFrame| (f.n as usize).min(DOF);
    b.frames.iter().rev().find_map(|f| {
        let asked: &ForceFrame = b.sent.iter().find(|s| s.seq == f.ack)?;
        f.force_measured[..n(f)].iter().any(|x| *x != 0.0).then(|| {
            let wide = |v: &[f32]| v[..n(f)].iter().map(|x| f64::from(*x)).collect();
            (wide(&f.force_measured), wide(&asked.force))
        })
    })
}

/// The engine dies.
fn silence(b: &mut Bench, a: &About, t: &mut Table) {
    let Some(last) = b.sent.last().copied() else { return };
    b.forget();
    let quarter = a.rate as usize / 4;
    b.listen(quarter.max(LOOK), PATIENCE);
    let over = last.t_host_ns + u64::from(last.ttl_us) * 1000;
    let mut expired: Vec<DeviceFrame> = b.frames.iter().filter(|f| f.t_host_ns > over).copied().collect();
    // the frame under way when the life of the force ends, and the one after it
    expired.drain(..expired.len().min(2));
    let goes_on = expired.len() * 2 > LOOK;
    t.row("goes on", goes_on, format!("{} frames after the engine fell silent", expired.len()));
    let bad = gives(&expired);
    let found = bad.clone().unwrap_or_else(|| {
        let cause = expired.last().map_or(Cause::None, |f| Cause::read(f.cause));
        format!("no force {} ms after the last frame, {}", last.ttl_us / 1000, cause.name())
    });
    t.row("watchdog", goes_on && bad.is_none(), found);
}

/// Another engine.
fn another(b: &mut Bench, profile: &mut Profile, force: f64, t: &mut Table) -> Result<(), Failure> {
    let mut p = b.player(profile)?;
    b.forget();
    b.play(&mut p, REST);
    let sent = b.sent.last().map_or(0, |f| f.seq);
    let ack = late(b).iter().all(|f| (1..=sent).contains(&f.ack)) && !late(b).is_empty();
    let found = late(b).last().map_or(0, |f| f.ack);
    t.row("restart", ack, format!("number {found} of {sent} of the new engine is used"));
    let bad = gives(late(b));
    t.row("at rest", bad.is_none(), bad.unwrap_or_else(|| "the new engine is at rest, and so is the device".into()));
    if !on(b, &mut p, profile)? {
        let (mode, cause) = b.mode();
        t.row("disarm", false, format!("cannot be armed again: mode {}, {}", mode.name(), cause.name()));
        return Ok(());
    }
    p.pull(force)?;
    b.play(&mut p, 200);
    p.order(Order::Disarm);
    b.forget();
    b.play(&mut p, REST);
    let bad = gives(late(b));
    t.row("disarm", bad.is_none(), bad.unwrap_or_else(|| "no force once disarmed".into()));
    Ok(())
}

/// What must not be used: an engine that was never at rest, frames of another layout, of another device, of the past.
/// All of them ask for no force.
fn strangers(b: &mut Bench, t: &mut Table) {
    let n = b.frames.last().map_or(1, |f| f.n as usize);
    let name = b.frames.last().map(|f| text(&f.device)).unwrap_or_default();
    let mut frame = ForceFrame::new(&name, n);
    (frame.session, frame.ttl_us, frame.mode, frame.cause) = (ca_haptic::host::session(), 5000, Mode::On as u32, 0);
    let mut send = |b: &mut Bench, change: &dyn Fn(&mut ForceFrame)| {
        b.forget();
        while b.frames.len() < LOOK / 2 && b.sent.len() < LOOK {
            frame.seq += 1;
            let mut f = frame;
            change(&mut f);
            b.send(&mut f);
            b.listen(b.frames.len() + 1, 10_000_000);
        }
        frame.seq
    };
    send(b, &|_| {});
    let bad = gives(late(b));
    t.row("unrested", bad.is_none(), bad.unwrap_or_else(|| "no force from an engine that was not seen at rest".into()));
    let wrong: [Wrong; 4] = [
        ("layout", |f| (f.layout, f.seq) = (f.layout ^ 1, f.seq + FAR)),
        ("address", |f| (f.device[0], f.seq) = (f.device[0] ^ 1, f.seq + FAR)),
        ("version", |f| (f.version, f.seq) = (f.version + 1, f.seq + FAR)),
        ("past", |f| f.seq = 1),
    ];
    for (name, change) in wrong {
        let sent = send(b, &change);
        let used = late(b).iter().find(|f| f.ack > sent || f.ack == 1);
        let found = match used {
            Some(f) => format!("it says it used number {}", f.ack),
            None => "not used".into(),
        };
        t.row(name, used.is_none() && !late(b).is_empty(), found);
    }
}
