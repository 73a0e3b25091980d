//! Open Sound Control: plays packets and makes their answers. The caller owns the socket.
//!
//! Time tags are ignored: everything applies now. A bundle sets all its values in one tick. An error is answered by
//! `/error`. A packet has at most [`LARGEST`] bytes, which also bounds the nesting of bundles.
//!
//! | message | effect |
//! |---|---|
//! | `/param NAME VALUE`, `/param/NAME VALUE` | sets a live parameter, a number \[SI\] or a text with a unit |
//! | `/preset NAME` | sets the live parameters of a preset |
//! | `/port NAME VALUE [SECONDS]` | moves a position port \[m\] or a force port \[N\] |
//! | `/note KEY VELOCITY [CHANNEL]`, `/control NUMBER VALUE [CHANNEL]` | as MIDI |
//! | `/gesture 1`, `/gesture 0` | starts or stops the model's own gesture |
//! | `/state` | is answered by `/param NAME VALUE MIN MAX` for each parameter, and `/tick N` |

use crate::answer::value;
use crate::host::Language;
use crate::midi::Midi;
use crate::preset;
use crate::refused::Refused;
use ca_haptic::control::Given;
use ca_haptic::engine::GLIDE;
use ca_haptic::serve::Recorder;
use rosc::{OscMessage, OscPacket, OscType, decoder, encoder};
use std::time::Duration;

/// Largest packet \[bytes\].
pub const LARGEST: usize = 4096;

/// Parts that a packet plays.
pub struct Target<'a> {
    /// Receives ports, parameters and gestures.
    pub recorder: &'a mut Recorder,
    /// Receives notes and controllers.
    pub midi: &'a mut Midi,
    /// Parses texts with units.
    pub language: &'a dyn Language,
    /// Time of the caller's clock.
    pub now: Duration,
}

/// Values set by a packet, and its invalid messages with address and reason.
#[derive(Default)]
struct Outcome {
    sets: Vec<(String, f64)>,
    wrong: Vec<(String, String)>,
    /// True if a message requests the state.
    asked: bool,
}

/// Plays a packet and returns the packets of its answer. `admit` removes the token from an address, or refuses it. A
/// packet with a refused address has no effect.
pub fn play(packet: &[u8], admit: &dyn Fn(&str) -> Result<String, String>, target: &mut Target<'_>) -> Vec<Vec<u8>> {
    let decoded = match decoder::decode_udp(packet) {
        _ if packet.len() > LARGEST => Err(format!("a packet may have at most {LARGEST} bytes")),
        Ok((_, packet)) => Ok(packet),
        Err(e) => Err(format!("not an OSC packet: {e}")),
    };
    let mut done = Outcome::default();
    match decoded.and_then(|mut packet| strip(&mut packet, admit).map(|()| packet)) {
        Ok(packet) => {
            apply(packet, target, &mut done);
            if !done.sets.is_empty() {
                done.wrong.extend(target.recorder.set(&done.sets).err().map(|why| ("/param".into(), why.to_string())));
            }
        }
        Err(why) => done.wrong.push((String::new(), why)),
    }
    let errors = done.wrong.into_iter().map(|w| ("/error", vec![OscType::String(w.0), OscType::String(w.1)]));
    let mut replies: Vec<_> = errors.collect();
    if done.asked {
        replies.extend(state(target.recorder));
    }
    let encoded = |(addr, args): (&str, Vec<OscType>)| {
        encoder::encode(&OscPacket::Message(OscMessage { addr: addr.into(), args })).ok()
    };
    replies.into_iter().filter_map(encoded).collect()
}

/// Removes the token from all addresses.
fn strip(packet: &mut OscPacket, admit: &dyn Fn(&str) -> Result<String, String>) -> Result<(), String> {
    match packet {
        OscPacket::Bundle(bundle) => bundle.content.iter_mut().try_for_each(|p| strip(p, admit)),
        OscPacket::Message(m) => {
            m.addr = admit(&m.addr)?;
            Ok(())
        }
    }
}

fn apply(packet: OscPacket, target: &mut Target<'_>, done: &mut Outcome) {
    match packet {
        OscPacket::Bundle(bundle) => bundle.content.into_iter().for_each(|p| apply(p, target, done)),
        // answered once per packet
        OscPacket::Message(m) if m.addr == "/state" => done.asked = true,
        OscPacket::Message(m) => {
            let why = message(&m, target, &mut done.sets).err();
            done.wrong.extend(why.map(|why| (m.addr, why.to_string())));
        }
    }
}

fn state(recorder: &Recorder) -> Vec<(&'static str, Vec<OscType>)> {
    let param = |p: &ca_core::LiveParam| {
        let numbers = [p.value, p.min, p.max].map(OscType::Double);
        ("/param", [vec![OscType::String(p.name.clone())], numbers.to_vec()].concat())
    };
    let tick = ("/tick", vec![OscType::Long(recorder.progress().1 as i64)]);
    recorder.controls().params().iter().map(param).chain([tick]).collect()
}

fn message(m: &OscMessage, target: &mut Target<'_>, sets: &mut Vec<(String, f64)>) -> Result<(), Refused> {
    let args = &m.args[..];
    let Target { recorder, midi: inputs, language, now } = target;
    if let Some(name) = m.addr.strip_prefix("/param/") {
        let [v] = args else { return Err("expects one value".into()) };
        sets.push((name.into(), value(recorder, *language, name, given(v)?)?));
        return Ok(());
    }
    match (m.addr.as_str(), args) {
        ("/param", [OscType::String(name), v]) => {
            sets.push((name.clone(), value(recorder, *language, name, given(v)?)?));
        }
        ("/preset", [OscType::String(name)]) => sets.extend(preset::values(recorder, *language, name)?),
        ("/preset", _) => return Err("expects the name of a preset".into()),
        ("/param", _) => return Err("expects the name of a live parameter and a value".into()),
        ("/port", [OscType::String(name), v]) => recorder.port(name, number(v)?, GLIDE)?,
        ("/port", [OscType::String(name), v, over]) => recorder.port(name, number(v)?, number(over)?)?,
        ("/port", _) => return Err("expects the name of a port, a value and optionally a time in seconds".into()),
        ("/note", [key, velocity, rest @ ..]) => inputs.play(recorder, &midi(0x90, [key, velocity], rest)?, *now),
        ("/note", _) => return Err("expects a key, a velocity (0 releases the key) and optionally a channel".into()),
        ("/control", [n, v, rest @ ..]) => inputs.play(recorder, &midi(0xb0, [n, v], rest)?, *now),
        ("/control", _) => return Err("expects a controller, a value and optionally a channel".into()),
        ("/gesture", [v]) => recorder.gesture(truth(v)?)?,
        ("/gesture", _) => return Err("expects 1 or 0".into()),
        _ => return Err("unknown address; use /param, /preset, /port, /note, /control, /gesture or /state".into()),
    }
    Ok(())
}

fn number(v: &OscType) -> Result<f64, Refused> {
    match v {
        OscType::Float(v) => Ok(f64::from(*v)),
        OscType::Double(v) => Ok(*v),
        OscType::Int(v) => Ok(f64::from(*v)),
        OscType::Long(v) => Ok(*v as f64),
        _ => Err("the value must be a number".into()),
    }
}

fn given(v: &OscType) -> Result<Given, Refused> {
    match v {
        OscType::String(text) => Ok(Given::Text(text.clone())),
        v => number(v).map(Given::Number),
    }
}

fn truth(v: &OscType) -> Result<bool, Refused> {
    match v {
        OscType::Bool(v) => Ok(*v),
        v => match number(v)? {
            n if n.is_nan() => Err("expects 1 or 0".into()),
            n => Ok(n != 0.0),
        },
    }
}

/// Returns the bytes of a channel event, by default on channel 1.
fn midi(status: u8, data: [&OscType; 2], channel: &[OscType]) -> Result<[u8; 3], Refused> {
    let byte = |v: &OscType, range: core::ops::RangeInclusive<f64>| -> Result<u8, Refused> {
        let n = number(v)?.round();
        if range.contains(&n) {
            Ok(n as u8)
        } else {
            Err(format!("{n} is outside {} to {}", range.start(), range.end()).into())
        }
    };
    let channel = match channel {
        [] => 1,
        [c] => byte(c, 1.0..=16.0)?,
        _ => return Err("expects two values and optionally a channel".into()),
    };
    Ok([status | (channel - 1), byte(data[0], 0.0..=127.0)?, byte(data[1], 0.0..=127.0)?])
}
