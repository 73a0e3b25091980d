//! LIA: the laws of interaction between two MATs.
//!
//! Decides that a law is written **once**, as a [`Phi`]: a force from the elongation `e = x_j − x_i + e₀` and its change
//! per tick `w = d_j − d_i`, F > 0 pulling the ends together. Every form of the law (gather and run here, 3-D and LPR
//! elsewhere), the energy ledger and the stability bounds call these functions; a law never sees positions, so it
//! cannot depend on a dimension. Coefficients are an array of fixed size, read column-wise by the kernels, so that a
//! homogeneous pass vectorises.

use crate::kind::{ANY, Kind, Need, Param, Type, Unit};
use crate::op::{Form, Kernel, kernel};
use crate::table::Table;

mod att;
mod bow;
mod but;
mod cub;
mod fro;
mod hrz;
mod lnl;
mod plk;
mod pow;
mod ref_;
mod res;

/// All LIA kinds, in the order of the documentation. To add a law: one file, one line here.
pub const KINDS: &[&Kind] = &[
    &res::KIND,
    &fro::KIND,
    &ref_::KIND,
    &but::KIND,
    &cub::KIND,
    &pow::KIND,
    &hrz::KIND,
    &lnl::KIND,
    &plk::KIND,
    &att::KIND,
    &bow::KIND,
];

pub use ref_::KIND as REF;

/// The two ends of a link.
pub const BETWEEN: Param =
    Param::new("between", Type::Between, Need::Required, "the two ends, first and second; lists pair one to one");
/// Rest length.
pub const L0: Param =
    Param::number("l0", Unit::METRE, ANY, Need::Optional, "length at which it is slack; the rest distance if left out");

/// How many links two lists of ends make.
pub const PAIRS: Param = Param::new(
    "pairs",
    Type::Choice(&["each", "all"]),
    Need::Default(0.0),
    "each: lists pair one to one; all: every pair, once",
);

/// Linear bound of a law: no slope of its force exceeds `k` \[N/m\] against elongation nor `z` \[N/(m/tick)\] against
/// change of elongation. Both ≥ 0 except for springs that are negative on purpose. `contact` marks laws that switch.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Bound {
    /// largest slope against elongation \[N/m\]
    pub k: f64,
    /// largest slope against change of elongation per tick \[N per m/tick\]
    pub z: f64,
    /// true where the force switches on and off with distance
    pub contact: bool,
    /// true where the law is linear and the bound therefore exact
    pub linear: bool,
    /// true where the law can feed energy in by itself
    pub active: bool,
}

/// A law of interaction. `C` coefficients per link, `M` numbers of memory per link.
pub trait Phi<const C: usize, const M: usize> {
    /// True where force is linear in `e` and `w`: the ledger identity then holds exactly.
    const LINEAR: bool = false;

    /// Coefficients per tick from the parameters in SI (in the order of [`Kind::params`]) and the tick `te` \[s\].
    fn coefs(p: &[Option<f64>], te: f64) -> [f64; C];

    /// Memory at load, for elongation `e`.
    fn start(_c: &[f64; C], _e: f64) -> [f64; M] {
        [0.0; M]
    }

    /// The force \[N\], F > 0 pulls the ends together.
    fn force(c: &[f64; C], mem: &mut [f64; M], tables: &[Table], e: f64, w: f64) -> f64;

    /// Potential energy \[J\] at elongation `e`.
    fn potential(_c: &[f64; C], _mem: &[f64; M], _tables: &[Table], _e: f64) -> f64 {
        0.0
    }

    /// Energy held between two ticks \[J\] (numerics 2.2); linear laws override it with the exact product form.
    fn stored(c: &[f64; C], mem: &[f64; M], tables: &[Table], e0: f64, e1: f64) -> f64 {
        0.5 * (Self::potential(c, mem, tables, e0) + Self::potential(c, mem, tables, e1))
    }

    /// Energy turned to heat during a tick \[J\], from the elongations at the tick before, at it, and after.
    fn lost(_c: &[f64; C], _mem: &[f64; M], _tables: &[Table], _e: [f64; 3]) -> f64 {
        0.0
    }

    /// Linear bounds, for the certificate.
    fn bound(c: &[f64; C], tables: &[Table]) -> Bound;
}

/// A law as data: the functions of a [`Phi`] over slices, and its kernels.
#[derive(Clone, Copy)]
pub struct Law {
    /// code of the law that runs, e.g. `RES` for a REF without viscosity
    pub code: &'static str,
    /// coefficients per link
    pub coefs: usize,
    /// numbers of memory per link
    pub mem: usize,
    /// see [`Phi::LINEAR`]
    pub linear: bool,
    /// see [`Phi::coefs`]; `out` has [`Law::coefs`] places
    pub load: fn(p: &[Option<f64>], te: f64, out: &mut [f64]),
    /// see [`Phi::start`]
    pub start: fn(c: &[f64], e: f64, mem: &mut [f64]),
    /// see [`Phi::force`]
    pub force: fn(c: &[f64], mem: &mut [f64], tables: &[Table], e: f64, w: f64) -> f64,
    /// see [`Phi::stored`]
    pub stored: fn(c: &[f64], mem: &[f64], tables: &[Table], e0: f64, e1: f64) -> f64,
    /// see [`Phi::lost`]
    pub lost: fn(c: &[f64], mem: &[f64], tables: &[Table], e: [f64; 3]) -> f64,
    /// see [`Phi::bound`]
    pub bound: fn(c: &[f64], tables: &[Table]) -> Bound,
    /// the pass for one form of the law
    pub kernel: fn(Form) -> Kernel,
    /// a cheaper law for these parameters (`None` marks one that may change while playing), if there is one
    pub simpler: fn(p: &[Fixed]) -> Option<&'static Law>,
    /// a table the law needs whatever its parameters; its number is handed over after the last parameter
    pub table: Option<fn() -> Table>,
}

/// What is known of a parameter when a law is specialised.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Fixed {
    /// not written
    Absent,
    /// this value, for good
    At(f64),
    /// may change while playing
    Live,
}

impl Fixed {
    /// True where the parameter is nothing and stays so.
    pub fn is_zero(self) -> bool {
        matches!(self, Fixed::Absent | Fixed::At(0.0))
    }
}

fn arr<const N: usize>(s: &[f64]) -> [f64; N] {
    s.first_chunk::<N>().copied().unwrap_or([0.0; N])
}

impl Law {
    /// The record of a law.
    pub const fn of<P: Phi<C, M> + 'static, const C: usize, const M: usize>(code: &'static str) -> Law {
        Law {
            code,
            coefs: C,
            mem: M,
            linear: P::LINEAR,
            load: |p, te, out| out.copy_from_slice(&P::coefs(p, te)),
            start: |c, e, mem| mem.copy_from_slice(&P::start(&arr(c), e)),
            force: |c, mem, tables, e, w| {
                let mut m = arr(mem);
                let f = P::force(&arr(c), &mut m, tables, e, w);
                mem.copy_from_slice(&m);
                f
            },
            stored: |c, mem, tables, e0, e1| P::stored(&arr(c), &arr(mem), tables, e0, e1),
            lost: |c, mem, tables, e| P::lost(&arr(c), &arr(mem), tables, e),
            bound: |c, tables| P::bound(&arr(c), tables),
            kernel: kernel::<P, C, M>,
            simpler: |_| None,
            table: None,
        }
    }

    /// The same law with a rule that picks a cheaper one.
    #[must_use]
    pub const fn or(mut self, simpler: fn(&[Fixed]) -> Option<&'static Law>) -> Law {
        self.simpler = simpler;
        self
    }

    /// The same law with a table of its own.
    #[must_use]
    pub const fn with_table(mut self, table: fn() -> Table) -> Law {
        self.table = Some(table);
        self
    }
}

/// Energy of the linear part between two ticks, with the negative mass of the backward damper (numerics 2.1).
fn linear_stored(k: f64, z: f64, e0: f64, e1: f64) -> f64 {
    0.5 * k * e0 * e1 - 0.25 * z * (e1 - e0) * (e1 - e0)
}

/// Heat of a linear damper in one tick (numerics 2.1); `z` in N per m/tick.
fn linear_lost(z: f64, e: [f64; 3]) -> f64 {
    0.25 * z * (e[2] - e[0]) * (e[2] - e[0])
}
