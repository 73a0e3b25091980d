//! Diagnostics for an author: a code, a title, places, a reason and a fix.
//!
//! Reader and compiler do not stop at the first error. They add to one [`Diags`], which is sorted by place and shown as
//! a whole. Wording: lower case, names and commands in backticks, the value after a colon, one suggestion. `render.rs`
//! (feature `parse`) shows them with carets and as JSON. This file is free of dependencies, so models built by programs
//! get the same diagnostics without the parser.

use super::model::Span;
use alloc::format;
use alloc::string::String;
use alloc::vec::Vec;

/// Severity of a finding.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// The model cannot be compiled.
    Error,
    /// It compiles, but probably differs from the intention.
    Warning,
    /// Useful to know.
    Note,
}

/// Replacement of a span by a text that would correct the finding.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fix {
    /// Replaced range; empty for an insertion.
    pub span: Span,
    /// New text.
    pub text: String,
}

/// One finding.
#[derive(Clone, Debug, PartialEq)]
pub struct Diag {
    /// Entry of [`CODES`].
    pub code: &'static str,
    /// Error, warning or note.
    pub severity: Severity,
    /// One line that is clear without context and names the module.
    pub title: String,
    /// Places, with a few words for each; the first is the main place.
    pub labels: Vec<(Span, String)>,
    /// Remedy in words.
    pub help: Option<String>,
    /// Remedy as an edit.
    pub fix: Option<Fix>,
}

impl Diag {
    /// Makes an error.
    pub fn error(code: &'static str, title: impl Into<String>) -> Diag {
        Diag::new(code, Severity::Error, title)
    }
    /// Makes a warning.
    pub fn warning(code: &'static str, title: impl Into<String>) -> Diag {
        Diag::new(code, Severity::Warning, title)
    }
    /// Makes a note.
    pub fn note(code: &'static str, title: impl Into<String>) -> Diag {
        Diag::new(code, Severity::Note, title)
    }
    fn new(code: &'static str, severity: Severity, title: impl Into<String>) -> Diag {
        debug_assert!(CODES.iter().any(|c| c.0 == code), "{code} is not in diag::CODES");
        Diag { code, severity, title: title.into(), labels: Vec::new(), help: None, fix: None }
    }
    /// Adds a place and its label.
    #[must_use]
    pub fn at(mut self, span: Span, label: impl Into<String>) -> Diag {
        self.labels.push((span, label.into()));
        self
    }
    /// Sets the remedy in words.
    #[must_use]
    pub fn help(mut self, text: impl Into<String>) -> Diag {
        self.help = Some(text.into());
        self
    }
    /// Sets the remedy as an edit.
    #[must_use]
    pub fn fix(mut self, span: Span, text: impl Into<String>) -> Diag {
        if span.is_some() {
            self.fix = Some(Fix { span, text: text.into() });
        }
        self
    }
    /// Returns the main place, for sorting.
    pub fn span(&self) -> Span {
        self.labels.first().map_or(Span::NONE, |l| l.0)
    }
}

/// Largest number of findings that are kept for each severity. Nobody reads more, and a file with a million wrong lines
/// would otherwise need many times its size.
pub const KEPT: usize = 100;

/// All findings about one model, in order of place after [`Diags::sort`].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Diags {
    /// Findings: at most [`KEPT`] of a severity, and one more that reports further errors.
    pub list: Vec<Diag>,
    /// Number of dropped findings of each severity.
    more: [usize; 3],
}

impl Diags {
    /// Returns an empty list.
    pub fn new() -> Diags {
        Diags::default()
    }
    /// Adds a finding, or only counts it after [`KEPT`] of its severity. The first error too many is replaced by E027.
    pub fn push(&mut self, d: Diag) {
        let severity = d.severity;
        if self.list.iter().filter(|o| o.severity == severity).count() < KEPT {
            self.list.push(d);
            return;
        }
        if severity == Severity::Error && !self.is_full() {
            let d = Diag::error("E027", format!("more than {KEPT} errors: the search stopped there"));
            self.list.push(d.help("fix these first"));
        }
        self.more[severity as usize] += 1;
    }
    /// Removes warnings and notes.
    pub fn keep_errors(&mut self) {
        self.list.retain(|d| d.severity == Severity::Error);
        self.more[1..].fill(0);
    }
    /// Adds all findings of another list.
    pub fn extend(&mut self, found: Diags) {
        found.list.into_iter().for_each(|d| self.push(d));
        self.more.iter_mut().zip(found.more).for_each(|(a, b)| *a += b);
    }
    /// Counts the findings of a severity, including dropped ones.
    pub fn count(&self, severity: Severity) -> usize {
        self.list.iter().filter(|d| d.severity == severity).count() + self.more[severity as usize]
    }
    /// Returns true after more than [`KEPT`] errors, when the search for others can stop.
    pub fn is_full(&self) -> bool {
        self.more[Severity::Error as usize] > 0
    }
    /// Returns true if there is an error.
    pub fn has_errors(&self) -> bool {
        self.list.iter().any(|d| d.severity == Severity::Error)
    }
    /// Reduces equal findings in several instances of a part to one, which gives the number of the others.
    pub fn merge_instances(&mut self) {
        // `note[3].hammer` and `note[4].hammer` are equal
        let alike = |title: &str| -> String {
            title.split(']').map(|t| t.trim_end_matches(|c: char| c.is_ascii_digit())).collect::<Vec<_>>().join("]")
        };
        let mut first: Vec<(String, usize, usize)> = Vec::new();
        let mut kept: Vec<Diag> = Vec::new();
        for d in core::mem::take(&mut self.list) {
            let of_instance = d.title.contains("].") || d.title.contains("]` needs");
            if !of_instance || !d.span().is_some() {
                kept.push(d);
                continue;
            }
            let title = alike(&d.title);
            let same = |at: usize| kept.get(at).is_some_and(|k| k.code == d.code && k.span() == d.span());
            if let Some(f) = first.iter_mut().find(|f| f.0 == title && same(f.1)) {
                f.2 += 1;
            } else {
                first.push((title, kept.len(), 0));
                kept.push(d);
            }
        }
        for (_, at, more) in first.into_iter().filter(|f| f.2 > 0) {
            let Some(d) = kept.get_mut(at) else { continue };
            let more = format!("the same in {more} other instance{}", if more == 1 { "" } else { "s" });
            d.help = Some(match d.help.take() {
                Some(help) => format!("{help} ({more})"),
                None => more,
            });
        }
        self.list = kept;
    }

    /// Sorts by place, stable at one place; findings without a place come last.
    pub fn sort(&mut self) {
        self.list.sort_by_key(|d| (d.span().start, d.severity));
    }
}

impl core::fmt::Display for Diags {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        for d in &self.list {
            writeln!(f, "[{}] {}", d.code, d.title)?;
        }
        Ok(())
    }
}
impl core::error::Error for Diags {}

/// Every code with its meaning: `E` errors, `W` warnings, `N` notes. A test checks that `diagnostics/*.md` explains
/// each.
pub const CODES: &[(&str, &str)] = &[
    ("E001", "not TOML"),
    ("E002", "unknown section or kind"),
    ("E003", "a module must be a table"),
    ("E004", "unknown parameter"),
    ("E005", "parameter missing"),
    ("E006", "wrong type of value"),
    ("E007", "not a quantity"),
    ("E008", "unit of the wrong dimension"),
    ("E009", "value out of range"),
    ("E010", "parameters exclude each other"),
    ("E011", "not one of the choices"),
    ("E012", "name used twice"),
    ("E013", "unknown name"),
    ("E014", "not a name"),
    ("E015", "not a selector"),
    ("E016", "index out of range"),
    ("E017", "module of the wrong family"),
    ("E018", "wrong number of values in a list"),
    ("E019", "points that are not a table"),
    ("E020", "invalid sound rate or gesture rate"),
    ("E021", "gesture that drives nothing"),
    ("E022", "a link needs two different ends"),
    ("E023", "tuning not possible"),
    ("E024", "nothing to compute"),
    ("E025", "not live"),
    ("E026", "MIDI mapping"),
    ("E027", "too large"),
    ("E028", "not supported"),
    ("E029", "does not fit the dimension of its space"),
    ("E030", "not a MIMS model"),
    ("E031", "file that cannot be read"),
    ("E032", "conflicting equivalences"),
    ("E033", "a part that uses itself"),
    ("E034", "a group at the gesture rate"),
    ("W101", "module without effect on an output"),
    ("W102", "contact already presses at load"),
    ("W103", "unstable"),
    ("W104", "stiff contact"),
    ("W105", "damper directly on a device key"),
    ("W106", "link without force"),
    ("W107", "stability not proven"),
    ("W108", "no output"),
    ("W109", "unused parameter"),
    ("W110", "active law"),
    ("W111", "an LPR without support"),
    ("W112", "an LPR on a support softer than itself"),
    ("W113", "steep friction"),
    ("W114", "decay not possible"),
    ("W115", "damping that couples modes"),
    ("W116", "gesture and port start at different positions"),
    ("W117", "a contact that is unstable while it presses"),
    ("W118", "friction that creeps"),
    ("W119", "contact so stiff that rounding adds energy"),
    ("N201", "lost on import"),
    ("N202", "file used only in part"),
    ("N203", "a heavy junction"),
    ("N204", "ports on one degree of freedom"),
    ("N205", "TOML 1.1"),
    ("N206", "secant method instead of Newton's method"),
    ("N207", "explicit method instead of `auto`"),
];
