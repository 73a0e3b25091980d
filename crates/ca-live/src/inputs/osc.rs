//! Receives OSC over UDP from this machine.
//!
//! Every user of this machine can send to the port. So a model with devices accepts only messages whose address begins
//! with the token ([`token`](super::token)): `/TOKEN/param`. A packet with any other message is dropped as a whole. A
//! model without devices accepts messages with and without the token. [`ca_session::osc`] defines the messages.

use super::Inputs;
use super::token::Token;
use crate::language::ModelLanguage;
use ca_haptic::serve::Recorder;
use ca_lab::Failure;
use ca_session::osc::{self, LARGEST, Target};
use std::net::{Ipv4Addr, UdpSocket};
use std::time::Instant;

pub(super) struct Osc {
    socket: UdpSocket,
    packet: Vec<u8>,
    token: Option<Token>,
    /// Refuses messages without the token.
    closed: bool,
}

impl Osc {
    /// Listens at a port. If `closed` is true, refuses messages without the token.
    pub(super) fn open(port: u16, token: Option<Token>, closed: bool) -> Result<Osc, Failure> {
        let open = || {
            let socket = UdpSocket::bind((Ipv4Addr::LOCALHOST, port))?;
            socket.set_nonblocking(true)?;
            Ok(socket)
        };
        let failed = |e: std::io::Error| Failure::Failed(format!("--osc {port}: {e}; use `--osc 0` for a free port"));
        Ok(Osc { socket: open().map_err(failed)?, packet: vec![0; LARGEST + 1], token, closed })
    }

    pub(super) fn message(&self) -> String {
        let token = self.token.as_ref().filter(|_| self.closed);
        let token = token.map(|t| format!("; addresses must begin with the token in {}", t.path.display()));
        format!("OSC: UDP port {} on this machine{}", self.port(), token.unwrap_or_default())
    }

    fn port(&self) -> u16 {
        self.socket.local_addr().map_or(0, |a| a.port())
    }

    /// Plays the packets received since the last call, at least one and none after `end`.
    pub(super) fn poll(&mut self, inputs: &mut Inputs, recorder: &mut Recorder, end: Instant) {
        let Osc { socket, packet, token, closed } = self;
        let admit = |address: &str| match token.as_ref().and_then(|t| t.strip(address)) {
            Some(rest) => Ok(rest.into()),
            None if *closed => {
                Err("an address must begin with the token, as in `/TOKEN/param`; `ca` names its file at the start"
                    .into())
            }
            None => Ok(address.into()),
        };
        loop {
            let Ok((n, from)) = socket.recv_from(packet) else { return };
            let now = inputs.now();
            let mut target = Target { recorder, midi: &mut inputs.midi, language: &ModelLanguage, now };
            for reply in osc::play(&packet[..n], &admit, &mut target) {
                // replies to a sender that does not listen are lost
                let _ = socket.send_to(&reply, from);
            }
            if Instant::now() >= end {
                return;
            }
        }
    }
}
