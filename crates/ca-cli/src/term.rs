//! Terminal output: optional colour, and prefixes for messages.
//!
//! Text is plain with `NO_COLOR`, with `TERM=dumb`, and outside a terminal. A closed stderr does not cause a panic.

use ca_device_tools::Message;
use ca_model::diag::{Diags, Severity};
use ca_model::printable::printable;
use ca_model::quantity::short;
use ca_model::{Model, render};
use indicatif::{ProgressBar, ProgressStyle};
use std::io::{IsTerminal as _, Write as _};
use std::sync::atomic::{AtomicBool, Ordering};

/// Returns true if stderr supports colour.
pub fn color() -> bool {
    let set = |name: &str| std::env::var_os(name).is_some_and(|v| !v.is_empty());
    !set("NO_COLOR") && std::env::var_os("TERM").is_none_or(|t| t != "dumb") && std::io::stderr().is_terminal()
}

fn lead(word: &str, code: &str, text: &str) {
    let text = printable(text);
    let mut err = std::io::stderr().lock();
    let _ =
        if color() { writeln!(err, "\x1b[1;{code}m{word}\x1b[0m: {text}") } else { writeln!(err, "{word}: {text}") };
}

/// Prints `error: …`.
pub fn error(text: &str) {
    lead("error", "31", text);
}

/// Prints `warning: …`.
pub fn warning(text: &str) {
    lead("warning", "33", text);
}

/// Prints `note: …`.
pub fn note(text: &str) {
    lead("note", "36", text);
}

/// Prints a message of a tool.
pub fn message(message: Message) {
    match message {
        Message::Note(text) => note(&text),
        Message::Warning(text) => warning(&text),
    }
}

/// True while the next findings should refer to `ca explain`; it is reset after the first time in a run.
static EXPLAINING: AtomicBool = AtomicBool::new(false);

/// Sets whether findings refer to `ca explain`.
pub fn explaining(yes: bool) {
    EXPLAINING.store(yes, Ordering::Relaxed);
}

/// Prints findings with their places, and the page about the first error or else the first warning.
pub fn findings(diags: &Diags, model: &Model) {
    let text = render::text(diags, model, color());
    let worst = diags.list.iter().filter(|d| d.severity != Severity::Note).min_by_key(|d| d.severity);
    let mut err = std::io::stderr().lock();
    let _ = write!(err, "{text}");
    if let Some(d) = worst
        && EXPLAINING.swap(false, Ordering::Relaxed)
    {
        let _ = writeln!(err, "for details, run `ca explain {}`", d.code);
    }
}

/// Formats a time \[s\] in a convenient unit.
pub fn time(seconds: f64) -> String {
    let (by, unit) = match seconds {
        s if s < 1.0 => (1e3, "ms"),
        s if s < 120.0 => (1.0, "s"),
        s if s < 7200.0 => (1.0 / 60.0, "min"),
        s if s < 172_800.0 => (1.0 / 3600.0, "h"),
        _ => (1.0 / 86_400.0, "days"),
    };
    format!("{} {unit}", short(seconds * by))
}

/// Creates a progress bar for long work. It stays hidden if stderr is not a terminal.
pub fn progress(steps: u64) -> ProgressBar {
    let bar = ProgressBar::new(steps);
    let template =
        if color() { "{bar:40.cyan} {percent:>3} % {eta} left" } else { "{bar:40} {percent:>3} % {eta} left" };
    if let Ok(style) = ProgressStyle::with_template(template) {
        bar.set_style(style);
    }
    bar
}
