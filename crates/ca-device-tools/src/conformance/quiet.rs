//! Tests without forces: the description of the device, its frames, an engine at rest, and frames that the device must
//! ignore.

use super::Conformance;
use super::bench::{Bench, LOOK, PATIENCE, Player, REST, TRIES};
use super::table::CheckTable;
use crate::{Message, ToolError, store};
use ca_haptic::frame::{About, Cause, DOF, DeviceFrame, ForceFrame, Mode, status, text};
use ca_haptic::guard::Order;
use ca_haptic::guard::wait::Wait;
use ca_haptic::profile::Profile;
use ca_model::quantity::Plain;

/// Name of a fault, and the function that puts it into a force frame.
type Wrong = (&'static str, fn(&mut ForceFrame));
/// Added to the number of a frame that must not be used, to recognise it.
const FAR: u64 = 1_000_000;

/// Tests the description of the device. Returns `None` if the tests cannot continue.
pub(super) fn presented(b: &mut Bench, t: &mut CheckTable) -> Result<Option<About>, ToolError> {
    b.forget();
    b.listen(1, PATIENCE);
    if b.frames.is_empty() {
        if b.foreign > 0 {
            t.row(
                "frames",
                false,
                "of another version or for another device; rebuild the device with this release of ca",
            );
            return Ok(None);
        }
        let fix = "start it (`ca device list` shows running devices)";
        return Err(ToolError::Failed(format!("no running device `{}`; {fix}", b.name)));
    }
    // a device sends its description once a second
    for _ in 0..20 {
        if b.about().is_some() {
            break;
        }
        b.listen(usize::MAX, 100_000_000);
    }
    let Some(a) = b.about() else {
        t.row("about", false, "the device does not send its description (`About`)");
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

/// Makes a profile with the limits that the device describes.
pub(super) fn profile(a: &About) -> Profile {
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

/// Tests the frames that the device sends unasked.
pub(super) fn alive(b: &mut Bench, a: &About, t: &mut CheckTable) {
    b.forget();
    b.listen((a.rate as usize / 2).max(LOOK), PATIENCE);
    let (frames, n) = (&b.frames, a.n as usize);
    let last = frames.len().saturating_sub(1);
    t.row("frames", b.foreign == 0 && last > 0, format!("{} of this version, {} others", frames.len(), b.foreign));
    let same = frames.iter().all(|f| f.session == a.session && f.session != 0 && f.n == a.n);
    t.row("session", same, format!("{:x} in the description", a.session));
    let grows = last > 0 && frames.windows(2).all(|w| w[1].seq > w[0].seq);
    let lost = frames.last().map_or(0, |f| f.seq.saturating_sub(frames[0].seq).saturating_sub(last as u64));
    t.row(
        "numbers",
        grows,
        format!("{} from frame to frame, {lost} missed", if grows { "increase" } else { "do not increase" }),
    );
    let clocks = frames.windows(2).all(|w| w[1].t_host_ns > w[0].t_host_ns && w[1].t_device_ns >= w[0].t_device_ns);
    let found = if clocks { "host and device run forward" } else { "host or device does not run forward" };
    t.row("clocks", clocks, found);
    // the median between consecutive frames, since delays by this machine do not count
    let mut gaps: Vec<u64> = frames
        .windows(2)
        .filter(|w| w[1].seq == w[0].seq.wrapping_add(1))
        .map(|w| w[1].t_host_ns.saturating_sub(w[0].t_host_ns))
        .collect();
    gaps.sort_unstable();
    let rate = gaps.get(gaps.len() / 2).filter(|g| **g > 0).map_or(0.0, |g| 1e9 / *g as f64);
    let near = (rate / f64::from(a.rate) - 1.0).abs() <= 0.05;
    t.row("rate", near, format!("{rate:.1} frames a second, {} in the description", a.rate));
    let finite = frames.iter().all(|f| f.pos[..n].iter().all(|x| x.is_finite()));
    let outside = frames.iter().flat_map(|f| (0..n).map(move |k| (k, f.pos[k]))).find(|(k, x)| {
        let [low, high] = [a.low[*k], a.high[*k]].map(f64::from);
        let slack = 0.01 * (high - low);
        !(low - slack..=high + slack).contains(x)
    });
    let found = match outside {
        Some((k, x)) => format!("axis {k} is at {} m, outside its range of {} to {} m", Plain(x), a.low[k], a.high[k]),
        None => "inside the range".into(),
    };
    t.row("positions", finite && outside.is_none(), found);
    let ready = frames.iter().all(|f| f.status & (status::CONNECTED | status::POWERED) == 3);
    t.row("status", ready, if ready { "connected and powered" } else { "not always connected and powered" });
}

/// Tests that `ca serve` would use the frames of the device with its profile, and would give it forces.
pub(super) fn served(
    b: &mut Bench,
    asked: &Conformance,
    a: &About,
    t: &mut CheckTable,
    say: &mut dyn FnMut(Message),
) -> Result<(), ToolError> {
    let own = store::profile_of(&asked.name, &asked.profile, say)?;
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
        let what = format!("{by}: the profile needs {} degrees of freedom, the device has {}", profile.dof, a.n);
        t.row("serve", false, format!("{what}; no frame is used"));
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
        // tries again if this machine paused at this moment
        if wait != Wait::Stale {
            break;
        }
    }
    let used = taken > 0 && dropped * 100 <= taken;
    let mut found = format!("{by}: {taken} of {} frames used", taken + dropped);
    if wait != Wait::Nothing {
        found = format!("{found}; forces stay off after arming: {wait}");
    }
    t.row("serve", used && wait == Wait::Nothing, found);
    Ok(())
}

/// Describes frames that should have no force, but have one or give no reason; `None` if there are none.
pub(super) fn unexpected_forces(frames: &[DeviceFrame]) -> Option<String> {
    let none = |f: &&DeviceFrame| Cause::read(f.cause) == Cause::None;
    let pushes = |f: &DeviceFrame| f.force_measured[..(f.n as usize).min(DOF)].iter().any(|x| *x != 0.0);
    let (silent, pushing) = (frames.iter().filter(none).count(), frames.iter().filter(|f| pushes(f)).count());
    (silent + pushing > 0)
        .then(|| format!("of {} frames, {silent} report cause NONE and {pushing} report a force", frames.len()))
}

/// Returns the second half of the frames of a phase, in which the device must have received the first force frames.
pub(super) fn late(b: &Bench) -> &[DeviceFrame] {
    &b.frames[b.frames.len() / 2..]
}

pub(super) fn rest(b: &mut Bench, p: &mut Player, t: &mut CheckTable) {
    b.forget();
    b.play(p, REST);
    let (sent, frames) = (b.sent.last().map_or(0, |f| f.seq), late(b));
    let (first, last) = (frames.first().map_or(0, |f| f.ack), frames.last().map_or(0, |f| f.ack));
    let follows = last > first && last <= sent && frames.windows(2).all(|w| w[1].ack >= w[0].ack);
    t.row("ack", follows, format!("{sent} forces sent; the device reports that it used number {last}"));
    let bad = unexpected_forces(frames);
    t.row("rest", !frames.is_empty() && bad.is_none(), bad.unwrap_or_else(|| "no force from an engine at rest".into()));
}

/// Tests frames that must not be used: from an engine that was never at rest, of another layout, version or device, and
/// of the past. All of them have zero force.
pub(super) fn strangers(b: &mut Bench, t: &mut CheckTable) {
    let n = b.frames.last().map_or(1, |f| f.n as usize);
    let name = b.frames.last().map(|f| text(&f.device)).unwrap_or_default();
    let mut frame = ForceFrame::new(&name, n);
    (frame.session, frame.ttl_us, frame.mode, frame.cause) =
        (ca_haptic::host::session_number(), 5000, Mode::On as u32, 0);
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
    let bad = unexpected_forces(late(b));
    t.row("unrested", bad.is_none(), bad.unwrap_or_else(|| "no force from an engine that was never at rest".into()));
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
            Some(f) => format!("the device reports that it used number {}", f.ack),
            None => "not used".into(),
        };
        t.row(name, used.is_none() && !late(b).is_empty(), found);
    }
}
