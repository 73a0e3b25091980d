//! Types of the older dialect, with the number of their modules and numbers.
//!
//! The published tools skip an unknown type silently, and one of their models writes `springDamperDamper` throughout,
//! so it is silent. Here a doubled word or other case is read as the type that it doubles, with a note. Any other
//! misspelling is an error with the nearest type: `nlSpring2` and `nlSpring3` differ by one letter, and sound unlike.

use super::names::Losses;
use super::parse::{Line, refuse_younger, shown};
use alloc::format;
use alloc::string::String;
use alloc::vec::Vec;
use ca_model::diag::{Diag, Diags};

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum What {
    Param,
    AudioParam,
    Mass,
    MassG,
    Osc,
    Ground,
    PosInput,
    Spring,
    Damper,
    /// `nlSpring`, which the tools read in two ways.
    NlSpring,
    NlSpring2,
    NlSpring3,
    Contact,
    /// Old name of `contact`.
    Detent,
    NlPluck,
    NlBow,
    FrcInput,
    PosOutput,
    FrcOutput,
}

#[derive(Clone, Copy, Debug)]
pub(super) struct Type {
    pub name: &'static str,
    pub what: What,
    /// Number of `@module` arguments, which come first.
    pub ends: usize,
    /// Names of the numbers that follow.
    pub numbers: &'static [&'static str],
    /// Count of these that may be left out, from the end.
    pub optional: usize,
    /// True if a drawing buffer and its x and y may follow.
    pub drawn: bool,
    /// Count of numbers that only the younger dialect writes.
    pub younger: Option<usize>,
}

const fn mat(name: &'static str, what: What, numbers: &'static [&'static str], younger: Option<usize>) -> Type {
    Type { name, what, ends: 0, numbers, optional: 0, drawn: true, younger }
}
const fn link(name: &'static str, what: What, numbers: &'static [&'static str], younger: Option<usize>) -> Type {
    Type { name, what, ends: 2, numbers, optional: 0, drawn: false, younger }
}
const fn port(name: &'static str, what: What) -> Type {
    Type { name, what, ends: 1, numbers: &[], optional: 0, drawn: false, younger: None }
}
const fn value(name: &'static str, what: What) -> Type {
    Type { name, what, ends: 0, numbers: &["value"], optional: 0, drawn: false, younger: None }
}

const TYPES: &[Type] = &[
    value("param", What::Param),
    value("audioParam", What::AudioParam),
    mat("mass", What::Mass, &["M", "x0", "xDelayed"], Some(4)),
    mat("massG", What::MassG, &["M", "G", "x0", "xDelayed"], None),
    mat("osc", What::Osc, &["M", "K", "Z", "x0", "xDelayed"], Some(6)),
    mat("ground", What::Ground, &["x0"], None),
    mat("posInput", What::PosInput, &["x0"], None),
    Type { optional: 1, ..link("spring", What::Spring, &["K", "Z"], None) },
    Type { optional: 1, ..link("springDamper", What::Spring, &["K", "Z"], None) },
    link("damper", What::Damper, &["Z"], None),
    link("nlSpring", What::NlSpring, &["K", "Q", "Z"], None),
    link("nlSpring2", What::NlSpring2, &["K", "Q", "Z"], None),
    link("nlSpring3", What::NlSpring3, &["K", "Q", "Z"], None),
    link("contact", What::Contact, &["K", "Z", "threshold"], Some(2)),
    link("detent", What::Detent, &["K", "Z", "threshold"], None),
    link("nlPluck", What::NlPluck, &["K", "scale"], Some(3)),
    link("nlBow", What::NlBow, &["Z", "scale"], Some(3)),
    port("frcInput", What::FrcInput),
    port("posOutput", What::PosOutput),
    port("frcOutput", What::FrcOutput),
];

/// Types that only the younger dialect has.
const YOUNGER: &[&str] =
    &["string", "stiffString", "chain", "mesh", "closedMesh", "cornerMesh", "nlContact", "nlSpringDamper"];

/// Returns the lines with a known type and number of arguments, and reports the others.
pub(super) fn typed<'l, 'a>(lines: &'l [Line<'a>], diags: &mut Diags) -> Vec<(&'l Line<'a>, &'static Type)> {
    let mut losses = Losses::default();
    let mut found = Vec::new();
    for line in lines {
        let known = TYPES.iter().find(|t| t.name == line.ty.text);
        if known.is_none() && YOUNGER.contains(&line.ty.text) {
            *diags = Diags::new();
            refuse_younger(line.number, line.ty.span, "only in the younger dialect", diags);
            return Vec::new();
        }
        let near = || TYPES.iter().find(|t| same_word(t.name, line.ty.text) && fits(t, line));
        let Some(ty) = known.or_else(near) else {
            // the younger dialect may still show in a later line
            if !diags.is_full() {
                unknown(line, diags);
            }
            continue;
        };
        if known.is_none() {
            losses.add(
                &format!("near {}", line.ty.text),
                Diag::note("N201", format!("`{}` is read as `{}`", shown(line.ty.text), ty.name))
                    .at(line.ty.span, "not a type; MIMS skips such a line")
                    .help("if the link was meant to be missing, delete it"),
            );
        }
        if Some(line.args.len()) == ty.younger.map(|n| n + ty.ends) {
            *diags = Diags::new();
            refuse_younger(
                line.number,
                line.ty.span,
                "this count of numbers exists only in the younger dialect",
                diags,
            );
            return Vec::new();
        }
        if fits(ty, line) {
            found.push((line, ty));
        } else {
            wrong_count(line, ty, diags);
        }
    }
    losses.into_diags(diags);
    found
}

fn fits(ty: &Type, line: &Line<'_>) -> bool {
    let most = ty.ends + ty.numbers.len();
    let n = line.args.len();
    (most - ty.optional..=most).contains(&n) || (ty.drawn && n == most + 3)
}

/// Compares words without case and with words that are doubled in a row.
fn same_word(known: &str, word: &str) -> bool {
    let mut parts: Vec<String> = Vec::new();
    for c in word.chars() {
        if c.is_ascii_uppercase() || parts.is_empty() {
            parts.push(String::new());
        }
        if let Some(part) = parts.last_mut() {
            part.push(c.to_ascii_lowercase());
        }
    }
    parts.dedup();
    known.eq_ignore_ascii_case(word) || known.eq_ignore_ascii_case(&parts.concat())
}

fn unknown(line: &Line<'_>, diags: &mut Diags) {
    let word = line.ty.text;
    let d = Diag::error("E002", format!("unknown type: `{}`", shown(word))).at(line.ty.span, "not a type of MIMS");
    diags.push(match nearest(word, TYPES.iter().map(|t| t.name)) {
        Some(name) => d.help(format!("did you mean `{name}`?")).fix(line.ty.span, name),
        None => {
            d.help("types are `mass`, `massG`, `osc`, `ground`, `posInput`, links, `frcInput`, `posOutput`, `param`")
        }
    });
}

/// Returns the most similar name, if one is similar enough.
pub(super) fn nearest<'n>(word: &str, names: impl Iterator<Item = &'n str>) -> Option<&'n str> {
    if word.len() > 80 {
        return None;
    }
    let (score, name) = names.map(|n| (strsim::jaro_winkler(word, n), n)).max_by(|a, b| a.0.total_cmp(&b.0))?;
    (score > 0.8).then_some(name)
}

fn wrong_count(line: &Line<'_>, ty: &Type, diags: &mut Diags) {
    let most = ty.ends + ty.numbers.len();
    let mut form = format!("`@{} {}", shown(line.label.text), ty.name);
    for end in ["@a", "@b"].iter().take(ty.ends) {
        form.push(' ');
        form.push_str(end);
    }
    for (i, n) in ty.numbers.iter().enumerate() {
        let (open, close) = if i + ty.optional >= ty.numbers.len() { (" [", "]") } else { (" ", "") };
        form.extend([open, n, close]);
    }
    form.push('`');
    let (n, label) = (line.args.len(), shown(line.label.text));
    diags.push(match line.args.get(most) {
        Some(extra) => {
            Diag::error("E004", format!("too many arguments for `{label}`: {n}, `{}` takes {most}", ty.name))
                .at(extra.span, "from here on")
                .help(format!("write {form}"))
        }
        None => Diag::error("E005", format!("arguments missing for `{label}`: {n}, `{}` takes {most}", ty.name))
            .at(line.ty.span, "takes more")
            .help(format!("write {form}")),
    });
}
