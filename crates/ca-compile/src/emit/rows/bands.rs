//! Bands: meshes whose links along and across the rows run in the pass that integrates their masses.
//!
//! Meshes are found by slots alone, whatever made them: links of one law, some between neighbours and others between
//! slots at a constant distance, the width. Like a row, a mesh is fused only if the list of passes sums in the same
//! order ([`Added`]), links along the rows first.

use crate::emit::cost;
use crate::emit::layout_builder::LayoutBuilder;
use crate::emit::rows::added::Added;
use crate::emit::rows::batch::{Batch, JOINT, Mesh};
use alloc::vec::Vec;
use ca_core::internal::op::Band;
use ca_core::internal::state::Fold;
use core::ops::Range;

fn slots(builder: &LayoutBuilder, b: &Batch) -> Range<u32> {
    let [first, second] = builder.ends(b.links[0]);
    first..second + b.links.len() as u32
}

/// Returns the first slots of both ends of a row, and its number of links.
fn ends(builder: &LayoutBuilder, b: &Batch) -> ([u32; 2], u32) {
    (builder.ends(b.links[0]), b.links.len() as u32)
}

/// Returns the meshes among `batches` whose masses have one class (`alike`), each with its batches in the order of
/// their slots.
pub fn meshes(
    builder: &LayoutBuilder,
    batches: &[Batch],
    added: &Added,
    fits: impl Fn(&Batch) -> bool,
    alike: impl Fn(Range<usize>) -> bool,
) -> Vec<(Mesh, Vec<usize>)> {
    let mut all: Vec<(Mesh, Vec<usize>)> = Vec::new();
    let mut tried = alloc::vec![false; batches.len()];
    for (i, across) in batches.iter().enumerate() {
        let width = across.stride;
        if width < 2 || tried[i] || !fits(across) {
            continue;
        }
        let mut range = slots(builder, across);
        let mut stages: Vec<Option<u8>> = alloc::vec![None; batches.len()];
        // Rows of the same law that share masses with the mesh so far.
        loop {
            let found = range.clone();
            for (k, b) in batches.iter().enumerate().filter(|(_, b)| b.stride == 1 || b.stride == width) {
                let same = stages[k].is_none() && core::ptr::eq(b.law, across.law) && fits(b);
                let r = if same { slots(builder, b) } else { 0..0 };
                if r.start < range.end && range.start < r.end {
                    range = range.start.min(r.start)..range.end.max(r.end);
                    stages[k] = Some(u8::from(b.stride == width));
                }
            }
            if found == range {
                break;
            }
        }
        let mut mesh = Mesh {
            first: range.start,
            slots: range.end - range.start,
            width: width as u32,
            head: [0; 2],
            tail: [0; 2],
        };
        let body = mesh;
        // Links across to an incomplete first or last row have another stride.
        for (k, b) in batches.iter().enumerate() {
            if b.stride < 2 || b.stride == width || !core::ptr::eq(b.law, across.law) || !fits(b) {
                continue;
            }
            let ([first, second], n) = ends(builder, b);
            // Offset from the first node of the body to the first of their second ends, or of their first ends.
            let above = second.checked_sub(range.start).filter(|above| above + n <= width as u32);
            let below = first.checked_sub(range.start).filter(|below| {
                let reaches = below + n <= body.slots && below + width as u32 >= body.slots;
                reaches && second == range.end
            });
            match (above, below) {
                (Some(above), _) if first + n == range.start && mesh.head[0] == 0 => {
                    mesh = Mesh { first, slots: mesh.slots + n, head: [n, above], ..mesh };
                }
                (_, Some(below)) if mesh.tail[0] == 0 => {
                    mesh = Mesh { slots: mesh.slots + n, tail: [n, below + mesh.width - body.slots], ..mesh };
                }
                _ => continue,
            }
            stages[k] = Some(1);
        }
        let mut of: Vec<usize> = (0..batches.len()).filter(|k| stages[*k].is_some()).collect();
        of.iter().filter(|k| batches[**k].stride > 1).for_each(|k| tried[*k] = true);
        of.sort_by_key(|k| (stages[*k], slots(builder, &batches[*k]).start));
        // If two rows of one direction meet at a mass, the lower one must add first. Two links of one direction between
        // the same masses are not a mesh.
        let behind = |a: &usize, b: &usize| {
            let (([a_first, _], n), ([b_first, _], _)) = (ends(builder, &batches[*a]), ends(builder, &batches[*b]));
            stages[*a] != stages[*b] || (a < b && a_first + n <= b_first)
        };
        let ordered = of.is_sorted_by(behind);
        let wide = mesh.nodes().div_ceil(Fold::LANES) > width;
        let mut places = mesh.first as usize..(mesh.first + mesh.slots) as usize;
        let by_others = |slot: usize| added.of(slot).iter().filter(|i| stages[**i as usize].is_none());
        let rows_over = places.clone().flat_map(by_others).filter(|i| batches[**i as usize].stride > 0).count();
        if wide
            && of.iter().any(|k| batches[*k].stride == 1)
            && ordered
            && cost::bands(mesh.nodes(), across.law.coefs, rows_over)
            && alike(places.clone())
            && places.all(|slot| added.begins(slot, |k| stages[k]))
        {
            all.push((mesh, of));
        }
    }
    all
}

/// Returns the batches of a mesh as two, links along its rows and links across them, with joints in the gaps.
pub fn joined(builder: &LayoutBuilder, mesh: Mesh, of: &[Batch]) -> [Batch; 2] {
    let width = mesh.width as usize;
    [(1, Band::Along(width)), (width, Band::Across)].map(|(stride, band)| {
        let mut links = alloc::vec![JOINT; mesh.nodes()];
        for l in of.iter().filter(|b| (b.stride == 1) == (stride == 1)).flat_map(|b| &b.links) {
            links[mesh.node((builder.ends(*l)[0] - mesh.first) as usize)] = *l;
        }
        Batch { links, stride, band, mesh: Some(mesh), ..of[0] }
    })
}
