//! What is looked at with small forces on: whether they come, whether a known spring is felt as one, and whether they end with
//! the engine, under another one and once disarmed.

use super::bench::{Bench, LOOK, PATIENCE, Player, REST, TRIES};
use super::quiet::{late, unexpected_forces};
use super::table::CheckTable;
use crate::ToolError;
use ca_haptic::frame::{About, Cause, DOF, DeviceFrame, ForceFrame, Mode};
use ca_haptic::guard::Order;
use ca_haptic::profile::Profile;
use ca_model::quantity::short;

/// The most that a force may live \[s\], in tries after a watchdog; what no device outlives is 0.1 s.
const PATIENT: f64 = 0.08;
/// How long a device may say nothing before it has left \[ns\].
const LEFT: u64 = 1_000_000_000;
/// Frames of the device until a spring that is new has its stiffness.
const RISE: usize = 10;
/// How much more than the force of the stretched spring a device may come to feel, which swings about its rest.
const BEYOND: f64 = 1.5;
/// ... and how much the guard may add, as part of the largest force of the device.
const GUARD: f64 = 0.1;
/// A hand that moves by more than this part of the stretch without a force is not held still.
const MOVED: f64 = 0.5;

/// Another engine after a watchdog, whose frames live twice as long: what stands still for milliseconds is this machine,
/// and how long a force lives is no matter of the device, as long as it ends then.
pub(super) fn patient(b: &mut Bench, p: &mut Player, profile: &mut Profile) -> Result<(), ToolError> {
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
pub(super) fn on(b: &mut Bench, p: &mut Player, profile: &mut Profile) -> Result<bool, ToolError> {
    for _ in 0..TRIES {
        patient(b, p, profile)?;
        p.pull(0.0)?;
        p.order(Order::Arm);
        for _ in 0..60 {
            let before = b.frames.len();
            b.play(p, 100);
            if b.frames.len() == before {
                // it has left, or this machine lets it wait
                b.listen(before + 1, LEFT);
                if b.frames.len() == before {
                    return Ok(false);
                }
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
pub(super) fn forces(
    b: &mut Bench,
    p: &mut Player,
    profile: &mut Profile,
    force: f64,
    t: &mut CheckTable,
) -> Result<bool, ToolError> {
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
pub(super) fn spring(
    b: &mut Bench,
    p: &mut Player,
    profile: &mut Profile,
    force: f64,
    t: &mut CheckTable,
) -> Result<(), ToolError> {
    for attempt in 1..=TRIES {
        // from where it is now, which pulls before may have changed
        *p = b.player(profile)?;
        b.forget();
        b.play(p, REST);
        let moved = travelled(&b.frames);
        if !on(b, p, profile)? {
            never_on(b, t, "the spring");
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
        let hint = if !pass && moved > MOVED * p.stretch {
            let moved = short(1e3 * moved);
            format!("; the hand moved by {moved} mm without a force: hold it still, and test again")
        } else if most > limit {
            "; do positions and forces have the same sign?".into()
        } else {
            String::new()
        };
        t.row("spring", pass, what + &hint);
        return Ok(());
    }
    Ok(())
}

/// Travel of a hand at the degree of freedom that went farthest \[m\].
fn travelled(frames: &[DeviceFrame]) -> f64 {
    let n = frames.iter().map(|f| f.n as usize).max().unwrap_or(0).min(DOF);
    let way = |d: usize| {
        let [low, high] = frames
            .iter()
            .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], f| [low.min(f.pos[d]), high.max(f.pos[d])]);
        high - low
    };
    (0..n).map(way).fold(0.0, f64::max)
}

/// Forces it measured and those it was given, of the last frame whose force is known; `None` where it measures none.
pub(super) fn measured(b: &Bench) -> Option<(Vec<f64>, Vec<f64>)> {
    let n = |f: &DeviceFrame| (f.n as usize).min(DOF);
    b.frames.iter().rev().find_map(|f| {
        let asked: &ForceFrame = b.sent.iter().find(|s| s.seq == f.ack)?;
        f.force_measured[..n(f)].iter().any(|x| *x != 0.0).then(|| {
            let wide = |v: &[f32]| v[..n(f)].iter().map(|x| f64::from(*x)).collect();
            (wide(&f.force_measured), wide(&asked.force))
        })
    })
}

/// Forces are off where they should have been on: what would have been asked with them is left open.
fn never_on(b: &Bench, t: &mut CheckTable, before: &str) {
    let (mode, cause) = b.mode();
    t.row("arms again", false, format!("before {before}: mode {}, {}", mode.name(), cause.name()));
}

/// The engine dies while the device gives a force: one that has none already would pass without a watchdog.
pub(super) fn silence(
    b: &mut Bench,
    p: &mut Player,
    profile: &mut Profile,
    force: f64,
    a: &About,
    t: &mut CheckTable,
) -> Result<(), ToolError> {
    let mut last = None;
    for _ in 0..TRIES {
        if !on(b, p, profile)? {
            break;
        }
        p.pull(force)?;
        b.play(p, 100);
        let gives = b.frames.last().is_some_and(|f| Cause::read(f.cause) == Cause::None);
        last = b.sent.last().copied().filter(|f| gives && Mode::read(f.mode) == Mode::On);
        if last.is_some() {
            break;
        }
    }
    let Some(last) = last else {
        never_on(b, t, "the engine falls silent");
        return Ok(());
    };
    b.forget();
    let quarter = a.rate as usize / 4;
    b.listen(quarter.max(LOOK), PATIENCE);
    let over = last.t_host_ns + u64::from(last.ttl_us) * 1000;
    let mut expired: Vec<DeviceFrame> = b.frames.iter().filter(|f| f.t_host_ns > over).copied().collect();
    // the frame under way when the life of the force ends, and the one after it
    expired.drain(..expired.len().min(2));
    let goes_on = expired.len() * 2 > LOOK;
    t.row("goes on", goes_on, format!("{} frames after the engine fell silent", expired.len()));
    let bad = unexpected_forces(&expired);
    let found = bad.clone().unwrap_or_else(|| {
        let cause = expired.last().map_or(Cause::None, |f| Cause::read(f.cause));
        format!("no force {} ms after the last frame, {}", last.ttl_us / 1000, cause.name())
    });
    t.row("watchdog", goes_on && bad.is_none(), found);
    Ok(())
}

/// Another engine.
pub(super) fn another(b: &mut Bench, profile: &mut Profile, force: f64, t: &mut CheckTable) -> Result<(), ToolError> {
    let mut p = b.player(profile)?;
    b.forget();
    b.play(&mut p, REST);
    let sent = b.sent.last().map_or(0, |f| f.seq);
    let ack = late(b).iter().all(|f| (1..=sent).contains(&f.ack)) && !late(b).is_empty();
    let found = late(b).last().map_or(0, |f| f.ack);
    t.row("restart", ack, format!("number {found} of {sent} of the new engine is used"));
    let bad = unexpected_forces(late(b));
    t.row("at rest", bad.is_none(), bad.unwrap_or_else(|| "the new engine is at rest, and so is the device".into()));
    if !on(b, &mut p, profile)? {
        never_on(b, t, "it is disarmed");
        return Ok(());
    }
    p.pull(force)?;
    b.play(&mut p, 200);
    p.order(Order::Disarm);
    b.forget();
    b.play(&mut p, REST);
    let bad = unexpected_forces(late(b));
    t.row("disarm", bad.is_none(), bad.unwrap_or_else(|| "no force once disarmed".into()));
    Ok(())
}
