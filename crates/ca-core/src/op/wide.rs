//! Wide: runs the body of a pass compiled for the widest vectors the processor has.
//!
//! Decides that a body is written once, in plain Rust over slices, and instantiated twice, portable and AVX2, with the
//! choice made at run time by `pulp` (no unsafe of ours). The operations and their order are the same in both, and no
//! product is fused with a sum, so the bits do not depend on the processor.

use super::Op;
use crate::layout::Layout;
use crate::state::State;
use core::marker::PhantomData;
pub use pulp::Simd;

/// The loops of a pass. Everything `run` calls must be inlined into it, or it stays narrow.
pub trait Body {
    /// Runs the pass; what is not a plain loop takes its vectors from `simd`.
    fn run<S: Simd>(simd: S, op: &Op, layout: &Layout, s: &mut State);
}

struct Call<'a, B> {
    op: &'a Op,
    layout: &'a Layout,
    s: &'a mut State,
    body: PhantomData<B>,
}

impl<B: Body> pulp::WithSimd for Call<'_, B> {
    type Output = ();
    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        B::run(simd, self.op, self.layout, self.s);
    }
}

/// A pass whose body is `B`.
pub fn wide<B: Body>(op: &Op, layout: &Layout, s: &mut State) {
    pulp::Arch::new().dispatch(Call { op, layout, s, body: PhantomData::<B> });
}
