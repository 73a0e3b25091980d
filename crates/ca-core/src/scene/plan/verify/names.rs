//! Verifies the names of ports, channels, probes and modules: their number and order.

use super::{Verified, ensure};
use crate::kind::name::Index;
use crate::scene::{Scene, Symbols};

pub(super) fn scene(scene: &Scene) -> Verified {
    let (l, probes) = (&scene.layout, scene.names.probe_names.len());
    let inputs = [scene.initial.input.len(), scene.before.as_ref().map_or(scene.inputs.len(), |b| b.state.input.len())];
    ensure(inputs == [scene.inputs.len(); 2], "inputs and their names differ in number")?;
    let outputs = scene.names.channel_names.len() == l.counts.channels
        && l.counts.channels.checked_add(probes) == Some(l.counts.n_out);
    ensure(outputs && scene.names.probe_of.len() == probes, "outputs and their names differ in number")?;
    ensure(scene.rate > 0.0 && scene.rate.is_finite(), "the sound rate is not above 0")?;
    symbols(&scene.symbols, scene)
}

fn symbols(symbols: &Symbols, scene: &Scene) -> Verified {
    let Symbols { runs, mats, lias } = symbols;
    ensure(super::each(mats, scene.layout.counts.n_mat), "a name belongs to a mass that does not exist")?;
    let lia = |[op, i]: &[u32; 2]| scene.passes.forces.get(*op as usize).is_some_and(|op| (*i as usize) < op.n);
    ensure(lias.iter().all(lia), "a name belongs to a link that does not exist")?;
    let all = mats.len().checked_add(lias.len()).and_then(|all| u32::try_from(all).ok());
    let all = all.ok_or(super::Wrong("there are more names than modules"))?;
    let begins = runs.first().is_none_or(|run| run.first == 0) && runs.is_empty() == (all == 0);
    let rising = runs.windows(2).all(|r| r[0].first < r[1].first) && runs.last().is_none_or(|run| run.first < all);
    ensure(begins && rising, "names are not in sequence")?;
    let ends = runs.iter().skip(1).map(|run| run.first).chain([all]);
    let counted = runs.iter().zip(ends).all(|(run, end)| {
        let more = |i: u32| i.checked_add(end - run.first).is_some();
        let index = match run.name.index {
            Index::None => true,
            Index::One(i) | Index::Two(_, i) => more(i),
        };
        index && run.name.axis.is_none_or(|axis| axis < 3)
    });
    ensure(counted, "a name has a number that does not exist")
}
