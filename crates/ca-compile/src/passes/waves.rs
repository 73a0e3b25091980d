//! Waves: tunes waveguides to delays and filters once their links are known.
//!
//! A junction without a written mass takes the mass that its links need: ½(kT² + 2zT) for each linear link, twice that
//! if both ends move, and 2(kT² + 2zT) for a contact (docs/numerics.md §7.2, §3.2). The minimum is a 16th of the mass
//! of the string per sample. The mass is set before tuning, so that it does not change the pitch.

use crate::findings::round_up;
use crate::lower::resolve::does_not_fit;
use crate::net::worst::worst_bounds;
use crate::net::{End, Pruned};
use crate::options::Options;
use alloc::format;
use alloc::vec::Vec;
use ca_core::Unit;
use ca_core::internal::tuning::wave::{HighDecay, tune};
use ca_model::Model;
use ca_model::diag::{Diag, Diags};
use ca_model::quantity::{self, Plain};
use core::f64::consts::PI;

/// Share of the sound rate below which the corner frequency of a junction is reported.
const LOW_CORNER: f64 = 0.25;

/// Sets the masses of the junctions that stay, and tunes the waveguides.
pub fn settle(model: &Model, net: &mut Pruned, options: &Options, diags: &mut Diags) {
    let high = if options.is_since(8) { HighDecay::Pole } else { HighDecay::Gain };
    let mut lines = core::mem::take(&mut net.lines);
    lines.retain(|l| net.alive[l.first as usize]);
    if !lines.is_empty() {
        let needs = needs(net);
        for line in &mut lines {
            let masses: Vec<f64> = line.junctions().map(|m| line.spec.mass(needs[m as usize], net.tick_dt)).collect();
            let tick_dt = net.tick_dt;
            let item = &mut net.items[line.item as usize];
            for (i, m) in masses.iter().enumerate() {
                item.slots[1 + i] = Some(line.spec.cell(*m, tick_dt));
            }
            let item = &net.items[line.item as usize];
            let source = &model.items[item.model];
            match tune(&line.spec, &masses, net.tick_dt, high) {
                Ok(tuned) => {
                    let low = masses.iter().fold(0.0f64, |a, b| a.max(*b));
                    let corner = line.spec.z / (PI * low);
                    if corner < LOW_CORNER * net.rate {
                        let title = format!(
                            "above {:.0} Hz, the mass of a junction of `{}` dominates over the string",
                            Plain(corner),
                            item.name
                        );
                        let d = Diag::note("N203", title)
                            .at(source.name_span, quantity::show(round_up(low), Unit::KILOGRAM));
                        diags.push(
                            d.help("to raise this frequency, use softer links, a larger `z` or a higher sound rate"),
                        );
                    }
                    if let (Some(t60), Some([f, _])) = (tuned.reached, line.spec.high) {
                        let title = format!(
                            "`{}` cannot decay that fast at {} Hz: it takes {:.3} s",
                            item.name,
                            Plain(f),
                            Plain(t60)
                        );
                        let d = Diag::warning("W114", title);
                        let entry = source.args.iter().find(|e| e.key == "t60_high");
                        let d = d.at(entry.map_or(source.name_span, |e| e.span), "out of reach");
                        diags.push(d.help(
                            "the filter with three taps cannot do more with this `t60`; \
                                          use a longer `t60_high`, or a shorter `t60`",
                        ));
                    }
                    line.tuned = Some(tuned);
                }
                Err(p) => diags.push(does_not_fit(&item.name, source, p)),
            }
        }
    }
    net.lines = lines;
}

/// Returns the mass that the links of each MAT need if it is a junction \[kg\].
fn needs(net: &Pruned) -> Vec<f64> {
    let mut needs = alloc::vec![0.0; net.mats.len()];
    for (l, b) in net.lias.iter().zip(worst_bounds(net)).filter(|(l, _)| l.law.stage.is_explicit()) {
        let moving = l.all_ends().filter(|e| net.under(*e).iter().any(|m| !net.mats[*m as usize].is_fixed())).count();
        let share = if b.contact { 2.0 } else { 0.5 * moving as f64 };
        for e in l.all_ends() {
            let End::Mat(m) = e else { continue };
            needs[m as usize] += share * net.tick_dt * net.tick_dt * (b.k + 2.0 * b.z).max(0.0);
        }
    }
    needs
}
