//! Live MIDI: turns bytes into motions of ports and changes of controllers.
//!
//! Bytes may arrive in pieces of any size, from a cable or a page, as a stream with running status and interleaved
//! clock messages. Ports move as they do from a file ([`MidiPort`]). An event that moves nothing is reported once for
//! each kind, not dropped silently. Controllers 0 to 31 have 14 bits if the controller 32 above follows.

#[cfg(feature = "files")]
pub mod cables;

use crate::gesture::{MidiPort, Motion, PortMap};
use midly::MidiMessage;
use midly::live::LiveEvent;
use midly::stream::MidiStream;
use std::collections::BTreeSet;

/// Effect of an event.
#[derive(Clone, Debug, PartialEq)]
pub enum Played {
    /// A port moves.
    Port(String, Motion),
    /// A controller moved, and may be bound to something.
    Control {
        /// Channel, from 1.
        channel: u8,
        /// Number of the controller, 0 … 127.
        number: u8,
        /// Position of the controller, 0 … 1.
        part: f64,
        /// True if a port follows it.
        used: bool,
    },
    /// a program change, which may choose a preset
    Program {
        /// from 1
        channel: u8,
        /// 0 … 127
        number: u8,
    },
    /// Description of an event that moves nothing, once for each kind.
    Unheard(String),
}

/// Stream of bytes from one source: its running status and its incomplete event.
#[derive(Default)]
pub struct Cable(MidiStream);

/// The ports of a model that listen to MIDI.
pub struct LiveMidi {
    ports: Vec<(String, MidiPort)>,
    /// Upper seven bits of the controllers that may have 14 bits.
    coarse: [[u8; 32]; 16],
    /// Kinds of events already reported, by channel.
    told: BTreeSet<(u8, String)>,
}

impl LiveMidi {
    /// Starts with no note held.
    pub fn new(ports: &[PortMap]) -> LiveMidi {
        let names = ports.iter().map(|p| p.port.clone());
        let ports = names.zip(MidiPort::all(ports)).collect();
        LiveMidi { ports, coarse: [[0; 32]; 16], told: BTreeSet::new() }
    }

    /// Returns true if some port listens.
    pub fn listens(&self) -> bool {
        !self.ports.is_empty()
    }

    /// Takes bytes from a cable and returns the effects of the events that they complete.
    pub fn feed(&mut self, cable: &mut Cable, bytes: &[u8]) -> Vec<Played> {
        let mut events = Vec::new();
        cable.0.feed(bytes, |event| {
            if let LiveEvent::Midi { channel, message } = event {
                events.push((channel.as_int() + 1, message));
            }
        });
        events.into_iter().flat_map(|(channel, message)| self.event(channel, message)).collect()
    }

    fn event(&mut self, channel: u8, message: MidiMessage) -> Vec<Played> {
        let moved =
            |(name, port): &mut (String, MidiPort)| Some(Played::Port(name.clone(), port.event(channel, message)?));
        let mut all: Vec<Played> = self.ports.iter_mut().filter_map(moved).collect();
        let used = self.ports.iter().any(|(_, port)| port.follows(channel, message));
        match message {
            MidiMessage::Controller { controller, value } => {
                let (number, value) = (controller.as_int(), value.as_int());
                let coarse = &mut self.coarse[usize::from(channel - 1)];
                let (number, part, used) = match number {
                    0..=31 => {
                        coarse[usize::from(number)] = value;
                        (number, f64::from(value) / 127.0, used)
                    }
                    32..=63 => {
                        let all = u16::from(coarse[usize::from(number - 32)]) << 7 | u16::from(value);
                        let whole = MidiMessage::Controller { controller: (number - 32).into(), value: 0.into() };
                        let used = used || self.ports.iter().any(|(_, port)| port.follows(channel, whole));
                        (number - 32, f64::from(all) / 16383.0, used)
                    }
                    _ => (number, f64::from(value) / 127.0, used),
                };
                // from 120 on they are channel mode messages
                if number < 120 {
                    all.push(Played::Control { channel, number, part, used });
                }
            }
            MidiMessage::ProgramChange { program } => all.push(Played::Program { channel, number: program.as_int() }),
            _ if used => {}
            MidiMessage::NoteOn { key, vel } if vel > 0 => all.extend(self.unheard(channel, format!("note {key}"))),
            MidiMessage::PitchBend { .. } => all.extend(self.unheard(channel, "pitch bend".into())),
            MidiMessage::ChannelAftertouch { .. } => all.extend(self.unheard(channel, "channel pressure".into())),
            MidiMessage::Aftertouch { .. } => all.extend(self.unheard(channel, "key pressure".into())),
            _ => {}
        }
        all
    }

    /// Reports an event that moves nothing, the first time.
    fn unheard(&mut self, channel: u8, what: String) -> Option<Played> {
        let text = format!("{what} on channel {channel} moves no port");
        self.told.insert((channel, what)).then_some(Played::Unheard(text))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gesture::Glide;
    use ca_core::internal::io::midi::{MidiMap, MidiSource};

    fn port(name: &str, source: MidiSource) -> PortMap {
        let map =
            MidiMap { source, channel: None, from: 1.0, to: 2.0, attack: 0.25, release: 0.5, ..MidiMap::new(source) };
        PortMap { port: name.to_owned(), map }
    }

    struct Keys(LiveMidi, Cable);

    impl Keys {
        fn feed(&mut self, bytes: &[u8]) -> Vec<Played> {
            self.0.feed(&mut self.1, bytes)
        }
    }

    fn key() -> Keys {
        let ports = [port("key", MidiSource::Note { low: 60, high: 62 }), port("mod", MidiSource::Control(1))];
        Keys(LiveMidi::new(&ports), Cable::default())
    }

    fn moved(name: &str, to: f64, over: f64) -> Played {
        Played::Port(name.into(), Motion { lift: None, glide: Glide { to, over } })
    }

    fn glides(to: f64, over: f64) -> Played {
        moved("key", to, over)
    }

    #[test]
    fn notes_in_pieces_with_running_status_and_clocks_between_move_a_port() {
        let mut midi = key();
        assert!(midi.0.listens());
        assert_eq!(midi.feed(&[0x90]), []);
        assert_eq!(midi.feed(&[60, 0xf8]), []);
        assert_eq!(midi.feed(&[127]), [glides(2.0, 0.25)]);
        // running status; the newest note wins, and its end returns to the note still held
        assert_eq!(midi.feed(&[61, 0, 62, 64]), [glides(1.0 + 64.0 / 127.0, 0.25)]);
        assert_eq!(midi.feed(&[62, 0]), [glides(2.0, 0.25)]);
        assert_eq!(midi.feed(&[0x80, 60, 0]), [glides(1.0, 0.5)]);
    }

    #[test]
    fn what_nothing_listens_to_is_told_once() {
        let mut midi = key();
        let note = midi.feed(&[0x91, 30, 9, 30, 9]);
        assert_eq!(note, [Played::Unheard("note 30 on channel 2 moves no port".into())]);
        assert_eq!(midi.feed(&[0x91, 30, 9]), []);
        for (bytes, what) in
            [(&[0xe1, 0, 0][..], "pitch bend"), (&[0xd1, 5], "channel pressure"), (&[0xa1, 60, 5], "key pressure")]
        {
            assert_eq!(midi.feed(bytes), [Played::Unheard(format!("{what} on channel 2 moves no port"))]);
            assert_eq!(midi.feed(bytes), []);
        }
    }

    #[test]
    fn the_pedal_holds_a_note_and_a_note_under_it_comes_up_first() {
        let mut midi = key();
        let pedal = |value| Played::Control { channel: 1, number: 64, part: f64::from(value) / 127.0, used: true };
        assert_eq!(midi.feed(&[0xb0, 64, 127]), [pedal(127)]);
        assert_eq!(midi.feed(&[0x90, 60, 127, 60, 0]), [glides(2.0, 0.25)]);
        let up = Glide { to: 1.0, over: 0.5 };
        let again = Motion { lift: Some(up), glide: Glide { to: 2.0, over: 0.25 } };
        assert_eq!(midi.feed(&[0x90, 61, 127, 61, 0]), [Played::Port("key".into(), again)]);
        assert_eq!(midi.feed(&[0xb0, 64, 63]), [glides(1.0, 0.5), pedal(63)]);
    }

    #[test]
    fn controllers_are_there_for_whoever_binds_them_in_seven_or_fourteen_bits() {
        let mut midi = key();
        let control = |number, part, used| Played::Control { channel: 1, number, part, used };
        assert_eq!(midi.feed(&[0xb0, 74, 127]), [control(74, 1.0, false)]);
        assert_eq!(midi.feed(&[0xb0, 1, 127]), [moved("mod", 2.0, 0.25), control(1, 1.0, true)]);
        assert_eq!(midi.feed(&[0xb0, 33, 127]), [control(1, 1.0, true)]);
        assert_eq!(
            midi.feed(&[0xb0, 2, 64, 34, 0]),
            [control(2, 64.0 / 127.0, false), control(2, 8192.0 / 16383.0, false)]
        );
    }

    #[test]
    fn any_bytes_are_taken() {
        let mut midi = key();
        let mut x = 1_u32;
        for n in 0..20_000 {
            x = x.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let all = midi.feed(&x.to_le_bytes()[..n % 5]);
            let fits = |p: &Played| !matches!(p, Played::Control { part, .. } if !(0.0..=1.0).contains(part));
            assert!(all.iter().all(fits));
        }
    }
}
