//! Compile: all passes, one after the other, from a model to a scene.
//!
//! Decides that the order of the passes stands in this one file: a pass knows the network and none of those behind it. What is
//! asked for besides a scene, its linear part, takes the same way as far as the network goes.

use crate::certify::{beside, certify};
use crate::connect::{coupling, hands, wire};
use crate::emit::slow::Slow;
use crate::emit::{ordering, schedule};
use crate::lower::{params, resolve, values};
use crate::net::Pruned;
#[cfg(feature = "analysis")]
use crate::net::linear::Purpose;
use crate::options::{KernelClass, Options};
use crate::passes::slow::SlowPart;
use crate::passes::{implicit, modal, pefrl, prune, rates, reach, single, slow, solve_order, specialise, waves};
use alloc::boxed::Box;
use ca_core::{Catalog, Certificate, Precision, Scene, Unit};
use ca_model::diag::Diags;
use ca_model::{Entry, Model};

/// What a model became.
#[derive(Debug)]
pub struct Compiled {
    /// what runs
    pub scene: Scene,
    /// the same with the energy ledger, where [`Options::audited`] asks for it and one can be kept
    pub audited: Option<Box<Scene>>,
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
fn network(model: &Model, catalog: &Catalog, options: &Options) -> Result<(Pruned, Diags), Diags> {
    let mut diags = Diags::new();
    let net = resolve::resolve(model, catalog, options, &mut diags);
    let mut net = wire::wire(model, net, options, &mut diags);
    hands::check(model, &net, &mut diags);
    if diags.has_errors() {
        diags.sort();
        return Err(diags);
    }
    params::report_unused(&net, &mut diags);
    coupling::couple(&mut net, &options.couplings);
    implicit::choose(&mut net);
    specialise::specialise(model, &mut net, &mut diags);
    let mut net = prune::prune(model, net, options, &mut diags);
    solve_order::choose(model, &mut net, options.arithmetic, &mut diags);
    implicit::check(model, &net, &mut diags);
    waves::settle(model, &mut net, &mut diags);
    pefrl::check(model, &net, options, &mut diags);
    reach::mark(&mut net);
    if options.precision == Precision::Single {
        single::check(model, &net, &mut diags);
    }
    Ok((net, diags))
}

/// A number that stands in another text than a model, such as the plan of a sweep: in SI, read and judged as one of a
/// model that has no parameters; `what` names it in what is said.
///
/// # Errors
/// With one finding, where it is no such number or out of range.
pub fn measured(e: &Entry, unit: Unit, range: (f64, f64), what: &str) -> Result<f64, Diags> {
    let mut diags = Diags::new();
    let v = values::Values::new(None, &mut diags).constant(e, unit, range, what);
    v.ok_or(diags)
}

/// The linear part of a model at load, for its modes.
///
/// # Errors
/// All findings, sorted, with an error among them; also where the numbers are beyond computing.
#[cfg(feature = "analysis")]
pub fn linear(model: &Model, catalog: &Catalog, options: &Options) -> Result<crate::analysis::Network, Diags> {
    linear_part(model, catalog, options, Purpose::Modes)
}

/// The same with the coefficients that a tick computes with, and with the places that position ports move
/// ([`Network::driven`](crate::analysis::Network::driven)): what a tick does, as matrices.
///
/// # Errors
/// As [`linear`].
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
        // what the numbers are is for the certificate to say
        certify(model, &net, crate::options::Effort::Open, &mut diags);
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
    let part = slow::find(model, &net, &mut diags);
    let group = match &part {
        Some(_) if diags.has_errors() => {
            diags.sort();
            return Err(diags);
        }
        Some(part) => {
            rates::sound(&mut net, part);
            // the same once more: what was said of it is said
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
        certificate = beside(certificate, slow, part.compensated);
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
    // `pefrl` keeps no ledger
    let audited = options.audited && !options.energy && !net.is_composed();
    let kept = || emit(&Options { energy: true, ..options.clone() }, &mut Diags::new());
    Ok(Compiled { scene, audited: if audited { kept().map(Box::new) } else { None }, findings: diags })
}

/// The groups at the gesture rate as a scene of their own. Its rows are not fused: the force on a mass is known before it moves.
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

/// The order of the MATs in the state.
fn order(net: &Pruned, options: &Options) -> ordering::Storage {
    match options.kernel {
        KernelClass::Fast | KernelClass::Listed => ordering::storage(net),
        KernelClass::Reference => ordering::document(net),
    }
}
