//! Makes a part of modules of the model, and one instance of it in their place.

use crate::paths::Paths;
use crate::references::Reference;
use crate::symbols::{Class, Symbol, Written};
use crate::tree::{Header, Statement};
use crate::value::shown;
use crate::{Document, Edited, Refusal, TextEdit};
use ca_model::select::is_word;
use std::collections::BTreeSet;

/// Moves what `names` says into the new part `part`. Outside of it, `hammer` becomes `INSTANCE.hammer`.
pub(crate) fn group(w: &Written, names: &[String], part: &str, instance: Option<&str>) -> Result<Edited, Refusal> {
    let instance = instance.unwrap_or(part);
    let mut moved: BTreeSet<Symbol> = BTreeSet::new();
    for name in names {
        moved.insert(w.find(name)?);
    }
    check(w, &moved, part, instance)?;
    let paths: Paths = moved.iter().map(|s| w.path(*s)).collect();
    let sections = sections(w, &paths, part);
    let mut edits = w.layout().remove(&paths);
    // behind the last section that loses something
    let statements = &w.document.tree().statements;
    let last = statements.iter().rposition(|s| paths.cover_statement(s)).map_or(0, |i| i + 1);
    let rest = statements[last..].iter().take_while(|s| matches!(s, Statement::Pair(_))).count();
    let at = (last + rest).checked_sub(1).and_then(|i| statements.get(i));
    let at = at.map_or(w.text().len(), |s| w.layout().line_end(s.range().end));
    let eol = w.layout().eol();
    let use_path = ["use".to_owned(), instance.to_owned()];
    let line = format!("{{ part = \"{part}\" }}");
    // the section may lose all its entries
    let left = Document::read(&Edited::new(w.text(), edits.clone()).text)?;
    let has_use = left.tree().is_table(&use_path[..1]);
    let mut text = sections;
    if has_use {
        edits.extend(w.layout().set(&use_path, &line));
    } else {
        text += &[eol, "[use]", eol, instance, " = ", &line, eol].concat();
    }
    let gap = if w.text()[at..].starts_with(['\n', '\r']) || at == w.text().len() { "" } else { eol };
    edits.push(w.layout().insert_lines(at, format!("{text}{gap}").trim_end_matches(['\n', '\r'])));
    let is_inside = |r: &Reference| {
        let before = statements.partition_point(|s| s.range().start <= r.range.start);
        before.checked_sub(1).and_then(|i| statements.get(i)).is_some_and(|s| paths.cover_statement(s))
    };
    let outside: Vec<Reference> = w.references().into_iter().filter(|r| !is_inside(r)).collect();
    for r in &outside {
        edits.extend(prefixed(w, r, &moved, instance));
    }
    let edited = Edited::new(w.text(), edits);
    let now = Written::read(&edited.text, w.catalog)?;
    if now.references().len() < w.references().len() {
        let help = "choose another name for the part and its instance";
        return Err(Refusal::new(format!("`{instance}` has another meaning where a module of it is used"), help));
    }
    Ok(edited)
}

fn check(w: &Written, moved: &BTreeSet<Symbol>, part: &str, instance: &str) -> Result<(), Refusal> {
    if moved.is_empty() {
        return Err(Refusal::new("nothing is chosen", "name the modules of the part"));
    }
    for s in moved {
        let name = w.address(*s);
        if s.scope.is_some() || !matches!(s.class, Class::Module | Class::Group | Class::Instance) {
            let help = "choose modules, groups and instances of the model itself";
            return Err(Refusal::new(format!("`{name}` cannot be in a new part"), help));
        }
        let item = w.model.items.get(s.index).filter(|_| s.class == Class::Module);
        if let Some((group, _)) = item.and_then(|i| i.name.split_once('.')) {
            return Err(Refusal::new(
                format!("`{name}` is in the group `{group}`"),
                format!("choose `{group}` as a whole"),
            ));
        }
        let is_output = |kind: &str| matches!(kind, "SOX" | "SOF");
        let outputs = w.model.items.iter().filter(|i| is_output(&i.kind)).count();
        if item.is_some_and(|i| is_output(&i.kind) && outputs > 1 && !i.args.iter().any(|e| e.key == "channel")) {
            let what = format!("`{name}` has no `channel`, so its channel follows from its line");
            return Err(Refusal::new(what, "give each output a `channel` first"));
        }
    }
    if !is_word(part) || w.model.parts.iter().any(|p| p.name == part) {
        let what = format!("`{}` cannot be the name of a part", shown(part));
        return Err(Refusal::new(what, "use a word that no other part has"));
    }
    let own = w.named(None, instance).is_some_and(|s| moved.contains(&s));
    if !is_word(instance) {
        let what = format!("`{}` cannot be the name of an instance", shown(instance));
        return Err(Refusal::new(what, "use one word"));
    }
    if own { Ok(()) } else { w.check_free(None, instance) }
}

/// Writes the sections of the part, with the entries that move.
fn sections(w: &Written, paths: &Paths, part: &str) -> String {
    let (layout, eol) = (w.layout(), w.layout().eol());
    let name = |words: &str| if words.is_empty() { format!("[part.{part}]") } else { format!("[part.{part}.{words}]") };
    let mut all: Vec<(String, String)> = Vec::new();
    let mut header: Option<&Header> = None;
    for s in &w.document.tree().statements {
        let moves = paths.cover_statement(s);
        if let Statement::Header(h) = s {
            header = Some(h);
        }
        if !moves {
            continue;
        }
        let words = header.map_or("", |h| w.text()[h.range.clone()].trim_matches(['[', ']', ' ']));
        let title = name(words);
        if all.last().is_none_or(|l| l.0 != title) {
            match all.iter().position(|l| l.0 == title) {
                Some(i) => {
                    let again = all.remove(i);
                    all.push(again);
                }
                None => all.push((title, String::new())),
            }
        }
        if let (Statement::Pair(p), Some(last)) = (s, all.last_mut()) {
            last.1 += w.text()[layout.lines(&p.range())].trim_end();
            last.1 += eol;
        }
    }
    all.iter().flat_map(|(title, lines)| [eol, title, eol, lines]).collect()
}

/// Writes the instance before a name of something that moved.
fn prefixed(w: &Written, r: &Reference, moved: &BTreeSet<Symbol>, instance: &str) -> Option<TextEdit> {
    let old = &w.text()[r.range.clone()];
    let heads: Vec<usize> = r.hits.iter().filter(|h| moved.contains(&h.symbol)).map(|h| h.at.start).collect();
    if heads.is_empty() {
        return None;
    }
    if r.is_key && !old.starts_with(['"', '\'']) {
        return Some(TextEdit::insert(r.range.start, format!("{instance}.")));
    }
    let mut text = r.text.clone();
    for at in heads.iter().rev() {
        text.insert_str(*at, &format!("{instance}."));
    }
    w.rewritten(r, &text)
}
