//! Copies modules, groups, instances and parameters under new names. Links among the copied ones join the copies.

use crate::add::fresh;
use crate::layout::key;
use crate::symbols::{Class, Symbol, Written};
use crate::tree::Statement;
use crate::{Edited, Refusal, TextEdit};
use core::ops::Range;
use std::collections::{BTreeMap, BTreeSet};

/// Largest number of bytes that one operation adds.
const MOST: usize = 1 << 24;

pub(crate) fn duplicate(w: &Written, names: &[String]) -> Result<Edited, Refusal> {
    let mut new: BTreeMap<Symbol, String> = BTreeMap::new();
    let mut taken: BTreeSet<String> = BTreeSet::new();
    for name in names {
        let symbol = w.find(name)?;
        if matches!(symbol.class, Class::Part | Class::Preset) {
            return Err(Refusal::new(format!("`{name}` is not copied"), "copy its lines in the text"));
        }
        let old = w.name(symbol);
        let (group, word) = old.rsplit_once('.').map_or((None, old), |(g, word)| (Some(g), word));
        let full = |word: &str| group.map_or(word.to_owned(), |g| format!("{g}.{word}"));
        let is_free = |n: &str| w.check_free(symbol.scope, &full(n)).is_ok() && !taken.contains(&full(n));
        let copy = fresh(word, is_free);
        taken.insert(full(&copy));
        new.insert(symbol, copy);
    }
    let references = w.references();
    let mut edits = Vec::new();
    for (symbol, copy) in &new {
        let path = w.path(*symbol);
        // the group goes with its members
        let in_group = w.body(symbol.scope).items.get(symbol.index).and_then(|i| i.group).map(|index| Symbol {
            scope: symbol.scope,
            class: Class::Group,
            index,
        });
        if symbol.class == Class::Module && in_group.is_some_and(|g| new.contains_key(&g)) {
            continue;
        }
        let chunks = chunks(w, &path);
        let Some(end) = chunks.last().map(|c| c.end) else { continue };
        let mut text = String::new();
        for chunk in chunks {
            let mut inner = Vec::new();
            w.document.tree().words(&mut |at, word| {
                if at == path && chunk.contains(&word.range.start) {
                    inner.push(TextEdit::new(word.range.clone(), key(copy)));
                }
            });
            let within = references.iter().filter(|r| chunk.contains(&r.range.start));
            inner.extend(within.filter_map(|r| w.rewrite(r, &|s| new.get(&s).cloned())));
            for e in &mut inner {
                e.range = e.range.start - chunk.start..e.range.end - chunk.start;
            }
            let copied = Edited::new(&w.text()[chunk], inner).text;
            text += &copied;
            if !copied.ends_with('\n') {
                text += w.layout().eol();
            }
        }
        let layout = w.layout();
        let text = text.trim_end_matches(['\n', '\r']);
        let gap = if text.starts_with('[') { layout.eol() } else { "" };
        edits.push(layout.insert_lines(layout.line_end(end.saturating_sub(1)), &format!("{gap}{text}")));
    }
    if edits.iter().map(|e| e.text.len()).sum::<usize>() > MOST {
        return Err(Refusal::new("the copies are too large", "copy less at once"));
    }
    Ok(Edited::new(w.text(), edits))
}

/// Returns the lines that define `path`, each chunk a section or an entry; a comment behind an entry is not in it.
pub(crate) fn chunks(w: &Written, path: &[String]) -> Vec<Range<usize>> {
    let layout = w.layout();
    let mut all: Vec<Range<usize>> = Vec::new();
    let mut in_section = false;
    for s in &w.document.tree().statements {
        let lines = layout.lines(&s.range());
        match s {
            Statement::Header(_) => {
                in_section = s.is_below(path);
                if in_section {
                    all.push(lines);
                }
            }
            Statement::Pair(_) if in_section => {
                if let Some(last) = all.last_mut() {
                    last.end = lines.end;
                }
            }
            Statement::Pair(_) if s.is_below(path) => all.push(lines.start..s.range().end),
            Statement::Pair(_) => {}
        }
    }
    all
}
