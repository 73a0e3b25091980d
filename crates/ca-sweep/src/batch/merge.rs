//! Merges instances of one model into one model, so that each tick begins once for all of them.
//!
//! Parts (`ca_model::part`) rename the modules of each instance and all references to them, so the merged model is an
//! ordinary one. Modules of the instances alternate, because rows of equal links side by side are computed together.
//! Instances are not merged if they differ in something that a model has once, or if the number of modules changes.

use ca_core::Catalog;
use ca_io::gesture::{Gesture, Track};
use ca_model::part::{self, Part, Use};
use ca_model::{Entry, Item, Model, Span, Value};

/// Name of instance `i` in the merged model.
fn name(i: usize) -> String {
    format!("i{i}")
}

/// Merges instances, each with `channels` channels; `None` where that is not possible.
pub fn models(all: &[Model], channels: usize, catalog: &Catalog) -> Option<Model> {
    let first = all.first()?;
    let once = |m: &Model| m.meta == first.meta && m.rate == first.rate && m.equivalence == first.equivalence;
    let mut merged = Model {
        file: first.file.clone(),
        meta: first.meta.clone(),
        rate: first.rate.clone(),
        equivalence: first.equivalence.clone(),
        ..Model::default()
    };
    for (i, m) in all.iter().enumerate() {
        if !once(m) || m.items.len() != first.items.len() || !m.lost.is_empty() {
            return None;
        }
        let items = m.items.iter().map(|item| placed(item, &m.params, i, channels)).collect::<Option<_>>()?;
        let (params, gestures, groups) = (m.params.clone(), m.gestures.clone(), m.groups.clone());
        let body = Model { params, gestures, groups, items, ..Model::default() };
        let part = Part { name: name(i), span: Span::NONE, doc: String::new(), props: Vec::new(), body };
        if part::add(&mut merged, &part, &Use::new(&name(i)), catalog).has_errors() {
            return None;
        }
    }
    let (n, per) = (all.len(), first.items.len());
    if merged.items.len() != n * per {
        return None;
    }
    // outputs stay together, since their order gives the channels
    let (outputs, mut others): (Vec<_>, Vec<_>) =
        merged.items.into_iter().enumerate().partition(|(_, item)| is_output(item));
    others.sort_by_key(|(at, _)| (at % per, at / per));
    merged.items = others.into_iter().chain(outputs).map(|(_, item)| item).collect();
    Some(merged)
}

fn is_output(item: &Item) -> bool {
    matches!(item.kind.as_str(), "SOX" | "SOF")
}

/// Moves a module to the channels of instance `i`. Its text position is dropped, so that modules keep their order.
/// Returns `None` for a channel that the instances do not have.
fn placed(item: &Item, params: &[Entry], i: usize, channels: usize) -> Option<Item> {
    let mut item = Item { name_span: Span::NONE, ..item.clone() };
    if is_output(&item) {
        for e in item.args.iter_mut().filter(|e| e.key == "channel") {
            let channel = number(&e.value, params).filter(|c| (0.0..channels as f64).contains(c))?;
            e.value = Value::Num(channel + (i * channels) as f64);
        }
    }
    Some(item)
}

/// Returns a plain number, or the number of the named parameter.
fn number(value: &Value, params: &[Entry]) -> Option<f64> {
    let named = |name: &str| params.iter().find(|p| p.key == name.trim()).map(|p| &p.value);
    match value {
        Value::Num(v) => Some(*v),
        Value::Text(name) => number(named(name)?, &[]),
        Value::Table(t) => number(&t.iter().find(|e| e.key == "value")?.value, &[]),
        _ => None,
    }
}

/// Repeats a gesture for `n` instances.
pub fn gesture(of_one: &Gesture, n: usize) -> Option<Gesture> {
    let track = |(i, t): (usize, &Track)| t.clone().named(format!("{}.{}", name(i), t.name()));
    let all = (0..n).flat_map(|i| of_one.tracks().iter().map(move |t| track((i, t))));
    Gesture::new(all.collect()).ok()
}

/// Repeats probes for `n` instances, one instance after the other.
pub fn probes(of_one: &[String], n: usize) -> Vec<String> {
    (0..n).flat_map(|i| of_one.iter().map(move |p| format!("{}.{p}", name(i)))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use ca_compile::Options;
    use ca_io::perform::Performance;
    use ca_lab::load::{BUNDLED, Loaded, catalog};

    /// Plays three merged instances beside a single one and compares the bits. Returns false where they are not merged.
    fn same_bits(what: &str, text: &str) -> bool {
        let loaded = Loaded::read(text, what);
        let options = Options { bounds_only: true, ..Options::default() };
        let alone = loaded.compile(&options).expect("an example compiles").scene;
        let Some(model) = models(&vec![loaded.model.clone(); 3], alone.counts.channels, &catalog()) else {
            return false;
        };
        let merged =
            Loaded { model, ..loaded }.compile(&options).unwrap_or_else(|e| panic!("{what}: {:?}", e.diags)).scene;
        assert_eq!(
            (merged.counts.n_out, merged.inputs.len()),
            (3 * alone.counts.n_out, 3 * alone.inputs.len()),
            "{what}"
        );
        let [mut one, mut all] = [&alone, &merged].map(|s| Performance::new(s, None).expect("its gesture plays"));
        for n in 0..3000 {
            one.tick();
            all.tick();
            for (k, v) in all.state.output.iter().enumerate() {
                let want = one.state.output[k % alone.counts.channels];
                assert_eq!(v.to_bits(), want.to_bits(), "{what}, sample {n}, channel {k}: {v:e}, not {want:e}");
            }
        }
        true
    }

    #[test]
    fn instances_that_are_played_as_one_have_the_bits_of_each() {
        let examples = catalog().iter().map(|k| (k.code, k.example)).collect::<Vec<_>>();
        let apart: Vec<&str> =
            BUNDLED.iter().chain(&examples).filter(|(what, text)| !same_bits(what, text)).map(|m| m.0).collect();
        assert!(apart.is_empty(), "{apart:?} are not merged");
    }
}
