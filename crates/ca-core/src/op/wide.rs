//! Wide: runs the body of a pass compiled for the widest vectors the processor has.
//!
//! Decides that a body is written once, in plain Rust over slices, and instantiated for each width, portable and AVX2, and
//! AVX-512 where vectors stand on cache lines ([`widest`]): elsewhere it gains nothing and takes as long to build. The choice
//! is made by `pulp` (no unsafe of ours), once, at load ([`Vectors`]): to ask the processor in each pass is to test a dozen of its
//! features in each pass. The operations and their order are the same in all, and no product is fused with a sum, so the bits
//! do not depend on the processor.

use super::Op;
use crate::numeric::{Precision, Real};
use crate::op::layout::Layout;
use crate::state::State;
use core::marker::PhantomData;
use pulp::Arch;
pub use pulp::Simd;

/// The vectors that passes use.
#[derive(Clone, Copy, Debug)]
pub struct Vectors {
    /// passes over arrays as they stand
    plain: Arch,
    /// passes whose vectors stand on cache lines
    widest: Arch,
}

impl Vectors {
    /// What every processor has.
    pub const PORTABLE: Vectors = Vectors { plain: Arch::Scalar, widest: Arch::Scalar };

    /// The widest of this processor, or narrower ones where the environment has `CA_VECTORS=portable` or `avx2`, by which all tests
    /// and benches can be run as on another processor. Without the feature `std`, the widest this was compiled for.
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

    /// Runs `call` with the vectors for arrays that stand on cache lines.
    pub(crate) fn widest<W: pulp::WithSimd>(self, call: W) -> W::Output {
        self.widest.dispatch(call)
    }

    /// All that this processor has, narrowest first: a scene plays the same bits with each.
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

/// The loops of a pass. Everything `run` calls must be inlined into it, or it stays narrow.
pub trait Body<R: Real> {
    /// Runs the pass; what is not a plain loop takes its vectors from `simd`.
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

/// A pass whose body is `B`.
pub fn wide<R: Real, B: Body<R>>(op: &Op<R>, layout: &Layout<R>, s: &mut State<R>) {
    plain(layout, Call { op, layout, s, body: PhantomData::<B> });
}

/// Runs `call` with the vectors for arrays as they stand.
#[inline(always)]
pub(crate) fn plain<R: Real, W: pulp::WithSimd>(layout: &Layout<R>, call: W) -> W::Output {
    // a number with its derivatives is a vector of the widest
    if const { matches!(R::PRECISION, Precision::Dual) } {
        return layout.vectors.widest.dispatch(call);
    }
    // no third width is made of a body that would not gain by it
    match layout.vectors.plain {
        #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
        Arch::V3(simd) => Simd::vectorize(simd, call),
        #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
        _ => Simd::vectorize(pulp::Scalar::new(), call),
        #[cfg(not(any(target_arch = "x86", target_arch = "x86_64")))]
        other => other.dispatch(call),
    }
}

/// A pass whose body is `B`, over vectors that stand on cache lines or wait for roots.
pub fn widest<B: Body<f64>>(op: &Op, layout: &Layout, s: &mut State) {
    layout.vectors.widest.dispatch(Call { op, layout, s, body: PhantomData::<B> });
}
