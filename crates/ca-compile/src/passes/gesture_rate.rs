//! Slow: finds the modules computed once per gesture frame, the links across to the sound, and the modules of the sound
//! that respond within one frame (docs/numerics.md §5.4).
//!
//! A link belongs to the group if it joins masses of the group with each other or with fixed points. Any other link of
//! such a mass crosses. A force travels one link per tick, so that only modules fewer links away than a frame has ticks
//! respond within the frame. These modules must be linear and constant in time.
//!
//! With `border = "compensated"` they need not be: the forecast of the border then omits those that are not. The
//! setting belongs to a group, because any link may cross to it, and must be the same in all groups at the gesture
//! rate, because they are computed as one.

use crate::net::linearisation::{own, slopes};
use crate::net::{End, LiaNode, MatRole, Measure, OutputTap, Pruned};
use alloc::collections::{BTreeMap, BTreeSet};
use alloc::format;
use alloc::string::String;
use alloc::vec::Vec;
use ca_core::internal::kind::PortRole;
use ca_core::internal::mat::{MAS, SOL};
use ca_core::internal::op::layout::Shape;
use ca_core::internal::tuning::{Method, Scheme};
use ca_model::diag::{Diag, Diags};
use ca_model::quantity::Plain;
use ca_model::{Model, Span};

/// Largest number of axes of masses that links across may hold.
pub const MOST: usize = 48;
/// Largest product of MATs within reach and ticks per frame. Each MAT costs a number per frame, and two frames at load.
pub const REACH: usize = 65_536;
/// Largest stable T²K/M of a mass M behind a compensated border, on a spring K to a fixed point (docs/numerics.md §5.4,
/// eq. 5).
const LIGHT: f64 = 0.65;

/// Modules computed once per gesture frame, and their links to the sound.
pub struct SlowPart {
    /// Masses, by document number.
    pub slow: Vec<bool>,
    /// Links among them, by document number.
    pub inner: Vec<bool>,
    /// Axes of masses that links across hold.
    pub coupled: Vec<(u32, u8)>,
    /// MATs of the sound that respond within a frame.
    pub reach: Vec<u32>,
    /// True if some response is unknown as a frame begins, which the border compensates.
    pub compensated: bool,
}

/// Finds the modules at the gesture rate and reports what they cannot have; `None` if there are none.
pub fn find(model: &Model, net: &Pruned, diags: &mut Diags) -> Option<SlowPart> {
    let compensated = net.media.iter().any(|m| m.slow && m.compensated);
    let mut say =
        Findings { model, net, diags, said: BTreeSet::new(), compensated, unknown: false, held: BTreeMap::new() };
    say.borders();
    let in_slow = |group: Option<u32>| net.medium_of(group).slow;
    // A group on which no output depends is empty.
    let mats = net.mats.iter().zip(&net.alive).filter(|(_, alive)| **alive).map(|(m, _)| m.group);
    let items = mats.chain(net.lines.iter().map(|l| net.items[l.item as usize].group));
    if !items.into_iter().any(in_slow) {
        return None;
    }
    say.groups();
    for m in net.mats.iter().filter(|m| in_slow(m.group) && m.code != MAS.code && m.code != SOL.code) {
        let help = if matches!(m.role, MatRole::Port(..)) {
            "put the port into a separate group, and link it to a mass of this group"
        } else {
            "use `[MAS]`, `[SOL]` and links, or give the group `rate = \"sound\"`"
        };
        say.item(m.item, &format!("`{}` is of the kind {}", m.name, m.code), "neither a mass nor a fixed point", help);
    }
    for l in net.lines.iter().filter(|l| in_slow(net.items[l.item as usize].group)) {
        let name = &net.items[l.item as usize].name;
        say.item(l.item, &format!("`{name}` is a waveguide"), "not made of masses", "use a `[STRING]`");
    }
    let slow: Vec<bool> = net.mats.iter().map(|m| in_slow(m.group) && !m.is_fixed()).collect();
    for m in (0..).zip(&net.mats).filter(|(i, m)| slow[*i as usize] && net.is_live(m.item)).map(|(_, m)| m) {
        say.item(m.item, &format!("`{}` follows a live parameter", m.name), "not constant", LIVE);
    }
    let holds = |e: End, slow: &[bool]| net.under(e).iter().any(|m| slow[*m as usize]);
    for p in net.pushes.iter().filter(|p| holds(p.end, &slow)) {
        let name = net.inputs[p.input as usize].name.clone();
        let item = net.under(p.end).first().map_or(0, |m| net.mats[*m as usize].item);
        let help = "push a mass at the sound rate, and link it to this one";
        say.item(item, &format!("`{name}` pushes `{}`", net.end_name(p.end)), "pushed from outside", help);
    }
    let fixed = |m: u32| matches!(net.mats[m as usize].role, MatRole::Mat(s) if s.fixed);
    let point = |e: End| matches!(e, End::Point(_));
    let mut part = SlowPart {
        inner: net
            .lias
            .iter()
            .map(|l| {
                let own = |e: End| matches!(e, End::Mat(m) if slow[m as usize] || fixed(m));
                l.all_ends().all(own) && l.all_ends().any(|e| holds(e, &slow))
            })
            .collect(),
        slow,
        coupled: Vec::new(),
        reach: Vec::new(),
        compensated: false,
    };
    let slow = &part.slow;
    let (mut coupled, mut edge) = (BTreeSet::new(), BTreeSet::new());
    for (l, inner) in net.lias.iter().zip(&part.inner) {
        if *inner {
            if l.law.implicit || !l.law.stage.is_explicit() {
                let help = "leave out its `method`, or give the group `rate = \"sound\"`";
                say.item(l.item, &format!("`{}` is implicit", l.name), "depends on future motion", help);
            } else if net.is_live(l.item) {
                say.item(l.item, &format!("`{}` follows a live parameter", l.name), "not constant", LIVE);
            }
            continue;
        }
        if !l.all_ends().any(|e| holds(e, slow)) {
            continue;
        }
        if l.all_ends().any(|e| point(e) && holds(e, slow)) {
            let help = "end the link at a mass";
            say.item(l.item, &format!("`{}` ends at a moving point", l.name), "not a mass", help);
            continue;
        }
        if let Some(why) = varies(net, l) {
            say.varies(l, &why, None);
            // It may act on all axes. The modules at its other ends respond outside the forecast.
            let held = l.all_ends().filter_map(|e| if let End::Mat(m) = e { Some(m) } else { None });
            let held =
                held.filter(|m| slow[*m as usize]).inspect(|m| *say.held.entry(*m).or_default() += slopes(net, l).k);
            coupled.extend(held.flat_map(|m| (0..net.axes(End::Mat(m))).map(move |k| (m, k))));
            continue;
        }
        for (end, axes) in l.ends.into_iter().zip(axes(net, l)) {
            let End::Mat(m) = end else { continue };
            if slow[m as usize] {
                coupled.extend(axes.into_iter().map(|k| (m, k)));
            } else {
                edge.insert(m);
            }
        }
    }
    part.coupled = coupled.into_iter().collect();
    part.reach = reach(net, &part, edge, &mut say);
    say.outputs(&part);
    part.compensated = say.unknown;
    say.compensated(&part);
    if part.coupled.len() > MOST {
        let title = format!(
            "links to the sound hold {} axes of masses at the gesture rate, the limit is {MOST}",
            part.coupled.len()
        );
        let help = "link the sound to fewer masses of the group, or give the group `rate = \"sound\"`";
        say.diags.push(Diag::error("E034", title).at(say.group(), "this group").help(help));
    }
    let frame = (net.ratio * net.oversample) as usize;
    if part.reach.len() * frame > REACH {
        let title = format!(
            "{} modules respond to the group within a frame of {frame} ticks; with this number of ticks, the limit is {}",
            part.reach.len(),
            REACH / frame
        );
        let help = "raise `gesture` in `[rate]`, or give the group `rate = \"sound\"`";
        say.diags.push(Diag::error("E034", title).at(say.group(), "this group").help(help));
    }
    Some(part)
}

const LIVE: &str = "use a number instead, or give the group `rate = \"sound\"`";

/// Returns the reason why the force of a link is not a constant linear function of positions and motion, if it is not.
fn varies(net: &Pruned, l: &LiaNode) -> Option<String> {
    let radial = l.measure == Measure::Radial || l.onto.as_ref().is_some_and(|o| o.measure == Measure::Radial);
    Some(match () {
        () if l.all_ends().any(|e| matches!(e, End::Point(_))) => "ends at a moving point".into(),
        () if net.is_live(l.item) => "follows a live parameter".into(),
        () if l.law.implicit || !l.law.stage.is_explicit() => "is implicit".into(),
        () if !l.law.linear || l.law.mem > 0 || l.sets.is_some() => {
            format!("is of the kind {}, which is not linear", l.kind.code)
        }
        () if radial => {
            "measures a distance in space, which is not linear, instead of a difference `along` an axis".into()
        }
        () if l.onto.is_some() => "joins two pairs of ends".into(),
        () => return None,
    })
}

fn axes(net: &Pruned, l: &LiaNode) -> [Vec<u8>; 2] {
    [0, 1].map(|side| match l.measure {
        Measure::Line(axis) => alloc::vec![axis[side]],
        Measure::Along(n) => (0..net.axes(l.ends[side])).filter(|k| n[*k as usize] != 0.0).collect(),
        Measure::Radial => Vec::new(),
    })
}

/// Returns the MATs of the sound that respond within a frame, following links from those at the `edge`.
fn reach(net: &Pruned, part: &SlowPart, edge: BTreeSet<u32>, say: &mut Findings) -> Vec<u32> {
    let mut at: Vec<Vec<u32>> = alloc::vec![Vec::new(); net.mats.len()];
    for (i, l) in (0..).zip(&net.lias).filter(|(i, _)| !part.inner[*i as usize]) {
        for m in l.all_ends().flat_map(|e| net.under(e)) {
            at[m as usize].push(i);
        }
    }
    let pushed: BTreeSet<u32> = net.pushes.iter().flat_map(|p| net.under(p.end)).collect();
    let waves: BTreeSet<u32> = net.lines.iter().flat_map(crate::net::waveguides::WaveguideNode::junctions).collect();
    let frame = net.ratio * net.oversample;
    let (mut seen, mut now, mut distance) = (edge.clone(), edge, 1);
    while !now.is_empty() && distance <= frame {
        let mut next = BTreeSet::new();
        for m in now {
            let mat = &net.mats[m as usize];
            let last = distance == frame;
            let (modal, wave) = (net.scheme(mat.group) == Scheme::Modal, waves.contains(&m));
            let why = match mat.role {
                MatRole::Port(PortRole::Tgr, _) if net.crossing.shape == Shape::Hold => {
                    say.held_key(mat.item, &format!("`{}` is a key with `border = \"hold\"`", mat.name), distance);
                    continue;
                }
                MatRole::Port(PortRole::Tgr, _) => continue,
                MatRole::Port(..) => "is moved from outside in every sample",
                _ if mat.is_fixed() || part.slow[m as usize] => continue,
                _ if modal => "is in a group with `method = \"modal\"`",
                _ if wave => "is part of a waveguide",
                _ if net.is_live(mat.item) => "follows a live parameter",
                _ if pushed.contains(&m) && !last => "is pushed from outside in every sample",
                _ => "",
            };
            if !why.is_empty() {
                say.reached(mat.item, &format!("`{}` {why}", mat.name), distance);
            }
            let ends = matches!(mat.role, MatRole::Port(..)) || modal || wave;
            if last || !why.is_empty() && (ends || !say.compensated) {
                continue;
            }
            for l in &at[m as usize] {
                let l = &net.lias[*l as usize];
                if let Some(why) = varies(net, l) {
                    say.varies(l, &why, Some(distance));
                } else {
                    next.extend(l.all_ends().flat_map(|e| net.under(e)).filter(|m| !seen.contains(m)));
                }
            }
        }
        seen.extend(&next);
        (now, distance) = (next, distance + 1);
    }
    // Fixed points do not respond, group masses act as ports, and modes and waves have other states than positions.
    let counts = |m: &u32| {
        let mat = &net.mats[*m as usize];
        let place = net.scheme(mat.group) != Scheme::Modal && !waves.contains(m);
        !part.slow[*m as usize] && place && (!mat.is_fixed() || matches!(mat.role, MatRole::Port(..)))
    };
    seen.into_iter().filter(counts).collect()
}

fn distance_text(why: &str, distance: u32) -> String {
    let links = if distance == 1 { "1 link".into() } else { format!("{distance} links") };
    format!("{why}, but responds to a group at the gesture rate within a frame, {links} from it")
}

/// Reports findings, at most one per item.
struct Findings<'a> {
    model: &'a Model,
    net: &'a Pruned,
    diags: &'a mut Diags,
    said: BTreeSet<u32>,
    /// True if a response may be unknown as a frame begins.
    compensated: bool,
    /// True if there is such a response.
    unknown: bool,
    /// Masses of the group at unknown links across, with the sum of their stiffnesses \[N/m\].
    held: BTreeMap<u32, f64>,
}

impl Findings<'_> {
    fn group(&self) -> Span {
        let slow = self.model.groups.iter().zip(&self.net.media).find(|(_, m)| m.slow);
        slow.and_then(|(g, _)| g.props.iter().find(|e| e.key == "rate")).map_or(Span::NONE, |e| e.span)
    }

    fn farther(&self) -> String {
        let frame = self.net.ratio * self.net.oversample;
        format!(
            "place it more than {frame} links from the group, write `border = \"compensated\"` in the group (stability \
             is then not proven), or give the group `rate = \"sound\"`"
        )
    }

    fn item(&mut self, item: u32, why: &str, label: &str, help: &str) {
        if self.said.insert(item) {
            let at = self.model.items[self.net.items[item as usize].model].name_span;
            self.diags
                .push(Diag::error("E034", format!("{why}, in a group at the gesture rate")).at(at, label).help(help));
        }
    }

    /// Records a response that is unknown as a frame begins; an error unless the border is compensated.
    fn unknown(&mut self, item: u32, title: String) {
        self.unknown = true;
        if !self.compensated && self.said.insert(item) {
            let at = self.model.items[self.net.items[item as usize].model].name_span;
            let d = Diag::error("E034", title).at(at, "not known when the frame begins");
            let farther = self.farther();
            self.diags.push(d.help(farther));
        }
    }

    fn reached(&mut self, item: u32, why: &str, distance: u32) {
        self.unknown(item, distance_text(why, distance));
    }

    /// Reports a held key, whose jumps differ from the straight line that the forecast assumes.
    fn held_key(&mut self, item: u32, why: &str, distance: u32) {
        if self.said.insert(item) {
            let at = self.model.items[self.net.items[item as usize].model].name_span;
            let d = Diag::error("E034", distance_text(why, distance)).at(at, "not known when the frame begins");
            self.diags.push(d.help("leave out `border` in `[rate]`, or give the group `rate = \"sound\"`"));
        }
    }

    fn varies(&mut self, l: &LiaNode, why: &str, distance: Option<u32>) {
        let why = format!("`{}` {why}", l.name);
        match distance {
            Some(distance) => self.reached(l.item, &why, distance),
            None => self.unknown(l.item, format!("{why}, but links a group at the gesture rate to the sound")),
        }
    }

    /// Reports `border` without a group at the gesture rate, and groups with different borders.
    fn borders(&mut self) {
        for (g, m) in self.model.groups.iter().zip(&self.net.media) {
            let at = |key: &str| g.props.iter().find(|e| e.key == key).map_or(Span::NONE, |e| e.span);
            let (title, label, help) = match (m.slow, m.compensated) {
                (false, true) => (
                    format!("`{}` is at the sound rate, where `border` does not apply", g.name),
                    "only for a group at the gesture rate",
                    "write `rate = \"gesture\"` too, or leave out `border`",
                ),
                (true, false) if self.compensated => (
                    format!("`{}` has an exact border, but another group has a compensated one", g.name),
                    "groups at the gesture rate are computed as one",
                    "write `border = \"compensated\"` in all of them, or in none",
                ),
                _ => continue,
            };
            let span = if m.compensated || at("border") != Span::NONE { at("border") } else { at("rate") };
            self.diags.push(Diag::error("E034", title).at(span, label).help(help));
        }
    }

    /// Warns that stability with a compensated border is not proven.
    fn compensated(&mut self, part: &SlowPart) {
        if part.compensated && !self.diags.has_errors() {
            let title = "stability is not proven: `border = \"compensated\"` predicts forces from the frames before";
            let of = self.model.groups.iter().flat_map(|g| &g.props).find(|e| e.key == "border");
            let d = Diag::warning("W107", title).at(of.map_or(Span::NONE, |e| e.span), "may add energy");
            let help = "measure it with `ca render --energy`, or raise `gesture` in `[rate]` to reduce it";
            let d = match self.lightest() {
                Some((m, a)) if a > LIGHT => d.help(format!(
                    "`{}` is too light for its links to the sound: T²K/M is {:.2}, and with a fixed point at the other \
                     end it diverges above {LIGHT}; make it heavier, soften the links, or raise `gesture` in `[rate]`",
                    self.net.mats[m as usize].name,
                    Plain(a)
                )),
                _ => d.help(help),
            };
            self.diags.push(d);
        }
    }

    /// Returns the mass with the largest T²K/M, where T is a frame, and this ratio.
    fn lightest(&self) -> Option<(u32, f64)> {
        let frame = f64::from(self.net.ratio * self.net.oversample);
        let all = self.held.iter().map(|(m, k)| (*m, own(self.net, &self.net.mats[*m as usize]).c * frame * frame * k));
        all.max_by(|a, b| a.1.total_cmp(&b.1))
    }

    /// Reports methods and starts that need a single rate.
    fn groups(&mut self) {
        for (g, m) in self.model.groups.iter().zip(&self.net.media).filter(|(_, m)| m.slow) {
            let at = |key: &str| g.props.iter().find(|e| e.key == key).map_or(Span::NONE, |e| e.span);
            if !matches!(m.method, Method::Ca | Method::Auto) {
                let title = format!("`{}` is at the gesture rate, which only `method = \"ca\"` supports", g.name);
                let d = Diag::error("E034", title).at(at("rate"), "not with this method");
                self.diags.push(d.help("leave out `rate` or `method` of the group"));
            }
            if self.net.as_milib {
                let title = format!("`{}` is at the gesture rate, but the model has `start = \"mi.lib\"`", g.name);
                let d = Diag::error("E034", title).at(at("rate"), "mi.lib has one rate");
                self.diags.push(d.help("leave out `rate` of the group or `start` of the model"));
            }
        }
    }

    /// Reports outputs of forces and points within the groups, which the state of the sound does not contain.
    fn outputs(&mut self, part: &SlowPart) {
        let net = self.net;
        for o in &net.outs {
            let slow = |e: End| net.under(e).iter().any(|m| part.slow[*m as usize]);
            let what = match o.tap {
                OutputTap::ForceOn(e) if slow(e) => "the force on a mass",
                OutputTap::Position(e @ End::Point(_)) if slow(e) => "a moving point",
                OutputTap::ForceOf(l) if part.inner[l as usize] => "the force of a link",
                _ => continue,
            };
            let item = o.item.map(|i| net.items[i as usize].model);
            let at = item.map_or(Span::NONE, |i| self.model.items[i].name_span);
            let title = format!("`{}` reads {what} in a group at the gesture rate", o.name);
            let d = Diag::error("E034", title).at(at, "not part of the sound");
            self.diags.push(d.help("read the position of a mass, or a link between the group and the sound"));
        }
    }
}
