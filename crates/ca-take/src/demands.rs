//! Demands of a model on a device, before it is played.
//!
//! The stiffness of a key is the larger of two: the sum that the compiler certifies (all contacts closed, live parameters at
//! their stiffest), and the steepest place of the force over the whole travel of the device, with everything behind the key at
//! rest. The second one finds a law that stiffens without end. Two limits are reported: the stiffness of the profile, and what
//! stays passive with the friction of the device, K ≤ b/(κT), where κT is the delay of the border and one frame more, because a
//! real device takes each force a frame later (docs/numerics.md §5.2: κ = 2). A frame is one of the device if those are longer.
//! A stiffer key is softened while it is played ([`coupling`]). Every hard stop makes a force beyond the
//! largest: the report says where in the travel it begins. A gesture of the model, or a rest of a key, beyond the travel
//! of the device cannot be played: that is a fault too.

use ca_core::equivalence::Gains;
use ca_core::{Scene, Unit};
use ca_haptic::calibration::Calibration;
use ca_haptic::coupling::{self, Held, Needed, Presented};
use ca_haptic::engine::Setup;
use ca_haptic::equivalence;
use ca_haptic::profile::Profile;
use ca_lab::facts::border::quantity;
use ca_model::quantity::{short, show};

/// A key against the device, in the units of the hand.
pub struct LimitRow<'a> {
    /// name of the key
    pub name: &'a str,
    /// its degree of freedom
    pub dof: u32,
    /// its scale
    pub gains: Gains,
    /// what it presents over the travel
    pub presented: Presented,
    /// where it is softened while it is played, the stiffness that is felt \[N/m\]
    pub felt: Option<f64>,
    /// no coupling fits it
    pub too_stiff: bool,
    /// largest force within the travel \[N\]
    pub force: f64,
    /// where in the travel the force first passes the largest of the device, from the rest of the key \[m\]
    pub saturates: Option<f64>,
    /// links straight on it, stiffest first, with their stiffness in the hand
    pub links: Vec<(&'a str, f64)>,
    /// the device has this degree of freedom
    pub there: bool,
    /// least and largest position that its rest and its gesture ask for \[m\]
    pub asks: [f64; 2],
}

impl LimitRow<'_> {
    /// Stiffness in the hand \[N/m\].
    pub fn k(&self) -> f64 {
        self.presented.k()
    }
}

/// All that is asked.
pub struct DeviceDemands<'a> {
    /// the device
    pub profile: &'a Profile,
    /// a key each
    pub rows: Vec<LimitRow<'a>>,
    /// what it holds
    pub held: Held,
    /// gesture frames a second
    pub rate: f64,
    /// names of the devices of the model that were compared
    pub devices: Vec<&'a str>,
    /// forces reach the hand
    pub feedback: bool,
}

impl<'a> DeviceDemands<'a> {
    /// Compares. The devices of the model that bear the profile's name are meant, or all where none does.
    pub fn new(scene: &'a Scene, profile: &'a Profile) -> DeviceDemands<'a> {
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

    /// Keys at degrees of freedom that the device lacks.
    pub fn missing(&self) -> Vec<&LimitRow<'a>> {
        self.rows.iter().filter(|r| !r.there).collect()
    }

    /// True if the device sends fewer frames than the model has.
    pub fn slow(&self) -> bool {
        self.profile.rate < self.rate * (1.0 - 1e-9)
    }

    /// Keys the device cannot render, and which limit they pass.
    pub fn beyond(&self, r: &LimitRow) -> [bool; 2] {
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

    /// True if a key is to be where the device cannot bring it.
    pub fn outside(&self, r: &LimitRow) -> bool {
        let [low, high] = self.profile.range;
        let slack = 1e-6 * (high - low);
        r.asks[0] < low - slack || r.asks[1] > high + slack
    }

    /// True if the device cannot give all that is asked.
    pub fn too_much(&self) -> bool {
        !self.missing().is_empty()
            || self.rows.iter().any(|r| self.outside(r))
            || self.rows.iter().any(|r| self.beyond(r).contains(&true) || self.firmly(r).is_some())
    }

    /// The result of a key, in words.
    pub fn verdict(&self, r: &LimitRow) -> String {
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
}

/// Three digits of a force.
pub fn newton(v: f64) -> String {
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
