//! The scene compiler: from what the author wrote to what runs, leaving out what the scene does not need.
//!
//! ```text
//! Model ─resolve→ Net ─wire→ Net ─prune→ ─specialise→ ─number→ ─schedule→ Scene
//!        units,          links,    what      cheaper      order    passes     ▲
//!        ranges          names     nobody    laws         of MATs             └─ certify
//!                                  hears
//! ```
//! Decides on one network of plain records ([`net::Net`]) between model and scene: every pass reads and rewrites that,
//! and all of them push findings into one list, so an author sees everything at once.

#![no_std]
#![forbid(unsafe_code)]

extern crate alloc;

#[cfg(feature = "analysis")]
pub mod analysis;
pub mod certify;
mod crossing;
mod cutoff;
mod ears;
mod equivalence;
mod expand;
mod fed;
mod gesture;
mod implicit;
#[cfg(feature = "analysis")]
mod linear;
mod lines;
mod links;
mod lists;
#[cfg(feature = "parse")]
pub mod load;
mod lowpass;
mod midi;
mod milib;
#[cfg_attr(not(feature = "analysis"), path = "no_modal.rs")]
mod modal;
mod named;
pub mod net;
mod number;
mod options;
mod oversample;
mod params;
mod passes;
mod pefrl;
mod plan;
mod pressed;
mod prune;
mod rates;
mod resolve;
mod say;
mod schedule;
mod select;
mod sense;
mod sets;
mod single;
mod slopes;
mod space;
mod specialise;
mod turns;
mod values;
mod waves;
mod wire;
mod wiring;

#[cfg(feature = "parse")]
pub use load::load;
pub use options::{KernelClass, Options};

use ca_core::catalog::Catalog;
use ca_core::kind::Unit;
use ca_core::real::SINGLE;
use ca_core::scene::Scene;
use ca_model::diag::Diags;
use ca_model::{Entry, Model};
use net::Net;

/// What a model became.
#[derive(Debug)]
pub struct Compiled {
    /// what runs
    pub scene: Scene,
    /// warnings and notes, sorted by place
    pub findings: Diags,
}

/// It reads as its scene, with the findings added.
impl core::ops::Deref for Compiled {
    type Target = Scene;
    fn deref(&self) -> &Scene {
        &self.scene
    }
}

/// The network of a model, without what nobody hears.
fn network(model: &Model, catalog: &Catalog, options: &Options) -> Result<(Net, Diags), Diags> {
    let mut diags = Diags::new();
    let net = resolve::resolve(model, catalog, options, &mut diags);
    let mut net = wire::wire(model, net, options, &mut diags);
    if diags.has_errors() {
        diags.sort();
        return Err(diags);
    }
    params::report_unused(&net, &mut diags);
    implicit::choose(&mut net);
    specialise::specialise(model, &mut net, &mut diags);
    prune::prune(model, &mut net, &mut diags);
    turns::turns(model, &mut net, &mut diags);
    implicit::check(model, &net, &mut diags);
    waves::settle(model, &mut net, &mut diags);
    pefrl::check(model, &net, options, &mut diags);
    fed::mark(&mut net);
    if SINGLE {
        single::check(model, &net, &mut diags);
    }
    Ok((net, diags))
}

/// A number that stands in another text than a model, such as the plan of a sweep: in SI, read and judged as one of a
/// model that has no parameters; `what` names it in what is said.
pub fn measured(e: &Entry, unit: Unit, range: (f64, f64), what: &str) -> Result<f64, Diags> {
    let mut diags = Diags::new();
    let v = values::Values::new(None, &mut diags).constant(e, unit, range, what);
    v.ok_or(diags)
}

/// The linear part of a model at load, for its modes.
#[cfg(feature = "analysis")]
pub fn linear(model: &Model, catalog: &Catalog, options: &Options) -> Result<crate::analysis::Network, Diags> {
    let (net, mut diags) = network(model, catalog, options)?;
    let linear = linear::network(&net);
    let numbers = |p: &crate::analysis::Place| [p.c, p.k, p.z].iter().all(|v| v.is_finite());
    if !linear.linear.places.iter().all(numbers) || !linear.linear.rows.iter().all(|r| (r.k + r.z).is_finite()) {
        // what the numbers are is for the certificate to say
        certify::certify(model, &net, false, &mut diags);
        diags.sort();
        return Err(diags);
    }
    Ok(linear)
}

/// Compiles a model.
///
/// # Errors
/// All findings, sorted, with an error among them.
pub fn compile(model: &Model, catalog: &Catalog, options: &Options) -> Result<Compiled, Diags> {
    let (mut net, mut diags) = network(model, catalog, options)?;
    modal::modal(model, &mut net, &mut diags);
    let certificate = certify::certify(model, &net, options.exact, &mut diags);
    if diags.has_errors() {
        diags.sort();
        return Err(diags);
    }
    let order = match options.kernel {
        KernelClass::Fast => number::number(&net),
        KernelClass::Reference => number::document(&net),
    };
    let scene = schedule::schedule(model, &net, &order, options, certificate, &mut diags);
    diags.sort();
    match scene {
        Some(scene) if !diags.has_errors() => Ok(Compiled { scene, findings: diags }),
        _ => Err(diags),
    }
}
