//! Writes `docs/commands.md` from the help of the commands.
//!
//! The input is the text that `ca help` prints, because this crate has no public access to its parser. The text is
//! joined to paragraphs again, so that the width of a terminal does not change the page.

use std::collections::BTreeMap;
use std::fmt::Write as _;

const HEAD: &str = "# Commands

After this page you can find the command for a task, and its options.

Made by `UPDATE=1 cargo test $ALL --test cli -- docs` from `ca help`: do not edit. `ca help COMMAND` prints the same text, with
more examples.

";
const SHARED: &str = "Options of several commands";
/// An option with the same text in at least this many commands has one row at the end of the page.
const SEVERAL: usize = 3;

/// The help of one command.
struct Help {
    /// Its words after `ca`, such as `device sim`.
    name: String,
    /// Paragraphs, beginning with its purpose.
    about: Vec<String>,
    usage: String,
    /// Arguments and options: name with value, and meaning.
    rows: Vec<(String, String)>,
    /// Names of its subcommands.
    inner: Vec<String>,
    /// Other parts: title, indented lines, and the paragraph after them.
    parts: Vec<(String, Vec<String>, String)>,
}

/// Writes the page. `help` returns the long help of a command, given by its words.
pub fn page(help: impl Fn(&[&str]) -> String) -> String {
    let general = read("", &help(&[]));
    let mut all = Vec::new();
    for name in &general.inner {
        let outer = read(name, &help(&[name]));
        let inner: Vec<Help> =
            outer.inner.iter().map(|word| read(&format!("{name} {word}"), &help(&[name, word]))).collect();
        all.push(outer);
        all.extend(inner);
    }
    let shared = shared(&all);
    let mut out = HEAD.to_string() + "| command | purpose |\n|---|---|\n";
    for c in all.iter().filter(|c| !c.name.contains(' ')) {
        let _ = writeln!(out, "| [`ca {0}`](#ca-{0}) | {1} |", c.name, c.about[0]);
    }
    let _ = writeln!(out, "\n{}", general.about[1..].join("\n\n"));
    for (place, c) in all.iter().enumerate() {
        // examples of a subcommand are in the help of its command
        let outer = all[..=place].iter().rfind(|outer| !outer.name.contains(' ')).unwrap();
        section(&mut out, c, outer, &shared);
    }
    let _ = writeln!(out, "\n## {SHARED}\n");
    out + &table(&shared)
}

fn section(out: &mut String, c: &Help, outer: &Help, shared: &[(String, String)]) {
    let level = if c.name.contains(' ') { "###" } else { "##" };
    let _ = writeln!(out, "\n{level} ca {}\n\n{}.\n", c.name, c.about[0]);
    for paragraph in &c.about[1..] {
        let _ = writeln!(out, "{paragraph}\n");
    }
    let _ = writeln!(out, "```text\n{}\n```", c.usage);
    let (common, own): (Vec<_>, Vec<_>) = c.rows.iter().cloned().partition(|row| shared.contains(row));
    if !own.is_empty() {
        let _ = write!(out, "\n{}", table(&own));
    }
    if !common.is_empty() {
        let anchor = SHARED.to_lowercase().replace(' ', "-");
        let names: Vec<String> = common.iter().map(|(name, _)| format!("`{}`", short(name))).collect();
        let _ = writeln!(out, "\n[{SHARED}](#{anchor}): {}.", names.join(", "));
    }
    for (title, lines, after) in c.parts.iter().filter(|(title, ..)| title != "Examples") {
        let _ = write!(out, "\n{title}:\n\n```text\n{}\n```\n", lines.join("\n"));
        if !after.is_empty() {
            let _ = writeln!(out, "\n{after}");
        }
    }
    let command = format!("ca {}", c.name);
    let examples = outer.parts.iter().filter(|(title, ..)| title == "Examples").flat_map(|(_, lines, _)| lines);
    let examples: Vec<&str> =
        examples.map(String::as_str).filter(|l| format!("{l} ").contains(&format!("{command} "))).take(2).collect();
    if !examples.is_empty() && c.inner.is_empty() {
        let _ = write!(out, "\n```sh\n{}\n```\n", examples.join("\n"));
    }
}

/// Returns the rows that many commands have, in the order of the page. Of several texts about one option the most
/// frequent one counts.
fn shared(all: &[Help]) -> Vec<(String, String)> {
    let mut count: BTreeMap<&(String, String), usize> = BTreeMap::new();
    for row in all.iter().flat_map(|c| &c.rows) {
        *count.entry(row).or_default() += 1;
    }
    let mut rows: Vec<(String, String)> = Vec::new();
    for row in all.iter().flat_map(|c| &c.rows) {
        let most = count.iter().filter(|(other, _)| other.0 == row.0).map(|(_, n)| *n).max().unwrap_or(0);
        if count[row] >= SEVERAL && count[row] == most && !rows.iter().any(|(name, _)| *name == row.0) {
            rows.push(row.clone());
        }
    }
    rows
}

fn table(rows: &[(String, String)]) -> String {
    let mut out = "| option | meaning |\n|---|---|\n".to_string();
    for (name, text) in rows {
        let _ = writeln!(out, "| `{}` | {text} |", name.replace('|', "\\|"));
    }
    out
}

/// Returns `--output` for `-o, --output <FILE>`, and the name of an argument as it is.
fn short(name: &str) -> &str {
    name.split(' ').find(|word| word.starts_with("--")).unwrap_or(name)
}

/// Joins lines, links the page about safety, and escapes the characters of Markdown outside of code.
fn joined<'a>(lines: impl IntoIterator<Item = &'a str>) -> String {
    let words: Vec<&str> = lines.into_iter().flat_map(str::split_whitespace).collect();
    let mut out = String::new();
    for (place, piece) in words.join(" ").split('`').enumerate() {
        let piece = piece.replace('|', "\\|");
        if place % 2 == 1 {
            let _ = write!(out, "`{piece}`");
        } else {
            let plain = piece.replace('*', "\\*").replace('<', "\\<");
            out += &plain.replace("docs/safety.md", "[safety.md](safety.md)");
        }
    }
    out
}

/// Reads the long help of a command.
fn read(name: &str, help: &str) -> Help {
    let (about, rest) = help.split_once("Usage: ").unwrap_or_else(|| panic!("no usage in\n{help}"));
    let (usage, rest) = rest.split_once("\n\n").unwrap_or((rest, ""));
    let about = about.split("\n\n").map(|p| joined(p.lines())).filter(|p| !p.is_empty()).collect();
    let usage = usage.trim().to_string();
    let mut c = Help { name: name.to_string(), about, usage, rows: Vec::new(), inner: Vec::new(), parts: Vec::new() };
    let lines: Vec<&str> = rest.lines().collect();
    let is_title = |l: &&str| l.ends_with(':') && !l.starts_with(' ');
    let mut starts: Vec<usize> = (0..lines.len()).filter(|i| is_title(&lines[*i])).collect();
    starts.push(lines.len());
    for pair in starts.windows(2) {
        let title = lines[pair[0]].trim_end_matches(':');
        let body = &lines[pair[0] + 1..pair[1]];
        // names of options are at column 2 or 6, names of arguments at column 2, and their texts further right
        let is_row = |l: &str| {
            let name = l.trim_start();
            match l.len() - name.len() {
                0 => !name.is_empty(),
                2 => name.starts_with(['-', '<', '[']),
                6 => name.starts_with('-'),
                _ => false,
            }
        };
        let first = body.iter().find(|l| !l.trim().is_empty()).map_or("", |l| l.trim_start());
        if title == "Commands" {
            let words = body.iter().filter(|l| l.starts_with("  ") && !l.starts_with("   "));
            let words = words.filter_map(|l| l.split_whitespace().next()).filter(|w| *w != "help");
            c.inner.extend(words.map(str::to_string));
        } else if title == "Arguments" || first.starts_with('-') {
            let mut at: Vec<usize> = (0..body.len()).filter(|i| is_row(body[*i])).collect();
            // paragraphs after the last section of options stand at the margin
            let end = at.iter().copied().find(|i| !body[*i].starts_with(' ')).unwrap_or(body.len());
            c.about.extend(
                body[end..].split(|l| l.is_empty()).map(|p| joined(p.iter().copied())).filter(|p| !p.is_empty()),
            );
            at.retain(|i| *i < end);
            at.push(end);
            let rows = at.windows(2).map(|pair| {
                // a short text is beside the name
                let line = body[pair[0]].trim();
                let (name, text) = line.split_once("  ").unwrap_or((line, ""));
                let lines = std::iter::once(text).chain(body[pair[0] + 1..pair[1]].iter().copied());
                (name.to_string(), meaning(lines))
            });
            c.rows.extend(rows.filter(|(name, _)| !name.starts_with("-h, --help") && !name.starts_with("-V, ")));
        } else {
            let (code, after): (Vec<&str>, Vec<&str>) = body.iter().partition(|l| l.is_empty() || l.starts_with("  "));
            let code: Vec<String> = code.iter().map(|l| l.trim_start_matches("  ").to_string()).collect();
            let length = code.iter().rposition(|l| !l.is_empty()).map_or(0, |i| i + 1);
            c.parts.push((title.to_string(), code[..length].to_vec(), joined(after)));
        }
    }
    c
}

/// Joins the text of an option, with its values and its default.
fn meaning<'a>(lines: impl Iterator<Item = &'a str>) -> String {
    let mut out = String::new();
    let mut listed = false;
    for line in lines.map(str::trim).filter(|l| !l.is_empty()) {
        let bracket = |word: &str| line.strip_prefix(word)?.strip_suffix(']');
        if line == "Possible values:" {
            out += ". Values:";
        } else if let Some((value, text)) = line.strip_prefix("- ").and_then(|l| l.split_once(':')) {
            let _ = write!(out, "{} `{value}`, {}", if listed { ";" } else { "" }, text.trim());
            listed = true;
        } else if let Some(value) = bracket("[default: ") {
            let _ = write!(out, ". Default: `{}`", value.trim_matches('"'));
        } else if let Some(values) = bracket("[possible values: ") {
            let _ = write!(out, ". Values: {values}");
        } else {
            let _ = write!(out, " {line}");
        }
    }
    let text = joined([out.as_str()]);
    text.trim_start_matches(". ").to_string()
}
