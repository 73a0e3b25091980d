//! OSC over UDP, from this machine alone.
//!
//! Every user of this machine can send here, so a model with devices takes only messages whose address begins with the
//! token ([`token`](super::token)): `/TOKEN/param`. Of a packet with another message nothing is used. A model without
//! devices takes all messages, with the token or without it.
//!
//! Time tags count as now, and a bundle sets all its values in one tick. A mistake is answered (`/error`) to the sender. A
//! packet has at most [`LARGEST`] bytes, which also bounds how deep bundles nest.
//!
//! | message | does |
//! |---|---|
//! | `/param NAME VALUE`, `/param/NAME VALUE` | sets a live parameter, a number \[SI\] or a text with a unit |
//! | `/port NAME VALUE [SECONDS]` | sends a position port \[m\] or a force port \[N\] |
//! | `/note KEY VELOCITY [CHANNEL]`, `/control NUMBER VALUE [CHANNEL]` | as MIDI |
//! | `/gesture 1`, `/gesture 0` | the model's own gesture |
//! | `/state` | is answered by `/param NAME VALUE MIN MAX` for each, and `/tick N` |

use super::Inputs;
use super::token::Token;
use crate::language::ModelLanguage;
use crate::outcome::Failure;
use ca_haptic::engine::GLIDE;
use ca_haptic::host::control::Given;
use ca_haptic::serve::Recorder;
use ca_session::value;
use rosc::{OscMessage, OscPacket, OscType, decoder, encoder};
use std::net::{Ipv4Addr, SocketAddr, UdpSocket};
use std::time::Instant;

/// The largest packet \[bytes\].
const LARGEST: usize = 4096;

/// An open port.
pub(super) struct Osc {
    socket: UdpSocket,
    packet: Vec<u8>,
    token: Option<Token>,
    /// messages without the token are refused
    closed: bool,
    /// the packet asks for the state
    asked: bool,
}

impl Osc {
    /// Listens at a port; `closed` to messages without the token.
    pub(super) fn open(port: u16, token: Option<Token>, closed: bool) -> Result<Osc, Failure> {
        let open = || {
            let socket = UdpSocket::bind((Ipv4Addr::LOCALHOST, port))?;
            socket.set_nonblocking(true)?;
            Ok(socket)
        };
        let failed = |e: std::io::Error| Failure::Failed(format!("--osc {port}: {e}; 0 takes a free port"));
        Ok(Osc { socket: open().map_err(failed)?, packet: vec![0; LARGEST + 1], token, closed, asked: false })
    }

    /// Port and token, in words.
    pub(super) fn said(&self) -> String {
        let token = self.token.as_ref().filter(|_| self.closed);
        let token = token.map(|t| format!("; addresses begin with the token in {}", t.path.display()));
        format!("OSC: UDP port {} of this machine{}", self.port(), token.unwrap_or_default())
    }

    fn port(&self) -> u16 {
        self.socket.local_addr().map_or(0, |a| a.port())
    }

    /// What came since the last turn, one packet at least, and no more after `end`.
    pub(super) fn turn(&mut self, inputs: &mut Inputs, recorder: &mut Recorder, end: Instant) {
        loop {
            let Ok((n, from)) = self.socket.recv_from(&mut self.packet) else { return };
            let packet = match decoder::decode_udp(&self.packet[..n]) {
                _ if n > LARGEST => Err(format!("a packet has at most {LARGEST} bytes")),
                Ok((_, packet)) => Ok(packet),
                Err(e) => Err(format!("not OSC: {e}")),
            };
            let mut wrong = Vec::new();
            match packet.and_then(|mut packet| self.admit(&mut packet).map(|()| packet)) {
                Ok(packet) => {
                    let mut sets = Vec::new();
                    self.apply(packet, inputs, recorder, &mut sets, &mut wrong);
                    if !sets.is_empty() {
                        wrong.extend(recorder.set(&sets).err().map(|why| ("/param".into(), why)));
                    }
                }
                Err(why) => wrong.push((String::new(), why)),
            }
            for (address, why) in wrong {
                self.reply(from, "/error", vec![OscType::String(address), OscType::String(why)]);
            }
            if core::mem::take(&mut self.asked) {
                self.state(recorder, from);
            }
            if Instant::now() >= end {
                return;
            }
        }
    }

    /// Takes the token off all addresses.
    fn admit(&self, packet: &mut OscPacket) -> Result<(), String> {
        match packet {
            OscPacket::Bundle(bundle) => bundle.content.iter_mut().try_for_each(|p| self.admit(p)),
            OscPacket::Message(m) => match self.token.as_ref().and_then(|t| t.strip(&m.addr)) {
                Some(rest) => {
                    m.addr = rest.into();
                    Ok(())
                }
                None if self.closed => Err("an address begins with the token, `/TOKEN/param`; `ca` says at its start \
                                            where it lies"
                    .into()),
                None => Ok(()),
            },
        }
    }

    fn apply(
        &mut self,
        packet: OscPacket,
        inputs: &mut Inputs,
        recorder: &mut Recorder,
        sets: &mut Vec<(String, f64)>,
        wrong: &mut Vec<(String, String)>,
    ) {
        match packet {
            OscPacket::Bundle(bundle) => {
                bundle.content.into_iter().for_each(|p| self.apply(p, inputs, recorder, sets, wrong));
            }
            OscPacket::Message(m) => {
                let done = match m.addr.as_str() {
                    // once for a packet
                    "/state" => {
                        self.asked = true;
                        Ok(())
                    }
                    _ => message(&m, inputs, recorder, sets),
                };
                wrong.extend(done.err().map(|why| (m.addr, why)));
            }
        }
    }

    fn state(&self, recorder: &Recorder, from: SocketAddr) {
        for p in recorder.controls().params() {
            let numbers = [p.value, p.min, p.max].map(OscType::Double);
            self.reply(from, "/param", [vec![OscType::String(p.name.clone())], numbers.to_vec()].concat());
        }
        self.reply(from, "/tick", vec![OscType::Long(recorder.progress().1 as i64)]);
    }

    /// Whoever does not listen hears nothing.
    fn reply(&self, to: SocketAddr, addr: &str, args: Vec<OscType>) {
        let packet = OscPacket::Message(OscMessage { addr: addr.into(), args });
        if let Ok(bytes) = encoder::encode(&packet) {
            let _ = self.socket.send_to(&bytes, to);
        }
    }
}

fn message(
    m: &OscMessage,
    inputs: &mut Inputs,
    recorder: &mut Recorder,
    sets: &mut Vec<(String, f64)>,
) -> Result<(), String> {
    let args = &m.args[..];
    if let Some(name) = m.addr.strip_prefix("/param/") {
        let [v] = args else { return Err("takes one value".into()) };
        sets.push((name.into(), value(recorder, &ModelLanguage, name, given(v)?)?));
        return Ok(());
    }
    match (m.addr.as_str(), args) {
        ("/param", [OscType::String(name), v]) => {
            sets.push((name.clone(), value(recorder, &ModelLanguage, name, given(v)?)?));
        }
        ("/param", _) => return Err("takes the name of a live parameter and its value".into()),
        ("/port", [OscType::String(name), v]) => recorder.port(name, number(v)?, GLIDE)?,
        ("/port", [OscType::String(name), v, over]) => recorder.port(name, number(v)?, number(over)?)?,
        ("/port", _) => return Err("takes the name of a port, its value and, if you like, seconds".into()),
        ("/note", [key, velocity, rest @ ..]) => inputs.play(recorder, &midi(0x90, [key, velocity], rest)?),
        ("/note", _) => return Err("takes a key, a velocity (0 to let go) and, if you like, a channel".into()),
        ("/control", [n, v, rest @ ..]) => inputs.play(recorder, &midi(0xb0, [n, v], rest)?),
        ("/control", _) => return Err("takes a controller, a value and, if you like, a channel".into()),
        ("/gesture", [v]) => recorder.gesture(truth(v)?)?,
        ("/gesture", _) => return Err("takes 1 or 0".into()),
        _ => return Err("there is /param, /port, /note, /control, /gesture and /state".into()),
    }
    Ok(())
}

fn number(v: &OscType) -> Result<f64, String> {
    match v {
        OscType::Float(v) => Ok(f64::from(*v)),
        OscType::Double(v) => Ok(*v),
        OscType::Int(v) => Ok(f64::from(*v)),
        OscType::Long(v) => Ok(*v as f64),
        _ => Err("a value is a number".into()),
    }
}

fn given(v: &OscType) -> Result<Given, String> {
    match v {
        OscType::String(text) => Ok(Given::Text(text.clone())),
        v => number(v).map(Given::Number),
    }
}

fn truth(v: &OscType) -> Result<bool, String> {
    match v {
        OscType::Bool(v) => Ok(*v),
        v => match number(v)? {
            n if n.is_nan() => Err("takes 1 or 0".into()),
            n => Ok(n != 0.0),
        },
    }
}

/// The bytes of an event of a channel, the first where none is given.
fn midi(status: u8, data: [&OscType; 2], channel: &[OscType]) -> Result<[u8; 3], String> {
    let byte = |v: &OscType, range: core::ops::RangeInclusive<f64>| {
        let n = number(v)?.round();
        if range.contains(&n) { Ok(n as u8) } else { Err(format!("{n} is not {} to {}", range.start(), range.end())) }
    };
    let channel = match channel {
        [] => 1,
        [c] => byte(c, 1.0..=16.0)?,
        _ => return Err("takes two values and a channel".into()),
    };
    Ok([status | (channel - 1), byte(data[0], 0.0..=127.0)?, byte(data[1], 0.0..=127.0)?])
}
