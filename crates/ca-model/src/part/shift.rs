//! Shifts the spans of a separately read file behind the other files.

use crate::diag::{Diags, Fix};
use crate::model::{Entry, Item, Model, Span, Value};

/// Returns the offset of the first byte of the next file of a model.
pub(super) fn next_file(model: &Model) -> usize {
    // a finding may point at the end of a text, one past its last byte
    model.files.last().map_or(model.text.len(), |f| f.start + f.text.len()) + 1
}

pub(super) fn shift_diags(diags: &mut Diags, by: usize) {
    for d in &mut diags.list {
        for (span, _) in &mut d.labels {
            shift(span, by);
        }
        if let Some(Fix { span, .. }) = &mut d.fix {
            shift(span, by);
        }
    }
}

pub(super) fn shift_model(model: &mut Model, by: usize) {
    let Model { meta, rate, params, gestures, presets, equivalence, .. } = model;
    for s in [meta, rate, params, gestures, presets, equivalence] {
        entries(s, by);
    }
    for g in &mut model.groups {
        shift(&mut g.span, by);
        entries(&mut g.props, by);
    }
    for Item { kind_span, name_span, span, args, .. } in &mut model.items {
        for s in [kind_span, name_span, span] {
            shift(s, by);
        }
        entries(args, by);
    }
    for p in &mut model.parts {
        shift(&mut p.span, by);
        entries(&mut p.props, by);
        shift_model(&mut p.body, by);
    }
    for u in &mut model.uses {
        shift(&mut u.span, by);
        for e in [&mut u.part, &mut u.file, &mut u.n].into_iter().flatten() {
            entry(e, by);
        }
        entries(&mut u.with, by);
    }
}

fn shift(span: &mut Span, by: usize) {
    if span.is_some() {
        (span.start, span.end) = (span.start + by, span.end + by);
    }
}

fn entries(list: &mut [Entry], by: usize) {
    for e in list {
        entry(e, by);
    }
}

fn entry(e: &mut Entry, by: usize) {
    shift(&mut e.key_span, by);
    shift(&mut e.span, by);
    if let Value::List(list) | Value::Table(list) = &mut e.value {
        entries(list, by);
    }
}
