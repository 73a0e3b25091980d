//! Reads rates, units and media, i.e. settings of the whole model or of a group.
//!
//! This module defines the tick of the physics relative to the sample of the outputs.

use crate::lower::values::Values;
use crate::net::{Medium, Resolved};
use crate::options::Options;
use alloc::format;
use ca_core::internal::io::TGR;
use ca_core::internal::phi::implicit::{OF_GROUP, OF_MODEL, THETA};
use ca_core::internal::tuning::Method;
use ca_core::{ANY, Need, POSITIVE, Param, Type, Unit};
use ca_model::diag::{Diag, Diags};
use ca_model::quantity::Plain;
use ca_model::suggest::nearest;
use ca_model::{Entry, Model, Span, Value};

/// Slowest and fastest clock \[Hz\].
pub const CLOCK: (f64, f64) = (1.0, 1e7);
/// Largest number of ticks per sample.
pub const FINEST: u32 = 64;
const OVERSAMPLE: Param =
    Param::new("oversample", Type::Count { min: 1, max: FINEST }, Need::Default(1.0), "ticks per sample");

ca_core::choice! {
    enum GroupRate {
        Sound = "sound",
        Gesture = "gesture",
    }
}
const RATE: Param =
    Param::new("rate", Type::Choice(GroupRate::WORDS), Need::Default(0.0), "rate at which a group is computed");

ca_core::choice! {
    /// Border between a group at the gesture rate and the sound.
    enum GroupBorder {
        /// The force of a frame is known as it begins.
        Exact = "exact",
        /// The unknown part of the force is extrapolated from the frames before.
        Compensated = "compensated",
    }
}
const BORDER: Param = Param::new(
    "border",
    Type::Choice(GroupBorder::WORDS),
    Need::Default(0.0),
    "how a group at the gesture rate is coupled to the sound",
);

/// Sets the sound rate, the ticks per sample, the tick and the ratio of the rates.
pub fn rates(model: &Model, options: &Options, net: &mut Resolved, diags: &mut Diags) {
    let hertz = |key: &str, diags: &mut Diags| {
        let e = model.rate.iter().find(|e| e.key == key)?;
        let mut v = Values::new(None, diags);
        Some((v.number(e, Unit::HERTZ, CLOCK, &format!("`rate.{key}`")).map(|n| n.0), e.span))
    };
    let written = hertz("sound", diags);
    let gesture = hertz("gesture", diags);
    let asked = options.rate.filter(|r| {
        let good = (CLOCK.0..=CLOCK.1).contains(r);
        if !good {
            let d = Diag::error("E020", format!("the sound rate cannot be {} Hz", Plain(*r)));
            diags.push(d.help(format!("use a rate from {} to {} Hz", Plain(CLOCK.0), Plain(CLOCK.1))));
        }
        good
    });
    let sound = asked.or(written.and_then(|w| w.0)).unwrap_or(48_000.0);
    net.rate = sound;
    let finer = model.rate.iter().find(|e| e.key == OVERSAMPLE.name).and_then(|e| {
        // `arg` uses the kind only for exponents.
        Values::new(None, diags).arg(&TGR, &OVERSAMPLE, e, &[], "[rate]")?.0.num()
    });
    net.oversample = finer.map_or(1, |n| n as u32);
    net.tick_dt = 1.0 / (sound * f64::from(net.oversample));
    net.ratio = 1;
    // A rate that could not be read cannot be compared.
    if matches!(written, Some((None, _))) || matches!(gesture, Some((None, _))) || options.rate != asked {
        return;
    }
    // Default: 3 kHz, or the nearest rate that divides the sound rate, e.g. 44.1 kHz / 15.
    let slow = gesture.and_then(|g| g.0).unwrap_or(sound / libm::round(sound / 3000.0).max(1.0));
    let ratio = libm::round(sound / slow).max(1.0);
    if (sound / ratio - slow).abs() > 1e-6 * slow || slow > sound {
        let place = |w: Option<(Option<f64>, Span)>| w.map_or(Span::NONE, |w| w.1);
        let span = place(gesture);
        let title =
            format!("the sound rate, {} Hz, is not a multiple of the gesture rate, {} Hz", Plain(sound), Plain(slow));
        let mut d = Diag::error("E020", title).at(span, "does not divide the sound rate");
        if asked.is_some() {
            d = d.help(format!("with this gesture rate, use a sound rate of {} Hz", Plain(slow * ratio)));
        } else {
            if place(written).is_some() {
                d = d.at(place(written), "the sound rate");
            }
            let near = sound / ratio;
            d = d.help(format!("the nearest rate that does is {} Hz", Plain(near)));
            // A fraction of a hertz is not offered as a fix.
            if near == libm::round(near) {
                d = d.fix(span, format!("\"{near} Hz\""));
            }
        }
        diags.push(d);
    }
    net.ratio = ratio as u32;
}

/// Returns the tick of the reference rate, for `alg` units.
pub fn reference(model: &Model, net: &Resolved, diags: &mut Diags) -> Option<f64> {
    let e = model.meta("units")?;
    let word = if let Value::Text(t) = &e.value { t.as_str() } else { "" };
    match word {
        "si" => None,
        "alg" => {
            let Some(e) = model.meta("reference_rate") else { return Some(1.0 / net.rate) };
            let mut v = Values::new(None, diags);
            v.number(e, Unit::HERTZ, CLOCK, "`model.reference_rate`").map(|r| 1.0 / r.0)
        }
        _ => {
            let d = Diag::error("E011", "`units` of `[model]` is neither `si` nor `alg`").at(e.span, "not a choice");
            let all = "`si`: SI units; `alg`: per-sample units at `reference_rate`, as in GENESIS and mi.lib";
            diags.push(match nearest(word, ["si", "alg"].into_iter()) {
                Some(near) => d.help(all).fix(e.span, format!("\"{near}\"")),
                None => d.help(all),
            });
            None
        }
    }
}

/// Reads gravity, friction and methods of every group; the medium of the model comes last.
pub fn media(model: &Model, net: &mut Resolved, v: &mut Values<'_>) {
    let method = if format(model, v) >= 2.0 { Method::Auto } else { Method::Ca };
    let plain = Medium { method, ..Medium::default() };
    let root = medium(&model.meta, ["`[model]`", "[model]"], plain, &OF_MODEL, v);
    for g in &model.groups {
        let m = medium(&g.props, [&format!("group `{}`", g.name), &g.name], root, &OF_GROUP, v);
        net.media.push(m);
    }
    net.media.push(root);
}

/// Reads `format`, the version of the language that a model is written in. From 2 on the default method is `auto`.
fn format(model: &Model, v: &mut Values<'_>) -> f64 {
    const NEWEST: f64 = 2.0;
    let Some(e) = model.meta("format") else { return 1.0 };
    let whole = v.constant(e, Unit::NONE, (1.0, f64::MAX), "`format` of `[model]`").unwrap_or(1.0);
    if whole > NEWEST || whole.fract() != 0.0 {
        let d = Diag::error(
            "E009",
            format!("`format` of `[model]` is {}, but this program reads formats 1 and 2", Plain(whole)),
        );
        v.diags.push(d.at(e.span, "unknown format").help("write `format = 2`, or use a newer program"));
        return 1.0;
    }
    whole
}

/// Reads the medium of an owner, given as its phrase in findings and its bare name.
fn medium(props: &[Entry], [owner, name]: [&str; 2], outer: Medium, methods: &Param, v: &mut Values<'_>) -> Medium {
    let mut m = outer;
    // First `dim`: the direction of gravity depends on it.
    if let Some(e) = props.iter().find(|e| e.key == "dim") {
        let what = format!("`dim` of {owner}");
        match e.value {
            Value::Num(n) if [1.0, 2.0, 3.0].contains(&n) => m.dim = n as u8,
            _ => {
                let d = Diag::error("E009", format!("{what} must be the number of axes: 1, 2 or 3"));
                let d = d.at(e.span, "neither 1, 2 nor 3");
                v.diags.push(d.help("1: a line; 2: a plane; 3: space").fix(e.span, "3"));
            }
        }
        // The gravity of the model acts along the last axis of the group.
        if m.dim != outer.dim {
            m.gravity = down(m.dim, -down_of(outer));
        }
    }
    for e in props {
        let what = format!("`{}` of {owner}", e.key);
        match e.key.as_str() {
            "gravity" => {
                if let Some(g) = gravity(e, m.dim, &what, v) {
                    m.gravity = g;
                }
            }
            "friction" => {
                if let Some(z) = v.constant(e, Unit::VISCOSITY, POSITIVE, &what) {
                    m.friction = z;
                }
            }
            "method" => m.method = v.word(methods, e, name).map_or(m.method, Method::of),
            "rate" => m.slow = GroupRate::of(v.word(&RATE, e, name)) == GroupRate::Gesture,
            "border" => m.compensated = GroupBorder::of(v.word(&BORDER, e, name)) == GroupBorder::Compensated,
            "theta" => m.theta = v.word(&THETA, e, name).or(m.theta),
            _ => {}
        }
    }
    m
}

/// Returns an acceleration `g` towards negative positions of the last axis.
fn down(dim: u8, g: f64) -> [f64; 3] {
    let mut all = [0.0; 3];
    all[dim as usize - 1] = -g;
    all
}

/// Returns the acceleration along the last axis.
fn down_of(m: Medium) -> f64 {
    m.gravity[m.dim as usize - 1]
}

/// Reads gravity: one number towards negative positions of the last axis, or an acceleration with a number per axis.
fn gravity(e: &Entry, dim: u8, what: &str, v: &mut Values<'_>) -> Option<[f64; 3]> {
    if let Value::List(_) = e.value {
        let list = v.position(e, Unit::ACCELERATION, what)?;
        return crate::lower::space::position(Some(&list), dim, e.span, &what, v.diags);
    }
    v.constant(e, Unit::ACCELERATION, ANY, what).map(|g| down(dim, g))
}
