//! `ca set`, `ca audio`, `ca arm`, `ca disarm`, `ca status`, `ca stop`: requests to a running `ca serve`.

use crate::args::common::pair;
use crate::outcome::{Ended, Failure, Outcome};
use ca_haptic::host::Site;
use ca_haptic::host::control::{Given, Reply, Request, ask};
use clap::Args;
use std::io::Write as _;
use std::time::{Duration, Instant};

/// Changes parameters of a running `ca serve` or `ca play`
///
/// All given live parameters change in the same tick, with a ramp over one gesture frame. If one value is refused, none
/// changes. Values may have units; plain numbers are in SI units. `preset=NAME` applies a preset. Without arguments,
/// the live parameters with their values and the presets are listed.
///
/// Any other parameter, as with `--set`, makes `ca play` load the model again with the new value and play on. `ca play`
/// reports errors in it.
#[derive(Args)]
#[command(after_long_help = "Examples:
  ca set
  ca set preset=soft
  ca set k='900 N/m' z=0.5")]
pub struct SetArgs {
    /// Parameters and their new values
    #[arg(value_name = "NAME=VALUE", value_parser = pair)]
    pub values: Vec<(String, String)>,
    /// Prints the answer as JSON
    #[arg(long)]
    pub json: bool,
}

/// Shows or changes the sound output of a running `ca serve` or `ca play`
///
/// Without a name, it shows the current output and the possible ones: a server (`jack`, `pulse`), a sound device by
/// name (with the feature `audio`), and `page`, the page of `ca play`. With a name, the sound moves there while the
/// model plays on. If the new output does not open, the sound stays where it is. If a device disappears, the sound
/// returns to it when it is back.
#[derive(Args)]
#[command(after_long_help = "Examples:
  ca audio
  ca audio --json")]
pub struct AudioArgs {
    /// The server, the sound device, or `page`
    pub device: Option<String>,
    /// Prints the answer as JSON
    #[arg(long)]
    pub json: bool,
}

/// Of which device forces are turned on or off; what it does is said where the commands are listed.
#[derive(Args)]
#[command(after_long_help = "Examples:
  ca arm
  ca arm tgr12
  ca disarm")]
pub struct ArmArgs {
    /// Name of the device (default: all devices)
    pub device: Option<String>,
    /// Prints the answer as JSON
    #[arg(long)]
    pub json: bool,
}

/// Shows the state of a running `ca serve`, or ends it
#[derive(Args)]
#[command(after_long_help = "Examples:
  ca status
  ca status --json
  ca stop")]
pub struct StatusArgs {
    /// Prints the answer as JSON
    #[arg(long)]
    pub json: bool,
}

/// Longest wait for a server, which answers every 2 ms unless the machine is very busy.
const PATIENCE: Duration = Duration::from_secs(5);

/// Longest wait for a sound device to open, and the poll interval.
const OPENS: Duration = Duration::from_secs(15);
const LOOK: Duration = Duration::from_millis(20);

/// Runs `ca set`.
pub fn set(args: &SetArgs) -> Outcome {
    if args.values.is_empty() {
        return print(&Request::Status, args.json, |r| {
            let list = r.fields.get("params").and_then(|p| p.as_array()).cloned().unwrap_or_default();
            if list.is_empty() {
                return "this model does not have live parameters; add `live = true` to a `[param]` to get one".into();
            }
            let line = |p: &serde_json::Value| {
                let part = |k: &str| match &p[k] {
                    serde_json::Value::String(s) => s.clone(),
                    v => v.as_f64().map_or_else(|| v.to_string(), |v| v.to_string()),
                };
                format!("{} = {} {} ({} to {})", part("name"), part("value"), part("unit"), part("min"), part("max"))
            };
            let presets = r.fields.get("presets").and_then(|p| p.as_array());
            let presets: Vec<&str> = presets.into_iter().flatten().filter_map(|p| p.as_str()).collect();
            let presets = (!presets.is_empty()).then(|| format!("presets: {}", presets.join(", ")));
            list.iter().map(line).chain(presets).collect::<Vec<_>>().join("\n")
        });
    }
    let values = args.values.iter().map(|(n, v)| (n.clone(), Given::Text(v.clone()))).collect();
    print(&Request::Set { values }, args.json, |r| r.text.clone())
}

/// Runs `ca audio`.
pub fn audio(args: &AudioArgs) -> Outcome {
    if args.device.is_some() {
        let site = Site::of_user()?;
        let reply = ask(&site, &Request::Audio { to: args.device.clone() }, PATIENCE)?;
        if !reply.ok {
            return Err(Failure::Failed(reply.text));
        }
        // the device opens on another thread while the performance goes on
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
                return Err(Failure::Failed(format!("the sound output does not open within {} s", OPENS.as_secs())));
            }
            std::thread::sleep(LOOK);
        }
    }
    print(&Request::Audio { to: None }, args.json, |r| r.text.clone())
}

/// Runs `ca arm`.
pub fn arm(args: &ArmArgs) -> Outcome {
    print(&Request::Arm { device: args.device.clone() }, args.json, |r| r.text.clone())
}

/// Runs `ca disarm`.
pub fn disarm(args: &ArmArgs) -> Outcome {
    print(&Request::Disarm { device: args.device.clone() }, args.json, |r| r.text.clone())
}

/// Runs `ca status`.
pub fn status(args: &StatusArgs) -> Outcome {
    print(&Request::Status, args.json, |r| r.text.clone())
}

/// Runs `ca stop`.
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
