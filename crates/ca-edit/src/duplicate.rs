//! Copies modules, groups, instances and parameters under new names. Links among the copied ones join the copies.

use crate::add::fresh;
use crate::layout::key;
use crate::symbols::{Class, Symbol, Written};
use crate::tree::Statement;
use crate::{Edited, Refusal, TextEdit};
use core::ops::Range;
use std::collections::{BTreeMap, HashMap, HashSet};

/// Largest number of bytes that one operation adds.
const MOST: usize = 1 << 24;

pub(crate) fn duplicate(w: &Written, names: &[String]) -> Result<Edited, Refusal> {
    let new = new_names(w, names)?;
    // a module goes with its group
    let goes_with_group = |s: &Symbol| {
        let group = w.body(s.scope).items.get(s.index).filter(|_| s.class == Class::Module).and_then(|i| i.group);
        group.is_some_and(|index| new.contains_key(&Symbol { class: Class::Group, index, ..*s }))
    };
    let copied: HashMap<Vec<String>, &str> =
        new.iter().filter(|(s, _)| !goes_with_group(s)).map(|(s, copy)| (w.path(*s), copy.as_str())).collect();
    // all changes in a copy, by their place in the original
    let mut changes: Vec<TextEdit> = Vec::new();
    w.document.tree().words(&mut |at, word| {
        changes.extend(copied.get(at).map(|copy| TextEdit::new(word.range.clone(), key(copy))));
    });
    changes.extend(w.references().iter().filter_map(|r| w.rewrite(r, &|s| new.get(&s).cloned())));
    changes.sort_by_key(|e| e.range.start);
    let layout = w.layout();
    let mut edits = Vec::new();
    for chunks in chunks(w, &copied).into_values() {
        let Some(end) = chunks.last().map(|c| c.end) else { continue };
        let mut text = String::new();
        for chunk in chunks {
            let from = changes.partition_point(|e| e.range.start < chunk.start);
            let within = changes[from..].iter().take_while(|e| e.range.start < chunk.end);
            let shifted =
                |e: &TextEdit| TextEdit::new(e.range.start - chunk.start..e.range.end - chunk.start, e.text.as_str());
            text += &Edited::new(&w.text()[chunk.clone()], within.map(shifted).collect()).text;
            if !text.ends_with('\n') {
                text += layout.eol();
            }
        }
        let text = text.trim_end_matches(['\n', '\r']);
        let gap = if text.starts_with('[') { layout.eol() } else { "" };
        edits.push(layout.insert_lines(layout.line_end(end.saturating_sub(1)), &[gap, text].concat()));
    }
    if edits.iter().map(|e| e.text.len()).sum::<usize>() > MOST {
        return Err(Refusal::new("the copies are too large", "copy less at once"));
    }
    Ok(Edited::new(w.text(), edits))
}

/// Makes a free name for each copy: the old one with another number.
fn new_names(w: &Written, names: &[String]) -> Result<BTreeMap<Symbol, String>, Refusal> {
    let mut new = BTreeMap::new();
    let mut taken: HashSet<String> = HashSet::new();
    let mut next: HashMap<String, u64> = HashMap::new();
    for name in names {
        let symbol = w.find(name)?;
        if matches!(symbol.class, Class::Part | Class::Preset) {
            return Err(Refusal::new(format!("`{name}` is not copied"), "copy its lines in the text"));
        }
        let old = w.name(symbol);
        let (group, word) = old.rsplit_once('.').map_or((None, old), |(g, word)| (Some(g), word));
        let full = |word: &str| group.map_or(word.to_owned(), |g| format!("{g}.{word}"));
        let is_free = |n: &str| w.check_free(symbol.scope, &full(n)).is_ok() && !taken.contains(&full(n));
        let stem = full(word.trim_end_matches(|c: char| c.is_ascii_digit()));
        let copy = fresh(word, next.entry(stem).or_insert(2), is_free);
        taken.insert(full(&copy));
        new.insert(symbol, copy);
    }
    Ok(new)
}

/// Returns the lines that define each path, each chunk a section or an entry without the comment behind it.
fn chunks(w: &Written, copied: &HashMap<Vec<String>, &str>) -> BTreeMap<Vec<String>, Vec<Range<usize>>> {
    let layout = w.layout();
    let mut all: BTreeMap<Vec<String>, Vec<Range<usize>>> = BTreeMap::new();
    let of =
        |path: &[String]| (1..=path.len()).map(|n| &path[..n]).find(|p| copied.contains_key(*p)).map(<[_]>::to_vec);
    let mut section: Option<Vec<String>> = None;
    for s in &w.document.tree().statements {
        let lines = layout.lines(&s.range());
        match s {
            Statement::Header(h) => {
                section = of(&h.words.iter().map(|w| w.name.clone()).collect::<Vec<_>>());
                all.extend(section.clone().filter(|p| !all.contains_key(p)).map(|p| (p, Vec::new())));
                if let Some(chunks) = section.as_ref().and_then(|p| all.get_mut(p)) {
                    chunks.push(lines);
                }
            }
            Statement::Pair(p) => match &section {
                Some(path) => {
                    if let Some(last) = all.get_mut(path).and_then(|c| c.last_mut()) {
                        last.end = lines.end;
                    }
                }
                None => {
                    if let Some(path) = of(&p.path) {
                        all.entry(path).or_default().push(lines.start..s.range().end);
                    }
                }
            },
        }
    }
    all
}
