//! `ca set`, `ca audio`, `ca arm`, `ca disarm`, `ca status`, `ca stop`: what is said to a running `ca serve`.

use crate::args::{ArmArgs, AudioArgs, SetArgs, StatusArgs};
use crate::outcome::{Ended, Failure, Outcome};
use ca_haptic::host::Site;
use ca_haptic::host::control::{Given, Reply, Request, ask};
use std::io::Write as _;
use std::time::{Duration, Instant};

/// How long a server may take to answer: it does so every 2 ms, unless the machine is very busy.
const PATIENCE: Duration = Duration::from_secs(5);

/// Longest time in which a sound device opens, and the poll interval.
const OPENS: Duration = Duration::from_secs(15);
const LOOK: Duration = Duration::from_millis(20);

/// `ca set`.
pub fn set(args: &SetArgs) -> Outcome {
    if args.values.is_empty() {
        return print(&Request::Status, args.json, |r| {
            let list = r.fields.get("params").and_then(|p| p.as_array()).cloned().unwrap_or_default();
            if list.is_empty() {
                return "this model has no live parameters".into();
            }
            let line = |p: &serde_json::Value| {
                let part = |k: &str| match &p[k] {
                    serde_json::Value::String(s) => s.clone(),
                    v => v.as_f64().map_or_else(|| v.to_string(), |v| v.to_string()),
                };
                format!("{} = {} {} ({} to {})", part("name"), part("value"), part("unit"), part("min"), part("max"))
            };
            list.iter().map(line).collect::<Vec<_>>().join("\n")
        });
    }
    let values = args.values.iter().map(|(n, v)| (n.clone(), Given::Text(v.clone()))).collect();
    print(&Request::Set { values }, args.json, |r| r.text.clone())
}

/// `ca audio`.
pub fn audio(args: &AudioArgs) -> Outcome {
    if args.device.is_some() {
        let site = Site::of_user()?;
        let reply = ask(&site, &Request::Audio { to: args.device.clone() }, PATIENCE)?;
        if !reply.ok {
            return Err(Failure::Failed(reply.text));
        }
        // a device is opened beside the performance, which goes on
        let end = Instant::now() + OPENS;
        loop {
            let fields = ask(&site, &Request::Audio { to: None }, PATIENCE)?.fields;
            if let Some(why) = fields.get("refused").and_then(|r| r.as_str()) {
                return Err(Failure::Failed(why.into()));
            }
            if fields.get("busy").and_then(serde_json::Value::as_bool) == Some(false) {
                break;
            }
            if Instant::now() > end {
                return Err(Failure::Failed(format!("it does not open within {} s", OPENS.as_secs())));
            }
            std::thread::sleep(LOOK);
        }
    }
    print(&Request::Audio { to: None }, args.json, |r| r.text.clone())
}

/// `ca arm`.
pub fn arm(args: &ArmArgs) -> Outcome {
    print(&Request::Arm { device: args.device.clone() }, args.json, |r| r.text.clone())
}

/// `ca disarm`.
pub fn disarm(args: &ArmArgs) -> Outcome {
    print(&Request::Disarm { device: args.device.clone() }, args.json, |r| r.text.clone())
}

/// `ca status`.
pub fn status(args: &StatusArgs) -> Outcome {
    print(&Request::Status, args.json, |r| r.text.clone())
}

/// `ca stop`.
pub fn stop(args: &StatusArgs) -> Outcome {
    print(&Request::Stop, args.json, |r| r.text.clone())
}

fn print(request: &Request, json: bool, text: impl FnOnce(&Reply) -> String) -> Outcome {
    let reply = ask(&Site::of_user()?, request, PATIENCE)?;
    let mut out = std::io::stdout().lock();
    if json {
        writeln!(out, "{:#}", serde_json::to_value(&reply).unwrap_or_default())?;
        return if reply.ok { Ok(Ended::Well) } else { Err(Failure::Reported) };
    }
    if !reply.ok {
        return Err(Failure::Failed(reply.text));
    }
    writeln!(out, "{}", text(&reply))?;
    Ok(Ended::Well)
}
