//! Tests with small forces: they arrive, a known spring is rendered as one, and they end when the engine dies, is
//! replaced, or is disarmed.

use super::bench::{Bench, LOOK, PATIENCE, Player, REST, TRIES};
use super::quiet::{late, unexpected_forces};
use super::table::CheckTable;
use crate::ToolError;
use ca_haptic::frame::{About, Cause, DOF, DeviceFrame, ForceFrame, Mode};
use ca_haptic::guard::Order;
use ca_haptic::profile::Profile;
use ca_model::quantity::short;

/// Longest time to live of a force in retries after a watchdog \[s\]; a device ends every force after 0.1 s.
const PATIENT: f64 = 0.08;
/// Time without frames after which a device has left \[ns\].
const LEFT: u64 = 1_000_000_000;
/// Frames of the device until a new spring has its stiffness.
const RISE: usize = 10;
/// Largest force relative to the force of the stretched spring, because the device swings about the rest position.
const BEYOND: f64 = 1.5;
/// Allowed addition by the guard, as a share of the largest force of the device.
const GUARD: f64 = 0.1;
/// Motion without a force, as a share of the stretch, beyond which the hand is not still.
const MOVED: f64 = 0.5;

/// After a watchdog fault, replaces the engine by one whose frames live twice as long. A pause of milliseconds is the
/// fault of this machine. The time to live does not matter for the device, as long as it ends the force then.
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

/// Switches forces on; returns false if this fails.
pub(super) fn on(b: &mut Bench, p: &mut Player, profile: &mut Profile) -> Result<bool, ToolError> {
    for _ in 0..TRIES {
        patient(b, p, profile)?;
        p.pull(0.0)?;
        p.order(Order::Arm);
        for _ in 0..60 {
            let before = b.frames.len();
            b.play(p, 100);
            if b.frames.len() == before {
                // the device has left, or this machine delays it
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

/// Tests small forces. Returns true if the device still has them at the end.
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
                if mode == Mode::Off { ", waiting for a calibrated device, fresh frames and no push" } else { "" };
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
        t.row("forces", most, format!("{held} of {} frames have forces", b.frames.len()));
        let reported = measured(b);
        match reported {
            Some((is, want)) => {
                let near = is.iter().zip(&want).all(|(a, b)| (a - b).abs() <= 0.1 * force.max(1e-9));
                t.row(
                    "measured",
                    near,
                    format!("{} N on the first axis, {} N requested", short(is[0]), short(want[0])),
                );
            }
            None => t.row("measured", true, "not reported"),
        }
        return Ok(mode == Mode::On);
    }
    Ok(false)
}

/// Tests a known spring on either side of the position: each force is the spring force at the position that it
/// answers, and none is much larger than the first.
pub(super) fn spring(
    b: &mut Bench,
    p: &mut Player,
    profile: &mut Profile,
    force: f64,
    t: &mut CheckTable,
) -> Result<(), ToolError> {
    for attempt in 1..=TRIES {
        // at the present position, which earlier pulls may have changed
        *p = b.player(profile)?;
        b.forget();
        b.play(p, REST);
        let moved = travelled(&b.frames);
        if !on(b, p, profile)? {
            never_on(b, t, "the spring test");
            return Ok(());
        }
        let k = force / p.stretch;
        let (mut most, mut offs) = (0.0_f64, Vec::new());
        for side in 0..2 {
            b.forget();
            p.springs([[k, 0.0], [0.0, k]][side])?;
            b.play(p, REST);
            for s in &b.sent {
                // skips the transient at the first frames
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
        // the guard may add to the force briefly, but not half of the time
        offs.sort_by(f64::total_cmp);
        let off = offs.get(offs.len() / 2).copied().unwrap_or(f64::INFINITY);
        // a device that followed the first spring is twice as far from the second
        let limit = 2.0 * BEYOND * force + GUARD * profile.force;
        let pass = most <= limit && off <= 0.1 * force;
        let what = format!(
            "{} N/m stretched by {} mm is {} N: largest {} N, limit {} N; half of all forces within {} N of the spring",
            short(k),
            short(1e3 * p.stretch),
            short(force),
            short(most),
            short(limit),
            short(off)
        );
        let hint = if !pass && moved > MOVED * p.stretch {
            let moved = short(1e3 * moved);
            format!("; the hand moved {moved} mm without a force: hold it still and test again")
        } else if most > limit {
            "; check that positions and forces have the same sign".into()
        } else {
            String::new()
        };
        t.row("spring", pass, what + &hint);
        return Ok(());
    }
    Ok(())
}

/// Returns the travel of the hand at the degree of freedom that moved most \[m\].
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

/// Returns measured and requested forces of the last frame whose force is known; `None` if the device measures none.
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

/// Reports that forces could not be switched on, so that the test after `before` is left out.
fn never_on(b: &Bench, t: &mut CheckTable, before: &str) {
    let (mode, cause) = b.mode();
    t.row("arms again", false, format!("before {before}: mode {}, {}", mode.name(), cause.name()));
}

/// Tests that forces end when the engine dies. The device must have a force at that moment, since otherwise it would
/// pass without a watchdog.
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
        never_on(b, t, "the watchdog test");
        return Ok(());
    };
    b.forget();
    let quarter = a.rate as usize / 4;
    b.listen(quarter.max(LOOK), PATIENCE);
    let over = last.t_host_ns + u64::from(last.ttl_us) * 1000;
    let mut expired: Vec<DeviceFrame> = b.frames.iter().filter(|f| f.t_host_ns > over).copied().collect();
    // skips the frame under way when the force expires, and the next one
    expired.drain(..expired.len().min(2));
    let goes_on = expired.len() * 2 > LOOK;
    t.row("goes on", goes_on, format!("{} frames after the engine stopped sending", expired.len()));
    let bad = unexpected_forces(&expired);
    let found = bad.clone().unwrap_or_else(|| {
        let cause = expired.last().map_or(Cause::None, |f| Cause::read(f.cause));
        format!("no force {} ms after the last frame, {}", last.ttl_us / 1000, cause.name())
    });
    t.row("watchdog", goes_on && bad.is_none(), found);
    Ok(())
}

pub(super) fn another(b: &mut Bench, profile: &mut Profile, force: f64, t: &mut CheckTable) -> Result<(), ToolError> {
    let mut p = b.player(profile)?;
    b.forget();
    b.play(&mut p, REST);
    let sent = b.sent.last().map_or(0, |f| f.seq);
    let ack = late(b).iter().all(|f| (1..=sent).contains(&f.ack)) && !late(b).is_empty();
    let found = late(b).last().map_or(0, |f| f.ack);
    let found = format!("the new engine sent {sent} forces; the device reports that it used number {found}");
    t.row("restart", ack, found);
    let bad = unexpected_forces(late(b));
    t.row("at rest", bad.is_none(), bad.unwrap_or_else(|| "no force while the new engine is at rest".into()));
    if !on(b, &mut p, profile)? {
        never_on(b, t, "the disarm test");
        return Ok(());
    }
    p.pull(force)?;
    b.play(&mut p, 200);
    p.order(Order::Disarm);
    b.forget();
    b.play(&mut p, REST);
    let bad = unexpected_forces(late(b));
    t.row("disarm", bad.is_none(), bad.unwrap_or_else(|| "no force after disarming".into()));
    Ok(())
}
