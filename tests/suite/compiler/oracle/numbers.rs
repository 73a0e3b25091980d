//! Numbers of a model in SI, by parameter name.

use super::network::Curve;
use ca_model::{Entry, Item, Model, Value, quantity};

pub fn entry<'e>(list: &'e [Entry], key: &str) -> Option<&'e Value> {
    list.iter().find(|e| e.key == key).map(|e| &e.value)
}

pub fn list(v: &Value) -> &[Entry] {
    if let Value::List(l) = v { l } else { &[] }
}

/// Text of a parameter, empty if missing.
pub fn word<'i>(i: &'i Item, key: &str) -> &'i str {
    if let Some(Value::Text(t)) = entry(&i.args, key) { t } else { "" }
}

pub struct Numbers<'a> {
    pub model: &'a Model,
    /// Length of a tick [s].
    pub tick_dt: f64,
    /// Ticks per gesture frame.
    pub ratio: u64,
    /// Tick for which bare numbers are written [s], in per-sample units.
    sample: Option<f64>,
}

impl<'a> Numbers<'a> {
    pub fn new(model: &'a Model) -> Numbers<'a> {
        let mut n = Numbers { model, tick_dt: 1.0, ratio: 1, sample: None };
        let sound = entry(&model.rate, "sound").map_or(48e3, |v| n.value(v, 0.0));
        let near = sound / (sound / 3000.0).round().max(1.0);
        let gesture = entry(&model.rate, "gesture").map_or(near, |v| n.value(v, 0.0));
        (n.tick_dt, n.ratio) = (1.0 / sound, (sound / gesture).round() as u64);
        if model.meta("units").is_some_and(|e| e.value == "alg".into()) {
            n.sample = Some(model.meta("reference_rate").map_or(n.tick_dt, |e| 1.0 / n.value(&e.value, 0.0)));
        }
        n
    }

    /// Value of a number, quantity or parameter name. Bare numbers scale with the sample to this power.
    pub fn value(&self, v: &Value, power: f64) -> f64 {
        let bare = self.sample.map_or(1.0, |t| libm::pow(t, power));
        let read = |t: &str| match quantity::parse(t) {
            Ok(q) if q.has_unit => q.value,
            Ok(q) => q.value * bare,
            Err(_) => f64::NAN,
        };
        match v {
            Value::Num(v) => v * bare,
            Value::Bool(b) => f64::from(u8::from(*b)),
            Value::Text(t) if quantity::is_quantity(t) => read(t),
            Value::Text(t) => match entry(&self.model.params, t) {
                Some(Value::Table(p)) => match (entry(p, "value"), entry(p, "unit")) {
                    (Some(Value::Num(v)), Some(Value::Text(u))) if !u.is_empty() => read(&format!("{v} {u}")),
                    (v, _) => self.value(v.expect("a value"), power),
                },
                Some(v) => self.value(v, power),
                None => quantity::note(t).expect("a parameter or a note"),
            },
            _ => f64::NAN,
        }
    }

    pub fn maybe(&self, i: &Item, key: &str) -> Option<f64> {
        let power = match (i.kind.as_str(), key) {
            (_, "m" | "m_total") => 2.0,
            (_, "z" | "zo" | "t60" | "t60_high" | "h") => 1.0,
            ("BOW", "f") => 0.0,
            (_, "f" | "f_high" | "v" | "v0" | "v1") => -1.0,
            _ => 0.0,
        };
        entry(&i.args, key).map(|v| self.value(v, power))
    }

    pub fn num(&self, i: &Item, key: &str) -> f64 {
        self.maybe(i, key).unwrap_or(0.0)
    }

    /// Gravity, friction or number of axes for a module: of its group, else of the model.
    fn around(&self, i: &Item, key: &str) -> Option<&Value> {
        let group = i.group.and_then(|g| entry(&self.model.groups[g].props, key));
        group.or(self.model.meta(key).map(|e| &e.value))
    }

    pub fn friction(&self, i: &Item) -> f64 {
        self.around(i, "friction").map_or(0.0, |v| self.value(v, 1.0))
    }

    /// Axes along which the module moves.
    pub fn axes(&self, i: &Item) -> usize {
        self.around(i, "dim").map_or(1.0, |v| self.value(v, 0.0)) as usize
    }

    /// Acceleration; a single number points down along the last axis.
    pub fn gravity(&self, i: &Item) -> [f64; 3] {
        let mut g = [0.0; 3];
        match self.around(i, "gravity") {
            Some(v @ Value::List(_)) => list(v).iter().zip(&mut g).for_each(|(e, g)| *g = self.value(&e.value, -2.0)),
            Some(v) => g[self.axes(i) - 1] = -self.value(v, -2.0),
            None => {}
        }
        g
    }

    /// One number per axis.
    pub fn place(&self, i: &Item, key: &str) -> [f64; 3] {
        let power = if matches!(key, "v" | "spin") { -1.0 } else { 0.0 };
        let mut place = [0.0; 3];
        match entry(&i.args, key) {
            Some(v @ Value::List(_)) => {
                list(v).iter().zip(&mut place).for_each(|(e, p)| *p = self.value(&e.value, power));
            }
            Some(v) => place[0] = self.value(v, power),
            None => {}
        }
        place
    }

    pub fn along(&self, i: &Item) -> Option<[f64; 3]> {
        let v = entry(&i.args, "along")?;
        if let Value::Text(t) = v {
            return Some(["x", "y", "z"].map(|a| f64::from(u8::from(a == t))));
        }
        let n = self.place(i, "along");
        let l = n.iter().map(|v| v * v).sum::<f64>().sqrt();
        Some(n.map(|v| v / l))
    }

    pub fn curve(&self, i: &Item, key: &str, power: f64) -> Option<Curve> {
        let pair = |e: &Entry| {
            let pair = list(&e.value);
            [self.value(&pair[0].value, power), self.value(&pair[1].value, 0.0)]
        };
        entry(&i.args, key).map(|v| list(v).iter().map(pair).collect())
    }

    /// kT²/m and zT/m of a mode heard at `f` that decays by 60 dB in `t60`.
    pub fn heard_at(&self, f: f64, t60: f64) -> (f64, f64) {
        let decay = 3.0 * std::f64::consts::LN_10 / t60;
        let lost = -libm::expm1(-decay * self.tick_dt);
        let half = libm::sin(std::f64::consts::PI * f * self.tick_dt);
        (lost * lost + 4.0 * (1.0 - lost) * half * half, -libm::expm1(-2.0 * decay * self.tick_dt))
    }
}
