//! What a model asks of a device, before anybody plays it.
//!
//! The stiffness of a key is the larger of two: the sum that the compiler certifies (all contacts closed, live parameters at
//! their stiffest), and the steepest place of the force over the whole travel of the device, with everything behind the key at
//! rest. The second one finds a law that stiffens without end. Two limits are reported: the stiffness of the profile, and what
//! stays passive with the friction of the device, K ≤ b/(κT), where κT is the delay of the border and one frame more, because a
//! real device takes each force a frame later (docs/numerics.md §5.2: κ = 2). A frame is one of the device if those are longer.
//! A stiffer key is softened while it is played ([`coupling`]). Every hard stop makes a force beyond the
//! largest: the report says where in the travel it begins. A gesture of the model, or a rest of a key, beyond the travel
//! of the device cannot be played: that is a fault too.

use crate::commands::border::quantity;
use crate::load::ticked;
use crate::outcome::Failure;
use crate::term::short;
use ca_core::equivalence::Gains;
use ca_core::{Scene, Unit};
use ca_haptic::calibration::Calibration;
use ca_haptic::coupling::{self, Held, Needed, Presented};
use ca_haptic::engine::Setup;
use ca_haptic::equivalence;
use ca_haptic::profile::Profile;
use ca_model::quantity::{show, six};
use serde_json::{Value as Json, json};
use std::io::Write;

/// A key against the device, in the units of the hand.
struct LimitRow<'a> {
    name: &'a str,
    dof: u32,
    gains: Gains,
    /// what it presents over the travel
    presented: Presented,
    /// where it is softened while it is played, the stiffness that is felt \[N/m\]
    felt: Option<f64>,
    /// no coupling fits it
    too_stiff: bool,
    /// largest force within the travel \[N\]
    force: f64,
    /// where in the travel the force first passes the largest of the device, from the rest of the key \[m\]
    saturates: Option<f64>,
    /// links straight on it, stiffest first, with their stiffness in the hand
    links: Vec<(&'a str, f64)>,
    /// the device has this degree of freedom
    there: bool,
    /// least and largest position that its rest and its gesture ask for \[m\]
    asks: [f64; 2],
}

impl LimitRow<'_> {
    fn k(&self) -> f64 {
        self.presented.k()
    }
}

/// All that is asked.
pub(super) struct DeviceDemands<'a> {
    profile: &'a Profile,
    rows: Vec<LimitRow<'a>>,
    /// what it holds
    held: Held,
    /// gesture frames a second
    rate: f64,
    /// names of the devices of the model that were compared
    devices: Vec<&'a str>,
    feedback: bool,
}

impl<'a> DeviceDemands<'a> {
    /// Compares. The devices of the model that bear the profile's name are meant, or all where none does.
    pub(super) fn new(scene: &'a Scene, profile: &'a Profile) -> DeviceDemands<'a> {
        let mut devices: Vec<&str> =
            scene.inputs.iter().filter_map(|i| i.device.as_ref()).map(|d| d.0.as_str()).collect();
        devices.sort_unstable();
        devices.dedup();
        if devices.contains(&profile.name.as_str()) {
            devices.retain(|d| *d == profile.name);
        }
        let rate = scene.rate / f64::from(scene.rates.ratio);
        let setup = |device: &&str| Setup {
            device: (*device).into(),
            profile: profile.clone(),
            calibration: Calibration::default(),
            gains: equivalence::gains(scene, device),
        };
        let needed = coupling::needed(scene, &devices.iter().map(setup).collect::<Vec<_>>());
        let rows = (0..scene.ports.tgr.len()).filter_map(|t| row(scene, t, profile, &devices, &needed)).collect();
        DeviceDemands {
            profile,
            rows,
            held: Held::new(scene, profile),
            rate,
            devices,
            feedback: scene.ports.crossing.feedback,
        }
    }

    fn missing(&self) -> Vec<&LimitRow<'a>> {
        self.rows.iter().filter(|r| !r.there).collect()
    }

    fn slow(&self) -> bool {
        self.profile.rate < self.rate * (1.0 - 1e-9)
    }

    /// Keys the device cannot render, and which limit they pass.
    fn beyond(&self, r: &LimitRow) -> [bool; 2] {
        let feedback = self.feedback;
        [
            feedback && self.profile.stiffness.is_some_and(|k| r.k() > k * (1.0 + 1e-9)),
            feedback && r.k() > self.held.passive * (1.0 + 1e-9),
        ]
    }

    /// The hold on a key that is firmer than springs, beyond the reach of the device.
    fn firmly(&self, r: &LimitRow) -> Option<String> {
        let (z, b) = (r.presented.viscosity, self.profile.body.friction);
        if !self.feedback || !r.presented.is_rigid(b) {
            None
        } else if r.presented.sticks {
            Some("held by friction that sticks".into())
        } else {
            Some(format!("damped by {} N s/m, × {} of its friction", short(z), short(z / b)))
        }
    }

    /// Whether a key is to be where the device cannot bring it.
    fn outside(&self, r: &LimitRow) -> bool {
        let [low, high] = self.profile.range;
        let slack = 1e-6 * (high - low);
        r.asks[0] < low - slack || r.asks[1] > high + slack
    }

    /// Whether something is asked that the device cannot give.
    pub(super) fn too_much(&self) -> bool {
        !self.missing().is_empty()
            || self.rows.iter().any(|r| self.outside(r))
            || self.rows.iter().any(|r| self.beyond(r).contains(&true) || self.firmly(r).is_some())
    }

    /// For people.
    pub(super) fn text(&self, out: &mut impl Write) -> Result<(), Failure> {
        let p = self.profile;
        writeln!(out, "\nOn {} (`{}`):", p.title, p.name)?;
        let metre = |v: f64| show(short(v).parse().unwrap_or(v), Unit::METRE);
        let own = p.stiffness.map_or("stiffness not known".into(), |k| format!("stiffness {}", quantity(k)));
        writeln!(
            out,
            "  device     {} degrees of freedom, travel {}, force {}, {own}, friction {} N s/m",
            p.dof,
            metre(p.range[1] - p.range[0]),
            newton(p.force),
            short(p.body.friction)
        )?;
        writeln!(
            out,
            "  passive    up to {} with that friction, each force a frame later; {} were it taken at once",
            quantity(self.held.passive),
            quantity(self.held.at_once)
        )?;
        let (wants, has) = (show(six(self.rate), Unit::HERTZ), show(six(p.rate), Unit::HERTZ));
        if self.slow() {
            writeln!(
                out,
                "  rates      the model wants {wants} and the device gives {has}: a frame without a new position repeats the last"
            )?;
        } else {
            writeln!(out, "  rates      {wants} wanted, {has} given")?;
        }
        if self.devices.is_empty() {
            writeln!(out, "  keys       none: the model has no TGR with a `device`")?;
            return Ok(());
        }
        let missing = self.missing();
        if !missing.is_empty() {
            let names = ticked(missing.iter().map(|r| r.name));
            writeln!(
                out,
                "  keys       {names} want degrees of freedom beyond the {} it has: they stay at rest",
                p.dof
            )?;
        }
        for r in self.rows.iter().filter(|r| self.outside(r)) {
            writeln!(
                out,
                "  travel     `{}` is to go from {} to {}, the device goes from {} to {}",
                r.name,
                metre(r.asks[0]),
                metre(r.asks[1]),
                metre(p.range[0]),
                metre(p.range[1])
            )?;
        }
        if self.rows.iter().any(|r| self.outside(r)) {
            writeln!(
                out,
                "             scale it for the hand (`ca equiv --set position=…`), or take a device with more travel"
            )?;
        }
        if !self.feedback {
            writeln!(out, "  forces     none reach the hand: `feedback` is false")?;
            return Ok(());
        }
        writeln!(
            out,
            "\n  {:<12} {:>4} {:>11} {:>11} {:>11} {:>11}  result",
            "key", "dof", "stiffness", "of device", "passive", "force"
        )?;
        for r in &self.rows {
            let limit = p.stiffness.map_or("?".into(), |k| format!("{} %", short(100.0 * r.k() / k)));
            let passive = format!("{} %", short(100.0 * r.k() / self.held.passive));
            writeln!(
                out,
                "  {:<12} {:>4} {:>11} {limit:>11} {passive:>11} {:>11}  {}",
                r.name,
                r.dof,
                quantity(r.k()),
                newton(r.force),
                self.verdict(r)
            )?;
            if self.beyond(r).contains(&true) {
                let steeper = r.presented.steepest > r.presented.certified * (1.0 + 1e-6);
                let all: Vec<String> = r.links.iter().take(4).map(|(n, k)| format!("`{n}` {}", quantity(*k))).collect();
                let more = steeper.then(|| "it stiffens within the travel".to_owned());
                let said: Vec<String> =
                    Some(all.join(", ")).filter(|s| !s.is_empty()).into_iter().chain(more).collect();
                writeln!(out, "  {:<17} {}", "", said.join("; "))?;
            }
            if let Some(x) = r.saturates {
                writeln!(
                    out,
                    "  {:<17} the force passes {} {} from rest and stays there",
                    "",
                    newton(p.force),
                    metre(x)
                )?;
            }
        }
        if self.rows.iter().any(|r| r.felt.is_some() || self.beyond(r).contains(&true)) {
            writeln!(
                out,
                "\n  A softened key is felt through a virtual coupling: the model and its sound stay as they are. A key above 0.9 of \
                 the passive\n  stiffness is softened to half of it, for a profile may be wrong. To feel more of it, lower the stiffness of \
                 its links, make the\n  model lighter in the hand (`ca equiv --set stiffness=…`), or raise `rate.gesture`: passive \
                 stiffness grows with it. A key\n  beyond a limit that is not softened can shake in the hand."
            )?;
        }
        Ok(())
    }

    fn verdict(&self, r: &LimitRow) -> String {
        if !r.there {
            return "not on this device".into();
        }
        let times = |limit: f64| short(r.k() / limit);
        let forces = match self.beyond(r) {
            [true, true] => format!(
                "× {} what it renders, × {} what stays passive",
                times(self.profile.stiffness.unwrap_or(f64::INFINITY)),
                times(self.held.passive)
            ),
            [true, false] => format!("× {} what it renders", times(self.profile.stiffness.unwrap_or(f64::INFINITY))),
            [false, true] => format!("× {} what stays passive", times(self.held.passive)),
            [false, false] if r.felt.is_some() || r.too_stiff => String::new(),
            [false, false] if self.outside(r) => return "beyond its travel".into(),
            [false, false] if r.saturates.is_some() => return format!("rendered up to {}", newton(self.profile.force)),
            [false, false] => return "rendered".into(),
        };
        let felt = match r.felt {
            Some(k) => format!("softened to {}", quantity(k)),
            None if r.too_stiff => "no coupling fits: it gives no force".into(),
            None => String::new(),
        };
        let outside = if self.outside(r) { "beyond its travel".into() } else { String::new() };
        let firmly = self.firmly(r).unwrap_or_default();
        [forces, firmly, felt, outside].into_iter().filter(|s| !s.is_empty()).collect::<Vec<_>>().join(", ")
    }

    /// For programs.
    pub(super) fn json(&self) -> Json {
        let p = self.profile;
        let keys: Vec<Json> = self
            .rows
            .iter()
            .map(|r| {
                let [stiff, active] = self.beyond(r);
                let links: Vec<Json> = r.links.iter().map(|(n, k)| json!({"name": n, "k": k})).collect();
                json!({
                    "name": r.name, "dof": r.dof, "there": r.there, "k": r.k(), "certified": r.presented.certified,
                    "steepest": r.presented.steepest, "viscosity": r.presented.viscosity, "sticks": r.presented.sticks,
                    "felt": r.felt, "too_stiff": r.too_stiff, "force": r.force, "saturates": r.saturates, "links": links,
                    "alpha": r.gains.alpha, "beta": r.gains.beta,
                    "beyond_stiffness": stiff, "beyond_passive": active,
                    "asks": r.asks, "beyond_travel": self.outside(r),
                })
            })
            .collect();
        json!({
            "profile": p.name, "dof": p.dof, "range": p.range, "force": p.force, "stiffness": p.stiffness,
            "friction": p.body.friction, "rate": p.rate, "gesture_rate": self.rate, "slow": self.slow(),
            "passive": self.held.passive, "passive_at_once": self.held.at_once, "devices": self.devices, "keys": keys,
            "too_much": self.too_much(),
        })
    }
}

fn newton(v: f64) -> String {
    show(short(v).parse().unwrap_or(v), Unit::NEWTON)
}

/// Device port number `t` of the scene.
fn row<'a>(scene: &'a Scene, t: usize, profile: &Profile, devices: &[&str], needed: &Needed) -> Option<LimitRow<'a>> {
    let port = scene.ports.tgr[t];
    let input = &scene.inputs[port.input as usize];
    let (device, dof) = input.device.as_ref()?;
    if !devices.contains(&device.as_str()) {
        return None;
    }
    let (gains, at) = (input.gains, port.mat as usize);
    let key = coupling::key(scene, at);
    let mut links: Vec<(&str, f64)> =
        key.iter().flat_map(|k| &k.links).map(|(n, k)| (n.as_str(), k * gains.stiffness())).collect();
    links.sort_by(|a, b| b.1.total_cmp(&a.1));
    let presented = Presented::new(scene, t, profile);
    let name = scene.mat_name(at);
    let rest = input.rest / gains.alpha;
    let own = scene.about.gestures.iter().filter(|g| g.0 == input.name).flat_map(|g| &g.1);
    let asks = own.map(|p| p[1] / gains.alpha).fold([rest; 2], |[a, b], x| [a.min(x), b.max(x)]);
    let travel = presented.travel.iter();
    let beyond = travel.clone().filter(|[_, f]| f.abs() > profile.force).map(|[x, _]| (x - rest).abs());
    Some(LimitRow {
        name: &input.name,
        dof: *dof,
        gains,
        force: travel.fold(0.0, |m, [_, f]| m.max(f.abs())),
        saturates: beyond.min_by(f64::total_cmp),
        felt: needed.softened.iter().find(|s| s.coupling.port == name).map(|s| s.felt),
        too_stiff: needed.too_stiff.iter().any(|t| t.port == name),
        presented,
        links,
        there: *dof < profile.dof,
        asks,
    })
}
