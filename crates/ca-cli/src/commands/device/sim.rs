//! `ca device sim`: runs a device process without hardware, using [`ca_device_tools::simulator`].

use super::{ScriptKind, SimArgs};
use crate::outcome::{Ended, Failure, Outcome};
use crate::{outputs, term};
use ca_device_tools::simulator::{Simulation, Simulator, Summary};
use ca_device_tools::store;
use ca_haptic::frame::CAUSES;
use ca_haptic::profile::Profile;
use ca_haptic::simulated::{Hand, Script, ScriptOptions};
use ca_io::gesture::Gesture;
use ca_model::quantity::short;
use serde_json::json;
use std::io::Write as _;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};

static STOP: AtomicBool = AtomicBool::new(false);

/// Runs the command.
pub fn run(args: &SimArgs) -> Outcome {
    if let Some(log) = &args.force_log {
        let profile = store::profile_file(&args.profile);
        let gesture = args.gesture.iter().map(|p| ("the gesture", &**p));
        let inputs: Vec<_> = profile.iter().map(|p| ("the profile", &**p)).chain(gesture).collect();
        outputs::check_distinct(&[("--force-log", log)], &inputs)?;
    }
    if args.wait && args.script == ScriptKind::Push {
        return Err(Failure::Usage(
            "--wait: `--script push` pushes all the time; leave out `--wait`, or choose another script".into(),
        ));
    }
    let mut profile = store::profile(&args.profile)?;
    if let Some(rate) = args.rate {
        profile.rate = rate;
    }
    let name = args.name.clone().unwrap_or_else(|| profile.name.clone());
    let script = script(args, &profile)?;
    let hand = if args.script == ScriptKind::Push {
        Hand::NONE
    } else {
        // without forces, the parameters of the hand do not matter
        Hand::finger(if profile.force > 0.0 { profile.force } else { 1.0 }, &profile)
    };
    let simulation = Simulation {
        name,
        profile,
        hand,
        script,
        delay: usize::from(args.delay),
        seed: args.seed,
        seconds: args.seconds,
        waits: args.wait,
        lockstep: args.lockstep,
        force_log: args.force_log.clone(),
        priority: (args.priority > 0).then_some(args.priority),
    };
    let simulator = Simulator::open(simulation)?;
    // a process can set only one handler; if this fails, Ctrl-C ends the process as usual
    let _ = ctrlc::set_handler(|| STOP.store(true, Relaxed));
    let summary = simulator.run(&STOP, &mut term::message)?;
    reported(&summary, args.json)?;
    Ok(Ended::Well)
}

fn script(args: &SimArgs, profile: &Profile) -> Result<Script, Failure> {
    if args.push.is_some() && args.script != ScriptKind::Push {
        return Err(Failure::Usage("--push: needs `--script push`".into()));
    }
    let asked = ScriptOptions { rest: args.rest.first().copied(), depth: args.depth, speed: args.speed };
    let goes = !matches!(args.script, ScriptKind::Push | ScriptKind::File);
    if !goes && (asked != ScriptOptions::default() || !args.dof.is_empty()) {
        return Err(Failure::Usage(
            "--rest, --dof, --depth and --speed: not for `--script push` and `--script file`; leave them out".into(),
        ));
    }
    if args.gesture.is_some() && args.script != ScriptKind::File {
        return Err(Failure::Usage("--gesture: needs `--script file`".into()));
    }
    let name = match args.script {
        ScriptKind::Strike => "strike",
        ScriptKind::Bow => "bow",
        ScriptKind::Shake => "shake",
        ScriptKind::Hold => "hold",
        ScriptKind::Push => match args.push {
            Some(force) if force.is_finite() => return Ok(Script::Push { force }),
            Some(_) => return Err(Failure::Usage("--push: expected a force in newtons".into())),
            None => "push",
        },
        ScriptKind::File => {
            let path = args.gesture.as_deref().unwrap_or(Path::new(""));
            return Ok(Script::File(Gesture::open(path, &[], None)?));
        }
    };
    let [low, high] = profile.range;
    let n = profile.dof as usize;
    if let Some(k) = args.dof.iter().find(|k| **k >= n) {
        let what =
            format!("--dof {k}: {} has {n} degrees of freedom, numbered 0 to {}", profile.title, n.saturating_sub(1));
        return Err(Failure::Usage(what));
    }
    if args.rest.len() > n {
        let what = format!(
            "--rest: {} positions for the {n} degrees of freedom of {}; give at most {n}",
            args.rest.len(),
            profile.title
        );
        return Err(Failure::Usage(what));
    }
    let moves = |k: usize| args.dof.is_empty() || args.dof.contains(&k);
    let rest = |k: usize| args.rest.get(k).or(args.rest.last()).copied().unwrap_or(0.5 * (low + high));
    for k in 0..n {
        let end = rest(k) + if moves(k) { args.depth.unwrap_or(0.0) } else { 0.0 };
        for (what, x) in [("--rest", rest(k)), ("--rest and --depth", end)] {
            if !(low..=high).contains(&x) {
                let travel = format!("choose {} to {} m", short(low), short(high));
                return Err(Failure::Usage(format!(
                    "{what}: {} m is outside the travel of {}; {travel}",
                    short(x),
                    profile.title
                )));
            }
        }
    }
    if args.depth == Some(0.0) {
        return Err(Failure::Usage("--depth 0: the hand would not move; use `--script hold`".into()));
    }
    let one = |k: usize| {
        let name = if moves(k) { name } else { "hold" };
        Script::named(name, profile, ScriptOptions { rest: Some(rest(k)), ..asked })
            .ok_or_else(|| Failure::Usage(format!("no script `{name}`")))
    };
    Ok(Script::Each((0..n).map(one).collect::<Result<_, _>>()?))
}

fn reported(s: &Summary, asked: bool) -> std::io::Result<()> {
    let mut out = std::io::stdout().lock();
    let (name, rate, loops) = (&s.device, s.rate, &s.loops);
    let causes = || CAUSES.iter().zip(s.causes).filter(|c| c.1 > 0);
    if asked {
        let causes: serde_json::Map<String, serde_json::Value> =
            causes().map(|(c, n)| (c.name().into(), json!(n))).collect();
        let v = json!({
            "device": name, "rate": rate, "frames": s.frames, "unread": s.unread,
            "first_answered": s.first_answered, "left_out": s.left_out, "asked_again": s.again, "forces": s.forces,
            "largest": s.largest, "loop_us": loops, "causes": causes, "restarts": s.restarts,
        });
        return writeln!(out, "{v:#}");
    }
    writeln!(out, "{name}: {} frames at {rate} Hz", s.frames)?;
    let again = if s.again > 0 { format!(", {} sent again", s.again) } else { String::new() };
    writeln!(out, "  {:<10}{} not read by any process, {} periods left out{again}", "sent", s.unread, s.left_out)?;
    let (k, most) = s.largest.iter().enumerate().fold((0, 0.0), |a, (k, f)| if *f > a.1 { (k, *f) } else { a });
    let engine = if s.restarts > 0 { format!("; the engine changed {} times", s.restarts) } else { String::new() };
    writeln!(out, "  {:<10}{} frames, largest {} N (dof {k}){engine}", "forces", s.forces, short(most))?;
    if loops.n > 0 {
        let [a, b, c, d] = [loops.p50, loops.p99, loops.p999, loops.max].map(short);
        writeln!(out, "  {:<10}p50 {a}  p99 {b}  p99.9 {c}  max {d} us, from a position to its force", "loop")?;
    }
    let list: Vec<String> = causes().map(|(c, n)| format!("{} {n}", c.name())).collect();
    writeln!(out, "  {:<10}{} (frames)", "off", list.join(", "))
}
