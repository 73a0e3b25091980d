//! Versions of a text: undo and redo.

use crate::Edited;
use std::collections::VecDeque;

/// One step between two versions: the replaced bytes and the new ones.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Step {
    name: String,
    at: usize,
    old: String,
    new: String,
}

impl Step {
    fn size(&self) -> usize {
        self.name.len() + self.old.len() + self.new.len() + size_of::<Step>()
    }
}

/// A text with its earlier and undone versions. Steps store differences, so the memory is bounded by `limit`.
///
/// ```
/// use ca_edit::History;
/// let mut h = History::new("a = 1\n", 1 << 20);
/// h.push("set a", "a = 2\n");
/// assert_eq!((h.undo().as_deref(), h.text()), (Some("set a"), "a = 1\n"));
/// assert_eq!((h.redo().as_deref(), h.text()), (Some("set a"), "a = 2\n"));
/// ```
#[derive(Clone, Debug)]
pub struct History {
    text: String,
    steps: VecDeque<Step>,
    /// Number of steps that are done; the others are undone.
    done: usize,
    size: usize,
    limit: usize,
}

impl History {
    /// Starts with a text. `limit` is the memory for steps \[bytes\]; the oldest steps are dropped beyond it.
    pub fn new(text: &str, limit: usize) -> History {
        History { text: text.into(), steps: VecDeque::new(), done: 0, size: 0, limit }
    }

    /// Returns the present version.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// Adds a version with the name of its step, and drops undone ones. An equal text is not a step.
    pub fn push(&mut self, name: &str, text: &str) {
        let Some(edit) = Edited::between(&self.text, text).edits.pop() else { return };
        self.size -= self.steps.drain(self.done..).map(|s| s.size()).sum::<usize>();
        let old = self.text[edit.range.clone()].to_owned();
        let step = Step { name: name.into(), at: edit.range.start, old, new: edit.text };
        self.size += step.size();
        self.steps.push_back(step);
        text.clone_into(&mut self.text);
        while self.size > self.limit {
            let Some(oldest) = self.steps.pop_front() else { break };
            self.size -= oldest.size();
        }
        self.done = self.steps.len();
    }

    /// Goes back one version; returns the name of the undone step, or `None` at the first version.
    pub fn undo(&mut self) -> Option<String> {
        let step = self.steps.get(self.done.checked_sub(1)?)?;
        self.text.replace_range(step.at..step.at + step.new.len(), &step.old);
        self.done -= 1;
        Some(step.name.clone())
    }

    /// Does the next undone step again; returns its name, or `None` at the last version.
    pub fn redo(&mut self) -> Option<String> {
        let step = self.steps.get(self.done)?;
        self.text.replace_range(step.at..step.at + step.old.len(), &step.new);
        self.done += 1;
        Some(step.name.clone())
    }

    /// Returns the name of the step that [`History::undo`] would undo.
    pub fn next_undo(&self) -> Option<&str> {
        Some(&self.steps.get(self.done.checked_sub(1)?)?.name)
    }

    /// Returns the name of the step that [`History::redo`] would do.
    pub fn next_redo(&self) -> Option<&str> {
        Some(&self.steps.get(self.done)?.name)
    }

    /// Returns the memory of the steps \[bytes\].
    pub fn size(&self) -> usize {
        self.size
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn versions_come_back() {
        let texts = ["", "é", "è", "xè", "x", "x\r\n", ""];
        let mut h = History::new(texts[0], 1 << 20);
        texts[1..].iter().for_each(|t| h.push(t, t));
        for t in texts.iter().rev().skip(1) {
            assert!(h.undo().is_some());
            assert_eq!(h.text(), *t);
        }
        assert_eq!((h.undo(), h.next_undo(), h.next_redo()), (None, None, Some("é")));
        texts[1..].iter().for_each(|t| assert_eq!((h.redo(), h.text().len()), (Some((*t).to_owned()), t.len())));
        assert_eq!((h.redo(), h.next_redo()), (None, None));
        h.undo();
        h.push("new", "y");
        assert_eq!((h.next_redo(), h.next_undo()), (None, Some("new")));
        h.push("same", "y");
        assert_eq!(h.next_undo(), Some("new"));
    }

    #[test]
    fn old_steps_are_dropped() {
        let mut h = History::new("", 1000);
        for i in 0..100 {
            h.push("step", &"x".repeat(i * 7 % 50));
            assert!(h.size() <= 1000);
        }
        let mut n = 0;
        while h.undo().is_some() {
            n += 1;
        }
        assert!((1..20).contains(&n), "{n}");
        // larger than all memory
        h.push("large", &"y".repeat(2000));
        assert_eq!((h.size(), h.undo()), (0, None));
    }
}
