//! Reads and checks `midi = { … }` of a port.

use crate::findings::type_name;
use crate::lower::values::Values;
use alloc::format;
use ca_core::internal::io::midi::{MidiMap, MidiSource, Velocity};
use ca_core::{ANY, POSITIVE, Unit};
use ca_model::diag::Diag;
use ca_model::quantity::{near_note, note_number};
use ca_model::suggest::nearest;
use ca_model::{Entry, Value};

const KEYS: &[&str] =
    &["note", "cc", "bend", "pressure", "channel", "from", "to", "attack", "release", "velocity", "back"];

impl Values<'_> {
    /// Reads the mapping `e`; `unit` is the unit of the port.
    pub fn midi(&mut self, e: &Entry, unit: Unit, owner: &str) -> Option<MidiMap> {
        let what = format!("`midi` of `{owner}`");
        let Value::Table(entries) = &e.value else {
            let title = format!("{what} must be a table, not {}", type_name(&e.value));
            let help = "write e.g. `midi = { note = \"C4\", to = \"5 mm\" }`";
            self.diags.push(Diag::error("E026", title).at(e.span, "not a table").help(help));
            return None;
        };
        let mut map = MidiMap::new(MidiSource::PitchBend);
        let mut source: Option<&Entry> = None;
        let (mut to, mut good) = (false, true);
        for m in entries {
            let what = format!("`{}` in {what}", m.key);
            let key = KEYS.iter().find(|k| **k == m.key).copied().unwrap_or("");
            let done = match key {
                "note" => self.notes(m, &what).map(|(low, high)| map.source = MidiSource::Note { low, high }),
                "cc" => self.small(m, (0, 127), "controllers", &what).map(|n| map.source = MidiSource::Control(n)),
                "bend" => self.yes(m, &what).map(|()| map.source = MidiSource::PitchBend),
                "pressure" => self.yes(m, &what).map(|()| map.source = MidiSource::Pressure),
                "channel" => self.small(m, (1, 16), "channels", &what).map(|n| map.channel = Some(n)),
                "from" => self.constant(m, unit, ANY, &what).map(|v| map.from = v),
                "to" => self.constant(m, unit, ANY, &what).map(|v| map.to = v),
                "attack" => self.constant(m, Unit::SECOND, POSITIVE, &what).map(|v| map.attack = v),
                "velocity" => self.velocity(m, &what).map(|v| map.velocity = v),
                "back" => self.flag(m, &what).map(|v| map.back = v),
                "release" => self.constant(m, Unit::SECOND, POSITIVE, &what).map(|v| map.release = v),
                _ => {
                    let d = Diag::error("E026", format!("unknown key {what}")).at(m.key_span, "not part of a mapping");
                    self.diags.push(match nearest(&m.key, KEYS.iter().copied()) {
                        Some(near) => d.help(format!("did you mean `{near}`?")).fix(m.key_span, near),
                        None => d.help(
                            "a mapping has one of `note`, `cc`, `bend`, `pressure`, then `to`, and optionally \
                             `from`, `channel`, `attack`, `release`, `velocity`, `back`",
                        ),
                    });
                    None
                }
            };
            good &= done.is_some();
            to |= m.key == "to";
            if matches!(key, "note" | "cc" | "bend" | "pressure") {
                if let Some(first) = source {
                    let d = Diag::error(
                        "E026",
                        format!("`midi` of `{owner}` has two sources: `{}` and `{}`", first.key, m.key),
                    );
                    let d = d.at(m.key_span, "second source").at(first.key_span, "first source");
                    self.diags.push(d.help("keep one of them: a port follows one source"));
                    good = false;
                }
                source = Some(m);
            }
        }
        if good && (source.is_none() || !to) {
            let (missing, help) = if to {
                ("a source", "add one of `note = \"C4\"`, `cc = 1`, `bend = true`, `pressure = true`".into())
            } else {
                ("`to`", format!("add `to = \"{}\"`: the value at full scale", crate::findings::example(unit)))
            };
            let d = Diag::error("E026", format!("`midi` of `{owner}` needs {missing}")).at(e.span, "incomplete");
            self.diags.push(d.help(help));
            return None;
        }
        if let (true, Some(e)) = (good, entries.iter().find(|e| matches!(e.key.as_str(), "velocity" | "back"))) {
            if !matches!(map.source, MidiSource::Note { .. }) {
                let d = Diag::error("E026", format!("`{}` in {what} is only for notes", e.key))
                    .at(e.key_span, "not with this source");
                self.diags.push(d.help("leave it out, or use `note` as the source"));
                return None;
            }
        }
        good.then_some(map)
    }

    fn velocity(&mut self, e: &Entry, what: &str) -> Option<Velocity> {
        match &e.value {
            Value::Text(t) if t == "depth" => return Some(Velocity::Depth),
            Value::Text(t) if t == "speed" => return Some(Velocity::Speed),
            Value::Text(t) if t == "none" => return Some(Velocity::None),
            _ => {}
        }
        let d = Diag::error("E026", format!("{what} must be `\"depth\"`, `\"speed\"` or `\"none\"`"));
        let help = "`depth`: velocity sets how far the port moves; `speed`: velocity sets how fast it moves all the way; \
                    `none`: it moves all the way in `attack` at any velocity";
        self.diags.push(d.at(e.span, "not a choice").help(help));
        None
    }

    fn flag(&mut self, e: &Entry, what: &str) -> Option<bool> {
        if let Value::Bool(b) = e.value {
            return Some(b);
        }
        let d = Diag::error("E026", format!("{what} must be `true` or `false`")).at(e.span, "neither");
        self.diags.push(
            d.help("with `false`, each note moves the port to its other side, and note off does not move it back"),
        );
        None
    }

    fn yes(&mut self, e: &Entry, what: &str) -> Option<()> {
        if e.value == Value::Bool(true) {
            return Some(());
        }
        let d = Diag::error("E026", format!("{what} must be `true` or left out")).at(e.span, "not `true`");
        self.diags.push(d.help("write `true`, or remove it"));
        None
    }

    fn small(&mut self, e: &Entry, (min, max): (u8, u8), things: &str, what: &str) -> Option<u8> {
        let n = small(e).filter(|n| (min..=max).contains(n));
        if n.is_none() {
            let d = Diag::error("E026", format!("{what} must be a whole number from {min} to {max}"));
            self.diags.push(d.at(e.span, "out of range").help(format!("MIDI has {things} {min} to {max}")));
        }
        n
    }

    /// Reads a note as number or name (C4 = 60), or a range of two.
    fn notes(&mut self, e: &Entry, what: &str) -> Option<(u8, u8)> {
        match &e.value {
            Value::List(l) if l.len() == 2 => {
                let (a, b) = (self.note(&l[0], what), self.note(&l[1], what));
                let (a, b) = (a?, b?);
                if a > b {
                    let d = Diag::error("E026", format!("{what}: the range goes down")).at(e.span, "from high to low");
                    self.diags.push(d.help("write the lowest note first"));
                    return None;
                }
                Some((a, b))
            }
            Value::List(l) => {
                let d = Diag::error("E026", format!("{what}: a range has two notes, not {}", l.len()));
                self.diags
                    .push(d.at(e.span, "not a range").help("write the lowest and the highest: `[\"C3\", \"C5\"]`"));
                None
            }
            _ => self.note(e, what).map(|n| (n, n)),
        }
    }

    fn note(&mut self, e: &Entry, what: &str) -> Option<u8> {
        let Value::Text(t) = &e.value else { return self.small(e, (0, 127), "notes", what) };
        let found = note_number(t);
        if found.is_none() {
            let d = Diag::error("E026", format!("{what}: `{t}` is not a MIDI note")).at(e.span, "not a note");
            let d = match near_note(t).filter(|m| note_number(m).is_some()) {
                Some(m) => d.help(format!("did you mean `{m}`?")).fix(e.span, format!("\"{m}\"")),
                None => d.help(
                    "write a letter from A to G, optionally `#` or `b`, and an octave, from `C-1` to `G9`; `C4` is 60",
                ),
            };
            self.diags.push(d);
        }
        found
    }
}

fn small(e: &Entry) -> Option<u8> {
    match e.value {
        Value::Num(v) if v == libm::floor(v) && (0.0..=127.0).contains(&v) => Some(v as u8),
        _ => None,
    }
}
