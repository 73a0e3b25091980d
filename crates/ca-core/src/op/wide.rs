//! Runs the body of a pass compiled for the widest vectors of the processor.
//!
//! A body is written once, in plain Rust over slices, and instantiated for portable and AVX2 vectors, and for AVX-512
//! where vectors are aligned to cache lines ([`widest`]); elsewhere that gains nothing and takes as long to build.
//! `pulp` chooses once, at load ([`Vectors`]), since asking in each pass would test a dozen processor features.
//!
//! Operations and their order are the same for all, and no product is fused with a sum, so the bits are the same.

use super::Op;
use crate::numeric::{Precision, Real};
use crate::op::layout::Layout;
use crate::state::State;
use core::marker::PhantomData;
use pulp::Arch;
pub use pulp::Simd;

/// Vector instructions that passes use.
#[derive(Clone, Copy, Debug)]
pub struct Vectors {
    /// for passes over arrays of any alignment
    plain: Arch,
    /// for passes whose vectors are aligned to cache lines
    widest: Arch,
}

impl Vectors {
    /// Vectors that every processor has.
    pub const PORTABLE: Vectors = Vectors { plain: Arch::Scalar, widest: Arch::Scalar };

    /// Returns the widest vectors of this processor (without `std`, of the compilation target). For tests and benches,
    /// `CA_VECTORS=portable` or `avx2` in the environment selects narrower ones.
    pub fn detect() -> Vectors {
        let own = Vectors::own();
        #[cfg(feature = "std")]
        match std::env::var("CA_VECTORS").as_deref() {
            Ok("portable") => return Vectors::PORTABLE,
            Ok("avx2") => return Vectors { widest: own.plain, ..own },
            _ => {}
        }
        own
    }

    fn own() -> Vectors {
        #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
        let plain = pulp::x86::V3::try_new().map_or(Arch::Scalar, Arch::V3);
        #[cfg(not(any(target_arch = "x86", target_arch = "x86_64")))]
        let plain = Arch::new();
        Vectors { plain, widest: Arch::new() }
    }

    /// Runs `call` with the vectors for arrays aligned to cache lines.
    pub(crate) fn widest<W: pulp::WithSimd>(self, call: W) -> W::Output {
        self.widest.dispatch(call)
    }

    /// Returns all vectors of this processor, narrowest first. A scene plays the same bits with each.
    pub fn all() -> [Vectors; 3] {
        let own = Vectors::own();
        [Vectors::PORTABLE, Vectors { widest: own.plain, ..own }, own]
    }
}

impl Default for Vectors {
    fn default() -> Vectors {
        Vectors::PORTABLE
    }
}

/// The loops of a pass. Everything that `run` calls must be inlined into it, or it is not vectorised at this width.
pub trait Body<R: Real> {
    /// Runs the pass. Code other than plain loops takes its vectors from `simd`.
    fn run<S: Simd>(simd: S, op: &Op<R>, layout: &Layout<R>, s: &mut State<R>);
}

struct Call<'a, R: Real, B> {
    op: &'a Op<R>,
    layout: &'a Layout<R>,
    s: &'a mut State<R>,
    body: PhantomData<B>,
}

impl<R: Real, B: Body<R>> pulp::WithSimd for Call<'_, R, B> {
    type Output = ();
    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        B::run(simd, self.op, self.layout, self.s);
    }
}

/// Runs a pass with the body `B`.
pub fn wide<R: Real, B: Body<R>>(op: &Op<R>, layout: &Layout<R>, s: &mut State<R>) {
    plain(layout, Call { op, layout, s, body: PhantomData::<B> });
}

/// Runs `call` with the vectors for arrays of any alignment.
#[inline(always)]
pub(crate) fn plain<R: Real, W: pulp::WithSimd>(layout: &Layout<R>, call: W) -> W::Output {
    // a dual number is one vector of the widest kind
    if const { matches!(R::PRECISION, Precision::Dual) } {
        return layout.vectors.widest.dispatch(call);
    }
    // avoids a third instance of bodies that would not gain by it
    match layout.vectors.plain {
        #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
        Arch::V3(simd) => Simd::vectorize(simd, call),
        #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
        _ => Simd::vectorize(pulp::Scalar::new(), call),
        #[cfg(not(any(target_arch = "x86", target_arch = "x86_64")))]
        other => other.dispatch(call),
    }
}

/// Runs a pass with the body `B`, for vectors that are aligned to cache lines or limited by square roots.
pub fn widest<B: Body<f64>>(op: &Op, layout: &Layout, s: &mut State) {
    layout.vectors.widest.dispatch(Call { op, layout, s, body: PhantomData::<B> });
}
