//! Verifies that a state at load has as many numbers as its layout counts.

use super::super::record::StateRecord;
use super::{Verified, each, ensure};
use crate::op::layout::Layout;

pub(in super::super) fn state(s: &StateRecord, l: &Layout) -> Verified {
    let glide = l.rates.substeps.as_ref().map_or(0, |substeps| substeps.inputs.len());
    let late = l.ports.tgr.len().checked_mul(l.ports.crossing.latency as usize);
    let taps = (2 * l.out.lowpass.len()).saturating_sub(1);
    let past = taps.checked_mul(2).and_then(|n| n.checked_mul(l.counts.channels));
    let implicit = l.implicit.as_ref().map_or(0, |a| 2 * a.places.len());
    let lengths = [
        (s.x.len(), l.counts.n_mat),
        (s.d.len(), l.counts.n_mat),
        (s.f.len(), l.counts.n_mat),
        (s.coef.len(), l.counts.n_coef),
        (s.mem.len(), l.counts.n_mem),
        (s.lengths.len(), l.links.reach.len()),
        (s.tap.len(), l.counts.n_tap),
        (s.last_input.len(), s.input.len()),
        (s.output.len(), l.counts.n_out),
        (s.cells.len(), l.places.moving_points.len()),
        (s.border.len(), l.ports.tgr.len()),
        (s.blocked.len(), l.out.blockers.len()),
        (s.glide.len(), glide),
        (s.implicit.len(), implicit),
        (s.under_way.len(), l.ports.ahead.len()),
        (s.turns.len(), if l.ports.ahead.is_empty() { 0 } else { l.counts.n_mat }),
    ];
    let counted = lengths.iter().all(|(is, by_layout)| is == by_layout);
    let rings = late == Some(s.late.len()) && past == Some(s.lowpass.len());
    ensure(counted && rings, "the state differs in shape from its layout")?;
    let cells = s.cells.iter().all(|cell| cell.n <= cell.node.len() && each(&cell.node, l.counts.n_mat));
    ensure(cells, "a moving point is beyond the masses")?;
    ensure(each(s.live.iter(), l.counts.n_coef), "a live coefficient does not exist")?;
    let [slots, coefs] = &s.written;
    ensure(
        each(slots.iter(), l.counts.n_mat) && each(coefs.iter(), l.counts.n_coef),
        "the order of the document is beyond the state",
    )?;
    ensure(s.kick.as_ref().is_none_or(|kick| kick.len() <= l.counts.n_mat), "the start pushes masses that do not exist")
}
