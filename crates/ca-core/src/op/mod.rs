//! Op: one homogeneous pass over many modules.
//!
//! Decides that a compiled layout is a flat list of records, each with a plain function that was chosen once, at load
//! (the law, the form, with or without offsets and taps). A function pointer rather than an enum of passes, because
//! other crates bring passes of their own (LPR), and rather than a boxed trait object, because the record is then plain
//! data that `ca check --schedule` can print.

use crate::law::Phi;
use crate::layout::Layout;
pub use crate::layout::{Gauge, Ports};
use crate::state::State;
use law::Law;

pub mod blocker;
pub mod crowd;
pub mod finer;
mod gather;
pub mod gauge;
pub mod law;
pub mod lowpass;
pub mod pass;
mod run;
mod space;
pub mod wave;
pub mod wide;

/// One pass, run once per tick.
pub type Kernel = fn(&Op, &Layout, &mut State);

/// How a batch of links is laid out; chooses the kernel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Form {
    /// 0: any MATs; else link i joins `mat + i` and `mat + i + stride`
    pub stride: usize,
    /// some link of the batch has e₀ ≠ 0
    pub offset: bool,
    /// the force of each link is kept in [`State::tap`]
    pub tap: bool,
    /// how the first port measures
    pub gauge: Gauge,
    /// how the second port measures, for quadripoles
    pub onto: Option<Gauge>,
    /// all pairs of two sets are one module; only for contacts without memory
    pub set: bool,
}

/// A pass and where its modules stand.
#[derive(Clone, Copy)]
pub struct Op {
    /// what to run
    pub kernel: Kernel,
    /// what it is, for people: the code of a law, or `advance`, `enx`, …
    pub name: &'static str,
    /// the law, for links
    pub law: Option<&'static Law>,
    /// layout of a batch of links
    pub form: Form,
    /// where the numbers of its ports stand
    pub ports: Ports,
    /// number of modules
    pub n: usize,
    /// first link in [`Layout::ends`], or first entry of whatever list the pass reads
    pub first: usize,
    /// first MAT
    pub mat: usize,
    /// first coefficient in [`State::coef`]; coefficient s of link i is at `coef + s·n + i`
    pub coef: usize,
    /// first number in [`State::mem`]; those of link i start at `mem + i·M`
    pub mem: usize,
    /// first place in [`State::tap`]
    pub tap: usize,
}

impl Op {
    /// A pass without links.
    pub fn pass(name: &'static str, kernel: Kernel, n: usize) -> Op {
        let (form, ports) = (Form::default(), Ports::default());
        Op { kernel, name, law: None, form, ports, n, first: 0, mat: 0, coef: 0, mem: 0, tap: 0 }
    }
}

/// The kernel of a law for one form of a dipole.
pub(crate) fn kernel<P: Phi<C, M> + 'static, const C: usize, const M: usize>(form: Form) -> Kernel {
    if form.set {
        return if form.tap {
            wide::wide::<crowd::All<P, C, M, true>>
        } else {
            wide::wide::<crowd::All<P, C, M, false>>
        };
    }
    match (form.gauge, form.stride > 0, form.offset, form.tap) {
        (Gauge::Line, false, false, false) => gather::gather::<P, C, M, false, false>,
        (Gauge::Line, false, false, true) => gather::gather::<P, C, M, false, true>,
        (Gauge::Line, false, true, false) => gather::gather::<P, C, M, true, false>,
        (Gauge::Line, false, true, true) => gather::gather::<P, C, M, true, true>,
        (Gauge::Line, true, false, _) => wide::wide::<run::Run<P, C, M, false>>,
        (Gauge::Line, true, true, _) => wide::wide::<run::Run<P, C, M, true>>,
        (Gauge::Along, _, _, false) => space::space::<P, gauge::Along, C, M, false>,
        (Gauge::Along, _, _, true) => space::space::<P, gauge::Along, C, M, true>,
        (Gauge::Radial, _, _, false) => space::space::<P, gauge::Radial, C, M, false>,
        (Gauge::Radial, _, _, true) => space::space::<P, gauge::Radial, C, M, true>,
    }
}
