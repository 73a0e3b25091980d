//! Reads the parts of `[rate]` besides the two rates: the border of devices and the low-pass of the outputs.

use crate::lower::lowpass;
use crate::lower::values::Values;
use crate::net::Resolved;
use ca_core::internal::io::TGR;
use ca_core::internal::op::layout::{Crossing, Shape};
use ca_core::{Need, Param, Type, Unit};
use ca_model::Model;
use ca_model::diag::Diags;

/// Longest delay \[frames\], about 3 s at 3 kHz; the state stores it.
const LATEST: u32 = 10_000;

ca_core::choice! {
    /// Position of a device between two frames.
    enum Border {
        Linear = "linear",
        Hold = "hold",
    }
}

const BORDER: Param =
    Param::new("border", Type::Choice(Border::WORDS), Need::Default(0.0), "position of a device within a frame");
const LATENCY: Param = Param::new(
    "latency",
    Type::Count { min: 0, max: LATEST },
    Need::Default(0.0),
    "delay added to each device, in frames",
);
const FEEDBACK: Param = Param::new("feedback", Type::Flag, Need::Default(1.0), "whether the device gets a force");
const FILTER: Param =
    Param::number("filter", Unit::HERTZ, (1.0, 1e7), Need::Optional, "edge of the low-pass of the outputs");

/// Reads the settings into the network, whose rates must be known.
pub fn crossing(model: &Model, net: &mut Resolved, diags: &mut Diags) {
    let mut v = Values::new(None, diags);
    let mut number = |p: &Param| {
        let e = model.rate.iter().find(|e| e.key == p.name)?;
        // `arg` uses the kind only for exponents, which these parameters are not.
        let (arg, _) = v.arg(&TGR, p, e, &[], "[rate]")?;
        arg.num()
    };
    let shape = match Border::of(number(&BORDER)) {
        Border::Linear => Shape::Linear,
        Border::Hold => Shape::Hold,
    };
    let latency = number(&LATENCY).unwrap_or(0.0) as u32;
    let feedback = number(&FEEDBACK) != Some(0.0);
    net.crossing = Crossing { shape, latency, feedback };
    // Ticks between samples are dropped only after a low-pass at half the sound rate.
    if let Some(edge) = number(&FILTER).or((net.oversample > 1).then_some(lowpass::WIDEST * net.rate)) {
        let span = model.rate.iter().find(|e| e.key == FILTER.name).map(|e| e.span);
        net.lowpass = lowpass::design(edge, net.rate, net.oversample, span, diags);
    }
}
