//! Outputs and probes: the quantities they read and, in space, the axes.

use crate::connect::select::{Meaning, Written};
use crate::connect::unknown::PROBE;
use crate::connect::wiring::Wiring;
use crate::findings::type_name;
use crate::lower::space;
use crate::net::{End, OutNode, OutputTap};
use alloc::format;
use alloc::string::ToString;
use alloc::vec::Vec;
use ca_core::internal::io::{HEAR, Hear};
use ca_core::internal::live::Source;
use ca_model::LARGEST;
use ca_model::diag::Diag;
use ca_model::part::instances;
use ca_model::{Entry, Span, Value};

impl Wiring<'_> {
    /// Returns the axes of an end that a port reads or pushes, with their shares.
    pub(super) fn directed(
        &mut self,
        end: End,
        along: Option<[f64; 3]>,
        owner: &str,
        span: Span,
        does: &str,
    ) -> Option<Vec<(u8, f64)>> {
        let axes = self.net.axes(end);
        let name = self.net.end_name(end);
        let d = match (axes, along) {
            (1, None) => return Some(alloc::vec![(0, 1.0)]),
            (1, Some(_)) => Diag::error("E029", format!("`{owner}` has a direction, but `{name}` is on a line"))
                .at(span, "on a line")
                .help("leave out `along`"),
            (_, None) => Diag::error("E029", format!("`{owner}` {does} `{name}`, which moves along {axes} axes"))
                .at(span, "no direction")
                .help("add `along = \"x\"`, `\"y\"`, `\"z\"` or a direction such as `[0, 0.6, 0.8]`"),
            (_, Some(n)) => {
                return Some((0..3u8).filter(|k| n[*k as usize] != 0.0).map(|k| (k, n[k as usize])).collect());
            }
        };
        self.diags.push(d);
        None
    }

    pub(super) fn taps(&mut self, e: &Entry, name: &str, force: bool) -> Vec<OutputTap> {
        let text = match &e.value {
            Value::Text(text) => text,
            Value::List(l) if !l.is_empty() => return l.iter().flat_map(|e| self.taps(e, name, force)).collect(),
            other => {
                let title = format!("`from` of `{name}` must be the name of a module, not {}", type_name(other));
                let help = "put the name in quotes, e.g. `\"bar\"`, or `\"low[*]\"` for all modules of `low`";
                self.diags.push(Diag::error("E006", title).at(e.span, "not a name").help(help));
                return Vec::new();
            }
        };
        let why = "SOX reads the position of a mass; SOF reads the force of a link";
        match self.select(Written { text, span: e.span, owner: name }, (!force).then_some(why)) {
            Some(Meaning::Links(l)) => l.into_iter().map(OutputTap::ForceOf).collect(),
            Some(Meaning::Ends(v)) if force => v.into_iter().map(OutputTap::ForceOn).collect(),
            Some(Meaning::Ends(v)) => v.into_iter().map(OutputTap::Position).collect(),
            None => Vec::new(),
        }
    }

    pub(super) fn output(&mut self, id: u32, force: bool) {
        let item = &self.net.items[id as usize];
        let (name, kind) = (item.name.clone(), item.kind);
        let index = |key: &str| kind.param(key).unwrap_or(0);
        let channel = item.args[index("channel")].num();
        let along = kind.param("along").and_then(|i| space::direction(&item.args[i]));
        let quantity = kind.param(HEAR.name).map_or(Hear::Position, |i| Hear::of(item.args[i].num()));
        let force = force || quantity == Hear::Force;
        if let (Hear::Acceleration, Some(e)) = (quantity, self.entry(id, "dc")) {
            let d = Diag::error("E010", format!("`{name}`: `dc` and `hear = \"acceleration\"` exclude each other"));
            let d = d.at(e.span, "an acceleration has a steady part of 0");
            self.diags.push(d.help("leave out `dc`, or write `hear = \"speed\"`"));
        }
        let Some(e) = self.entry(id, "from") else { return };
        let taps = self.taps(e, &name, force);
        let minus = self.entry(id, "minus").map(|e| (e, self.taps(e, &name, force)));
        if let Some((m, other)) = &minus {
            if !other.is_empty() && !taps.is_empty() && other.len() != taps.len() {
                let (a, b) = (taps.len(), other.len());
                let d = Diag::error("E018", format!("`{name}` has {a} modules in `from` and {b} in `minus`"))
                    .at(m.span, "a different number");
                self.diags.push(d.help("name the same number of modules in `minus` as in `from`"));
                return;
            }
        }
        let per_tick = match quantity {
            Hear::Speed => 1.0 / self.net.tick_dt,
            Hear::Acceleration => 1.0 / (self.net.tick_dt * self.net.tick_dt),
            _ => 1.0,
        };
        let many = taps.len() > 1 && channel.is_none();
        for (i, tap) in taps.into_iter().enumerate() {
            let own = if many { format!("{name}[{i}]") } else { name.to_string() };
            let channel = channel.map_or(self.net.channels.len() as u32, |c| c as u32);
            if channel > 255 {
                // Reported once.
                if !self.diags.list.iter().any(|d| d.code == "E027" && d.title.ends_with("256 channels")) {
                    let d = Diag::error("E027", format!("`{name}` is beyond the limit of 256 channels"));
                    self.diags.push(d.at(e.span, "one too many").help("give several outputs the same `channel`"));
                }
                return;
            }
            if self.net.outs.len() >= LARGEST {
                self.too_many(&name, "outputs", e.span);
                return;
            }
            while self.net.channels.len() <= channel as usize {
                self.net.channels.push(own.clone());
            }
            let gain = Source::Slot(index("gain") as u32);
            let other = minus.as_ref().and_then(|(e, all)| Some((*all.get(i)?, e.span, -per_tick)));
            for (tap, span, factor) in [(tap, e.span, per_tick)].into_iter().chain(other) {
                let parts = match tap {
                    OutputTap::Position(end) | OutputTap::ForceOn(end) => {
                        self.directed(end, along, &name, span, "reads")
                    }
                    OutputTap::ForceOf(_) => Some(alloc::vec![(0, 1.0)]),
                };
                for (axis, share) in parts.into_iter().flatten() {
                    let (name, share) = (own.clone(), share * factor);
                    let item = Some(id);
                    self.net.outs.push(OutNode { name, tap, quantity, axis, share, channel, gain, item, request: 0 });
                }
            }
        }
    }

    /// Adds a probe: one value on a line, one value per axis in space.
    pub(super) fn probe(&mut self, text: &str, request: u32) {
        if let Some(each) = instances(self.model, text) {
            return each.iter().for_each(|name| self.probe(name, request));
        }
        // The name of an output stands for its quantity, along its direction. An output with several channels gives one
        // value per channel.
        let of = |o: &OutNode| o.item.is_some_and(|i| o.name == text || *self.net.items[i as usize].name == *text);
        let heard: Vec<OutNode> = self.net.outs.iter().filter(|o| of(o)).cloned().collect();
        let mut last = None;
        for o in &heard {
            let channel = match last {
                Some((from, channel)) if from == o.channel => channel,
                _ => self.next_probe(),
            };
            last = Some((o.channel, channel));
            self.net.outs.push(OutNode { channel, gain: Source::Const(1.0), item: None, request, ..o.clone() });
        }
        if last.is_some() {
            return;
        }
        let taps = match self.select(Written { text, span: Span::NONE, owner: PROBE }, None) {
            Some(Meaning::Links(l)) => l.into_iter().map(OutputTap::ForceOf).collect::<Vec<_>>(),
            Some(Meaning::Ends(v)) => v.into_iter().map(OutputTap::Position).collect(),
            None => return,
        };
        let many = taps.len() > 1;
        for tap in taps {
            // A single result has the name that was asked for; several have their own names.
            let name = match tap {
                _ if !many => text.into(),
                OutputTap::Position(end) | OutputTap::ForceOn(end) => self.net.end_name(end),
                OutputTap::ForceOf(l) => self.net.lias[l as usize].name.to_string(),
            };
            let axes = if let OutputTap::Position(e) = tap { self.net.axes(e) } else { 1 };
            // Three values for a plane too: the frozen axis is stored like the others.
            for axis in 0..if axes > 1 { 3 } else { 1 } {
                let name = if axes > 1 { format!("{name}.{}", space::AXES[axis as usize]) } else { name.clone() };
                let (channel, gain) = (self.next_probe(), Source::Const(1.0));
                let (quantity, share, item) = (Hear::Position, 1.0, None);
                self.net.outs.push(OutNode { name, tap, quantity, axis, share, channel, gain, item, request });
            }
        }
    }

    /// Returns the channel of the next probe, after all sound channels.
    fn next_probe(&self) -> u32 {
        let probes = self.net.outs.iter().filter(|o| o.item.is_none()).map(|o| o.channel + 1).max();
        probes.unwrap_or(self.net.channels.len() as u32)
    }
}
