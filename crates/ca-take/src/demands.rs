//! Compares the stiffness, force and travel that a model needs with the limits of a device, before the model is played.
//!
//! The stiffness of a key is the larger of two values. The first is the sum that the compiler certifies, with all
//! contacts closed and live parameters at their stiffest. The second is the steepest slope of the force over the whole
//! travel of the device, with everything behind the key at rest; it also covers laws that stiffen without limit.
//!
//! Two stiffness limits are reported: the stiffness in the profile, and the passive limit K ≤ b/(κT) for the device's
//! friction b. κT is the delay of the rate boundary plus one frame, because a real device applies each force a frame
//! later (docs/numerics.md §5.2: κ = 2). T is the frame of the device if that is longer than the frame of the model.
//!
//! A stiffer key is softened while it is played ([`coupling`]). Every hard stop exceeds the largest force, so the
//! report says where in the travel that begins. It is also a fault if a gesture or the rest position of a key lies
//! beyond the travel of the device.

use ca_core::equivalence::Gains;
use ca_core::{Scene, Unit};
use ca_haptic::calibration::Calibration;
use ca_haptic::coupling::{self, Needed, Presented, StiffnessLimits};
use ca_haptic::engine::Setup;
use ca_haptic::equivalence;
use ca_haptic::profile::Profile;
use ca_lab::facts::border::quantity;
use ca_model::quantity::{short, show};

/// Comparison of a key with the device, in units at the hand.
pub struct LimitRow<'a> {
    /// Name of the key.
    pub name: &'a str,
    /// Degree of freedom of the key.
    pub dof: u32,
    /// Scale between model and hand.
    pub gains: Gains,
    /// Force and stiffness of the key over the travel.
    pub presented: Presented,
    /// Stiffness at the hand after softening \[N/m\], if the key is softened.
    pub stiffness: Option<f64>,
    /// True if no coupling fits the key.
    pub too_stiff: bool,
    /// Largest force within the travel \[N\].
    pub force: f64,
    /// Distance from the rest position of the key at which the force first exceeds the limit of the device \[m\].
    pub saturates: Option<f64>,
    /// Links attached directly to the key with their stiffness at the hand, stiffest first.
    pub links: Vec<(&'a str, f64)>,
    /// True if the device has this degree of freedom.
    pub has_dof: bool,
    /// Range of positions that the rest and the gesture of the key require \[m\].
    pub required_range: [f64; 2],
}

impl LimitRow<'_> {
    /// Stiffness at the hand \[N/m\].
    pub fn k(&self) -> f64 {
        self.presented.k()
    }
}

/// Demands of all keys on a device.
pub struct DeviceDemands<'a> {
    /// The device.
    pub profile: &'a Profile,
    /// One row per key.
    pub rows: Vec<LimitRow<'a>>,
    /// Limits of the device.
    pub held: StiffnessLimits,
    /// Gesture rate of the model \[Hz\].
    pub rate: f64,
    /// Names of the compared devices of the model.
    pub devices: Vec<&'a str>,
    /// True if forces reach the hand.
    pub feedback: bool,
}

impl<'a> DeviceDemands<'a> {
    /// Compares the devices of the model named like the profile, or all devices if none has that name.
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
            held: StiffnessLimits::new(scene, profile),
            rate,
            devices,
            feedback: scene.ports.crossing.feedback,
        }
    }

    /// Returns keys at degrees of freedom that the device lacks.
    pub fn missing(&self) -> Vec<&LimitRow<'a>> {
        self.rows.iter().filter(|r| !r.has_dof).collect()
    }

    /// Returns true if the frame rate of the device is below the gesture rate of the model.
    pub fn slow(&self) -> bool {
        self.profile.rate < self.rate * (1.0 - 1e-9)
    }

    /// Returns whether a key exceeds the stiffness of the profile, and whether it exceeds the passive limit.
    pub fn beyond(&self, r: &LimitRow) -> [bool; 2] {
        let feedback = self.feedback;
        [
            feedback && self.profile.stiffness.is_some_and(|k| r.k() > k * (1.0 + 1e-9)),
            feedback && r.k() > self.held.passive * (1.0 + 1e-9),
        ]
    }

    /// Describes friction or damping at a key that is too strong for the device.
    fn firmly(&self, r: &LimitRow) -> Option<String> {
        let (z, b) = (r.presented.viscosity, self.profile.body.friction);
        if !self.feedback || !r.presented.is_rigid(b) {
            None
        } else if r.presented.sticks {
            Some("held by sticking friction".into())
        } else {
            Some(format!("damped by {} N s/m, {} × its friction", short(z), short(z / b)))
        }
    }

    /// Returns true if a key must reach positions outside the range of the device.
    pub fn outside(&self, r: &LimitRow) -> bool {
        let [low, high] = self.profile.range;
        let slack = 1e-6 * (high - low);
        r.required_range[0] < low - slack || r.required_range[1] > high + slack
    }

    /// Returns true if the device cannot meet all demands.
    pub fn too_much(&self) -> bool {
        !self.missing().is_empty()
            || self.rows.iter().any(|r| self.outside(r))
            || self.rows.iter().any(|r| self.beyond(r).contains(&true) || self.firmly(r).is_some())
    }

    /// Describes the result for a key in words.
    pub fn verdict(&self, r: &LimitRow) -> String {
        if !r.has_dof {
            return "not on this device".into();
        }
        let times = |limit: f64| short(r.k() / limit);
        let forces = match self.beyond(r) {
            [true, true] => format!(
                "{} × what it can render, {} × the passive limit",
                times(self.profile.stiffness.unwrap_or(f64::INFINITY)),
                times(self.held.passive)
            ),
            [true, false] => format!("{} × what it can render", times(self.profile.stiffness.unwrap_or(f64::INFINITY))),
            [false, true] => format!("{} × the passive limit", times(self.held.passive)),
            [false, false] if r.stiffness.is_some() || r.too_stiff => String::new(),
            [false, false] if self.outside(r) => return "beyond its travel".into(),
            [false, false] if r.saturates.is_some() => return format!("rendered up to {}", newton(self.profile.force)),
            [false, false] => return "rendered".into(),
        };
        let felt = match r.stiffness {
            Some(k) => format!("softened to {}", quantity(k)),
            None if r.too_stiff => "no coupling fits, so it gives no force".into(),
            None => String::new(),
        };
        let outside = if self.outside(r) { "beyond its travel".into() } else { String::new() };
        let firmly = self.firmly(r).unwrap_or_default();
        [forces, firmly, felt, outside].into_iter().filter(|s| !s.is_empty()).collect::<Vec<_>>().join(", ")
    }
}

/// Formats a force with three digits.
pub fn newton(v: f64) -> String {
    show(short(v).parse().unwrap_or(v), Unit::NEWTON)
}

/// Compares device port `t` of the scene. Returns `None` if its device is not among `devices`.
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
        stiffness: needed.softened.iter().find(|s| s.coupling.port == name).map(|s| s.stiffness),
        too_stiff: needed.too_stiff.iter().any(|t| t.port == name),
        presented,
        links,
        has_dof: *dof < profile.dof,
        required_range: asks,
    })
}
