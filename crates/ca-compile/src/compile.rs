//! Compiles a model into a scene: calls all passes in order.
//!
//! The order of the passes is defined only in this file. A pass uses the network, never a later pass. `linear` runs the
//! same passes up to the finished network.

use crate::certify::{certify, combine};
use crate::connect::{coupling, port_checks, wire};
use crate::emit::gesture_rate::Slow;
use crate::emit::{ordering, schedule};
use crate::lower::{params, resolve, values};
use crate::net::Pruned;
#[cfg(feature = "analysis")]
use crate::net::linear::Purpose;
use crate::options::{KernelClass, Options};
use crate::passes::gesture_rate::SlowPart;
use crate::passes::{
    auto, gesture_rate, implicit, modal, pefrl, prune, rates, reach, single, solve_order, specialise, waves,
};
use alloc::boxed::Box;
use ca_core::{Catalog, Certificate, Precision, Scene, Unit};
use ca_model::diag::Diags;
use ca_model::{Entry, Model};

/// A compiled model.
#[derive(Debug)]
pub struct Compiled {
    /// The compiled scene.
    pub scene: Scene,
    /// The same scene with the energy ledger, if [`Options::audited`] asks for it and the method supports a ledger.
    pub audited: Option<Box<Scene>>,
    /// Warnings and notes, sorted by place.
    pub findings: Diags,
}

impl core::ops::Deref for Compiled {
    type Target = Scene;
    fn deref(&self) -> &Scene {
        &self.scene
    }
}

/// Returns the network of a model without the modules that no output depends on.
fn network(model: &Model, catalog: &Catalog, options: &Options) -> Result<(Pruned, Diags), Diags> {
    let mut left = auto::Left::default();
    loop {
        let (mut net, mut diags) = network_with(model, catalog, options, &left)?;
        if !left.learn(&mut net.chosen, &diags) {
            left.report(model, &net.items, &mut diags);
            return Ok((net, diags));
        }
    }
}

/// The same where `auto` leaves some links explicit.
fn network_with(
    model: &Model,
    catalog: &Catalog,
    options: &Options,
    left: &auto::Left,
) -> Result<(Pruned, Diags), Diags> {
    let mut diags = Diags::new();
    let net = resolve::resolve(model, catalog, options, &mut diags);
    let mut net = wire::wire(model, net, options, &mut diags);
    port_checks::check(model, &net, &mut diags);
    if diags.has_errors() {
        diags.sort();
        return Err(diags);
    }
    params::report_unused(&net, &mut diags);
    coupling::couple(&mut net, &options.couplings);
    implicit::choose(&mut net);
    auto::choose(model, &mut net, left, options);
    specialise::specialise(model, &mut net, &mut diags);
    let mut net = prune::prune(model, net, options, &mut diags);
    solve_order::choose(model, &mut net, options, &mut diags);
    implicit::check(model, &mut net, &mut diags);
    waves::settle(model, &mut net, options, &mut diags);
    pefrl::check(model, &net, options, &mut diags);
    reach::mark(&mut net);
    if options.precision == Precision::Single {
        single::check(model, &net, &mut diags);
    }
    Ok((net, diags))
}

/// Parses a number from a text other than a model, such as the plan of a sweep, and returns it in SI.
///
/// The text is checked as in a model without parameters. `what` names the number in findings.
///
/// # Errors
/// One finding, if the entry is not a number of this unit or is out of range.
pub fn measured(e: &Entry, unit: Unit, range: (f64, f64), what: &str) -> Result<f64, Diags> {
    let mut diags = Diags::new();
    let v = values::Values::new(None, &mut diags).constant(e, unit, range, what);
    v.ok_or(diags)
}

/// Returns the linear part of a model at load, for its modes.
///
/// # Errors
/// All findings, sorted, with at least one error. Numbers that are not finite are also an error.
#[cfg(feature = "analysis")]
pub fn linear(model: &Model, catalog: &Catalog, options: &Options) -> Result<crate::analysis::Network, Diags> {
    linear_part(model, catalog, options, Purpose::Modes)
}

/// Returns one tick as matrices: the linear part with the coefficients that the tick computes with.
///
/// The matrices include the positions that position ports move
/// ([`Network::driven`](crate::analysis::Network::driven)).
///
/// # Errors
/// As for [`linear`].
#[cfg(feature = "analysis")]
pub fn linear_tick(model: &Model, catalog: &Catalog, options: &Options) -> Result<crate::analysis::Network, Diags> {
    linear_part(model, catalog, options, Purpose::Tick)
}

#[cfg(feature = "analysis")]
fn linear_part(
    model: &Model,
    catalog: &Catalog,
    options: &Options,
    purpose: Purpose,
) -> Result<crate::analysis::Network, Diags> {
    let (net, mut diags) = network(model, catalog, options)?;
    let linear = crate::net::linear::network(&net, purpose);
    let numbers = |p: &crate::analysis::Dof| [p.c, p.k, p.z].iter().all(|v| v.is_finite());
    if !linear.linear.dofs.iter().all(numbers) || !linear.linear.rows.iter().all(|r| (r.k + r.z).is_finite()) {
        // The certificate reports which numbers these are.
        certify(model, &net, crate::options::Effort::Open, &mut diags);
        diags.sort();
        return Err(diags);
    }
    Ok(linear)
}

/// Compiles a model.
///
/// # Errors
/// All findings, sorted, with at least one error.
pub fn compile(model: &Model, catalog: &Catalog, options: &Options) -> Result<Compiled, Diags> {
    let (mut net, mut diags) = network(model, catalog, options)?;
    let part = gesture_rate::find(model, &net, &mut diags);
    let group = match &part {
        Some(_) if diags.has_errors() => {
            diags.sort();
            return Err(diags);
        }
        Some(part) => {
            rates::sound(&mut net, part);
            // The findings of this second run are dropped: the first one reported them.
            let (mut own, _) = network(model, catalog, options)?;
            rates::group(&mut own, part);
            Some((own, part))
        }
        None => None,
    };
    modal::modal(model, &mut net, &mut diags);
    solve_order::choose_modes(&mut net);
    let mut certificate = certify(model, &net, options.effort(), &mut diags);
    if let Some((own, part)) = &group {
        let slow = certify(model, own, options.effort(), &mut diags);
        certificate = combine(certificate, slow, part.compensated);
    }
    if diags.has_errors() {
        diags.sort();
        return Err(diags);
    }
    let order = order(&net, options);
    let emit = |options: &Options, diags: &mut Diags| {
        let slow = match &group {
            Some((own, part)) => Some(slow_scene(model, own, part, options, diags)?),
            None => None,
        };
        let scene = schedule::schedule(model, &net, &order, options, certificate.clone(), slow.as_ref(), diags);
        scene.filter(|_| !diags.has_errors())
    };
    let scene = emit(options, &mut diags);
    diags.sort();
    let Some(scene) = scene else { return Err(diags) };
    // `pefrl` does not support a ledger.
    let audited = options.audited && !options.energy && !net.is_composed();
    let kept = || emit(&Options { energy: true, ..options.clone() }, &mut Diags::new());
    Ok(Compiled { scene, audited: if audited { kept().map(Box::new) } else { None }, findings: diags })
}

/// Compiles the groups at the gesture rate to a separate scene. Its rows are not fused with integration, because the
/// force on a mass must be known before the mass moves.
fn slow_scene<'a>(
    model: &Model,
    net: &Pruned,
    part: &'a SlowPart,
    options: &Options,
    diags: &mut Diags,
) -> Option<Slow<'a>> {
    let kernel = if options.kernel == KernelClass::Fast { KernelClass::Listed } else { options.kernel };
    let options = Options { kernel, ..options.clone() };
    let order = order(net, &options);
    let scene = schedule::schedule(model, net, &order, &options, Certificate::default(), None, diags)?;
    Some(Slow::new(net, part, scene))
}

fn order(net: &Pruned, options: &Options) -> ordering::Storage {
    match options.kernel {
        KernelClass::Fast | KernelClass::Listed => ordering::storage(net),
        KernelClass::Reference => ordering::document(net),
    }
}
